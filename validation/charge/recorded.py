"""Numbers that other codes keep of their own runs: LAMMPS (unittest/granular) and MercuryDPM
(Drivers/Papers/OSBenchmark, self-tests).
"""

import math

from nutamill.charge.laws.oscillator import contact_time, damping_ratio_from_restitution
from validation.charge.closed_forms import hertz, hertz_mindlin, modulus, oblique, shear_modulus
from validation.charge.harness import DOWN, FLOOR, SAMPLES, Bench, follow, pair, sphere_mass, strike_floor
from validation.charge.rows import Row

LAMMPS = "LAMMPS unittest/granular/tests"


def lammps_linear() -> list[Row]:
    """Linear law: head on, falling, oblique, sliding to rolling."""
    rows = []
    radius, density, k, e = 0.0025, 2700.0, 1e6, 0.5
    mass = sphere_mass(radius, density)
    zeta = damping_ratio_from_restitution(e, False)
    dt = contact_time(k, mass / 2, zeta, False) / SAMPLES
    x = [[-radius - 6e-6, 0, 0], [radius + 6e-6, 0, 0]]
    bench = Bench(
        x, pair(k, zeta), dt, radius=radius, densities=(density,), velocities=[[2, 0, 0], [-2, 0, 0]]
    )
    got = follow(bench, (1, 0, 0), mass, 2 * radius, 4 * SAMPLES)
    rows.append(
        Row(
            "dem01-hooke-twosphere: velocity afterwards [m/s]",
            -0.99932937926762544,
            LAMMPS,
            got.v[0, 0],
            1e-3,
            "their own distance from the closed form, 1 m/s, 7e-4, and the ends of our dashpot",
        )
    )
    radius, density, k, height = 0.1, 2600.0, 1e4, 0.5
    mass = sphere_mass(radius, density)
    # gamma = 10/s is mass-weighted: c = gamma m
    zeta = 10.0 * mass / (2 * math.sqrt(k * mass))
    bench = Bench([0, 0, height], pair(k, zeta, stop=2.0), 1e-4, [FLOOR], radius, (density,), gravity=DOWN)
    bench.step(2500)
    rows.append(
        Row(
            "dem01-hooke-3d: height after 0.25 s [m]",
            0.19343750000000071,
            LAMMPS,
            bench.positions[0, 2],
            1e-9,
            "free fall is exact",
        )
    )
    bench.step(1500)
    error = (math.sqrt(k / mass) * 1e-3) ** 2 / 8
    why = "their step of 1 ms: (w dt)^2/8 of the speed at touch, and half a step of the dashpot"
    rows.append(
        Row(
            "dem01-hooke-3d: height after 0.4 s [m]",
            9.8142846897904992e-02,
            LAMMPS,
            bench.positions[0, 2],
            2.8 * (2 * error + 10 * 0.5e-3) * 0.11,
            why,
        )
    )
    rows.append(
        Row(
            "dem01-hooke-3d: velocity after 0.4 s [m/s]",
            1.4883590261689112,
            LAMMPS,
            bench.velocities[0, 2],
            2.8 * (2 * error + 10 * 0.5e-3),
            why,
        )
    )
    radius, density, k, k_t, e, mu = 0.0025, 2700.0, 2e7, 5.7e6, 0.98, 0.092
    mass = sphere_mass(radius, density)
    zeta = damping_ratio_from_restitution(e, False)
    time = contact_time(k, mass, zeta, False)
    got = strike_floor(radius, density, pair(k, zeta, k_t / k, friction=mu), time, 2.9876, 2.5069)
    for what, theirs, ours in (
        ("v_n' [m/s]", 2.9278279037320356, got.v[0, 2]),
        ("v_t' [m/s]", 1.9626463236052916, got.v[0, 0]),
        ("spin' [rad/s]", 5.4425367639471085e02, got.w[0, 1]),
    ):
        # their friction turns the sphere with its radius, ours with half an overlap less
        arm = 0.5 * 2.9876 * math.sqrt(mass / k) / radius if what[0] == "s" else 0.0
        why = (
            "their step, 1/240 of the contact; they take the radius for the arm of friction at a wall, "
            "we half an overlap less"
        )
        rows.append(
            Row(f"dem04-hookehistory-oblique: {what}", theirs, LAMMPS, ours, (1e-3 + arm) * theirs, why)
        )
    radius, density, k, k_t, mu, g = 0.0025, 2700.0, 1e4, 2.8e3, 0.4, 1.0
    mass = sphere_mass(radius, density)
    bench = Bench(
        [0, 0, 0.002499982],
        pair(k, 0.0, k_t / k, friction=mu),
        1e-5,
        [FLOOR],
        radius,
        (density,),
        gravity=(0, 0, -g),
        velocities=[1, 0, 0],
        domain=((0, 0, 0), 1.0),
    )
    records = (
        (2.3750050906720896e-01, 9.0000137227135268e-01, 9.9998627728646241e01),
        (4.5000101847256818e-01, 8.0000302069740337e-01, 1.9999697930258714e02),
    )
    swing = mu * g * math.sqrt(mass / k_t)
    for n, (place, speed, spin) in enumerate(records, 1):
        bench.step(25000)
        # the wall of theirs is sampled a step later: friction acts a step longer
        rows.append(
            Row(
                f"dem05-hookehistory-slip, {n}: way [m]",
                place,
                LAMMPS,
                bench.positions[0, 0],
                5e-6,
                "their first steps of friction, 1e-5 s x 0.4 m/s2 over the run",
            )
        )
        rows.append(
            Row(
                f"dem05-hookehistory-slip, {n}: speed [m/s]",
                speed,
                LAMMPS,
                bench.velocities[0, 0],
                2e-5,
                "the same, and their undamped bounce on the floor, 2e-6 m/s",
            )
        )
        rows.append(
            Row(
                f"dem05-hookehistory-slip, {n}: spin [rad/s]",
                spin,
                LAMMPS,
                bench.spins[0, 1],
                2.5 * 2e-5 / radius,
                "the same, 5/2",
            )
        )
    bench.step(25000)
    rows.append(
        Row(
            "dem05-hookehistory-slip, 3: speed [m/s]",
            7.1424033326038117e-01,
            LAMMPS,
            bench.velocities[0, 0],
            2 * swing,
            "both springs go on swinging about 5/7, undamped, each in its own phase",
        )
    )
    return rows


