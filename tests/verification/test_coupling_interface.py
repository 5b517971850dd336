"""What passes between charge and walls: momentum, angular momentum and energy, and the bits of the
numbers.
"""

import numpy as np
import pytest
from coupled_bench import CoupledBench, G, Scheme, inside_of_a_box, law, sphere_mass

R = 0.0025
BALL = sphere_mass(R)
BOX = 0.05
HALF = 0.012
INERTIA = np.diag([1.5e-5, 2.0e-5, 2.5e-5])
"""Of the box [kg m^2]."""


def shaken(
    window,
    free=True,
    gravity=0.0,
    precision="double",
    scheme=Scheme.STAGGERED,
    zeta=0.1,
    friction=0.3,
    seed=5,
    n=2,
    **options,
):
    """Balls on an n x n x n grid with random velocities of about 0.5 m/s in a box that moves and turns."""
    random = np.random.default_rng(seed)
    grid = (np.arange(n) - (n - 1) / 2) * 2.3 * R
    places = np.stack(np.meshgrid(grid, grid, grid), axis=-1).reshape(-1, 3)
    half = max(HALF, grid[-1] + 1.5 * R)
    return CoupledBench(
        places,
        inside_of_a_box((half, half, half)),
        law(1e5, zeta, friction=friction, rolling=0.1),
        window,
        BOX,
        INERTIA,
        guided=not free,
        gravity=(0.0, 0.0, -gravity),
        box_velocity=(0.05, -0.1, 0.02) if free else (0.0, 0.0, 0.1),
        box_spin=(1.0, 2.0, -3.0) if free else (0.0, 0.0, 0.0),
        velocities=0.5 * random.standard_normal((n**3, 3)),
        spins=50 * random.standard_normal((n**3, 3)),
        precision=precision,
        scheme=scheme,
        **options,
    )


def momenta(bench):
    """Momentum [kg m/s] and angular momentum about the origin [kg m^2/s] of box and balls, and their scales
    (sums of sizes).
    """
    state, rotation = bench.system.state, bench.system.scratch.rotation[0]
    spin = rotation @ INERTIA @ rotation.T @ state.angular_velocity[0]
    parts = np.vstack([BALL * bench.v, BOX * state.velocity[:1]])
    turning = np.vstack(
        [
            np.cross(bench.x, BALL * bench.v) + 0.4 * BALL * R**2 * bench.w,
            np.cross(state.position[:1], parts[-1:]),
            spin[None],
        ]
    )
    return (
        parts.sum(axis=0),
        turning.sum(axis=0),
        np.linalg.norm(parts, axis=1).sum(),
        np.linalg.norm(turning, axis=1).sum(),
    )


SCHEMES = pytest.mark.parametrize("scheme", [Scheme.STAGGERED, Scheme.ITERATED])


@SCHEMES
def test_impulse_given_by_the_charge_is_the_impulse_received_by_the_box(scheme):
    # the wrench is the impulse over the window: each window loses two roundings of its own impulse
    bench = shaken(1e-5, scheme=scheme).march(3000)
    rounding = 2 * len(bench.rows) * np.finfo(float).eps * np.linalg.norm(bench.coupling.charge_impulse)
    assert np.linalg.norm(bench.coupling.charge_impulse) > 0.1 * BALL
    assert np.abs(bench.coupling.charge_impulse - bench.coupling.mechanism_impulse).max() < rounding


@SCHEMES
def test_momentum_of_a_free_box_with_balls_stays(scheme):
    # Newton's third law inside, no force outside: round-off of 3000 windows of 10 substeps, growing at most
    # as their number
    bench = shaken(1e-5, scheme=scheme)
    before, _, scale, _ = momenta(bench)
    after, _, _, _ = momenta(bench.march(3000))
    assert np.abs(after - before).max() < 30_000 * np.finfo(float).eps * scale


@SCHEMES
def test_angular_momentum_of_a_free_box_with_balls_stays(scheme):
    # Balls keep it exactly; the box takes a window's impulse along its own path, whose bend within a window
    # is the share m/M
    # of the balls' own: (m/M) (w0 dt)^2/24 of the share of the momentum that passes the interface (0.13).
    for window in (2e-5, 5e-6):
        bench = shaken(window, scheme=scheme)
        _, before, _, scale = momenta(bench)
        _, after, _, _ = momenta(bench.until(0.03))
        assert np.abs(after - before).max() / scale < 0.13 * 1e5 / BOX * window**2 / 24


