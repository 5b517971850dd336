"""Where the parts of a machine are as assembled: axes along a direction, attitudes, corners of regions."""

import math
from collections.abc import Sequence

import numpy as np

from nutamill.case.names import Turn
from nutamill.case.walls import RegionEntry

RIM_POINTS = 96
"""Points on each rim of a cylindrical region [1]."""


def axes_along(
    axis: Sequence[float] | np.ndarray, across: Sequence[float] | np.ndarray | None = None
) -> np.ndarray:
    """Return right-handed axes as columns (3, 3): z along `axis`, x as near as can be to `across`, or to the
    world's x axis, or where that is parallel to z, to its y axis.
    """
    z = np.asarray(axis, float) / np.linalg.norm(axis)
    if across is None:
        across = (1.0, 0.0, 0.0) if abs(z[0]) < 0.9 else (0.0, 1.0, 0.0)
    x = np.asarray(across, float) - (np.asarray(across, float) @ z) * z
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def quaternion_of(turn: Turn | None) -> np.ndarray:
    """Return the attitude (w, x, y, z) after a rotation about an axis."""
    if turn is None:
        return np.array([1.0, 0.0, 0.0, 0.0])
    axis = np.asarray(turn.axis, float) / np.linalg.norm(turn.axis)
    return np.array([math.cos(0.5 * turn.angle), *(math.sin(0.5 * turn.angle) * axis)])


def region_axes(region: RegionEntry) -> np.ndarray:
    """Return the axes of a region as columns (3, 3), world."""
    return axes_along(region.axis, region.across)


def shape_corners(region: RegionEntry) -> np.ndarray | None:
    """Return the corners of a region [m] (n, 3), world as assembled, of a cylinder points on its rims. None
    for the inside of a mesh.
    """
    axes, point = region_axes(region), np.array(region.point, float)
    if region.size is not None:
        signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
        return point + (0.5 * signs * region.size) @ axes.T
    if region.radius is None or region.height is None:
        return None
    angle = np.linspace(0.0, math.tau, RIM_POINTS, endpoint=False)
    around = region.radius * np.column_stack([np.cos(angle), np.sin(angle)])
    ends = [np.column_stack([around, np.full(RIM_POINTS, z)]) for z in (0.0, region.height)]
    return point + np.concatenate(ends) @ axes.T
