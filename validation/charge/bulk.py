"""Many particles: free cooling (Haff), pressure on a silo's floor (Janssen), discharge through an orifice
(Beverloo).
"""

import math

import numpy as np

from nutamill.charge.laws.oscillator import contact_time, damping_ratio_from_restitution
from nutamill.charge.walls.surface import Surface, SurfaceKind
from validation.charge.harness import DOWN, FLOOR, Bench, G, pair, sphere_mass
from validation.charge.rows import Row

UP, TURNED = np.eye(3), np.diag([1.0, -1.0, -1.0])
THREADS = 2


def plane(name, normal, distance, body=0, material=0) -> Surface:
    """Plane whose free side is along `normal` (an axis of the frame), through the point `distance` [m] along
    it.
    """
    normal = np.array(normal, float)
    first = np.roll(normal, 1)
    return Surface(
        name,
        SurfaceKind.PLANE,
        body,
        material,
        tuple(distance * normal),
        np.column_stack([first, np.cross(normal, first), normal]),
    )


def haff() -> list[Row]:
    """Smooth inelastic spheres in a smooth elastic box lose their speed as T = T0/(1 + t/tau)^2."""
    n, d, density, phi, e, k = 4096, 0.01, 1000.0, 0.05, 0.9, 1e5
    mass = sphere_mass(d / 2, density)
    side = (n * math.pi * d**3 / 6 / phi) ** (1 / 3)
    # the room of the centres is what counts: walls keep them half a diameter away
    half = (side + d) / 2
    walls = [plane(f"{a}{s}", np.eye(3)[a] * s, -half, material=1) for a in range(3) for s in (1.0, -1.0)]
    rng = np.random.default_rng(5)
    m = round(n ** (1 / 3))
    grid = (np.stack(np.meshgrid(*[np.arange(m)] * 3), -1).reshape(-1, 3) + 0.5) * side / m - side / 2
    v = rng.normal(size=(n, 3))
    v -= v.mean(axis=0)
    v *= math.sqrt(3 * n / (v**2).sum())  # T0 = m (1 m/s)^2
    zeta = damping_ratio_from_restitution(e, False)
    dt = contact_time(k, mass / 2, zeta, False) / 25
    numbers = {(0, 0): pair(k, zeta), (0, 1): pair(k)}
    bench = Bench(
        grid, numbers, dt, walls, d / 2, (density, density), velocities=v, threads=THREADS, precision="single"
    )
    # a lattice is not a gas: it is let mix for one flight time before the clock starts; the temperature then
    # is T0
    chi = (1 - phi / 2) / (1 - phi) ** 3
    number = n / side**3
    # at a wall there are neighbours on one side only: two points of a cube are a distance d apart less often
    # than in endless space
    fewer = 1 - 1.5 * d / side + 2 / math.pi * (d / side) ** 2

    def collision_rate(temperature):
        return 4 * fewer * number * d * d * chi * math.sqrt(math.pi * temperature)

    bench.step(round(2.0 / collision_rate(1.0) / dt))
    t0 = float((bench.velocities**2).sum() / (3 * n))
    tau = 6 / ((1 - e * e) * collision_rate(t0))
    rows = []
    for part, expected in ((1, 0.25), (2, 1 / 9)):
        bench.step(round(tau / dt))
        t = float((bench.velocities**2).sum() / (3 * n)) / t0
        # contacts last: each impact takes half a contact time from the flight between two of them
        late = 2 * 0.5 * contact_time(k, mass / 2, zeta, False) * collision_rate(t0)
        noise = 3 * 2 * math.sqrt(2 / (3 * n))
        why = (
            f"3 standard deviations of the temperature of {n} spheres, contacts that last "
            f"({100 * late:.1f} %), and 2 % for Enskog's factor"
        )
        rows.append(
            Row(
                f"T/T0 after {part} tau ({part * tau:.3f} s) [1]",
                expected,
                "Haff 1983; van Noije and Ernst 1998",
                t,
                expected * (noise + late + 0.02),
                why,
            )
        )
    return rows


SILO_D, SILO_PARTICLE = 0.050, 0.005


