"""Disc, tube, rod and ball against closed forms and sampled points, and the room that walls bound."""

import math

import numpy as np
import pytest

from nutamill.charge.filling.fill_walls import in_room
from nutamill.charge.walls.shapes import cap_contact, round_contact
from nutamill.charge.walls.surface import Surface, SurfaceKind

R = 0.0025
DISC, TUBE = int(SurfaceKind.DISC), int(SurfaceKind.TUBE)
ROD, BALL = int(SurfaceKind.ROD), int(SurfaceKind.BALL)
HALF = math.sqrt(0.5)


def surface_points(kind, a, b):
    """Points of a surface as distance from its axis and height (n, 2): the half-plane of a centre holds the
    nearest."""
    share = np.linspace(0.0, 1.0, 2001)
    if kind == DISC:
        return np.stack([a * share, 0 * share], axis=1)
    if kind == TUBE:
        return np.stack([a + 0 * share, b * share], axis=1)
    if kind == ROD:
        side = np.stack([a + 0 * share, b * (2 * share - 1)], axis=1)
        return np.concatenate([side, *(np.stack([a * share, end + 0 * share], axis=1) for end in (-b, b))])
    return a * np.stack([np.sin(math.pi * share), np.cos(math.pi * share)], axis=1)


def distance_from_surface(kind, a, b, across, z):
    """How far a point beside a surface is off it [m]: zero on the surface."""
    if kind == DISC:
        return abs(z)
    if kind == TUBE:
        return abs(across - a)
    if kind == ROD:
        return max(abs(max(across - a, abs(z) - b)), across - a, abs(z) - b)
    return abs(math.hypot(across, z) - a)


@pytest.mark.parametrize(
    "kind, a, b",
    [(DISC, 0.02, 0.0), (TUBE, 0.02, 0.03), (ROD, 0.01, 0.006), (ROD, 0.004, 0.02), (BALL, 0.015, 0.0)],
)
def test_overlap_and_normal_lead_to_the_nearest_point(kind, a, b):
    points = surface_points(kind, a, b)
    rng = np.random.default_rng(1)
    touching = 0
    for turn, across, z in zip(
        rng.uniform(0, 7, 600), rng.uniform(0, 0.03, 600), rng.uniform(-0.035, 0.035, 600), strict=True
    ):
        centre = np.array([across * math.cos(turn), across * math.sin(turn), z])
        overlap, *normal = round_contact(kind, *centre, R, a, b)
        if overlap < -1.0:
            behind = -z if kind == DISC else across - a
            beside = across <= a if kind == DISC else 0.0 <= z < b
            assert kind in (DISC, TUBE) and (behind >= R or not beside)
            continue
        assert np.linalg.norm(normal) == pytest.approx(1.0, abs=1e-15)
        foot = centre + (R - overlap) * np.array(normal)
        assert distance_from_surface(kind, a, b, math.hypot(foot[0], foot[1]), foot[2]) < 1e-16
        assert np.linalg.norm(points - (across, z), axis=1).min() >= abs(R - overlap) - 1e-16
        touching += overlap > 0
    assert touching > 10


