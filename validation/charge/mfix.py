"""MFiX DEM01 to DEM04: J. Musser and others, MFiX Verification and Validation Manual; R. Garg, J. Galvin, T.
Li and S. Pannala, Powder Technology 220 (2012) 122-137.  Linear spring and dashpot."""

import math

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq

from nutamill.charge.laws.oscillator import contact_time, damping_ratio_from_restitution
from nutamill.charge.walls.surface import Surface, SurfaceKind
from validation.charge.harness import DOWN, FLOOR, Bench, G, pair, sphere_mass
from validation.charge.rows import Row, largest

SOURCE = "closed form, MFiX V&V manual"


def dem01() -> list[Row]:
    """A sphere falls, touches the floor and is followed through the contact."""
    rows = []
    radius, density, k, height = 0.1, 2600.0, 1e4, 0.5
    mass, fall = sphere_mass(radius, density), height - radius
    touch, speed = math.sqrt(2 * fall / G), math.sqrt(2 * G * fall)
    for e in (0.4, 0.7, 1.0):
        zeta = damping_ratio_from_restitution(e, False)
        time = contact_time(k, mass, zeta, False)
        dt = time / 1000
        bench = Bench([0, 0, height], pair(k, zeta, stop=0.9), dt, [FLOOR], radius, (density,), gravity=DOWN)
        bench.step(round(0.9 * touch / dt))
        exact = height - 0.5 * G * bench.time**2
        rows.append(
            Row(
                f"e = {e}: height in free fall at {bench.time:.4f} s [m]",
                exact,
                SOURCE,
                bench.positions[0, 2],
                1e-9,
                "exact but for rounding",
            )
        )
        w0, ds = math.sqrt(k / mass), mass * G / k
        wd = w0 * math.sqrt(1 - zeta * zeta)
        b = (speed - zeta * w0 * ds) / wd
        bench.step(round((touch + 0.25 * time) / dt) - round(0.9 * touch / dt))
        heights, speeds = [], []
        for _ in range(5):
            t = bench.time - touch
            ex, c, s = math.exp(-zeta * w0 * t), math.cos(wd * t), math.sin(wd * t)
            heights.append((radius - ds + ex * (ds * c - b * s), bench.positions[0, 2]))
            speeds.append(
                (
                    -ex * ((zeta * w0 * ds + wd * b) * c + (wd * ds - zeta * w0 * b) * s),
                    bench.velocities[0, 2],
                )
            )
            bench.step(round(0.12 * time / dt))
        # a step of the dashpot at touch is caught to second order; the start of contact is known to a
        # substep's share of that
        allowed = 4 * (math.pi / 1000) ** 2 * speed
        why = "second order in a substep of 1/1000 of the contact"
        rows.append(largest(f"e = {e}: height in contact [m]", heights, SOURCE, allowed / w0, why))
        rows.append(largest(f"e = {e}: velocity in contact [m/s]", speeds, SOURCE, allowed, why))
    return rows


def bounce_with_weight(mass: float, k: float, zeta: float, speed: float) -> float:
    """Speed [m/s] after a contact that begins at `speed` [m/s] under gravity: the damped oscillator to its
    next zero.
    """
    w0, ds = math.sqrt(k / mass), mass * G / k
    wd = w0 * math.sqrt(1 - zeta * zeta)
    b = (speed - zeta * w0 * ds) / wd

    def overlap(t):
        return ds + math.exp(-zeta * w0 * t) * (-ds * math.cos(wd * t) + b * math.sin(wd * t))

    end = brentq(overlap, 0.5 * math.pi / wd, 1.5 * math.pi / wd, xtol=1e-18, rtol=1e-14)
    return -math.exp(-zeta * w0 * end) * (
        (zeta * w0 * ds + wd * b) * math.cos(wd * end) + (wd * ds - zeta * w0 * b) * math.sin(wd * end)
    )


def dem02() -> list[Row]:
    """Heights of repeated bounces; in the limit of a stiff spring they fall with e^2."""
    rows = []
    height, radius, density, e = 0.5, 0.1, 2600.0, 0.8
    mass = sphere_mass(radius, density)
    zeta = damping_ratio_from_restitution(e, False)
    for k in (1e6, 1e8):
        time = contact_time(k, mass, zeta, False)
        dt = time / 100
        bench = Bench([0, 0, height], pair(k, zeta), dt, [FLOOR], radius, (density,), gravity=DOWN)
        speed = math.sqrt(2 * G * (height - radius))
        now = 0.0
        why = "second order in the substep, 1/100 of the contact, each bounce"
        for n in range(1, 6):
            after = bounce_with_weight(mass, k, zeta, speed)
            # from the middle of one flight to that of the next: half the way up is enough to know the top
            touch = now + (math.sqrt(2 * (height - radius) / G) if n == 1 else speed / G * 1.5)
            now = touch + time + 0.5 * after / G
            bench.step(max(1, round((now - bench.time) / dt)))
            apex = bench.positions[0, 2] + bench.velocities[0, 2] ** 2 / (2 * G)
            speed = after
            exact, stiff = radius + after**2 / (2 * G), radius + (height - radius) * e ** (2 * n)
            allowed = n * 4 * (math.pi / 100) ** 2 * (exact - radius)
            rows.append(
                Row(
                    f"k = {k:.0e} N/m: top of bounce {n} [m]",
                    exact,
                    "closed form with the weight during the contact",
                    apex,
                    allowed,
                    why,
                )
            )
            limit = "closed form of the stiff limit, MFiX V&V manual"
            rows.append(
                Row(
                    f"k = {k:.0e} N/m: top of bounce {n} [m]",
                    stiff,
                    limit,
                    apex,
                    abs(exact - stiff) + allowed,
                    "what the weight does during the contact, closed form; and the same",
                )
            )
    return rows


