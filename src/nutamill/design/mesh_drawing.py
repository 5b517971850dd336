"""The mesh of a chamber compared with the chamber as drawn."""

import math

import numpy as np

from nutamill.base.required import required
from nutamill.case import Case
from nutamill.simulation.setup.walls import wall_mesh


def chamber_volume(case: Case) -> float:
    """Return the volume of the chamber as drawn, without ribs [m^3]."""
    return 0.25 * math.pi * case.chamber.inner_diameter**2 * case.chamber.height


def distance_from_drawing(case: Case) -> float:
    """Return the largest distance [m] of the triangles of the chamber's mesh from the chamber as drawn.

    Sampled at corners, middles of sides and middles of triangles; a facet is farthest from a bore at the
    middle of a side.
    """
    chamber = case.chamber
    wall = next(wall for wall in case.machine.walls if wall.name == "chamber_mesh")
    corners = wall_mesh(case.machine, wall).corners + required(chamber.mesh).at
    sides = 0.5 * (corners + np.roll(corners, 1, axis=1))
    points = np.concatenate([corners, sides, corners.mean(axis=1, keepdims=True)], axis=1)
    x, y, z = points.reshape(-1, 3).T
    out = np.hypot(x, y) - chamber.inner_diameter / 2
    over = np.maximum(-chamber.floor_depth - z, z + chamber.ceiling_depth)
    outside = np.hypot(np.maximum(out, 0.0), np.maximum(over, 0.0))
    return float(np.where((out > 0.0) | (over > 0.0), outside, -np.maximum(out, over)).max())
