"""Cone and sphere cap against closed forms, their quick tests, and what is refused of walls."""

import math

import numpy as np
import pytest

from nutamill.base.errors import CaseError
from nutamill.base.kernel import JIT, kernel
from nutamill.charge.assembly import charge
from nutamill.charge.laws.pair import PairLaw
from nutamill.charge.walls.mesh import CREASE, closed_mesh, on_charge_side
from nutamill.charge.walls.mesh_patches import mesh_surfaces, mesh_walls
from nutamill.charge.walls.shapes import cap_contact, cone_contact
from nutamill.charge.walls.surface import Surface, SurfaceKind
from nutamill.charge.walls.surfaces import place_surfaces, surface_near
from nutamill.charge.walls.touching import touch_surface
from nutamill.charge.walls.triangles import winding_number
from nutamill.charge.walls.walls import wall_overlap

R = 0.0025
LAW = PairLaw(1e5, 0.0, 0.0, 1.0, 0.2, False, 0.5, 0.5, 0.01, 0.05, 0.9)


# simple shapes ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "r0, r1, h", [(0.02, 0.05, 0.03), (0.05, 0.02, 0.03), (0.04, 0.04, 0.05), (0.0, 0.03, 0.04)]
)
def test_cone_gives_the_distance_to_its_side_and_ends_at_its_rims(r0, r1, h):
    # the side sampled finely in the half-plane of the axis; the nearest sample is at most half a step along
    # it from the foot
    share = np.linspace(0.0, 1.0, 20001)
    side = np.stack([r0 + (r1 - r0) * share, h * share], axis=1)
    rng = np.random.default_rng(1)
    for angle, z, distance in zip(
        rng.uniform(0, 7, 200), rng.uniform(-0.3 * h, 1.3 * h, 200), rng.uniform(0, 0.05, 200), strict=True
    ):
        overlap, *normal = cone_contact(
            distance * math.cos(angle), distance * math.sin(angle), z, R, r0, r1, h
        )
        gaps = np.linalg.norm(side - (distance, z), axis=1)
        nearest = int(gaps.argmin())
        if 0 < nearest < 20000:
            inside = (distance - r0) * h - z * (r1 - r0) < 0
            step = math.hypot(r1 - r0, h) / 20000
            assert overlap == pytest.approx(R - gaps[nearest] * (1 if inside else -1), abs=step)
            # the normal leads to the nearest point (from behind: away from it)
            slope = np.array([h, r0 - r1]) / math.hypot(h, r1 - r0)
            assert normal == pytest.approx([slope[0] * math.cos(angle), slope[0] * math.sin(angle), slope[1]])
        else:
            assert overlap < -1.0


def test_two_cones_end_to_end_share_no_point_of_their_seam():
    # a contact whose foot is exactly on the seam of two cylinders, of length 0.5
    lower = cone_contact(0.998, 0.0, 0.5, 0.01, 1.0, 1.0, 0.5)[0]
    upper = cone_contact(0.998, 0.0, 0.0, 0.01, 1.0, 1.0, 0.5)[0]
    assert sorted([lower > 0, upper > 0]) == [False, True]


@pytest.mark.parametrize("angle", [0.3, math.pi / 2, 2.5, math.pi])
def test_cap_touches_within_its_angle_of_the_bottom(angle):
    radius = 0.06
    rng = np.random.default_rng(2)
    for polar, turn, depth in zip(
        rng.uniform(0, math.pi, 200), rng.uniform(0, 7, 200), rng.uniform(0.2, 1.02, 200), strict=True
    ):
        way = np.array([math.sin(polar) * math.cos(turn), math.sin(polar) * math.sin(turn), -math.cos(polar)])
        overlap, *normal = cap_contact(*(depth * radius * way), R, radius, angle)
        if polar < angle:
            assert overlap == pytest.approx(R + depth * radius - radius, abs=1e-12)
            assert normal == pytest.approx(way)
        else:
            assert overlap < -1.0


def test_ball_passes_from_a_cone_to_the_cap_that_meets_it_in_its_tangent_without_a_step():
    # a cone of half-angle 30 deg about z standing on a bowl of radius s: their tangents meet where the polar
    # angle is 60 deg from -z
    s, slope = 0.03, math.radians(30)
    rim, low = s * math.cos(slope), -s * math.sin(slope)
    h = 0.04
    r1 = rim + h * math.tan(slope)
    for polar in (math.radians(60) - 1e-9, math.radians(60) + 1e-9):
        c = (s - 0.9 * R) * np.array([math.sin(polar), 0.0, -math.cos(polar)])
        cap, cone = (
            cap_contact(*c, R, s, math.pi / 2 - slope),
            cone_contact(c[0], c[1], c[2] - low, R, rim, r1, h),
        )
        assert (cap[0] > 0) + (cone[0] > 0) == 1
        overlap, *normal = cap if cap[0] > 0 else cone
        assert overlap == pytest.approx(0.1 * R, abs=1e-10)
        assert normal == pytest.approx([math.sin(polar), 0.0, -math.cos(polar)], abs=1e-7)