def lammps_mindlin() -> list[Row]:
    """Hertz and Mindlin on a wall of the same material."""
    rows = []
    radius, density, young, nu, mu, e, v_n = 0.0025, 2700.0, 7e10, 0.33, 0.092, 0.98, 2.9876
    mass = sphere_mass(radius, density)
    e_star, g_star = modulus((young, nu), (young, nu)), shear_modulus((young, nu), (young, nu))
    zeta = damping_ratio_from_restitution(e, False)
    time = hertz(mass, radius, e_star, v_n).time
    numbers = pair(modulus=e_star, shear_modulus=g_star, zeta=zeta, friction=mu)
    for case, v_t, recorded in (
        ("dem04-mindlin-sticking", 0.5, (2.9278423105668629, 3.4437890244522057e-01, 1.5562109755477954e02)),
        (
            "dem04-mindlin-oblique-lowvt",
            2.29,
            (2.9278423105668629, 1.7457443950640865, 5.4425560493591468e02),
        ),
    ):
        got = strike_floor(radius, density, numbers, time, v_n, v_t, law=("hertz", "displacement", "none"))
        spring = hertz_mindlin(mass, radius, e_star, g_star, zeta, False)
        _, u, w = oblique(mass, radius, v_n, v_t, 0.0, mu, spring, "displacement", time / SAMPLES / 10)
        # LAMMPS has a tangential dashpot of half the normal one; it takes part in what sticks, not in what
        # slides
        damped = 2 * 0.5 * zeta * v_t if v_t < 1.0 else 0.0
        arm = 0.5 * hertz(mass, radius, e_star, v_n).overlap / radius
        why = (
            "their step, 1e-3; they take the radius for the arm of friction at a wall, we half an "
            "overlap less; their tangential dashpot"
            " of half the normal one takes zeta v_t where the contact sticks"
        )
        for what, theirs, ours, share in (
            ("v_n' [m/s]", recorded[0], got.v[0, 2], 0.0),
            ("v_t' [m/s]", recorded[1], got.v[0, 0], damped),
            ("spin' [rad/s]", recorded[2], got.w[0, 1], 2.5 * damped / radius + arm * recorded[2]),
        ):
            rows.append(Row(f"{case}: {what}", theirs, LAMMPS, ours, 1e-3 * theirs + share, why))
        rows.append(
            Row(
                f"{case}: v_t' [m/s]",
                u,
                "the same rule integrated with steps 10 times smaller",
                got.v[0, 0],
                1e-3,
                "dashpot's ends, stick and slip met in substeps",
            )
        )
        rows.append(
            Row(
                f"{case}: spin' [rad/s]",
                w,
                "the same rule integrated with steps 10 times smaller",
                got.w[0, 1],
                2.5e-3 / radius,
                "the same, 5/2",
            )
        )
    radius, density, v = 0.0025, 7000.0, 3.9
    # their constant 4/3 E* on the wall: F = 7.11111e10 sqrt(R) d^1.5
    e_star = 0.75 * 7.11111e10
    exact = hertz(sphere_mass(radius, density), radius, e_star, v)
    got = strike_floor(
        radius, density, pair(modulus=e_star), exact.time, v, law=("hertz", "displacement", "none")
    )
    rows.append(
        Row(
            "dem03-hertz-peak-wall: largest overlap [m]",
            0.0025 - 2.4773193520144258e-03,
            LAMMPS,
            got.overlap,
            1e-4 * exact.overlap,
            "their sample is at 9e-4 m/s from the turn: 3e-8 of the overlap; both steps, second order",
        )
    )
    rows.append(
        Row("dem03-hertz-peak-wall: speed afterwards [m/s]", 3.9, LAMMPS, got.v[0, 2], 1e-4 * 3.9, "elastic")
    )
    return rows


