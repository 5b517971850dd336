"""Meshed walls against the exact shapes they stand for, and against closed forms of edges and corners."""

import itertools
import math

import numpy as np
import pytest
from charge_bench import FLOOR, Bench, law, sphere_mass
from mesh_bench import box, cylinder, plate

from nutamill.base.errors import StepError
from nutamill.base.kernel import JIT, kernel
from nutamill.charge.filling.fill import random_fill
from nutamill.charge.walls.mesh import closed_mesh
from nutamill.charge.walls.mesh_contact import mesh_overlap
from nutamill.charge.walls.mesh_patches import mesh_surfaces, mesh_walls
from nutamill.charge.walls.surface import Surface, SurfaceKind
from nutamill.charge.walls.surfaces import surface_contact
from nutamill.charge.walls.triangles import signed_volumes

R, K = 0.0025, 5e5
M = sphere_mass(R)
HERE = np.array([[0.0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1]])
"""A surface placed at the origin."""


@kernel
def touched(walls, placed, points, radius, out):
    """Overlap and normal of each point with each patch, to `out` (patches, n, 4)."""
    for s in range(out.shape[0]):
        for i in range(out.shape[1]):
            out[s, i, 0], out[s, i, 1], out[s, i, 2], out[s, i, 3] = mesh_overlap(
                walls, placed, s, points[i, 0], points[i, 1], points[i, 2], radius
            )


def contacts(mesh, points, radius=R):
    """Overlaps (patches, n) and normals (patches, n, 3) of a mesh at the origin."""
    surfaces = mesh_surfaces(mesh, 0, 0)
    walls = mesh_walls(surfaces, radius)
    points = np.atleast_2d(np.array(points, float))
    out = np.empty((len(surfaces), len(points), 4))
    touched(walls, np.repeat(HERE, len(surfaces), axis=0), points, radius, out)
    return out[..., 0], out[..., 1:]


def test_meshed_box_touches_as_the_exact_box_does():
    half = np.array([0.01, 0.015, 0.005])
    n = 30_000 if JIT else 300
    points = np.random.default_rng(1).uniform(-1, 1, (n, 3)) * (half + 1.5 * R)
    exact = np.array([surface_contact(int(SurfaceKind.BOX), *p, R, *half) for p in points])
    # a grid finds centres up to a radius deep; the exact box finds them all
    shallow = exact[:, 0] < 2 * R
    overlap, normal = contacts(box(half), points)
    hits = overlap > 0
    assert (hits.sum(axis=0)[shallow] == (exact[shallow, 0] > 0)).all()
    patch, i = np.nonzero(hits & shallow)
    assert overlap[patch, i] == pytest.approx(exact[i, 0], abs=1e-12)
    assert normal[patch, i] == pytest.approx(exact[i, 1:], abs=1e-12 / R)
    assert len(i) > 0.3 * n


def test_inner_corner_gives_a_contact_with_each_face_and_none_with_its_edge():
    # 0.1 R into the floor, 0.2 R into a side wall, of a box that is the room
    room = box(np.full(3, 0.02), "inside")
    overlap, normal = contacts(room, [-0.02 + 0.8 * R, 0.001, -0.02 + 0.9 * R])
    assert sorted(overlap[overlap > 0]) == pytest.approx([0.1 * R, 0.2 * R])
    assert np.abs(normal[(overlap > 0)[:, 0], 0]).max(axis=1) == pytest.approx([1.0, 1.0])
    # in the corner of three faces, three
    overlap, _ = contacts(room, np.full(3, -0.02 + 0.7 * R))
    assert overlap[overlap > 0] == pytest.approx([0.3 * R] * 3)


@pytest.mark.parametrize("way", [(1.0, 0.0, 1.0), (1.0, 1.0, 1.0), (0.0, 1.0, 2.0), (3.0, 1.0, 2.0)])
def test_outer_edge_and_corner_give_one_contact_along_the_line_to_them(way):
    half = np.full(3, 0.02)
    way = np.array(way) / np.linalg.norm(way)
    foot = np.where(np.array(way) > 0, half, 0.003)
    overlap, normal = contacts(box(half), foot + 0.9 * R * way)
    assert (overlap > 0).sum() == 1
    assert overlap[overlap > 0] == pytest.approx(0.1 * R)
    assert normal[overlap > 0][0] == pytest.approx(-way)