def octahedron(size=0.02):
    vertices = size * np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]])
    faces = [
        (a, b, c) if s > 0 else (a, c, b)
        for a, b, c, s in ((i, 2 + j, 4 + k, (-1) ** (i + j + k)) for i, j, k in np.ndindex(2, 2, 2))
    ]
    return vertices, np.array(faces)


WALLS = [
    Surface("cone", SurfaceKind.CONE, 0, 0, size=(0.01, 0.03, 0.02)),
    Surface("funnel", SurfaceKind.CONE, 0, 0, size=(0.03, 0.01, 0.02)),
    Surface("cap", SurfaceKind.SPHERE_CAP, 0, 0, size=(0.02, 1.0, 0.0)),
    Surface("plane", SurfaceKind.PLANE, 0, 0),
    Surface("bore", SurfaceKind.CYLINDER, 0, 0, size=(0.02, 0.0, 0.0)),
    Surface("box", SurfaceKind.BOX, 0, 0, size=(0.01, 0.02, 0.005)),
    Surface("disc", SurfaceKind.DISC, 0, 0, size=(0.02, 0.0, 0.0)),
    Surface("tube", SurfaceKind.TUBE, 0, 0, size=(0.02, 0.015, 0.0)),
    Surface("rod", SurfaceKind.ROD, 0, 0, size=(0.01, 0.008, 0.0)),
    Surface("ball", SurfaceKind.BALL, 0, 0, size=(0.015, 0.0, 0.0)),
]


@kernel
def quick_tests(model, placed, x, radius, s, overlaps, near, test):
    """What touches surface `s` by the exact test, by that of a chunk and by the test before the exact one."""
    n = x.shape[1]
    c0, c1, c2, around = 0.0, 0.0, 0.0, 0.0
    for i in range(n):
        c0, c1, c2 = c0 + x[0, i] / n, c1 + x[1, i] / n, c2 + x[2, i] / n
    for i in range(n):
        overlaps[i] = wall_overlap(
            model.surface_kind[s], model, placed, s, x[0, i], x[1, i], x[2, i], radius[i]
        )[0]
        around = max(around, ((x[0, i] - c0) ** 2 + (x[1, i] - c1) ** 2 + (x[2, i] - c2) ** 2) ** 0.5)
    near[0] = surface_near(
        model.surface_kind, model.surface_size, placed, s, c0, c1, c2, around + model.largest_radius
    )
    touch_surface(model, x, radius, 0, n, s, placed[s], test)


@pytest.mark.parametrize("s", range(len(WALLS)), ids=[wall.name for wall in WALLS])
def test_quick_tests_lose_no_contact(s):
    turn = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    walls = [
        Surface(w.name, w.kind, 0, 0, (0.003, -0.002, 0.001), turn, w.size) for w in WALLS
    ]  # fmt: skip
    model = charge([[10.0, 0, 0]], [R], [0], [7800.0], {(0, 0): LAW}, [], 1)[0]
    model = _with_walls(model, walls)
    placed = np.zeros((len(walls), 12))
    place_surfaces(model, np.array([[0.0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1]]), placed)
    rng = np.random.default_rng(3)
    seen = missed_chunks = 0
    for _ in range(1000 if JIT else 30):
        x = np.asfortranarray((rng.uniform(-0.035, 0.035, 3) + rng.uniform(-0.008, 0.008, (16, 3))).T.copy())
        radius = rng.uniform(0.3 * R, R, 16)
        overlaps, near, test = np.empty(16), np.empty(1), np.empty(16)
        quick_tests(model, placed, x, radius, s, overlaps, near, test)
        touching = overlaps > 0
        seen += touching.sum()
        missed_chunks += near[0] <= 0
        assert (test[touching] > 0).all()
        assert near[0] > 0 or not touching.any()
    assert seen > 20 or not JIT
    assert missed_chunks > 2 or WALLS[s].kind in (SurfaceKind.PLANE, SurfaceKind.CYLINDER)


def _with_walls(model, walls):
    """A model of one particle far off with these walls, which would refuse none of the places a test
    tries.
    """
    return model._replace(
        surface_kind=np.array([int(w.kind) for w in walls]),
        surface_body=np.zeros(len(walls), np.int64),
        surface_material=np.zeros(len(walls), np.int64),
        surface_origin=np.array([w.origin for w in walls], float),
        surface_rotation=np.array([w.rotation for w in walls], float),
        surface_size=np.array([w.size for w in walls], float),
        mesh=mesh_walls(walls, R),
    )


