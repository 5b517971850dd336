"""Laws, surfaces, vector moves, input checks and fills of the charge, one at a time."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from nutamill.base.errors import CaseError
from nutamill.base.kernel import JIT, kernel
from nutamill.charge.assembly import charge
from nutamill.charge.filling import relax
from nutamill.charge.filling.fill import random_fill
from nutamill.charge.filling.room import cylinder_room, largest_fill
from nutamill.charge.kernels import simd
from nutamill.charge.kernels.dynamics import start, window
from nutamill.charge.kernels.team import run_team
from nutamill.charge.laws import displacement, linear, type_a, type_c
from nutamill.charge.laws.lanes import BATCH
from nutamill.charge.laws.pair import PairLaw, pair_stiffness
from nutamill.charge.particles.particles import LOOSE_PACKING
from nutamill.charge.readout import velocities
from nutamill.charge.walls.surface import Surface, SurfaceKind
from nutamill.charge.walls.surfaces import surface_contact

LAW = PairLaw(1e5, 0.0, 0.0, 1.0, 0.2, False, 0.5, 0.5, 0.01, 0.05, 0.1)


def test_stiffness_is_direct_or_in_series():
    assert pair_stiffness(1 / 5e5, 0.0, 0.0, (0.005, 0.003)) == pytest.approx(5e5)
    assert pair_stiffness(0.0, 1 / 2e8, 1 / 3e6, (0.005, 0.003)) == pytest.approx(
        1 / (1 / (2e8 * 0.005) + 1 / (3e6 * 0.003))
    )


def test_normal_force_is_cut_at_its_floor():
    # k d + 2 zeta sqrt(m k) v, d far above v dt
    damped = 1e5 * 1e-6 - 0.4 * math.sqrt(5e-4 * 1e5) * 0.5
    law = PairLaw(1e5, 0.0, 0.0, 1.0, 0.2, False, 0.0, 0.0, 0.0, 0.05, 0.1)
    for pair, expected in ((law, damped), (replace(law, tension_cut=True), 0.0)):
        p = tuple(linear.numbers(pair))
        got = linear.force(linear.LAW, p, 1e-6, -0.5, 0.0, 5e-4, 0.001, (0.005, 0.005), 1e-9)
        assert got[0] == pytest.approx(expected)


def test_first_substep_of_a_contact_carries_half_to_one_and_a_half_shares():
    assert linear.dashpot_speed(0.25e-6, 1.0, 1e-6) == pytest.approx(0.75)
    assert linear.dashpot_speed(0.75e-6, -1.0, 1e-6) == pytest.approx(-1.25)
    assert linear.dashpot_speed(2e-6, 1.0, 1e-6) == 1.0


UP, REST = (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)


def test_friction_never_exceeds_its_limit_and_goes_over_to_the_dynamic_coefficient():
    def friction(length, sliding):
        spring = (length, 0.0, 0.0)
        return displacement.force(
            displacement.LAW, (0.6, 0.4, 0.0), spring, sliding, REST, UP, 1e5, 1.0, 2.0, 1e-15, 1e-6
        )

    pull, _, sliding = friction(3e-5, 0.0)
    assert pull[0] == pytest.approx(-0.4 * 2.0)
    assert sliding == 1.0
    # below the static limit a resting spring holds; a sliding one is limited by the dynamic coefficient
    holds, slides = friction(1e-5, 0.0)[0], friction(1e-5, 1.0)[0]
    assert (holds[0], slides[0]) == (pytest.approx(-1.0), pytest.approx(-0.8))


def test_friction_spring_is_in_the_tangent_plane():
    pull, spring, _ = displacement.force(
        displacement.LAW,
        (1.0, 1.0, 0.0),
        (1e-6, 2e-6, 3e-6),
        0.0,
        (0.1, 0.0, 0.0),
        UP,
        1e5,
        1.0,
        9.0,
        1e-15,
        1e-6,
    )
    assert pull[2] == 0.0
    # trapezoidal: force with half the slip, memory with all of it
    assert pull[0] == pytest.approx(-1e5 * (1e-6 + 0.05e-6))
    assert spring[0] == pytest.approx(1e-6 + 0.1e-6)


def test_constant_rolling_moment_opposes_the_spin():
    # far above the spin that a tenth of the inertia would stop in a substep
    moment, rolled = type_a.moment(type_a.LAW, REST, (3.0, 0.0, 4.0), UP, 1e5, 1.0, 1.0, 0.0, 2e-5, 1e-6)
    assert moment == pytest.approx((-2e-5 * 0.6, 0.0, -2e-5 * 0.8))
    assert rolled == REST


def test_rolling_spring_ignores_twist_about_the_normal():
    moment, rolled = type_c.moment(type_c.LAW, REST, (0.0, 0.0, 4.0), UP, 1e-3, 1.0, 1.0, 0.0, 1.0, 1e-6)
    assert moment == pytest.approx(REST)
    assert rolled == pytest.approx(REST)


coordinate = st.floats(-0.03, 0.03)


@settings(max_examples=60, deadline=None)
@given(coordinate, coordinate, coordinate)
def test_box_gives_the_distance_to_its_nearest_point(x, y, z):
    # brute force: the nearest of all points of the solid box is the clamped one; sampled here on a grid of
    # each face
    half = np.array([0.01, 0.015, 0.005])
    r = 0.0025
    centre = np.array([x, y, z])
    overlap, *normal = surface_contact(int(SurfaceKind.BOX), x, y, z, r, *half)
    grid = np.linspace(-1.0, 1.0, 41)
    a, b = np.meshgrid(grid, grid)
    faces = [
        np.stack([s * np.ones_like(a), a, b], -1).reshape(-1, 3)[:, np.roll([0, 1, 2], k)]
        for k in range(3)
        for s in (-1, 1)
    ]
    nearest = np.linalg.norm(np.concatenate(faces) * half - centre, axis=1).min()
    inside = (np.abs(centre) < half).all()
    assert np.linalg.norm(normal) == pytest.approx(1.0)
    # a grid point is at most half a diagonal of a grid cell from the nearest point of the face
    cell = 0.5 * math.hypot(2 * 0.015 / 40, 2 * 0.01 / 40)
    expected = r + nearest if inside else r - nearest
    assert overlap == pytest.approx(expected, abs=cell)


def test_plane_and_cylinder_push_into_the_charge():
    overlap, *normal = surface_contact(int(SurfaceKind.PLANE), 0.1, 0.2, 0.002, 0.0025, 0.0, 0.0, 0.0)
    assert (overlap, normal) == (pytest.approx(0.0005), [0.0, 0.0, -1.0])
    overlap, *normal = surface_contact(int(SurfaceKind.CYLINDER), 0.03, 0.04, 0.7, 0.0025, 0.052, 0.0, 0.0)
    assert overlap == pytest.approx(0.0005)
    assert normal == pytest.approx([0.6, 0.8, 0.0])


@kernel
def move_all(rows, index, points, local, owner, columns, fixed):
    """Use every vector move once; returns the mask of touching pairs."""
    simd.gather_rows(rows, index, 3, 8, 4, columns)
    simd.gather_differences(points, index, local, owner, 3, 8, columns)
    mask = simd.touching(points, index, local, owner, 3)
    simd.add_rows(index, 3, columns, 8, 4, rows)
    simd.set_rows(owner, 3, columns, 8, 4, rows)
    simd.set_points(index, 12, fixed, 16, points)
    simd.negated_radii(points, index, 20, 7, local)
    simd.copy_lanes(columns, 4 * BATCH, 40 * BATCH, columns)
    simd.copy_lanes(columns, 40 * BATCH, BATCH, fixed)
    return mask


@pytest.mark.skipif(not JIT, reason="without the compiler there is only the plain twin")
def test_vector_moves_do_what_their_plain_twins_do():
    rng = np.random.default_rng(2)
    rows = rng.normal(size=(40, 8)).astype(np.float32)
    points = rng.integers(-(2**22), 2**22, (40, 4)).astype(np.int32)
    local = rng.integers(-(2**22), 2**22, (20, 4)).astype(np.int32)
    points[:, 3], local[:, 3] = 2**21, -(2**22)
    index = rng.permutation(40).astype(np.uint32)
    owner = rng.permutation(20).astype(np.uint32)
    columns = np.zeros(48 * BATCH, np.float32)
    fixed = rng.integers(-(2**30), 2**30, 4 * BATCH).astype(np.int32)
    arrays = rows, index, points, local, owner, columns, fixed
    plain = [a.copy() for a in arrays]
    mask = move_all(*arrays)
    assert mask == move_all.py_func(*plain)
    assert 0 < mask < 255
    for moved, expected in zip(arrays, plain, strict=True):
        assert (moved == expected).all()


def refuse(*words, **changes):
    """Build a small charge with `changes`, expect a CaseError that has all `words`."""
    given = {
        "positions": [[0, 0, 0], [0, 0, 0.01]],
        "radii": [0.0025, 0.0025],
        "materials": [0, 0],
        "densities": [7800.0],
    }
    given |= {"pair_laws": {(0, 0): LAW}, "surfaces": (), "n_bodies": 1}
    with pytest.raises(CaseError) as caught:
        charge(**(given | changes))
    for word in words:
        assert word in str(caught.value)


def test_overlapping_start_names_the_worst_pairs():
    refuse("must not overlap", "0-1 (20 %)", positions=[[0, 0, 0], [0, 0, 0.004]])


def test_particle_outside_is_named():
    floor = Surface("floor", SurfaceKind.PLANE, 0, 0)
    refuse('surface "floor"', "1", positions=[[0, 0, 0.01], [0, 0, -0.02]], surfaces=[floor])


def test_sizes_densities_and_laws_that_cannot_be_are_refused_together():
    refuse("radii", "density of material 0", radii=[0.0025, -1.0], densities=[0.0])
    refuse(
        "materials 0 and 1",
        materials=[0, 1],
        densities=[7800.0, 2500.0],
        pair_laws={(0, 0): LAW, (1, 1): LAW},
    )
    refuse("finite", positions=[[0, 0, math.nan], [0, 0, 0.01]])


def test_fill_is_random_without_overlaps_and_repeats_with_its_seed():
    radii = np.full(400, 0.0025)
    boxes = [((0.02, 0.0, 0.02), np.eye(3), (0.004, 0.004, 0.02))]
    x = random_fill(radii, 0.025, 0.0, 0.06, boxes, seed=5)
    gap = np.linalg.norm(x[:, None] - x[None], axis=2) + np.eye(400)
    assert gap.min() >= 0.005
    assert np.hypot(x[:, 0], x[:, 1]).max() <= 0.0225
    assert x[:, 2].min() >= 0.0025
    assert (x == random_fill(radii, 0.025, 0.0, 0.06, boxes, seed=5)).all()
    assert not (x == random_fill(radii, 0.025, 0.0, 0.06, boxes, seed=6)).any()


def test_fill_reaches_nine_tenths_of_the_loose_capacity():
    n = int(0.9 * LOOSE_PACKING * cylinder_room(0.03, 0.0, 0.06).volume / (4 / 3 * math.pi * 0.0025**3))
    x = random_fill(np.full(n, 0.0025), 0.03, 0.0, 0.06)
    gap = np.linalg.norm(x[:, None] - x[None], axis=2) + np.eye(n)
    assert gap.min() >= 0.005


@pytest.fixture(scope="module")
def full():
    """A cylinder of 16 diameters each way as full as the rule allows: centres, radius and size [m], count."""
    r, radius, height = 0.5e-3, 8e-3, 16e-3
    room = cylinder_room(radius, 0.0, height)
    n = int(largest_fill(np.array([r]), room) / (4 / 3 * math.pi * r**3))
    return random_fill(np.full(n, r), radius, 0.0, height), r, radius, height


def test_what_the_rule_allows_can_be_placed_although_it_is_denser_than_a_loose_bed(full):
    """The rule says 0.637 - 0.12 x 6/16 = 0.592 of it, against 0.58 of a loose bed."""
    x, r, radius, height = full
    solid = len(x) * 4 / 3 * math.pi * r**3
    assert LOOSE_PACKING < 0.5915 < solid / cylinder_room(radius, 0.0, height).volume < 0.592
    assert len(cKDTree(x).query_pairs(2.0 * r)) == 0
    assert np.hypot(x[:, 0], x[:, 1]).max() <= radius - r
    assert x[:, 2].min() >= r
    assert x[:, 2].max() <= height - r


def test_a_crowded_bed_is_denser_than_0_62_away_from_the_walls(full):
    """Three diameters from all walls, where a cylinder of 10 diameters is left: 40 000 random points have a
    standard deviation of 0.0024, of which three are allowed for.
    """
    x, r, radius, height = full
    draw, points = np.random.default_rng(1), 40_000
    angle, out = draw.uniform(0.0, math.tau, points), (radius - 6 * r) * np.sqrt(draw.random(points))
    z = draw.uniform(6 * r, height - 6 * r, points)
    near, _ = cKDTree(x).query(np.column_stack([out * np.cos(angle), out * np.sin(angle), z]))
    assert (near <= r).mean() > 0.62 - 3 * 0.0024


@pytest.mark.parametrize("share", [0.98, 1.0])
def test_a_crowded_fill_needs_no_thousand_sweeps(share, monkeypatch):
    """One whose overlaps are pushed apart without inertia needs 1151, and more than 3000."""
    sweeps, overlaps = [], relax.overlaps
    monkeypatch.setattr(relax, "overlaps", lambda *given: sweeps.append(1) or overlaps(*given))
    room = cylinder_room(6e-3, 0.0, 12e-3)
    n = int(share * largest_fill(np.array([0.5e-3]), room) / (4 / 3 * math.pi * 0.5e-3**3))
    random_fill(np.full(n, 0.5e-3), 6e-3, 0.0, 12e-3)
    assert len(sweeps) < 1000


def test_too_much_charge_is_refused():
    with pytest.raises(CaseError, match="placed without overlaps"):
        random_fill(np.full(2000, 0.0025), 0.025, 0.0, 0.06)


@pytest.mark.parametrize("overlap", [-1e-10, 0.0, 1e-12])
@pytest.mark.parametrize("v_n", [0.0, 1e-38, -1e-38])
def test_a_contact_at_rest_on_the_verge_of_touching_has_a_finite_force(overlap, v_n):
    # k = 1e5 N/m: at most 1e5 * 1e-10 = 1e-5 N of spring, and no dashpot at no speed
    p = tuple(np.float32(x) for x in linear.numbers(LAW))
    depth, speed, none, m_eff, r_eff, size, dt = (
        np.float32(x) for x in (overlap, v_n, 0.0, 1e-3, 1e-3, 5e-3, 3e-6)
    )
    push = linear.force(linear.LAW, p, depth, speed, none, m_eff, r_eff, (size, size), dt)[0]
    assert abs(push) <= 1.1e-5


def test_balls_that_just_touch_at_rest_stay_at_rest():
    # whatever the rounding of their distance: forces are at most k times the rounding of a coordinate in
    # single precision
    rng = np.random.default_rng(3)
    r, k, dt = 0.0025, 5e5, 3e-6
    first = 0.02 * np.stack(np.meshgrid(*[np.arange(6.0)] * 3), axis=-1).reshape(-1, 3) + 1e-4 * rng.random(
        (216, 3)
    )
    n, way = len(first), rng.normal(size=(216, 3))
    second = first + 2.0 * r * way / np.linalg.norm(way, axis=1)[:, None]
    law = PairLaw(k, 0.0, 0.0, 1.0, 0.2, False, 0.5, 0.5, 0.01, 0.05, 0.1)
    built = charge(
        np.concatenate([first, second]),
        np.full(2 * n, r),
        np.zeros(2 * n, int),
        [7800.0],
        {(0, 0): law},
        [],
        1,
        gravity=(0, 0, 0),
    )
    model, state, _ = built
    start(*built, dt)
    still = np.zeros((1, 19))
    still[0, 3] = 1.0
    run_team(window, (*built, still, np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0]), 1, dt), 1)
    # three coordinates of two balls and their two radii are each half a fixed-point unit off, and the
    # distance is a float32
    rounding = (math.sqrt(3.0) + 1.0) / model.scale + 2.0 * r * 2.0**-23
    assert state.status[0] == 0
    assert np.abs(velocities(model, state)).max() <= k * rounding * dt / state.mass_props[1, 0]
