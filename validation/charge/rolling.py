"""Rolling resistance: J. Ai, J.-F. Chen, J. M. Rotter and J. Y. Ooi, "Assessment of rolling resistance models
in discrete element simulations", Powder Technology 206 (2011) 269-282.  A sphere rolls on a level, and up an
incline, until it stops; type A and type C.
"""

import math

from nutamill.charge.laws.oscillator import contact_time, damping_ratio_from_restitution
from validation.charge.harness import FLOOR, Bench, G, pair, sphere_mass
from validation.charge.rows import Row

SOURCE = "rigid body with a constant moment (Ai et al. 2011)"
RADIUS, DENSITY, K, MU = 0.01, 2500.0, 1e5, 0.8
MASS = sphere_mass(RADIUS, DENSITY)
SAG = MASS * G / K
ZETA = damping_ratio_from_restitution(0.5, False)
DT = contact_time(K, MASS, ZETA, False) / 40


def ball(slope: float, rolling: float, law: str, speed: float) -> Bench:
    """A ball that rolls at `speed` [m/s] along x, up a slope [rad] (negative speed: down)."""
    gravity = (-G * math.sin(slope), 0.0, -G * math.cos(slope))
    numbers = pair(K, ZETA, 2 / 7, friction=MU, rolling=rolling)
    x = [0, 0, RADIUS - SAG * math.cos(slope)]
    law = ("linear", "displacement", law)
    return Bench(
        x,
        numbers,
        DT,
        [FLOOR],
        RADIUS,
        (DENSITY,),
        law,
        gravity,
        velocities=[speed, 0, 0],
        spins=[0, speed / RADIUS, 0],
    )


def decay() -> list[Row]:
    """On a level a constant moment slows a rolling sphere at 5/7 mu_r g."""
    rows = []
    mu_r, u0 = 0.05, 1.0
    stop = u0 / (5 / 7 * mu_r * G)
    way = 0.5 * u0 * stop
    w2 = 2 / 7 * K / MASS  # of both springs, tangential and rolling, per mass
    for law in ("type_a", "type_c"):
        bench = ball(0.0, mu_r, law, u0)
        bench.step(round(0.5 * stop / DT))
        why = "springs of friction and rolling stretched by mu_r m g/k_t first; half an overlap at the arm"
        allowed = (SAG / RADIUS + 2 * mu_r * G / math.sqrt(w2) / u0) * u0
        rows.append(
            Row(
                f"{law}: speed at half the time [m/s]", 0.5 * u0, SOURCE, bench.velocities[0, 0], allowed, why
            )
        )
        bench.step(round(0.6 * stop / DT))
        allowed = 2 * SAG / RADIUS * way + 4 * mu_r * G / w2 + 2 * mu_r * G / math.sqrt(w2) * stop
        rows.append(Row(f"{law}: way to the stop [m]", way, SOURCE, bench.positions[0, 0], allowed, why))
        fastest = 0.0
        for _ in range(200):
            bench.step(5)
            fastest = max(fastest, abs(bench.velocities[0, 0]))
        swing = 3.5 * mu_r * G / math.sqrt(w2)
        rows.append(
            Row(
                f"{law}: largest speed afterwards [m/s]",
                0.0,
                SOURCE,
                fastest,
                swing,
                "springs without dashpot keep swinging, at most as they were loaded",
            )
        )
        rows.append(
            Row(
                f"{law}: stands still afterwards [m/s]",
                0.0,
                "type C of Ai et al. with its dashpot stands still",
                fastest,
                1e-9,
                "none of the rolling laws here has a dashpot (as in Rocky)",
            )
        )
    return rows


def incline() -> list[Row]:
    """Up an incline, to the stop, and what then follows: rest where tan(slope) < mu_r, else rolling back."""
    rows = []
    slope, u0 = 0.1745, 0.5
    sin, cos = math.sin(slope), math.cos(slope)
    w2 = 2 / 7 * K / MASS
    for law in ("type_a", "type_c"):
        for mu_r in (0.10, 0.25):
            bench = ball(slope, mu_r, law, u0)
            slowing = 5 / 7 * G * (sin + mu_r * cos)
            top = u0**2 / (2 * slowing)
            bench.step(round(u0 / slowing / DT))
            late = 2 * mu_r * G / math.sqrt(w2) * u0 / slowing + 4 * G / w2 + SAG / RADIUS * top
            why = "springs of friction and rolling are stretched first; half an overlap at the arm"
            rows.append(
                Row(
                    f"{law}, mu_r = {mu_r}: way up 10 degrees [m]",
                    top,
                    SOURCE,
                    bench.positions[0, 0],
                    late,
                    why,
                )
            )
            t = 0.2
            bench.step(round(t / DT))
            back = max(0.0, 5 / 7 * G * (sin - mu_r * cos)) * t
            swing = 3.5 * (sin + mu_r) * G / math.sqrt(w2)
            drag = 0.0
            if law == "type_a" and mu_r > math.tan(slope):
                drag = G * sin * DT / 0.04 * 0.4
            rows.append(
                Row(
                    f"{law}, mu_r = {mu_r}: speed 0.2 s after the stop [m/s]",
                    -back,
                    SOURCE,
                    bench.velocities[0, 0],
                    swing + 0.01 * back + drag,
                    why + "; they go on swinging",
                )
            )
    return rows


CASES = {"Ai level": decay, "Ai incline": incline}