def mercury() -> list[Row]:
    """MercuryDPM's self-tests of the benchmark of Dosta et al. 2024: a normal impact, and a sphere that slips
    on a wall.
    """
    source = "MercuryDPM, OSHertzSelfTest and OSMindlinSelfTest"
    radius, density, v, e = 1e-3, 2500.0, 1.0, 0.4
    e_star = modulus((1e9, 0.2), (210e9, 0.2))
    zeta = damping_ratio_from_restitution(e, False)
    dt = 5e-7
    numbers = pair(modulus=e_star, zeta=zeta)
    bench = Bench(
        [0, 0, radius + 1e-5],
        numbers,
        dt,
        [FLOOR],
        radius,
        (density,),
        ("hertz", "displacement", "none"),
        velocities=[0, 0, -v],
    )
    bench.step(121)
    why = "both steps: 65 a contact, the dashpot's start within half a step"
    rows = [
        Row("Hertz: speed afterwards [m/s]", 0.40107538, source, bench.velocities[0, 2], 5e-3 * 0.4, why),
        Row(
            "Hertz: height after 60.5 us [m]",
            0.00100724022,
            source,
            bench.positions[0, 2],
            5e-3 * 3.5e-5 * 0.4 + 0.4 * dt,
            why,
        ),
    ]
    density, mu, g = 7200.0, 0.2, 5.0
    numbers = pair(
        modulus=e_star, shear_modulus=shear_modulus((1e9, 0.2), (210e9, 0.2)), zeta=zeta, friction=mu
    )
    bench = Bench(
        [0, 0, radius],
        numbers,
        dt,
        [FLOOR],
        radius,
        (density,),
        ("hertz", "displacement", "none"),
        (g, 0.0, -g),
    )
    bench.step(10001)
    why = (
        "the first bounces on the floor, of a contact of Hertz that begins at no load, and the spring of "
        "friction: 1e-3"
    )
    rows += [
        Row(
            "Mindlin: velocity after 5 ms [m/s]",
            0.0200031142,
            source,
            bench.velocities[0, 0],
            1e-3 * 0.02,
            why,
        ),
        Row("Mindlin: spin after 5 ms [rad/s]", 12.4983210, source, bench.spins[0, 1], 1e-3 * 12.5, why),
    ]
    return rows


CASES = {"LAMMPS linear": lammps_linear, "LAMMPS Hertz-Mindlin": lammps_mindlin, "MercuryDPM": mercury}
