"""The wall list of meshes: it misses no contact, changes no bit, and spares nearly all tests."""

import itertools

import numpy as np
import pytest
from charge_bench import Bench, law
from mesh_bench import box, cylinder, cylinder_corners, plate

from nutamill.base.kernel import JIT, kernel
from nutamill.charge.assembly import charge
from nutamill.charge.filling.fill import random_fill
from nutamill.charge.kernels.near_meshes import find_mesh_contacts
from nutamill.charge.walls.mesh import closed_mesh
from nutamill.charge.walls.mesh_contact import (
    contact_from,
    contact_in_cell,
    decides_alone,
    face_below,
    height_over,
    mesh_overlap,
    nearest_plane,
)
from nutamill.charge.walls.mesh_faces import MARGIN, NEAR_MARGIN
from nutamill.charge.walls.mesh_patches import mesh_surfaces, mesh_walls
from nutamill.charge.walls.surfaces import place_surfaces
from nutamill.charge.walls.wall_list import near_meshes

R = 0.0025


@kernel
def listed_contacts(model, near, x, radius, motion, surface_poses, out):
    """Contacts of one chunk by the wall list: normal and overlap, to `out` (S, n, 4)."""
    n = radius.shape[0]
    place_surfaces(model, motion, surface_poses)
    find_mesh_contacts(model, near, x, radius, motion, surface_poses, 0, n, 0)
    for s in range(out.shape[0]):
        q, last = near.head[0, s], -1
        near.head[0, s] = -1
        while q >= 0:
            l = near.link[0, 1, q]
            if l <= last:
                return False
            last = l
            for k in range(4):
                out[s, l, k] = near.contact[0, q, k]
            q = near.link[0, 0, q]
    return True


@kernel
def searched_contacts(model, x, radius, surface_poses, out):
    """Contacts of the same particles, each tested against every surface."""
    for s in range(out.shape[0]):
        for i in range(radius.shape[0]):
            overlap, n0, n1, n2 = mesh_overlap(
                model.mesh, surface_poses, s, x[0, i], x[1, i], x[2, i], radius[i]
            )
            if overlap > 0.0:
                out[s, i, 0], out[s, i, 1], out[s, i, 2], out[s, i, 3] = n0, n1, n2, overlap