def filled_silo(diameters: float, seed: int, walls, numbers, dt, density, d, room, grid_step=1.05) -> Bench:
    """Spheres of 0.9 to 1.1 `d` rained into the silo; `room` (x, y) -> inside, heights from 0 up."""
    rng = np.random.default_rng(seed)
    layer = np.arange(-15, 16) * grid_step * 1.1 * d
    x, y = (a.ravel() for a in np.meshgrid(layer, layer))
    inside = room(x, y)
    x, y = x[inside], y[inside]
    layers = math.ceil(diameters / len(x))
    places = np.concatenate(
        [np.column_stack([x, y, np.full(len(x), (j + 0.6) * grid_step * 1.1 * d)]) for j in range(layers)]
    )[: round(diameters)]
    radii = 0.5 * d * rng.uniform(0.9, 1.1, len(places))
    places[:, :2] += rng.uniform(-0.01, 0.01, (len(places), 2)) * d
    speeds = rng.normal(size=places.shape) * 0.1
    return Bench(
        places,
        numbers,
        dt,
        walls,
        radii,
        (density,),
        ("linear", "displacement", "none"),
        DOWN,
        velocities=speeds,
        threads=THREADS,
        precision="single",
        domain=((0.0, 0.0, 0.0), 1.2),
    )


def janssen() -> list[Row]:
    """Weight on the floor of a silo whose wall is drawn up slowly, so that its friction is mobilised, against
    the filled mass.
    """
    d, radius, density, k, mu = SILO_PARTICLE, SILO_D / 2, 2500.0, 1e4, 0.5
    zeta = damping_ratio_from_restitution(0.3, True)
    numbers = pair(k, zeta, 2 / 7, cut=True, friction=mu)
    dt = contact_time(k, sphere_mass(d / 2, density) / 2, zeta, True) / 20
    walls = [FLOOR, Surface("wall", SurfaceKind.CYLINDER, 1, 0, size=(radius, 0.0, 0.0))]
    filled, carried, balance = [], [], []
    for count in (250, 500, 1000, 2000, 4000):
        bench = filled_silo(
            count, count, walls, numbers, dt, density, d, lambda x, y: np.hypot(x, y) < radius - 0.6 * d
        )
        bench.step(round(0.4 / dt))
        bench.motion[1, 9] = 0.01
        bench.step(round(0.1 / dt))
        steps = round(0.1 / dt)
        before = bench.velocities.copy()
        bench.step(steps)
        mass = bench.state.mass_props[1, : len(before)].sum()
        masses = np.empty(len(before))
        masses[bench.state.ids[: len(before)]] = bench.state.mass_props[1, : len(before)]
        force = bench.wrenches[:, 2]
        change = (masses @ (bench.velocities - before))[2] / (steps * dt)
        filled.append(mass)
        carried.append(-force[0] / G)
        balance.append(abs(mass * G + force.sum() + change) / (mass * G))
    filled, carried = np.array(filled), np.array(carried)
    # one parameter, the saturation mass: least squares on a fine grid
    trials = np.linspace(0.2, 5.0, 4801) * carried.max()
    misfits = [((carried - m * (1 - np.exp(-filled / m))) ** 2).sum() for m in trials]
    saturation = trials[int(np.argmin(misfits))]
    explained = 1 - min(misfits) / ((carried - carried.mean()) ** 2).sum()
    bulk = 0.6 * density
    pressure_ratio = bulk * math.pi / 4 * SILO_D**2 * SILO_D / (4 * mu * saturation)
    source = "Janssen 1895; Vanel and Clement 1999"
    listed = ", ".join(f"{m:.3f}: {c:.3f}" for m, c in zip(filled, carried, strict=True))
    return [
        Row(
            "variance that M_sat (1 - exp(-M/M_sat)) explains [1]",
            1.0,
            source,
            explained,
            0.02,
            f"kg filled: kg on the floor: {listed}",
        ),
        Row(
            "ratio of horizontal to vertical stress [1]",
            0.8,
            source,
            pressure_ratio,
            0.4,
            "granular solids at a rough wall: 0.4 to 1.2; 60 % solids taken",
        ),
        Row(
            "weight, floor and wall force: largest imbalance over weight [1]",
            0.0,
            "Newton's second law",
            max(balance),
            1e-5,
            "single precision of the contact forces",
        ),
    ]