@pytest.mark.parametrize("precision", ["single", "double"])
def test_momentum_of_the_charge_changes_by_weight_and_what_it_gives_the_walls(precision):
    # dP = m g t - J. Forces are rounded once for every contact a ball has at a time, six at most, each to
    # half an ulp of the
    # precision; all forces together carry the weight m g t and turn every momentum round a few times.
    bench = shaken(1e-5, free=False, gravity=G, stiffness=2e4, precision=precision)
    scale = momenta(bench)[2]
    start = (BALL * bench.v).sum(axis=0)
    bench.march(3000)
    weight = 8 * BALL * G * bench.system.time
    defect = (
        (BALL * bench.v).sum(axis=0) - start + bench.coupling.charge_impulse + np.array([0.0, 0.0, weight])
    )
    rounding = np.finfo(np.float32 if precision == "single" else float).eps / 2
    steps = 30_000 * np.finfo(float).eps * scale  # the sums over substeps are double in both
    assert np.abs(defect).max() < 6 * rounding * (weight + 4 * scale) + steps
    assert np.linalg.norm(bench.coupling.charge_impulse) > 0.5 * weight


@SCHEMES
def test_energy_of_box_spring_and_balls_is_accounted_for(scheme):
    # kinetic + potential + elastic - works of contacts and gravity + loss of the damper stays; a contact's
    # forces do their work
    # on the box at the velocities of the windows' ends instead of mid-substep: second order in the window
    residual = []
    for window in (2e-5, 5e-6):
        bench = shaken(window, free=False, gravity=G, stiffness=2e4, damping=2.0, scheme=scheme).until(0.03)
        kinetic = bench.read("charge_energy", "kinetic_translational")
        rotation = bench.read("charge_energy", "kinetic_rotational")
        stored = bench.read("mechanism_energy").sum(axis=1) + kinetic + rotation
        works = bench.contact_work() + bench.read("ledger", "gravity")
        total = stored + bench.read("bushing_loss", "spring") - works
        residual.append(np.abs(total - total[0]).max() / kinetic[0])
        assert -bench.contact_work()[-1] > 0.2 * kinetic[0]
    assert residual[0] < 1e-3
    assert np.log2(residual[0] / residual[1]) / 2 > 1.8


def state_bits(bench):
    """All that moves, as bytes: mechanism, particles by their id, coupling."""
    charge = bench.charge[1]
    arrays = [
        *bench.system.state,
        bench.x,
        bench.v,
        bench.w,
        charge.ledger,
        charge.impulse,
        bench.coupling.charge_impulse,
        bench.rows,
    ]
    return [np.ascontiguousarray(array).tobytes() for array in arrays]


@SCHEMES
def test_one_and_two_threads_give_the_same_bits(scheme):
    # 125 balls are two chunks, one for each thread
    one, two = (state_bits(shaken(1e-5, scheme=scheme, n=5).march(200, threads)) for threads in (1, 2))
    assert one == two


@SCHEMES
def test_the_same_march_repeats_bit_for_bit_and_in_pieces(scheme):
    # a window that is repeated leaves no trace of its first pass
    whole = state_bits(shaken(1e-5, scheme=scheme, n=3).march(600))
    bench = shaken(1e-5, scheme=scheme, n=3).march(250)
    rows = bench.rows
    bench.march(350)
    bench.rows = np.vstack([rows, bench.rows])
    assert state_bits(bench) == whole


def test_iterated_windows_need_few_passes():
    # the wrench reaches the walls' path through half a window's acceleration: m_ball/m_box (w0 dt)^2/2 = 4e-4
    # of an error is
    # left by each pass, and a contact's wrench of some 10 N moves the box by 10 nm: two repetitions reach the
    # tolerance of 1 pm
    bench = shaken(1e-5, scheme=Scheme.ITERATED).march(3000)
    assert bench.coupling.windows[0] < bench.coupling.passes[0] <= 3 * bench.coupling.windows[0]
