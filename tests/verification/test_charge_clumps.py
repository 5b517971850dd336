"""Rigid clumps: free rotation, impacts, conservation, and the same answers as spheres where a clump is
one.
"""

import numpy as np
import pytest
from charge_bench import FLOOR, Bench, law
from scipy.integrate import solve_ivp

from nutamill.charge.face import Charge
from nutamill.charge.kernels.copying import copy_state
from nutamill.charge.model import Ledger
from nutamill.charge.particles.particles import Particles, clumps
from nutamill.charge.particles.shapes import clump_shape, sphere_shape
from nutamill.charge.pebbles import rotation_matrices

DENSITY = 2480.0
GRAIN = clump_shape([[0, 0, 0], [0.001, 0, 0], [0.0004, 0.0009, 0]], [0.001, 0.0009, 0.0008])
DUMBBELL = clump_shape([[-0.002, 0, 0], [0.002, 0, 0]], [0.0025, 0.0025])
UPRIGHT = [1.0, 0.0, 0.0, 0.0]


class ClumpBench(Charge):
    """Clumps of one shape, without gravity and in double precision by default."""

    def __init__(
        self,
        shape,
        centre,
        dt,
        pair_law=None,
        attitude=None,
        surfaces=(),
        gravity=(0.0, 0.0, 0.0),
        scale=None,
        precision="double",
        **options,
    ):
        centre = np.atleast_2d(np.array(centre, float))
        n = len(centre)
        sizes = np.full(n, shape.equivalent_diameter) if scale is None else scale
        attitude = np.tile(UPRIGHT, (n, 1)) if attitude is None else np.asarray(attitude, float)
        particles = clumps([shape], sizes).placed(centre, attitude)
        self.mass = particles.mass([DENSITY])
        pair_law = law() if pair_law is None else pair_law
        super().__init__(
            particles,
            [DENSITY],
            pair_law,
            surfaces,
            dt=dt,
            gravity=gravity,
            precision=precision,
            **options,
        )


def free_spin(inertia, spin, time):
    """Spin in body axes [rad/s] after `time` without a moment: Euler's equations, to 1e-12."""
    i1, i2, i3 = inertia

    def rate(_, w):
        return [(i2 - i3) / i1 * w[1] * w[2], (i3 - i1) / i2 * w[2] * w[0], (i1 - i2) / i3 * w[0] * w[1]]

    return solve_ivp(rate, (0, time), spin, rtol=1e-12, atol=1e-12, method="DOP853").y[:, -1]


def test_free_clump_tumbles_as_euler_says_with_second_order():
    spin, time = np.array([30.0, 200.0, 20.0]), 0.02
    expected = free_spin(GRAIN.inertia, spin, time)
    errors = []
    for n in (500, 1000):
        bench = ClumpBench(GRAIN, [0, 0, 0], time / n, spins=[spin], velocities=[[0.1, 0, 0]]).step(n)
        rotation = rotation_matrices(bench.attitudes)[0]
        errors.append(np.abs(rotation.T @ bench.spins[0] - expected).max())
    # a step of 200 rad/s x 2e-5 s turns by 4e-3 rad: its square is 1.6e-5 of 200 rad/s, 80 steps of memory at
    # most
    assert errors[1] < 200.0 * 1.6e-5 * 4
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)


def test_free_clump_keeps_its_angular_momentum():
    bench = ClumpBench(GRAIN, [0, 0, 0], 2e-5, spins=[[30.0, 200.0, 20.0]])
    before = bench.state.clumps[0, 6:9].copy()
    bench.step(2000)
    assert bench.state.clumps[0, 6:9] == pytest.approx(before, rel=1e-15)


def test_one_sphere_clump_moves_as_the_sphere():
    ball = law(k=1e5, zeta=0.1, friction=0.4)
    start_at, v, w = [0, 0, 0.0026], [0.3, 0.1, -0.5], [10.0, -20.0, 30.0]
    options = {"surfaces": [FLOOR], "gravity": (0.0, 0.0, -9.81)}
    sphere = Bench(start_at, ball, 1e-6, density=DENSITY, velocities=v, spins=w, **options).step(1500)
    # a charge of spheres alone takes another path, so a dumbbell flies along far away
    particles = Particles(
        (DUMBBELL, sphere_shape(0.005)), np.array([0, 1]), np.ones(2), np.zeros(2, np.int32)
    )
    placed = particles.placed(np.array([[0.1, 0.1, 0.1], start_at]), np.tile(UPRIGHT, (2, 1)))
    motion = np.array([np.zeros(3), v]), np.array([np.zeros(3), w])
    v, w = motion
    both = Charge(placed, [DENSITY], ball, [FLOOR], dt=1e-6, velocities=v, spins=w, precision="double").step(
        1500
    )
    # rotation goes through a quaternion: round-off of 1500 substeps
    assert both.positions[1] == pytest.approx(sphere.positions[0], abs=1e-12)
    assert both.velocities[1] == pytest.approx(sphere.velocities[0], abs=1e-10)
    assert both.spins[1] == pytest.approx(sphere.spins[0], abs=1e-8)


