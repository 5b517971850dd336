"""A wet charge in the whole engine: restitution, momentum, ledger, memory, and dry as its limit."""

import math
from dataclasses import replace

import numpy as np
import pytest
from charge_bench import FLOOR, Bench, law, sphere_mass

from nutamill.charge.face import FIXED_FRAME
from nutamill.charge.laws.composition import contact_law
from nutamill.charge.laws.viscous_film import stokes_number
from nutamill.charge.model import Clock, Ledger
from nutamill.charge.saved_state import put_back, saved_arrays
from nutamill.charge.walls.surface import Surface, SurfaceKind

R = 0.0025
M = sphere_mass(R)
WET = contact_law(film="viscous")
BORE = Surface("bore", SurfaceKind.CYLINDER, 0, 0, size=(0.015, 0, 0))
THICKNESS, ROUGHNESS, VISCOSITY = 80e-6, 1e-6, 0.1
LOG = math.log(THICKNESS / ROUGHNESS)


def wet(pair, **changes):
    liquid = {"liquid_viscosity": VISCOSITY, "film_thickness": THICKNESS, "film_roughness": ROUGHNESS}
    return replace(pair, **(liquid | changes))


def crowd(surfaces=(FLOOR, BORE), composed=WET, **changes):
    """Sixty wet spheres on a loose lattice in a tube, thrown together at about 1 m/s."""
    rng = np.random.default_rng(3)
    grid = np.array([[a, b, c] for c in range(7) for a in range(-1, 2) for b in range(-1, 2)], float)[:60]
    x = grid * 2.1 * R + [0, 0, 1.2 * R] + rng.uniform(-0.04, 0.04, (60, 3)) * R
    v = rng.normal(size=(60, 3)) - 40.0 * (x - x.mean(axis=0))
    options = {"velocities": v, "spins": 50.0 * rng.normal(size=(60, 3)), "law": composed}
    pair = law(1e5, 0.2, 0.8, friction=0.5, rolling=0.05)
    pair = wet(pair, **changes) if composed is WET else pair
    gravity = (0.0, 0.0, -9.81 if surfaces else 0.0)
    return Bench(x, pair, 3e-6, surfaces, gravity=gravity, precision="single", **options)


SPEEDS = np.array([0.8, 1.0, 1.5, 2.5, 4.0])
DT = math.pi * math.sqrt(M / 2 / 1e5) / 150
"""A 150th of an undamped contact of two."""


def rebounds(places, velocities, surfaces, closing):
    """Speeds of parting [m/s] of pairs, or of balls and the floor, once all are out of their films."""
    bench = Bench(
        places, wet(law(1e5)), DT, surfaces, velocities=velocities, law=WET, precision="single",
        domain=((0.25, 0.0, 0.0), 0.4),
    )  # fmt: skip
    bench.step(1500)
    assert bench.contacts == (0, 0)
    return bench, closing(bench.velocities)


def test_pairs_and_walls_give_the_restitution_of_a_film_both_ways():
    # e = 1 - 2 ln(thickness/roughness)/St: a line over 1/St. The spring is met at any phase, (w dt)^2/8 of
    # the speed; the separation is known to 6e-10 m, so that the logarithm is off by 6e-10/1e-6 at its end
    error = (math.pi / 150) ** 2 / 4 + 2e-3 / 10
    gap, n = 1.1 * THICKNESS, len(SPEEDS)
    x = 0.1 * np.arange(n)
    low, high = np.stack([x, 0 * x, 0 * x], 1), np.stack([x, 0 * x, 0 * x + 2 * R + gap], 1)
    down = np.stack([0 * x, 0 * x, -SPEEDS], 1)
    bench, parting = rebounds(
        np.concatenate([low, high]), np.concatenate([0 * down, down]), (), lambda v: v[n:, 2] - v[:n, 2]
    )
    stokes = np.array([stokes_number(wet(law()), M / 2, R / 2, v) for v in SPEEDS])
    assert parting / SPEEDS == pytest.approx(1.0 - 2.0 * LOG / stokes, abs=error)
    lost = 0.25 * M * (SPEEDS**2 - parting**2).sum()
    assert -bench.state.ledger[Ledger.PAIR_FILM] == pytest.approx(lost, rel=0.02)
    _, parting = rebounds(low + np.array([0, 0, R + gap]), down, (FLOOR,), lambda v: v[:, 2])
    stokes = np.array([stokes_number(wet(law()), M, R, v) for v in SPEEDS])
    assert parting / SPEEDS == pytest.approx(1.0 - 2.0 * LOG / stokes, abs=error)