def test_nothing_is_lost_and_nothing_counts_twice_where_regions_meet():
    # centres exactly above edges and corners, where the regions of faces, edges and corners share their
    # borders
    half = 0.0078125  # exact in binary, as are its sums with the heights
    heights = np.array([0.25, 0.5, 0.75]) * 0.001953125
    outside = box(np.full(3, half), radius=R)
    for h in heights:
        for foot in half * np.array(list(itertools.product((-1.0, 0.128, 1.0), repeat=3))):
            for axis in np.flatnonzero(np.abs(foot) == half):
                point = foot.copy()
                point[axis] += math.copysign(h, foot[axis])
                overlap, _ = contacts(outside, point)
                assert overlap[overlap > 0] == pytest.approx([R - h])


def test_centre_behind_a_thin_plate_is_not_pushed_by_its_far_side():
    # a plate thinner than a ball: above it, the centre is nearer to the top than to the bottom, which faces
    # away
    thin = box((0.02, 0.02, 0.2 * R))
    overlap, normal = contacts(thin, [0.001, 0.002, 0.2 * R + 0.9 * R])
    assert overlap[overlap > 0] == pytest.approx([0.1 * R])
    assert normal[overlap > 0][0] == pytest.approx([0, 0, -1])
    # and a centre that has gone in is pushed out of the nearer side
    overlap, normal = contacts(thin, [0.001, 0.002, 0.1 * R])
    assert overlap[overlap > 0] == pytest.approx([R + 0.1 * R])
    assert normal[overlap > 0][0] == pytest.approx([0, 0, -1])


