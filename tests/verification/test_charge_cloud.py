"""What a crowd of particles must keep: momentum, energy ledger, the same bits; and independent ways to its
forces.
"""

import numpy as np
import pytest
from charge_bench import FLOOR, Bench, law, sphere_mass

from nutamill.base.errors import StepError
from nutamill.charge.kernels.copying import copied, copy_state, state_arrays
from nutamill.charge.messages import status_text, status_time
from nutamill.charge.model import Clock, Ledger, Status
from nutamill.charge.walls.surface import Surface, SurfaceKind

R = 0.0025
M = sphere_mass(R)
BOX = (
    FLOOR,
    Surface("bore", SurfaceKind.CYLINDER, 0, 0, size=(0.02, 0, 0)),
    Surface("rib", SurfaceKind.BOX, 0, 0, origin=(0.02, 0, 0.01), size=(0.004, 0.004, 0.01)),
)


def cloud(n=200, surfaces=(), k=1e5, spread=1.0, seed=3, **options):
    """Random cloud on a loose lattice, thrown together at about 1 m/s."""
    rng = np.random.default_rng(seed)
    side = 6
    grid = np.array([[a, b, c] for c in range(60) for a in range(side) for b in range(side)], float)
    grid = grid[np.hypot(grid[:, 0] - 2.5, grid[:, 1] - 2.5) < 2.6][:n]
    x = (grid - [2.5, 2.5, 0.0]) * 2.1 * R + [0, 0, 1.2 * R] + rng.uniform(-0.04, 0.04, (n, 3)) * R
    x[:, 0] -= 0.002
    dt = options.pop("dt", 3e-6)
    options.setdefault("velocities", rng.normal(size=(n, 3)) * spread - 20.0 * (x - x.mean(axis=0)))
    options.setdefault("spins", rng.normal(size=(n, 3)) * 50.0)
    pair = options.pop("pair", law(k, 0.2, 0.8, friction=0.5, rolling=0.05))
    return Bench(x, pair, dt, surfaces, **options)


def angular_momentum(bench):
    x, v = bench.positions, bench.velocities
    return (M * np.cross(x, v) + 0.4 * M * R * R * bench.spins).sum(axis=0)


@pytest.mark.parametrize(("precision", "epsilon"), [("single", 2.0**-23), ("double", 2.0**-40)])
def test_isolated_cloud_keeps_momentum_and_angular_momentum(precision, epsilon):
    # action and reaction are the same number; a sum of a cloud's impulses is off by rounding, sqrt(steps) of
    # it at random
    bench = cloud(precision=precision)
    before, scale = bench.reading().momentum.copy(), M * np.abs(bench.velocities).sum()
    spin_before = angular_momentum(bench)
    bench.step(400)
    assert bench.reading().contacts[0] > 10
    assert bench.reading().momentum == pytest.approx(before, abs=8 * epsilon * scale)
    # positions enter at mid-substep and overlaps at half: arms are exact to the fixed-point grid and float32
    assert angular_momentum(bench) == pytest.approx(spin_before, abs=40 * epsilon * scale * 0.02 + 1e-12)


def test_energy_error_of_an_undamped_cloud_is_of_second_order():
    # a spring sampled at mid-substep is wrong by up to (w0 dt)^2/8 of the energy that goes through it, at
    # most all that moves;
    # frictionless, so that no tangential spring holds energy
    for part in (1, 2, 4):
        bench = cloud(60, dt=8e-6 / part, pair=law(1e5), spread=0.3)
        before = bench.reading().energy[:3].sum()
        bench.step(150 * part)
        after = bench.reading()
        assert after.contacts[0] > 5
        assert after.energy[:3].sum() == pytest.approx(before, abs=2e5 / M * bench.dt**2 / 8 * before)


def test_ledger_closes_to_rounding_in_kinetic_energy():
    # work of all contacts, of the surfaces' motion and of gravity is the change of kinetic energy: an
    # identity of the scheme
    bench = cloud(surfaces=BOX, gravity=(0, 0, -9.81))
    bench.motion[0, 7:13] = [0.1, 0.2, 0.0, 0.0, 0.0, 3.0]
    before = bench.reading().energy[:2].sum()
    bench.step(300)
    after = bench.reading()
    assert after.contacts[1] > 0
    assert bench.state.ledger.sum() == pytest.approx(after.energy[:2].sum() - before, abs=1e-10 * before)
    assert (
        bench.state.ledger[[Ledger.PAIR_NORMAL, Ledger.PAIR_TANGENTIAL, Ledger.WALL_TANGENTIAL]] < 0
    ).all()