def beverloo() -> list[Row]:
    """Discharge of a square, flat-bottomed silo through square orifices: mass per time grows with (D - k
    d)^(5/2).
    """
    d, density, k, mu = SILO_PARTICLE, 2500.0, 5e3, 0.5
    zeta = damping_ratio_from_restitution(0.5, True)
    numbers = pair(k, zeta, 2 / 7, cut=True, friction=mu)
    dt = contact_time(k, sphere_mass(d / 2, density) / 2, zeta, True) / 20
    half, count, depth = 10 * d, 5000, 0.010
    sides = [plane(f"{a}{s}", np.eye(3)[a] * s, -half) for a in range(2) for s in (1.0, -1.0)]
    bed = filled_silo(
        count,
        1,
        [FLOOR, *sides],
        numbers,
        dt,
        density,
        d,
        lambda x, y: np.maximum(abs(x), abs(y)) < half - 0.6 * d,
    )
    bed.step(round(0.4 / dt))
    radii = np.empty(count)
    radii[bed.state.ids[:count]] = bed.state.mass_props[0, :count]
    catch = Surface("catch", SurfaceKind.PLANE, 0, 0, (0.0, 0.0, -0.35))
    openings, rates, steady = np.array([6.0, 7.0, 8.0, 9.0, 10.0]), [], []
    for opening in openings:
        b = opening * d / 2
        middle = (half + d + b) / 2
        plates = [
            Surface("left", SurfaceKind.BOX, 0, 0, (-middle, 0, -depth), size=(middle - b, half + d, depth)),
            Surface("right", SurfaceKind.BOX, 0, 0, (middle, 0, -depth), size=(middle - b, half + d, depth)),
            Surface("front", SurfaceKind.BOX, 0, 0, (0, -middle, -depth), size=(half + d, middle - b, depth)),
            Surface("back", SurfaceKind.BOX, 0, 0, (0, middle, -depth), size=(half + d, middle - b, depth)),
        ]
        silo = Bench(
            bed.positions,
            numbers,
            dt,
            [catch, *sides, *plates],
            radii,
            (density,),
            gravity=DOWN,
            threads=THREADS,
            precision="single",
            domain=((0.0, 0.0, 0.0), 0.6),
        )
        masses = density * 4 / 3 * math.pi * radii**3
        times, out = [], []
        while len(out) < 2 or out[-1] < 0.45 * masses.sum():
            silo.step(round(0.01 / dt))
            times.append(silo.time)
            out.append(masses[silo.positions[:, 2] < -2 * depth].sum())
        times, out = np.array(times), np.array(out)
        flowing = out > 0.08 * masses.sum()
        times, out = times[flowing], out[flowing]
        rates.append(np.polyfit(times, out, 1)[0])
        middle = len(out) // 2
        first, last = (
            np.polyfit(times[part], out[part], 1)[0] for part in (slice(None, middle), slice(middle, None))
        )
        steady.append(last / first - 1)
    # exponent 5/2 with k left open: (rate)^(2/5) is linear in the opening
    slope, zero = np.polyfit(openings, np.array(rates) ** 0.4, 1)
    k_fit = -zero / slope
    exponent = np.polyfit(np.log(openings - 1.4), np.log(rates), 1)[0]
    c = slope**2.5 / (0.6 * density * math.sqrt(G) * d**2.5)
    source = "Beverloo, Leniger and van de Velde 1961; Nedderman 1992"
    listed = ", ".join(f"{o:.0f}: {r:.4f}" for o, r in zip(openings, rates, strict=True))
    return [
        Row(
            "exponent of (D - 1.4 d) [1]",
            2.5,
            source,
            exponent,
            0.15,
            f"scatter of discharge experiments; D/d: kg/s {listed}",
        ),
        Row("k of (D - k d)^(5/2), fitted [1]", 1.6, source, k_fit, 0.6, "1 to 2.2 are reported"),
        Row(
            "coefficient C over the square's side, fitted [1]",
            0.58 * 4 / math.pi,
            source,
            c,
            0.2,
            "0.55 to 0.65 of a round orifice, times 4/pi for the area; 60 % solids",
        ),
        Row(
            "rate of the second half over the first, less 1, mean of openings [1]",
            0.0,
            source,
            float(np.mean(steady)),
            0.05,
            "counts of particles; independent of the height of the fill",
        ),
    ]


CASES = {"Haff": haff, "Janssen": janssen, "Beverloo": beverloo}