def test_dumbbell_that_lands_flat_bounces_as_one_body_on_two_springs():
    k, v = 1e5, 0.5
    bench = ClumpBench(DUMBBELL, [0, 0, 0.002501], 1e-6, law(k=k), surfaces=[FLOOR], velocities=[[0, 0, -v]])
    mass = bench.mass[0]
    overlap = v * np.sqrt(mass / (2 * k))
    contact = np.pi * np.sqrt(mass / (2 * k))
    bench.step(round((0.5 * contact + 1e-6 / v) / 1e-6))
    # the sampled maximum of a cosine: off by at most half the square of half a step's phase
    assert bench.state.largest_overlap[1] * 0.005 == pytest.approx(
        overlap, rel=0.5 * (np.pi * 1e-6 / contact) ** 2 + 1e-3
    )
    bench.step(round(contact / 1e-6))
    assert bench.velocities[0] == pytest.approx([0, 0, v], abs=2e-4 * v)
    assert np.abs(bench.spins).max() < 1e-6


def test_dumbbell_hit_at_one_end_leaves_with_the_spin_of_a_free_rod():
    # frictionless impact at one pebble, normal through its centre: impulse J = 2 v / (1/m + c^2/I) for an
    # elastic bounce
    k, v, tilt = 1e7, 0.5, 0.3
    attitude = [np.cos(-tilt / 2), 0.0, np.sin(-tilt / 2), 0.0]
    centre = 0.0025 + 0.002 * np.sin(tilt) + 1e-7
    shape = DUMBBELL
    bench = ClumpBench(
        shape, [0, 0, centre], 2e-8, law(k=k), attitude=[attitude], surfaces=[FLOOR], velocities=[[0, 0, -v]]
    )
    rotation = rotation_matrices(np.array([attitude]))[0]
    ends = shape.offsets @ rotation.T
    low = ends[np.argmin(ends[:, 2])]
    inertia = rotation @ np.diag(shape.inertia * DENSITY) @ rotation.T
    arm = np.cross(low, [0, 0, 1.0])
    yielding = 1 / bench.mass[0] + arm @ np.linalg.solve(inertia, arm)
    impulse = 2 * v / yielding
    spin = np.linalg.solve(inertia, impulse * arm)
    contact = np.pi * np.sqrt(1 / (yielding * k))
    bench.step(round((1e-7 / v + 1.5 * contact) / 2e-8))
    # the rod turns during the contact by spin x contact, which moves the arm by that share
    share = np.linalg.norm(spin) * contact
    assert share < 0.02
    assert bench.spins[0] == pytest.approx(spin, abs=share * np.linalg.norm(spin))
    assert bench.velocities[0, 2] == pytest.approx(-v + impulse / bench.mass[0], abs=share * v)


def cloud(precision="double"):
    """343 grains that fly together, tumbling."""
    rng = np.random.default_rng(3)
    side = 7
    centre = (np.stack(np.meshgrid(*[np.arange(side)] * 3), -1).reshape(-1, 3) - 3) * 0.0031
    attitude = rng.normal(size=(side**3, 4))
    attitude /= np.linalg.norm(attitude, axis=1)[:, None]
    motion = {
        "velocities": rng.normal(size=centre.shape) * 0.3 - 40 * centre,
        "spins": rng.normal(size=centre.shape) * 100,
    }
    pair = law(k=1e4, zeta=0.1, friction=0.5, rolling=0.01)
    return ClumpBench(
        GRAIN, centre, 1e-6, pair, attitude, precision=precision, domain=((0, 0, 0), 0.5), **motion
    )


def moments(bench):
    """Momentum, angular momentum about the origin, kinetic energy."""
    clump = bench.state.clumps[np.argsort(bench.state.clumps[:, 18])]
    x, v = bench.positions, bench.velocities
    momentum = clump[:, 13, None] * v
    return (
        momentum.sum(axis=0),
        (np.cross(x, momentum) + clump[:, 6:9]).sum(axis=0),
        bench.reading().energy[:2].sum(),
    )


def test_cloud_of_clumps_keeps_momentum_and_closes_its_ledger():
    bench = cloud().step(1)
    scale = (bench.mass[:, None] * np.abs(bench.velocities)).sum()
    p, h, energy = moments(bench)
    ledger = bench.state.ledger.copy()
    for _ in range(8):
        bench.step(250)
    p_end, h_end, energy_end = moments(bench)
    # the positions the law sees are rounded to 1e-18 of the domain in double precision: only sums are left to
    # round
    assert np.abs(p_end - p).max() < 1e-12 * scale
    assert np.abs(h_end - h).max() < 1e-12 * scale * 0.03
    assert energy - energy_end > 0.05 * energy
    assert (bench.state.ledger - ledger).sum() == pytest.approx(energy_end - energy, abs=1e-10 * energy)
    # what predicted velocities and the scheme of rotation miss is of second order in the substep
    assert abs(bench.state.ledger[Ledger.SCHEME]) < 1e-3 * energy


def test_pebbles_of_one_clump_never_touch_each_other():
    bench = ClumpBench(GRAIN, [0, 0, 0], 1e-6, spins=[[100.0, 50.0, 0]]).step(500)
    assert bench.reading().contacts[0] == 0
    assert bench.state.largest_overlap[0] == 0


def test_clumps_have_the_same_bits_on_any_number_of_threads_and_after_a_copy():
    one, two = cloud("single"), cloud("single")
    two.threads = 2
    for _ in range(4):
        one.step(200)
        two.step(200)
    for name in ("x", "v", "published_rows", "clumps", "ledger", "ids"):
        assert np.array_equal(getattr(one.state, name), getattr(two.state, name)), name
    copy = cloud("single")
    copy_state(one.state, copy.state, 0, 1)
    one.step(150)
    copy.step(150)
    assert np.array_equal(one.state.clumps, copy.state.clumps)