def bumpy(bumps, radius=0.016, around=24):
    """A closed ball whose radius waves, as triangles: hollow and bulging everywhere."""
    polar = np.linspace(0.0, np.pi, around // 2 + 1)[1:-1]
    azimuth = 2.0 * np.pi * np.arange(around) / around
    p, a = (g.ravel() for g in np.meshgrid(polar, azimuth, indexing="ij"))
    way = np.stack([np.sin(p) * np.cos(a), np.sin(p) * np.sin(a), np.cos(p)], axis=1)
    way = np.concatenate([way, [[0, 0, 1.0], [0, 0, -1.0]]])
    vertices = radius * way * (1.0 + bumps * np.sin(9.0 * way @ [1.0, 0.7, 0.4]))[:, None]
    rows = np.arange(len(polar) * around).reshape(len(polar), around)
    faces = []
    for j in range(around):
        k = (j + 1) % around
        for upper, lower in itertools.pairwise(rows):
            faces += [(upper[j], lower[j], lower[k]), (upper[j], lower[k], upper[k])]
        faces += [(len(way) - 2, rows[0, j], rows[0, k]), (len(way) - 1, rows[-1, k], rows[-1, j])]
    return vertices, np.array(faces)


def model_of(surfaces, bodies, radius=R):
    """The arrays of a charge of one particle in free space, with meshes of several bodies."""
    return charge([[0.0, 0.02, 0.02]], [radius], [0], [7800.0], {(0, 0): law()}, surfaces, bodies)[0]


def moved(rng, motion):
    """Turn and shift each body a little, now and then a lot."""
    for body in motion:
        far = rng.random() < 0.02
        body[:3] += rng.normal(size=3) * (1e-3 if far else 2e-5)
        turn, _ = np.linalg.qr(np.eye(3) + rng.normal(size=(3, 3)) * (0.1 if far else 1e-3))
        body[3:12] = (turn * np.sign(np.diag(turn)) @ body[3:12].reshape(3, 3)).ravel()


def test_the_list_misses_no_contact_and_changes_no_bit():
    walls = [
        *mesh_surfaces(cylinder(0.03, -0.03, 0.03, 60), 0, 0),
        *mesh_surfaces(box(np.array([0.006, 0.008, 0.004])), 1, 0, (0.012, 0.0, 0.003)),
        *mesh_surfaces(closed_mesh("bumps", *bumpy(0.15, 0.01), "outside", R), 0, 0, (-0.012, 0.0, 0.0)),
        *mesh_surfaces(plate(0.01, 0.004, 12), 1, 0, (0.0, -0.01, -0.02)),
    ]
    model = model_of(walls, 2)
    rng = np.random.default_rng(2)
    n, steps = (60, 600) if JIT else (8, 12)
    x = rng.uniform(-0.03, 0.03, (3, n))
    radius = np.where(np.arange(n) < n // 3, rng.uniform(0.4 * R, R, n), R)
    near = near_meshes(model, n, 1)
    motion = np.zeros((2, 18))
    motion[:, 3] = motion[:, 7] = motion[:, 11] = 1.0
    poses = np.zeros((len(walls), 12))
    pace = 10.0 ** rng.uniform(-6.5, -3.5, n)
    touching = 0
    for step in range(steps):
        x += pace * rng.normal(size=(3, n))
        # some leap, as the particle of a slot does when slots are sorted
        leaps = rng.random(n) < 0.01
        x[:, leaps] = rng.uniform(-0.03, 0.03, (3, leaps.sum()))
        radius[leaps] = rng.permutation(radius)[leaps]
        moved(rng, motion)
        by_list, by_search = (np.zeros((len(walls), n, 4)) for _ in range(2))
        assert listed_contacts(model, near, x, radius, motion, poses, by_list), (
            "not in the order of the slots"
        )
        searched_contacts(model, x, radius, poses, by_search)
        assert (by_list == by_search).all(), f"step {step}"
        touching += (by_search[..., 3] > 0).sum()
    assert touching > 5 * steps


@kernel
def contacts_from(walls, points, faces, patches, radius, out):
    """Contact of each point with the patch of the triangle that its search begins at, and by a search of all
    triangles.
    """
    for i in range(len(faces)):
        patch = patches[i]
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        a0, a1, a2, a3, away, _ = contact_from(walls, patch, faces[i], x, y, z, radius)
        b0, b1, b2, b3, _, _ = contact_in_cell(walls, patch, faces[i], x, y, z, radius)
        out[i, 0], out[i, 1], out[i, 2], out[i, 3] = a0, a1, a2, a3
        out[i, 4], out[i, 5], out[i, 6], out[i, 7] = b0, b1, b2, b3
        out[i, 8] = away


@pytest.mark.parametrize("keep", ["inside", "outside"])
@pytest.mark.parametrize("shape", ["ball", "bumps", "slivers"])
def test_a_contact_is_the_same_wherever_its_search_begins(keep, shape):
    # slivers: a hundred times as long as wide, on the side and in the fans of both ends
    shapes = {
        "ball": (bumpy, 0.0),
        "bumps": (bumpy, 0.15),
        "slivers": (cylinder_corners, 0.016, 0.0, 0.02, 600),
    }
    corners, *numbers = shapes[shape]
    mesh = closed_mesh(shape, *corners(*numbers), keep, 0.2 * R)
    rng = np.random.default_rng(4)
    n = 20_000 if JIT else 60
    walls = mesh_walls(mesh_surfaces(mesh, 0, 0), 0.4 * R)
    radius = 0.4 * R
    near = rng.integers(len(mesh.faces), size=n)
    same_patch = [np.flatnonzero(mesh.patch == patch) for patch in range(mesh.n_patches)]
    start = np.array([rng.choice(same_patch[mesh.patch[face]]) for face in near], np.int32)
    foot = (mesh.corners[near] * rng.dirichlet([1, 1, 1], n)[:, :, None]).sum(axis=1)
    points = foot + rng.normal(size=(n, 3)) * 0.6 * radius
    out = np.zeros((n, 9))
    contacts_from(walls, points, start, mesh.patch[near], radius, out)
    touching = out[:, 4] > 0
    assert (out[touching, :4] == out[touching, 4:8]).all()
    assert ((out[:, 0] > 0) == touching).all()
    # the distance that is stated is one the patch has: no contact of a smaller ball
    assert (out[touching, 8] <= radius - out[touching, 4] + 1e-15)[out[touching, 4] < radius].all()
    assert touching.sum() > n / 5


@kernel
def decided_alone(rows, across, column, start, points, out):
    """Whether one triangle decides about each of the points, without a look at another, by the margins of
    `column`.
    """
    for i in range(len(points)):
        face, a, b, c = face_below(rows, across, start[i], points[i, 0], points[i, 1], points[i, 2])
        out[i] = face >= 0 and decides_alone(rows, face, column, a, b, c)


@pytest.mark.parametrize(("column", "radius"), [(MARGIN, 1.5 * R), (NEAR_MARGIN, R)])
@pytest.mark.parametrize("n", [32, 130])
def test_one_triangle_decides_for_most_balls_on_a_bore_of_any_fineness(n, column, radius):
    # faces are 2 BORE tan(pi/n) wide; margins of radius tan(pi/n) are at both seams, and larger by the step
    # from tangent to tangent, 1.14: a share that does not depend on n. The diagonal has none: rivals beyond
    # its ends take corners off the triangles, whose share is the square of that of a margin
    bore = 0.07
    margin = 1.14 * radius / (2.0 * bore)
    undecided = 2.0 * margin + 3.0 * margin**2
    mesh = cylinder(bore, 0.0, 0.1, n)
    walls = mesh_walls(mesh_surfaces(mesh, 0, 0), R)
    angle = 2.0 * np.pi * (np.arange(2000 if JIT else 50) + 0.5) / (2000 if JIT else 50)
    height = np.random.default_rng(1).uniform(0.02, 0.08, len(angle))
    points = np.column_stack([(bore - R) * np.cos(angle), (bore - R) * np.sin(angle), height])
    index = (angle / (2.0 * np.pi) * n).astype(int)
    start = np.flatnonzero(mesh.patch == mesh.patch[0])[2 * index].astype(np.int32)
    out = np.zeros(len(points), bool)
    decided_alone(walls.faces.rows, walls.faces.across, column, start, points, out)
    assert out.mean() > 1.0 - undecided
    assert np.isfinite(walls.faces.rows[:, column : column + 3]).all()


@kernel
def nearer_than_rivals(faces, start, points, out):
    """Whether the triangle below each of the points is nearer to it than the planes of its rivals."""
    for i in range(len(points)):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        face, a, b, c = face_below(faces.rows, faces.across, start[i], x, y, z)
        height = height_over(faces.rows, face, x, y, z)
        out[i] = nearest_plane(faces, face, height, False, a, b, c, x, y, z) == face


def test_in_a_bore_no_rival_of_the_triangle_below_a_ball_is_searched():
    bore, n = 0.07, 130
    mesh = cylinder(bore, 0.0, 0.1, n)
    walls = mesh_walls(mesh_surfaces(mesh, 0, 0), R)
    # a face that holds the foot is nearer than its neighbours: the planes between them pass the axis
    angle = 2.0 * np.pi * (np.arange(50) + 0.5) / 50
    points = np.column_stack([(bore - R) * np.cos(angle), (bore - R) * np.sin(angle), np.full(50, 0.05)])
    start = np.flatnonzero(mesh.patch == mesh.patch[0])[2 * (angle / (2.0 * np.pi) * n).astype(int)]
    out = np.zeros(len(points), bool)
    nearer_than_rivals(walls.faces, start.astype(np.int32), points, out)
    assert out.all()


def shaken(threads, steps):
    """Balls in a meshed cylinder that is shaken, with a meshed solid in it."""
    x = random_fill(np.full(300 if JIT else 10, R), 0.02, 0.012, 0.06, seed=2)
    walls = [
        *mesh_surfaces(cylinder(0.02, 0.0, 0.06, 48), 0, 0),
        *mesh_surfaces(box(np.array([0.008, 0.008, 0.004])), 0, 0, (0.0, 0.0, 0.005)),
    ]
    bench = Bench(
        x,
        law(5e5, 0.2, 0.8, friction=0.3),
        4e-6,
        walls,
        gravity=(0, 0, -9.81),
        domain=((0, 0, 0.02), 0.2),
        threads=threads,
    )
    bench.motion[0, 7:10] = 1.0, 0.5, 0.3
    return bench.step(steps)


def test_few_particles_are_tested_and_the_threads_change_no_bit():
    steps = 400 if JIT else 4
    one, two = shaken(1, steps), shaken(2, steps)
    assert (one.positions == two.positions).all()
    assert (one.impulses == two.impulses).all()
    # the next substep tests again only what touches, or has come nearer than its last test allows
    near, n = one.scratch.near, one.model.n_particles
    before = near.tested[0, :n].copy()
    touching = one.contacts[1]
    one.step(1)
    tested = (near.tested[0, :n] != before).any(axis=2).sum()
    listed = near.listed[0, :n].sum()
    assert touching <= tested <= 1.2 * touching + 5
    assert tested < 0.7 * listed