def rolled(surfaces, steps, floor=0.0):
    """Path, speed and spin of a ball that slides, then rolls, over a floor under gravity."""
    bench = Bench(
        [-0.011, -0.0072, floor + R - 1e-7], law(K, 0.2, 0.8, friction=0.4, rolling=0.02), 4e-6, surfaces,
        gravity=(0, 0, -9.81), velocities=[0.9, 0.55, 0.0], domain=((0, 0, 0), 0.5),
    )  # fmt: skip
    out = []
    for _ in range(steps // 50):
        bench.step(50)
        out.append(
            np.concatenate(
                [
                    bench.positions[0],
                    bench.velocities[0],
                    R * bench.spins[0],
                    bench.state.impulse[0] / (50 * bench.dt),
                ]
            )
        )
    return np.array(out)


def test_seams_in_a_plane_do_not_show():
    # 0.02 m over triangles of some 2 mm: a dozen seams
    steps = 5000 if JIT else 100
    meshed = rolled(mesh_surfaces(plate(0.02, 0.01, 16), 0, 0), steps)
    smooth = rolled([FLOOR], steps)
    # heights over a triangle are rounded like the sizes of the plate: 0.02 x 2^-53 = 2e-18 m, through a
    # stiffness of 5e5 N/m and
    # a memory that adds up over 5000 steps 1e-8 of the weight; forces are summed in double precision
    weight = M * 9.81
    assert meshed[:, :9] == pytest.approx(smooth[:, :9], abs=1e-10)
    assert meshed[:, 9:12] == pytest.approx(smooth[:, 9:12], abs=1e-7 * weight)
    assert meshed[:, 12:] == pytest.approx(smooth[:, 12:], abs=1e-7 * weight * 0.02)
    assert np.ptp(meshed[:, 0]) > 0.7 * 0.9 * (steps - 50) * 4e-6


def test_ball_bounces_straight_off_the_tip_of_a_corner_and_keeps_its_energy():
    # a pyramid with its tip at the origin; linear spring without damping: it leaves after pi sqrt(m/k) as
    # fast as it came

    corners = np.array([[0, 0, 0], [0.01, 0, -0.02], [0, 0.01, -0.02], [-0.01, 0, -0.02], [0, -0.01, -0.02]])
    faces = np.array([(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 1), (1, 4, 3), (1, 3, 2)])
    surfaces = mesh_surfaces(closed_mesh("pyramid", corners, faces, "outside", R), 0, 0)
    time = math.pi * math.sqrt(M / K)
    dt = time / 200
    bench = Bench(
        [0, 0, R + 0.5 * dt], law(K), dt, surfaces, velocities=[0, 0, -1.0], domain=((0, 0, 0), 0.5)
    )
    bench.step(100)
    assert R - bench.positions[0, 2] == pytest.approx(
        time / math.pi, rel=1e-3
    )  # deepest at half time: v sqrt(m/k)
    bench.step(104)
    # leapfrog keeps a spring's energy to (w dt)^2/24 = 1e-5; the two ends of the contact fall between steps:
    # w dt = 0.016 of a
    # step's force at zero overlap, twice squared
    assert bench.velocities[0] == pytest.approx([0, 0, 1.0], abs=3e-4)


def test_ball_on_a_slanting_edge_is_pushed_at_right_angles_to_it():
    half, angle = np.array([0.01, 0.01, 0.01]), math.pi / 4
    turn = np.array(
        [[math.cos(angle), 0, math.sin(angle)], [0, 1, 0], [-math.sin(angle), 0, math.cos(angle)]]
    )
    surfaces = mesh_surfaces(box(half), 0, 0, (0.003, 0.0, -0.01 * math.sqrt(2)), turn)
    # the edge is along y, through (0.003, y, 0); the centre stands 30 degrees off the upright over it
    off = math.radians(30)
    centre = [0.003 + 0.99 * R * math.sin(off), 0.002, 0.99 * R * math.cos(off)]
    bench = Bench(centre, law(K), 1e-7, surfaces, domain=((0, 0, 0), 0.5)).step(1)
    push = bench.velocities[0] * M / 1e-7
    assert push == pytest.approx(
        K * 0.01 * R * np.array([math.sin(off), 0, math.cos(off)]), rel=1e-9, abs=1e-9 * K * R
    )


BORE, HEIGHT = 0.03, 0.05


def packed():
    """A bed in a cylinder, pressed against its walls: random, the outermost balls 2 % of the diameter into
    them.
    """
    n = 500 if JIT else 40
    x = random_fill(np.full(n, R), BORE, 0.0, HEIGHT, seed=3)
    out = np.hypot(x[:, 0], x[:, 1])
    deep = BORE - R + 0.04 * R
    near = out > BORE - 1.3 * R
    x[near, :2] *= (deep / out[near])[:, None]
    return x


def test_overlap_in_a_tessellated_cylinder_converges_with_the_square_of_the_facet():
    x = packed()
    rho = np.hypot(x[:, 0], x[:, 1])
    exact = R + rho - BORE
    for n in (24, 48, 96, 192):
        mesh = cylinder(BORE, 0.0, HEIGHT, n)
        assert mesh.n_patches == 3  # bore, floor, ceiling
        overlap, normal = contacts(mesh, x)
        bore = int(mesh.patch[0])
        surplus = (overlap[bore] - exact)[exact > 1e-6]
        # the foot of a facet at angle p from the ball: R + rho cos p - BORE cos(pi/n), with p from 0 to pi/n
        sagitta = 1.0 - math.cos(math.pi / n)
        assert surplus.min() >= (BORE - rho.max()) * sagitta - 1e-15
        assert surplus.max() <= BORE * sagitta + 1e-15
        way = np.stack([x[:, 0], x[:, 1]], axis=1) / rho[:, None]
        cosine = (normal[bore, :, :2] * way).sum(axis=1)[exact > 1e-6]
        assert cosine.min() >= math.cos(math.pi / n) - 1e-12


def first_forces(surfaces, x):
    """Force and moment on the walls over one step from rest."""
    bench = Bench(x, law(K, stop=1.0), 1e-7, surfaces, domain=((0, 0, 0.02), 0.2)).step(1)
    return bench.state.impulse[0] / 1e-7, bench


def exact_cylinder():
    upside_down = np.diag([1.0, -1.0, -1.0])
    return [
        Surface("bore", SurfaceKind.CYLINDER, 0, 0, size=(BORE, 0, 0)),
        Surface("floor", SurfaceKind.PLANE, 0, 0),
        Surface("ceiling", SurfaceKind.PLANE, 0, 0, (0, 0, HEIGHT), upside_down),
    ]


def test_forces_on_a_meshed_chamber_converge_to_those_on_the_exact_one():
    x = packed()
    exact, reference = first_forces(exact_cylinder(), x)
    touching = np.hypot(x[:, 0], x[:, 1]) > BORE - R
    for n in (32, 128, 512):
        force, bench = first_forces(mesh_surfaces(cylinder(BORE, 0.0, HEIGHT, n), 0, 0), x)
        # each ball: overlap too large by up to BORE (1 - cos(pi/n)), direction off by up to pi/n
        overlap = 0.04 * R
        each = K * (BORE * (1 - math.cos(math.pi / n)) + overlap * math.pi / n)
        assert np.abs((bench.velocities - reference.velocities) * M / 1e-7).max() <= each
        # facets turn the forces both ways alike: their sum is off by the root of the number of balls and not
        # by the number
        first = K * overlap * math.pi / n * math.sqrt(touching.sum())
        second = K * BORE * (1 - math.cos(math.pi / n)) * touching.sum()
        assert np.linalg.norm(force[:3] - exact[:3]) <= first + second


def test_a_charge_moves_in_a_meshed_chamber_as_in_the_exact_one():
    # a chamber shaken in a circle for 4 ms; the trajectories part as the facets' sagitta allows
    x = random_fill(np.full(150 if JIT else 8, R), 0.02, 0.0, 0.04, seed=2)
    steps = 1000 if JIT else 20

    def kinetic(surfaces):
        bench = Bench(
            x,
            law(K, 0.2, 0.8, friction=0.3),
            4e-6,
            surfaces,
            gravity=(0, 0, -9.81),
            domain=((0, 0, 0.02), 0.2),
        )
        bench.motion[0, 7:10] = 1.0, 0.5, 0.0
        bench.step(steps)
        return 0.5 * M * (bench.velocities**2).sum(), bench.state.ledger[6]

    exact = [Surface("bore", SurfaceKind.CYLINDER, 0, 0, size=(0.02, 0, 0)), FLOOR]
    energy, work = kinetic(exact)
    fine = kinetic(mesh_surfaces(cylinder(0.02, 0.0, 0.06, 720), 0, 0))
    # balls are met earlier by the sagitta 0.02 (pi/720)^2/2 = 1.9e-7 m of some 4e-3 m the chamber moves, and
    # pushed up to pi/720
    # off the radius; a few collisions multiply that by ten
    assert fine == (pytest.approx(energy, rel=0.05), pytest.approx(work, rel=0.05))


def test_overlap_is_continuous_over_the_seams_of_a_tessellated_cylinder():
    mesh = cylinder(BORE, 0.0, HEIGHT, 60)
    angle = np.linspace(0.0, 0.4, 4001)
    rho = BORE - 0.9 * R
    x = np.column_stack([rho * np.cos(angle), rho * np.sin(angle), np.full(len(angle), 0.02)])
    overlap, _ = contacts(mesh, x)
    bore = overlap[int(mesh.patch[0])]
    assert ((overlap > 0).sum(axis=0) == 1).all()
    # the overlap changes at most as fast as the centre moves against a facet: sin(pi/60) of the arc
    assert np.abs(np.diff(bore)).max() <= rho * 1e-4 * math.sin(math.pi / 60) * 1.01
    # outside: the same prism as a post in the charge; its edges stand out, and belong to the one patch
    post = cylinder(BORE, 0.0, HEIGHT, 60, "outside")
    x[:, :2] *= (BORE + 0.9 * R) / rho
    overlap, _ = contacts(post, x)
    assert ((overlap > 0).sum(axis=0) == 1).all()
    assert (
        np.abs(np.diff(overlap[int(post.patch[0])])).max()
        <= (BORE + R) * 1e-4 * math.sin(math.pi / 60) * 1.01
    )


def test_a_round_smaller_than_a_ball_leaves_it_both_flanks():
    # a floor and a wall joined by a round of half the ball's radius, as a bent sheet 4 cm wide: the ball
    # touches both flanks
    fillet, size = 0.5 * R, 0.02
    arc = np.linspace(0.0, 0.5 * np.pi, 10)
    line = [
        (size, 0.0),
        *[(fillet - fillet * math.sin(a), fillet - fillet * math.cos(a)) for a in arc],
        (0.0, size),
        (size, size),
    ]
    n = len(line)
    vertices = np.array([(x, y, z) for y in (-size, size) for x, z in line])
    faces = []
    for i in range(n):
        j = (i + 1) % n
        faces += [(i, n + j, j), (i, n + i, n + j)]
    for i in range(1, n - 1):
        faces += [(n - 1, i - 1, i), (2 * n - 1, n + i, n + i - 1)]

    faces = np.array(faces)

    if signed_volumes(vertices[faces]).sum() < 0:
        faces = faces[:, ::-1]
    room = closed_mesh("sheet", vertices, faces, "inside", R)
    overlap, _ = contacts(room, [0.95 * R, 0.0, 0.98 * R])
    assert sorted(overlap[overlap > 0]) == pytest.approx([0.02 * R, 0.05 * R])
    # to a ball of a tenth of the size the same mesh is one smooth bend
    assert closed_mesh("sheet", vertices, faces, "inside", 0.1 * R).n_patches < room.n_patches
    overlap, _ = contacts(
        closed_mesh("sheet", vertices, faces, "inside", 0.1 * R), [fillet * 0.5, 0.0, fillet * 0.5], 0.1 * R
    )
    assert (overlap > 0).sum() <= 1


def test_fast_ball_that_has_gone_through_a_mesh_is_named():
    bench = Bench(
        [0.0, 0.0, 2 * R],
        law(1.0, stop=0.3),
        1e-5,
        mesh_surfaces(box((0.02, 0.02, 0.01), centre=(0, 0, -0.01)), 0, 0),
        velocities=[0, 0, -5.0],
        domain=((0, 0, 0), 0.5),
    )
    with pytest.raises(StepError, match="particle 0, at 5 m/s, overlaps surface"):
        bench.step(200)
    assert bench.state.status[:3].tolist() == [2, 0, bench.state.status[2]]