def test_isolated_wet_crowd_keeps_momentum_and_angular_momentum():
    # the film pushes both along the line between their centres, by the same number
    bench = crowd(surfaces=())
    scale = M * np.abs(bench.velocities).sum()

    def turning():
        x, v = bench.positions, bench.velocities
        return (M * np.cross(x, v) + 0.4 * M * R * R * bench.spins).sum(axis=0)

    before = bench.reading().momentum.copy(), turning()
    bench.step(400)
    assert -bench.state.ledger[Ledger.PAIR_FILM] > 0.02 * bench.reading().energy[0]
    assert bench.reading().momentum == pytest.approx(before[0], abs=8 * 2.0**-23 * scale)
    assert turning() == pytest.approx(before[1], abs=40 * 2.0**-23 * scale * 0.02)


def test_ledger_closes_with_the_work_of_the_films():
    bench = crowd()
    before = bench.reading().energy[:2].sum()
    bench.step(600)
    after = bench.reading()
    assert bench.state.ledger.sum() == pytest.approx(after.energy[:2].sum() - before, abs=1e-6 * before)
    assert (bench.state.ledger[[Ledger.PAIR_FILM, Ledger.WALL_FILM]] < 0.0).all()


def test_a_wet_crowd_goes_on_from_its_checkpoint_with_the_same_bits_on_two_threads():
    # films are remembered through new lists and through a checkpoint
    whole = crowd().step(350)
    saved = {name: array.copy() for name, array in saved_arrays(whole.model, whole.state).items()}
    assert (saved["contact_memory"][:, 7] < 0.0).sum() > 5
    assert (saved["wall_memory"][:, 7] < 0.0).any()
    whole.step(400)
    assert whole.state.clock[Clock.REBUILDS] > saved["clock"][Clock.REBUILDS]
    resumed = crowd()
    resumed.model, resumed.state, resumed.scratch = put_back(*resumed.parts, saved, FIXED_FRAME)
    resumed.threads = 2
    resumed.step(400)
    ends = (saved_arrays(bench.model, bench.state) for bench in (whole, resumed))
    for (name, one), other in zip(next(ends).items(), next(ends).values(), strict=True):
        assert one.tobytes() == other.tobytes(), name


def test_dry_is_the_limit_of_wet():
    # nothing without viscosity but float32 rounding of the reach, and in proportion to it where it is small
    dry, none = crowd(composed=contact_law()), crowd(liquid_viscosity=0.0)
    wet_ones = [crowd(liquid_viscosity=viscosity) for viscosity in (2e-3, 1e-3)]
    for bench in (dry, none, *wet_ones):
        bench.step(40)
    assert none.velocities == pytest.approx(dry.velocities, abs=1e-5)
    most, half = (np.abs(bench.velocities - dry.velocities).max() for bench in wet_ones)
    assert 1e-4 < most < 1e-2
    assert half == pytest.approx(most / 2, rel=0.1)


def test_films_are_listed_and_counted_as_gaps():
    # three balls: in contact, in the film, beyond it. The list holds the film beside the skin
    places = [[0, 0, 0], [2 * R - 1e-5, 0, 0], [4 * R + 4e-5, 0, 0], [6 * R + 2e-4, 0, 0]]
    bench = Bench(places, wet(law()), 1e-7, law=WET, precision="single").step(2)
    assert bench.contacts[0] == 1
    # a gap counts negative; of the contact, which opens, the history is the overlap whose work is booked
    alive = saved_arrays(bench.model, bench.state)["contact_memory"]
    assert sorted(alive[:, 7]) == pytest.approx([-(5e-5 + ROUGHNESS), 1e-5], abs=3e-7)
    assert bench.model.skin == pytest.approx(0.5 * R + THICKNESS - ROUGHNESS)