@pytest.mark.parametrize(
    "kind, size, centre, overlap, normal",
    [
        (DISC, (0.02, 0.0), (0.012, 0.016, 0.002), 0.0005, (0, 0, -1)),
        (DISC, (0.02, 0.0), (0.0, 0.0, -0.0024), 0.0049, (0, 0, -1)),
        (DISC, (0.02, 0.0), (0.0, 0.0, -0.0026), None, None),
        (DISC, (0.02, 0.0), (0.0201, 0.0, 0.002), None, None),
        (TUBE, (0.02, 0.03), (0.0108, 0.0144, 0.0), 0.0005, (0.6, 0.8, 0)),
        (TUBE, (0.02, 0.03), (0.018, 0.0, 0.03), None, None),
        (TUBE, (0.02, 0.03), (0.018, 0.0, -1e-9), None, None),
        (TUBE, (0.02, 0.03), (0.0, -0.0224, 0.01), 0.0049, (0, -1, 0)),
        (TUBE, (0.02, 0.03), (0.0, -0.0226, 0.01), None, None),
        (ROD, (0.01, 0.02), (0.0072, -0.0096, 0.02), 0.0005, (-0.6, 0.8, 0)),
        (ROD, (0.01, 0.02), (0.006, 0.008, -0.022), 0.0005, (0, 0, 1)),
        (ROD, (0.01, 0.02), (0.0, 0.0, 0.022), 0.0005, (0, 0, -1)),
        (ROD, (0.01, 0.02), (0.0, 0.01 + 0.002 * HALF, 0.02 + 0.002 * HALF), 0.0005, (0, -HALF, -HALF)),
        (ROD, (0.01, 0.02), (0.008, 0.0, 0.0), 0.0045, (-1, 0, 0)),
        (ROD, (0.01, 0.02), (0.0, 0.007, -0.019), 0.0035, (0, 0, 1)),
        (BALL, (0.01, 0.0), (0.0, -0.0072, 0.0096), 0.0005, (0, 0.6, -0.8)),
        (BALL, (0.01, 0.0), (0.0, 0.0, 0.004), 0.0085, (0, 0, -1)),
    ],
    ids=lambda value: value.__class__.__name__ if isinstance(value, tuple) else str(value),
)
def test_contact_at_faces_ends_rims_and_behind(kind, size, centre, overlap, normal):
    got, *way = round_contact(kind, *centre, R, *size)
    if overlap is None:
        assert got < -1.0
    else:
        assert got == pytest.approx(overlap, abs=1e-16)
        assert way == pytest.approx(normal, abs=1e-14)


def test_a_centre_on_the_axis_is_pushed_along_a_direction_of_length_one():
    for kind, a, b in ((TUBE, 0.002, 0.02), (ROD, 0.002, 0.02), (BALL, 0.002, 0.0)):
        _, *normal = round_contact(kind, 0.0, 0.0, 0.0, R, a, b)
        assert np.linalg.norm(normal) == 1.0


def test_two_tubes_end_to_end_share_no_point_of_their_seam():
    lower = round_contact(TUBE, 0.998, 0.0, 0.5, 0.01, 1.0, 0.5)[0]
    upper = round_contact(TUBE, 0.998, 0.0, 0.0, 0.01, 1.0, 0.5)[0]
    assert sorted([lower > 0, upper > 0]) == [False, True]


def test_a_bowl_does_not_touch_what_is_a_radius_behind_it():
    assert cap_contact(0.0, 0.0, -0.06 - 0.9 * R, R, 0.06, 1.0)[0] == pytest.approx(1.9 * R)
    assert cap_contact(0.0, 0.0, -0.06 - 1.1 * R, R, 0.06, 1.0)[0] < -1.0


def free(kind, size, *points):
    return in_room([Surface("wall", kind, 0, 0, size=size)], np.array(points, float)).tolist()


def test_walls_that_end_bound_a_room_at_their_own_heights():
    # each: in front, behind, and beyond the heights at which it counts
    verdict = [True, False, True]
    assert free(SurfaceKind.DISC, (1, 0, 0), (0, 0, 0.1), (0.9, 0, -5), (1.1, 0, -5)) == verdict
    assert free(SurfaceKind.TUBE, (1, 2, 0), (0.9, 0, 1), (0.8, 0.7, 1), (3, 0, 2.1)) == verdict
    assert free(SurfaceKind.CONE, (1, 3, 2), (1.9, 0, 1), (0, 2.1, 1), (5, 0, -0.1)) == verdict
    bowl = (1, math.pi / 3, 0)
    assert free(SurfaceKind.SPHERE_CAP, bowl, (0, 0, -0.9), (0.9, 0, -0.6), (2, 0, -0.4)) == verdict
    assert free(SurfaceKind.ROD, (1, 2, 0), (1.1, 0, 0), (0.9, 0, -1.9), (0, 0, -2.1)) == verdict
    assert free(SurfaceKind.BALL, (1, 0, 0), (0.8, 0, 0.7), (0.7, 0, -0.7), (0, 0, -1.1)) == verdict