def dem03() -> list[Row]:
    """Two spheres of different density, squeezed between floor and ceiling."""
    rp, k = 5e-4, 1e3
    densities, top = (20000.0, 10000.0), 3.6 * 5e-4
    m1, m2 = (sphere_mass(rp, density) for density in densities)
    ceiling = Surface("ceiling", SurfaceKind.PLANE, 0, 0, (0.0, 0.0, top), np.diag([1.0, -1.0, -1.0]))
    rows = []
    for e in (0.5, 0.7, 1.0):
        zeta = damping_ratio_from_restitution(e, False)
        c1, c2, c12 = (2 * zeta * math.sqrt(k * m) for m in (m1, m2, m1 * m2 / (m1 + m2)))
        matrix = np.array(
            [
                [0, 0, 1, 0],
                [0, 0, 0, 1],
                [-2 * k / m1, k / m1, -(c1 + c12) / m1, c12 / m1],
                [k / m2, -2 * k / m2, c12 / m2, -(c2 + c12) / m2],
            ]
        )
        load = np.array([0, 0, -G - k * rp / m1, -G + (k * (top - rp) + 2 * k * rp) / m2])
        rest = -np.linalg.solve(matrix, load)
        begin = np.array([0.25 * top, 0.75 * top, 0, 0])
        dt = contact_time(k, m1 * m2 / (m1 + m2), 0.0, False) / 400
        numbers = pair(k, zeta)
        bench = Bench(
            [[0, 0, 0.25 * top], [0, 0, 0.75 * top]],
            {(0, 0): numbers, (0, 1): numbers, (1, 1): numbers},
            dt,
            [FLOOR, ceiling],
            rp,
            densities,
            gravity=DOWN,
            materials=np.array([0, 1]),
        )
        pairs, end = [], 10e-3
        while bench.time < end:
            bench.step(50)
            exact = rest + expm(matrix * bench.time) @ (begin - rest)
            pairs += list(zip(exact[:2], bench.positions[:, 2], strict=True))
        # the phase of the fastest mode, w^2 = 3 k/m, is wrong by (w dt)^2/24; tested over 10 ms of at most
        # the first swing
        w = math.sqrt(3 * k / m2)
        allowed = 0.1 * rp * (w * dt) ** 2 / 24 * w * end
        rows.append(
            largest(
                f"e = {e}: heights over 10 ms [m]",
                pairs,
                SOURCE + "; Chen et al. 2007",
                allowed,
                "phase (w dt)^2/24 of the fast mode, 10 % of a radius",
            )
        )
    return rows


def dem04() -> list[Row]:
    """A sliding sphere comes to roll."""
    rows = []
    radius, density, k, u0 = 0.01, 2600.0, 1e5, 1.0
    mass = sphere_mass(radius, density)
    zeta = damping_ratio_from_restitution(0.5, False)
    dt = contact_time(k, mass, zeta, False) / 40
    sag = mass * G / k
    for mu in (0.2, 0.3, 0.6):
        bench = Bench(
            [0, 0, radius - sag],
            pair(k, zeta, friction=mu),
            dt,
            [FLOOR],
            radius,
            (density,),
            gravity=DOWN,
            velocities=[u0, 0, 0],
        )
        slides = 2 * u0 / (7 * mu * G)
        bench.step(round(slides / dt))
        # friction sets in with the stretching of its spring, mu sag in length; half an overlap at the arm; a
        # substep
        late = mu * sag / u0 + dt
        why = "the spring of friction is stretched by mu m g/k first; half an overlap at the arm"
        rows.append(
            Row(
                f"mu = {mu}: way until it rolls [m]",
                12 * u0**2 / (49 * mu * G),
                SOURCE,
                bench.positions[0, 0],
                2 * u0 * late,
                why,
            )
        )
        bench.step(round(0.2 * slides / dt))
        swing = mu * G * math.sqrt(mass / k) + sag / radius * u0
        rows.append(
            Row(
                f"mu = {mu}: rolling speed [m/s]",
                5 / 7 * u0,
                SOURCE,
                bench.velocities[0, 0],
                swing,
                "the spring of friction goes on swinging",
            )
        )
        rows.append(
            Row(
                f"mu = {mu}: rolling spin [rad/s]",
                5 / 7 * u0 / radius,
                SOURCE,
                bench.spins[0, 1],
                2.5 * swing / radius,
                "the same, 5/2",
            )
        )
    return rows


CASES = {"MFiX DEM01": dem01, "MFiX DEM02": dem02, "MFiX DEM03": dem03, "MFiX DEM04": dem04}