@pytest.mark.parametrize(
    "kind, size, words",
    [
        (
            SurfaceKind.CONE,
            (0.0, 0.0, 0.1),
            'surface "wall": must have two radii of at least 0, not both 0, and a positive height',
        ),
        (SurfaceKind.CONE, (0.1, -0.1, 0.1), "got 0.1, -0.1 and 0.1 m"),
        (SurfaceKind.CONE, (0.1, 0.2, 0.0), "A flat ring is a PLANE"),
        (
            SurfaceKind.SPHERE_CAP,
            (0.1, 4.0, 0.0),
            "a positive radius and an angle from 0 to pi rad, got 0.1 m and 4.0 rad",
        ),
        (SurfaceKind.SPHERE_CAP, (math.nan, 1.0, 0.0), "got nan m"),
        (SurfaceKind.CYLINDER, (0.0, 0.0, 0.0), "radius must be positive, got 0.0 m"),
        (SurfaceKind.BOX, (0.1, 0.1, 0.0), "half sizes must be positive"),
        (SurfaceKind.DISC, (-0.1, 0.0, 0.0), "radius must be positive, got -0.1 m"),
        (SurfaceKind.BALL, (math.inf, 0.0, 0.0), "radius must be positive, got inf m"),
        (SurfaceKind.TUBE, (0.1, 0.0, 0.0), "a positive radius and a positive height, got 0.1 and 0.0 m"),
        (SurfaceKind.ROD, (0.0, 0.1, 0.0), "a positive radius and a positive half height, got 0.0 and 0.1 m"),
        (SurfaceKind.MESH_PATCH, (0.0, 0.0, 0.0), "must have a mesh and the number of one of its patches"),
    ],
)
def test_sizes_that_no_surface_has_are_refused(kind, size, words):
    with pytest.raises(CaseError) as caught:
        charge([[0, 0, 0.05]], [R], [0], [7800.0], {(0, 0): LAW}, [Surface("wall", kind, 0, 0, size=size)], 1)
    assert words in str(caught.value)


# meshes -----------------------------------------------------------------------------------------------------


def refusal(vertices, faces, keep="outside"):
    with pytest.raises(CaseError) as caught:
        closed_mesh("rib.stl", vertices, faces, keep, R)
    return str(caught.value)


def test_open_mesh_names_the_triangles_at_the_hole():
    vertices, faces = octahedron()
    # triangle 3 is gone: its neighbours across its edges have none there
    message = refusal(vertices, np.delete(faces, 2, axis=0))
    assert message.startswith("rib.stl: triangle ")
    assert (
        "the mesh must be closed: each edge must have two triangles, this one has no neighbour, from ("
        in message
    )
    assert ") mm; triangles with such edges: 1, 3, 6. Close the holes" in message


def test_a_triangle_turned_over_is_named():
    vertices, faces = octahedron()
    faces[4] = faces[4, ::-1]
    assert refusal(vertices, faces) == (
        "rib.stl: triangle 5: all triangles must turn the same way, these are inverted against their "
        "neighbours: 5."
        " Make the normals consistent, out of the solid"
    )


def test_a_mesh_inside_out_is_refused():
    vertices, faces = octahedron()
    assert refusal(vertices, faces[:, ::-1]) == (
        "rib.stl: triangle 1: the normals must point out of the solid, this shell of 8 triangles is "
        "inverted. Flip the normals"
    )


def test_degenerate_and_double_triangles_are_named_together():
    vertices, faces = octahedron()
    vertices = np.concatenate([vertices, [[0.005, 0.0, 0.015]]])
    faces = np.concatenate([faces, [(0, 6, 4), faces[5, [1, 2, 0]]]])
    first, second = refusal(vertices, faces).splitlines()
    assert first == (
        "rib.stl: triangle 9: every triangle must have an area, these are degenerate (two corners "
        "the same, or all in a line): 9."
        " Clean the mesh of degenerate faces"
    )
    assert second == (
        "rib.stl: triangle 10: a triangle must be given once, this one repeats triangle 6; repeated: "
        "10. Clean the mesh of double faces"
    )


def test_an_edge_of_more_than_two_triangles_is_refused():
    # two octahedra that share an edge
    vertices, faces = octahedron()
    mirrored = np.array([0.02, 0.02, 0.0]) - vertices * (1, 1, 1)
    message = refusal(np.concatenate([vertices, mirrored]), np.concatenate([faces, faces[:, ::-1] + 6]))
    assert "the mesh must be simple: each edge must have two triangles, one has more, from (" in message
    assert "Give touching solids as meshes of their own" in message
    assert message.startswith("rib.stl: triangles ")


