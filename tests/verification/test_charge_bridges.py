"""A charge with capillary bridges in the whole engine: work of separation, momentum, lists and memory."""

import math
from dataclasses import replace

import numpy as np
import pytest
from charge_bench import FLOOR, Bench, law, sphere_mass

from nutamill.charge.face import FIXED_FRAME
from nutamill.charge.laws import capillary
from nutamill.charge.laws.composition import contact_law
from nutamill.charge.model import Clock, Ledger
from nutamill.charge.saved_state import put_back, saved_arrays
from nutamill.charge.walls.surface import Surface, SurfaceKind

R = 0.0025
M = sphere_mass(R)
LAW = contact_law(film="capillary")
VOLUME, TENSION = 1e-3 * R**3, 5.0
BORE = Surface("bore", SurfaceKind.CYLINDER, 0, 0, size=(0.015, 0, 0))


def wet(pair, **changes):
    """A pair with bridges whose liquid pulls strongly enough to be seen beside the impacts of a test."""
    return replace(pair, **({"bridge_volume": VOLUME, "surface_tension": TENSION} | changes))


def crowd(surfaces=(FLOOR, BORE)):
    """Sixty spheres with bridges and films on a loose lattice in a tube, thrown together at about 1 m/s."""
    rng = np.random.default_rng(3)
    grid = np.array([[a, b, c] for c in range(7) for a in range(-1, 2) for b in range(-1, 2)], float)[:60]
    x = grid * 2.1 * R + [0, 0, 1.2 * R] + rng.uniform(-0.04, 0.04, (60, 3)) * R
    v = rng.normal(size=(60, 3)) - 40.0 * (x - x.mean(axis=0))
    options = {"velocities": v, "spins": 50.0 * rng.normal(size=(60, 3)), "law": LAW}
    film = {"liquid_viscosity": 0.02, "film_thickness": 50e-6, "film_roughness": 1e-6}
    pair = wet(law(1e5, 0.2, 0.8, friction=0.5, rolling=0.05), **film)
    gravity = (0.0, 0.0, -9.81 if surfaces else 0.0)
    return Bench(x, pair, 3e-6, surfaces, gravity=gravity, precision="single", **options)


def bridges(saved):
    """Gaps with and without a bridge in a checkpoint [1]."""
    memory = np.concatenate([saved["contact_memory"], saved["wall_memory"]])
    apart = memory[:, 7] < 0.0
    return int((apart & (memory[:, 6] < 0.0)).sum()), int((apart & (memory[:, 6] > 0.0)).sum())


SPEEDS = np.array([0.6, 0.8, 1.2])
DT = 1e-6


def test_pairs_and_balls_on_a_floor_lose_the_work_of_separation():
    # the bridge begins and ends at any phase of a substep: half of one at the full pull, there and back
    x = 0.1 * np.arange(3)
    low, high = np.stack([x, 0 * x, 0 * x + 0.2], 1), np.stack([x, 0 * x, 0 * x + 0.2 + 2 * R + 5e-6], 1)
    drop = np.stack([x, 0 * x, 0 * x + R + 5e-6], 1)
    down = np.stack([0 * x, 0 * x, -SPEEDS], 1)
    bench = Bench(
        np.concatenate([low, high, drop]), wet(law(1e5)), DT, (FLOOR,), law=LAW, precision="single",
        velocities=np.concatenate([0 * down, down, down]), domain=((0.1, 0.0, 0.15), 0.3),
    )  # fmt: skip
    bench.step(1200)
    assert bench.contacts == (0, 0)
    v = bench.velocities[:, 2]
    taken = []
    for reduced, r_eff, parting in ((M / 2, R / 2, v[3:6] - v[:3]), (M, R, v[6:])):
        work, full = capillary.separation_work(wet(law()), r_eff), capillary.largest_pull(wet(law()), r_eff)
        lost = 0.5 * reduced * (SPEEDS**2 - parting**2)
        spring = 0.5 * reduced * SPEEDS**2 * math.pi**2 / 2 * (DT / math.pi) ** 2 * 1e5 / reduced
        assert lost == pytest.approx(work, abs=float((full * SPEEDS * DT + spring).max()))
        taken.append(lost.sum())
    assert -bench.state.ledger[[Ledger.PAIR_FILM, Ledger.WALL_FILM]] == pytest.approx(taken, rel=0.02)


def test_isolated_crowd_with_bridges_keeps_momentum():
    bench = crowd(surfaces=())
    scale = M * np.abs(bench.velocities).sum()
    before = bench.reading().momentum.copy()
    bench.step(400)
    assert bridges(saved_arrays(bench.model, bench.state))[0] > 5
    assert bench.reading().momentum == pytest.approx(before, abs=8 * 2.0**-23 * scale)


def test_ledger_closes_with_the_work_of_the_bridges():
    bench = crowd()
    before = bench.reading().energy[:2].sum()
    bench.step(600)
    after = bench.reading()
    assert bench.state.ledger.sum() == pytest.approx(after.energy[:2].sum() - before, abs=1e-6 * before)


def test_bridges_go_on_from_a_checkpoint_with_the_same_bits_on_two_threads():
    # which gaps have a bridge is remembered through new lists and through a checkpoint
    whole = crowd().step(350)
    saved = {name: array.copy() for name, array in saved_arrays(whole.model, whole.state).items()}
    assert min(bridges(saved)) > 5
    whole.step(400)
    assert whole.state.clock[Clock.REBUILDS] > saved["clock"][Clock.REBUILDS]
    resumed = crowd()
    resumed.model, resumed.state, resumed.scratch = put_back(*resumed.parts, saved, FIXED_FRAME)
    resumed.threads = 2
    resumed.step(400)
    ends = (saved_arrays(bench.model, bench.state) for bench in (whole, resumed))
    for (name, one), other in zip(next(ends).items(), next(ends).values(), strict=True):
        assert one.tobytes() == other.tobytes(), name


def test_a_list_holds_a_bridge_until_it_breaks():
    # of spheres of two sizes: the smallest have the longest bridges
    places = [[0, 0, 0], [2 * R - 1e-6, 0, 0], [0.03, 0, 0]]
    bench = Bench(
        places, wet(law(1e5)), 1e-6, law=LAW, precision="single", radius=[R, R, R / 2],
        velocities=[[-0.5, 0, 0], [0.5, 0, 0], [0, 0, 0]], skin=2e-5,
    )  # fmt: skip
    longest = capillary.rupture_distance(wet(law()), R / 4)
    assert bench.model.skin == pytest.approx(2e-5 + longest, rel=1e-6)
    end = capillary.rupture_distance(wet(law()), R / 2)
    bench.step(10)
    while bridges(saved_arrays(bench.model, bench.state))[0]:
        lasting = bench.positions[1, 0] - bench.positions[0, 0] - 2 * R
        bench.step(1)
    assert bench.state.clock[Clock.REBUILDS] > 2
    assert lasting == pytest.approx(end, abs=2.5e-6)
