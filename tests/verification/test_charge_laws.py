"""Composed laws in the whole engine: what every charge must keep, whatever its law."""

import math

import numpy as np
import pytest
from charge_bench import FLOOR, Bench, law, sphere_mass

from nutamill.charge.laws.composition import contact_law
from nutamill.charge.laws.impact import impact
from nutamill.charge.laws.pair import PairLaw
from nutamill.charge.model import Ledger
from nutamill.charge.walls.surface import Surface, SurfaceKind

R = 0.0025
M = sphere_mass(R)
HYSTERETIC = contact_law("hysteretic", "incremental", "type_c", "none")
HERTZ = contact_law("hertz", "displacement", "type_a", "area")
WALLS = (FLOOR, Surface("bore", SurfaceKind.CYLINDER, 0, 0, size=(0.015, 0, 0)))


def numbers(**changes):
    given = law(1e5, 0.2, 0.8, friction=0.5, rolling=0.05)
    shared = {
        "unloading_ratio": 3.0,
        "contact_modulus": 2e7,
        "contact_shear_modulus": 8e6,
        "cohesive_pressure": 0.0,
    }
    return PairLaw(**({name: getattr(given, name) for name in given.__slots__} | shared | changes))


def crowd(composed, precision="single", surfaces=WALLS):
    """Sixty spheres on a loose lattice in a tube, thrown together at about 1 m/s."""
    rng = np.random.default_rng(3)
    grid = np.array([[a, b, c] for c in range(7) for a in range(-1, 2) for b in range(-1, 2)], float)[:60]
    x = grid * 2.1 * R + [0, 0, 1.2 * R] + rng.uniform(-0.04, 0.04, (60, 3)) * R
    v = rng.normal(size=(60, 3)) - 40.0 * (x - x.mean(axis=0))
    pair = numbers(cohesive_pressure=2e5 if composed is HERTZ else 0.0)
    options = {
        "velocities": v,
        "spins": 50.0 * rng.normal(size=(60, 3)),
        "law": composed,
        "precision": precision,
    }
    return Bench(x, pair, 3e-6, surfaces, gravity=(0, 0, -9.81) if surfaces else (0, 0, 0), **options)


@pytest.mark.parametrize("composed", [HYSTERETIC, HERTZ])
def test_isolated_crowd_keeps_momentum_and_angular_momentum(composed):
    # action and reaction are the same number: float32 rounding of forces, sqrt(steps) of it at random
    bench = crowd(composed, surfaces=())
    scale = M * np.abs(bench.velocities).sum()
    energy = bench.reading().energy[0]
    before = (
        bench.reading().momentum.copy(),
        (M * np.cross(bench.positions, bench.velocities) + 0.4 * M * R * R * bench.spins).sum(axis=0),
    )
    bench.step(400)
    after = (
        bench.reading().momentum,
        (M * np.cross(bench.positions, bench.velocities) + 0.4 * M * R * R * bench.spins).sum(axis=0),
    )
    assert -bench.state.ledger[Ledger.PAIR_NORMAL] > 0.1 * energy
    assert after[0] == pytest.approx(before[0], abs=8 * 2.0**-23 * scale)
    assert after[1] == pytest.approx(before[1], abs=40 * 2.0**-23 * scale * 0.02)


@pytest.mark.parametrize("composed", [HYSTERETIC, HERTZ])
def test_ledger_closes_and_contacts_take_energy_out(composed):
    # work of contacts, walls and gravity is the change of kinetic energy, to rounding; what contacts took and
    # do not hold is lost
    bench = crowd(composed)
    before = bench.reading().energy[:2].sum()
    bench.step(600)
    after = bench.reading()
    assert bench.state.ledger.sum() == pytest.approx(after.energy[:2].sum() - before, abs=1e-6 * before)
    lost = -bench.state.ledger[: Ledger.INTERFACE] - after.energy[2:8]
    assert lost[[Ledger.PAIR_NORMAL, Ledger.PAIR_TANGENTIAL, Ledger.WALL_NORMAL]].min() > 0.0
    assert lost[Ledger.PAIR_ROLLING] > 0.0


def test_two_threads_give_the_bits_of_one_with_a_law_that_remembers():
    one, two = crowd(HYSTERETIC).step(300), crowd(HYSTERETIC)
    two.threads = 2
    two.step(300)
    for name in ("x", "v", "w", "impulse", "ledger"):
        assert getattr(one.state, name).tobytes() == getattr(two.state, name).tobytes(), name


@pytest.mark.parametrize("pair", [False, True])
@pytest.mark.parametrize("composed", [HYSTERETIC, HERTZ])
def test_engine_gives_the_impact_of_the_law(composed, pair):
    # reduced mass and radius of two spheres, and of a sphere and a wall; second order of w0 dt, and float32
    # overlaps of 1e-4 of the largest
    given = numbers(cohesive_pressure=2e5 if composed is HERTZ else 0.0, tension_cut=False)
    m, r = (M / 2, R / 2) if pair else (M, R)
    met = impact(composed, given, m, r, 2 * R, 2 * R, 1.0)
    dt = met.resolve / 100
    gap = 7.3 * dt
    if pair:
        places, speeds, surfaces = (
            [[-R - gap / 2, 0, 0], [R + gap / 2, 0, 0]],
            [[0.5, 0, 0], [-0.5, 0, 0]],
            (),
        )
    else:
        places, speeds, surfaces = [0, 0, R + gap], [0, 0, -1.0], [FLOOR]
    bench = Bench(places, given, dt, surfaces, velocities=speeds, law=composed, precision="single")
    bench.step(math.ceil(1.2 * met.time / dt) + 12)
    left = bench.velocities[1, 0] - bench.velocities[0, 0] if pair else bench.velocities[0, 2]
    ratio = given.unloading_ratio if composed is HYSTERETIC else 1.0
    assert left == pytest.approx(met.restitution, abs=met.stiffness * ratio / m * dt * dt + 1e-4)
    assert bench.state.largest_overlap[int(not pair)] * 2 * R == pytest.approx(
        met.overlap, rel=met.stiffness / m * dt * dt + 1e-4
    )