def test_a_cavity_is_no_inverted_shell_and_a_solid_in_a_solid_is_refused():
    vertices, faces = octahedron()
    both = np.concatenate([vertices, 0.5 * vertices])
    vessel = closed_mesh("vessel", both, np.concatenate([faces, faces[:, ::-1] + 6]), "outside", R)
    # octahedron of half diagonal a: 4/3 a^3
    assert vessel.volume == pytest.approx(4 / 3 * 0.02**3 * (1 - 1 / 8))
    assert on_charge_side(vessel, np.array([[0, 0, 0.0], [0, 0, 0.015], [0, 0, 0.03]])).tolist() == [
        True,
        False,
        True,
    ]
    assert "shells must not be inside each other, this shell of 8 triangles does" in refusal(
        both, np.concatenate([faces, faces + 6])
    )


def test_numbers_that_are_none_and_no_triangles_are_refused():
    vertices, faces = octahedron()
    assert "must be triangles" in refusal(vertices, faces[:0])
    assert "finite corners" in refusal(np.where(vertices == 0.02, math.nan, vertices), faces)


def test_a_mesh_of_a_million_triangles_is_refused_with_its_memory_and_a_tolerance_for_the_export():
    vertices, faces = octahedron()
    assert refusal(vertices, np.tile(faces, (125_000, 1))) == (
        "rib.stl: must have at most 500000 triangles, got 1000000, which take about 2.0 GB. Export it with a "
        "coarser tolerance: a distance of 0.025 mm from the drawing, a hundredth of a particle's radius, is "
        "fine enough"
    )


def test_corners_that_a_file_repeats_with_rounding_are_joined():
    vertices, faces = octahedron()
    loose = vertices[faces].reshape(-1, 3) + 1e-9 * np.random.default_rng(1).normal(size=(24, 3))
    mesh = closed_mesh("loose", loose, np.arange(24).reshape(-1, 3), "outside", R)
    assert (len(mesh.vertices), mesh.n_patches) == (6, 8)
    assert mesh.volume == pytest.approx(4 / 3 * 0.02**3, rel=1e-6)


def test_inside_and_outside_differ_at_any_distance():
    points = np.random.default_rng(4).uniform(-0.03, 0.03, (3000, 3))
    points = np.concatenate([points, [[5.0, 0, 0]]])
    within = np.abs(points).sum(axis=1) < 0.02
    assert (on_charge_side(closed_mesh("a", *octahedron(), "inside", R), points) == within).all()
    assert (on_charge_side(closed_mesh("a", *octahedron(), "outside", R), points) == ~within).all()


def test_winding_number_is_the_solid_angle_of_a_square():
    # seen from half its side over its middle, a square fills a sixth of the sphere
    square = np.array([[[-1, -1, 0], [1, -1, 0], [1, 1, 0]], [[-1, -1, 0], [1, 1, 0], [-1, 1, 0]]], float)
    assert winding_number(np.array([[0.0, 0, -1.0], [0.0, 0, 1.0]]), square) == pytest.approx([1 / 6, -1 / 6])


def test_particles_that_start_behind_a_mesh_are_named_however_far_behind():
    room = mesh_surfaces(closed_mesh("room.stl", *octahedron(), "inside", R), 0, 0)
    with pytest.raises(CaseError) as caught:
        charge([[0, 0, 0], [0.1, 0, 0]], [R] * 2, [0] * 2, [7800.0], {(0, 0): LAW}, room, 1)
    assert (
        'mesh "room.stl": particles must start inside of it, these do not: 1. Check its unit and '
        "place, and the fill" in str(caught.value)
    )


def test_edges_part_patches_from_the_crease_angle_on():
    # a roof of two slopes: its ridge bends by twice the slope
    for slope, patches in ((0.45 * CREASE, 4), (0.55 * CREASE, 5)):
        h = 0.01 * math.tan(slope)
        outline = [(-0.01, 0.0), (0.01, 0.0), (0.0, h)]
        vertices = np.array([(x, y, z) for y in (-0.01, 0.01) for x, z in outline])
        faces = np.array(
            [(0, 1, 2), (3, 5, 4), (0, 3, 4), (0, 4, 1), (1, 4, 5), (1, 5, 2), (2, 5, 3), (2, 3, 0)]
        )
        # ends, bottom and roof; the sharp eaves part the roof from the bottom only if they bend enough, and
        # they do: pi - slope
        assert closed_mesh("roof", vertices, faces, "outside", R).n_patches == patches