def test_impulse_on_the_body_is_what_the_charge_lost():
    bench = cloud(surfaces=BOX, gravity=(0, 0, -9.81))
    before = bench.reading().momentum.copy()
    bench.step(300)
    fallen = np.array([0, 0, -9.81]) * M * 200 * 300 * bench.dt
    assert bench.state.impulse[0, :3] == pytest.approx(before + fallen - bench.reading().momentum, abs=1e-12)


@pytest.mark.parametrize("precision", ["single", "double"])
def test_two_threads_give_the_bits_of_one(precision):
    one = cloud(surfaces=BOX, gravity=(0, 0, -9.81), precision=precision).step(300)
    two = cloud(surfaces=BOX, gravity=(0, 0, -9.81), precision=precision, threads=2).step(300)
    for name in ("x", "v", "w", "impulse", "ledger", "largest_overlap"):
        assert getattr(one.state, name).tobytes() == getattr(two.state, name).tobytes(), name


def test_restored_window_repeats_the_same_bits():
    bench = cloud(surfaces=BOX, gravity=(0, 0, -9.81), precision="single").step(200)
    other = cloud(surfaces=BOX, gravity=(0, 0, -9.81), precision="single")
    copy_state(bench.state, other.state, 0, 1)
    bench.step(150)
    other.step(150)
    for name in ("x", "v", "w", "impulse", "ledger", "ids"):
        assert getattr(bench.state, name).tobytes() == getattr(other.state, name).tobytes(), name


@pytest.mark.parametrize("threads", [2, 3, 4])
def test_window_repeated_many_times_by_a_team_always_gives_the_bits_of_one_thread(threads):
    # a race shows as bits that change from time to time: a window with a rebuild of the list, from the same
    # state, 25 times
    bench = cloud(400, surfaces=BOX, gravity=(0, 0, -9.81), precision="single").step(100)
    start, rebuilds = copied(bench.state), bench.state.clock[Clock.REBUILDS]
    start = state_arrays(start)

    def again(n_threads):
        for name, array in state_arrays(bench.state).items():
            np.copyto(array, start[name])
        bench.threads = n_threads
        bench.step(60)
        return {
            name: array.tobytes()
            for name, array in state_arrays(bench.state).items()
            if name not in ("saved_memory", "saved_partners", "saved_starts")
        }

    one = again(1)
    assert bench.state.clock[Clock.REBUILDS] > rebuilds
    for _ in range(25):
        assert again(threads) == one


def test_window_goes_on_after_the_lists_have_grown():
    # one list made too small by hand stops the march; after `grow` the window ends with the bits of an
    # undisturbed one
    whole = cloud(surfaces=BOX, precision="single").step(100)
    bench = cloud(surfaces=BOX, precision="single")
    pairs = bench.state.pairs
    short = {name: getattr(pairs, name)[:, :, :160].copy() for name in ("partners", "owners", "memory")}
    bench.state = bench.state._replace(pairs=pairs._replace(**short))
    bench.step(100)
    assert bench.state.pairs.partners.shape[2] > 160
    assert bench.state.clock[Clock.STEP] == 100
    assert bench.state.x.tobytes() == whole.state.x.tobytes()


def test_candidates_hold_every_touching_pair_and_forces_are_those_of_all_pairs():
    # frictionless and undamped: accelerations from the definition, over all pairs, against one substep of the
    # engine
    k = 1e5
    bench = cloud(pair=law(k), spread=0.5).step(250)
    x = bench.state.x[:, :200].T.copy()
    v = bench.state.v[:, :200].T.copy()
    bench.step(1)
    gap = x[None] - x[:, None]
    distance = np.linalg.norm(gap, axis=2) + np.eye(200)
    overlap = np.maximum(2 * R - distance, 0.0) * (1 - np.eye(200))
    force = -(k * overlap / distance)[:, :, None] * gap
    assert (overlap > 0).sum() > 40
    got = (bench.state.v[:, :200].T - v) / bench.dt * M
    assert got == pytest.approx(force.sum(axis=1), abs=1e-9 * k * R)


def test_single_precision_forces_are_those_of_double():
    # float32 law on exact differences: overlaps to 2^-24 of a diameter or the fixed-point unit, k times that
    # a contact
    k = 5e5
    single = cloud(k=k, precision="single", dt=1e-6).step(1)
    double = cloud(k=k, precision="double", dt=1e-6).step(1)
    unit = max(2 * R * 2.0**-24, 1.0 / single.model.scale)
    assert (single.velocities - double.velocities) / 1e-6 * M == pytest.approx(0.0, abs=12 * 8 * k * unit)


