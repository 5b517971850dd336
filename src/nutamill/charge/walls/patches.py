"""Surfaces cut into patches, and cells: index of the one that holds a point."""

import math
from typing import NamedTuple

import numpy as np

from nutamill.base.kernel import kernel

ANGLE_HEIGHT, ANGLE_RADIUS, FACE_HEIGHT = 0, 1, 2
"""How a surface is cut into patches: by azimuth and height in its own axes, by azimuth and distance from its
z axis, or by the six faces of a box (-x, +x, -y, +y, -z, +z) and height."""


class PatchTable(NamedTuple):
    """How each surface is cut into patches."""

    kind: np.ndarray
    """`ANGLE_HEIGHT` and others [1], int64 (S,)."""
    first: np.ndarray
    """First patch of each surface [1], and behind the last one, int64 (S + 1,)."""
    rows: np.ndarray
    """Patches of each surface along its second coordinate [1], int64 (S,)."""
    range: np.ndarray
    """Lowest and highest second coordinate of each surface [m] (S, 2), surface axes; points beyond
    count in the outermost patch.
    """


def patch_table(cuts: list[tuple[int, int, int, float, float]]) -> PatchTable:
    """Return a table from one row for each surface: how it is cut, patches along the azimuth (6 for
    `FACE_HEIGHT`), patches along the second coordinate [1], its lowest and highest value [m]."""
    return PatchTable(
        np.array([cut[0] for cut in cuts], np.int64),
        np.cumsum([0] + [cut[1] * cut[2] for cut in cuts]).astype(np.int64),
        np.array([cut[2] for cut in cuts], np.int64),
        np.array([cut[3:] for cut in cuts], float).reshape(-1, 2),
    )


@kernel(inline="always")
def whole(value, per_unit):
    """Return the nearest whole number of small units, `per_unit` of them in 1."""
    return np.int64(math.floor(float(value) * per_unit + 0.5))


@kernel(inline="always")
def part_of(value, low, high, n):
    """Return which of `n` equal parts from `low` to `high` holds `value`. The outermost hold all beyond."""
    k = math.floor((value - low) / (high - low) * n)
    return min(max(k, 0), n - 1)


@kernel(inline="always")
def sector_of(angle, n):
    """Return which of `n` sectors holds an angle [rad]. Sector 0 begins at angle 0."""
    turns = angle * (0.5 / math.pi)
    return min(int((turns - math.floor(turns)) * n), n - 1)


@kernel
def patch_of(table, pose, size, s, p0, p1, p2):
    """Return the number of the patch of surface `s` at the point (p0, p1, p2) [m], world.

    `pose` (12,) is where the surface is, as from `place_surfaces`, and `size` (3,) [m] its sizes.
    """
    d0, d1, d2 = p0 - pose[0], p1 - pose[1], p2 - pose[2]
    a = pose[3] * d0 + pose[6] * d1 + pose[9] * d2
    b = pose[4] * d0 + pose[7] * d1 + pose[10] * d2
    c = pose[5] * d0 + pose[8] * d1 + pose[11] * d2
    rows, first, kind = table.rows[s], table.first[s], table.kind[s]
    along = math.sqrt(a * a + b * b) if kind == ANGLE_RADIUS else c
    row = part_of(along, table.range[s, 0], table.range[s, 1], rows)
    if kind == FACE_HEIGHT:
        out_a, out_b, out_c = abs(a) - size[0], abs(b) - size[1], abs(c) - size[2]
        if out_a >= out_b and out_a >= out_c:
            face = int(a > 0.0)
        elif out_b >= out_c:
            face = 2 + int(b > 0.0)
        else:
            face = 4 + int(c > 0.0)
        return first + face * rows + row
    sectors = (table.first[s + 1] - first) // rows
    return first + sector_of(math.atan2(b, a), sectors) * rows + row