def test_heap_at_rest_weighs_what_it_weighs():
    # after the fall has died away, bore, floor and rib together carry the weight; averaged over 1000 substeps
    still = {"velocities": np.zeros((80, 3)), "spins": np.zeros((80, 3))}
    bench = cloud(
        80, BOX, gravity=(0, 0, -9.81), pair=law(2e4, 0.4, friction=0.5, rolling=0.02), dt=1.5e-5, **still
    )
    bench.step(40000)
    kinetic = bench.reading().energy[:2].sum()
    bench.step(1000)
    weight = 80 * M * 9.81
    # what still moves changes the mean force by its momentum over the time
    moving = 2 * np.sqrt(2 * kinetic * 80 * M) / (1000 * bench.dt)
    assert -bench.state.impulse[0, 2] / (1000 * bench.dt) == pytest.approx(weight, abs=1e-3 * weight + moving)
    assert moving < 0.01 * weight


def test_too_deep_overlap_stops_with_the_names_of_the_particles():
    bench = Bench(
        [[0, 0, 0], [2.1 * R, 0, 0], [9 * R, 0, 0]],
        law(1e3, stop=0.05),
        1e-6,
        velocities=[[10, 0, 0], [-10, 0, 0], [0, 0, 0]],
    )
    with pytest.raises(StepError, match="overlap by 5") as stop:
        bench.step(500)
    assert bench.state.status[0] == Status.PAIR_OVERLAP
    assert sorted(bench.state.status[1:3]) == [0, 1]
    # 0.2 mm of gap at 20 m/s, then 5 % of the diameter: 17 to 25 substeps
    assert 10 < bench.state.status[3] < 30
    assert bench.state.largest_overlap[2] == pytest.approx(0.05, abs=0.02)
    # a spring of 1 kN/m has stopped next to nothing by then: they come at 10 m/s each, and close at 20 m/s;
    # in 5 % of the diameter
    # it takes k d^2/2 of the energy m_eff u^2/2, k d^2/(2 m_eff u^2) of the speed, and the velocity is
    # predicted for mid-substep
    lost = 1e3 * (0.07 * 2 * R) ** 2 / (M * 20.0**2)
    assert bench.state.halt_speeds == pytest.approx([10.0, 10.0, 20.0], rel=lost)
    message = str(stop.value)
    assert (
        "particles 0 and 1, at 10 and 10 m/s, overlap by 5." in message
        or "particles 1 and 0, at 10 and 10 m/s, overlap by 5." in message
    )
    assert "and close at 20 m/s. The substep is 1e-06 s. Shorten it or stiffen the contacts." in message
    # touch after 0.5 mm less one radius tenth of gap: (2.1 - 2) R at 20 m/s, then 5 % of the diameter
    assert status_time(bench.state, bench.dt) == pytest.approx((0.1 * R + 0.05 * 2 * R) / 20.0, abs=2e-6)


def test_too_deep_overlap_with_a_moving_wall_names_the_speeds_of_both():
    # floor rises at 30 m/s, ball falls at 10 m/s beside it with 5 m/s along: they close at 40 m/s
    bench = Bench([0, 0, 1.2 * R], law(1e3, stop=0.05), 1e-6, [FLOOR], velocities=[5.0, 0, -10.0])
    bench.motion[0, 9] = 30.0
    with pytest.raises(
        StepError, match=r'particle 0, at 11\.2 m/s, overlaps surface "floor", there at 30 m/s'
    ):
        bench.step(500)
    assert list(bench.state.status[:3]) == [Status.WALL_OVERLAP, 0, 0]
    lost = 1e3 * (0.07 * 2 * R) ** 2 / (2 * M * 40.0**2) * 4
    assert bench.state.halt_speeds == pytest.approx([np.hypot(5.0, 10.0), 30.0, 40.0], rel=lost)
    assert "overlaps surface number 0, there at 30 m/s" in status_text(bench.state)


def test_particle_that_leaves_is_named():
    bench = Bench([[0, 0, 0], [0.1, 0, 0]], law(), 1e-5, velocities=[[0, 0, 0], [100, 0, 0]])
    with pytest.raises(StepError, match="particle 1, at 100 m/s, left the chamber"):
        bench.step(20000)
    assert list(bench.state.status[:2]) == [Status.OUTSIDE, 1]
