"""Whether two closed solids of triangles reach into each other."""

import numpy as np

from nutamill.charge.walls.triangles import winding_number

PAIRS = 300_000
"""Pairs of edge and triangle that are looked at together [1]."""

INTO = 1e-9
"""Length [m] on both sides of a triangle that an edge must have to cross it: with less it only touches."""

CIRCLE = 48
"""Corners of a polygon that stands for a circle [1]: it is inside of the circle, by 0.2 % of the radius."""

BOX_FACES = np.array(
    [
        [0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
        [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3],
    ]
)  # fmt: skip
"""Triangles of a box with corners in the order of `box_triangles`, normals outwards."""


def box_triangles(half: np.ndarray) -> np.ndarray:
    """Return the twelve triangles [m] (12, 3, 3) of a box about the origin with half sizes [m] (3,)."""
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half
    return corners[BOX_FACES]


def round_triangles(radii: np.ndarray, heights: np.ndarray) -> np.ndarray:
    """Return the triangles [m] (n, 3, 3) of a solid of revolution about z, from its outline: radii and
    heights [m] (k,) from the lowest point to the highest. The first and the last radius are zero.
    """
    angle = np.linspace(0.0, 2.0 * np.pi, CIRCLE + 1)
    around = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    rings = np.concatenate(
        [radii[:, None, None] * around, np.broadcast_to(heights[:, None, None], (len(radii), CIRCLE + 1, 1))],
        axis=2,
    )
    a, b, c, d = rings[:-1, :-1], rings[:-1, 1:], rings[1:, :-1], rings[1:, 1:]
    both = np.concatenate([np.stack([a, b, d], axis=2), np.stack([a, d, c], axis=2)]).reshape(-1, 3, 3)
    across = np.cross(both[:, 1] - both[:, 0], both[:, 2] - both[:, 0])
    return both[np.linalg.norm(across, axis=1) > 0.0]


def rod_triangles(radius: float, half: float) -> np.ndarray:
    """Return the triangles [m] (n, 3, 3) of a rod about z of a radius and half a height [m]."""
    return round_triangles(np.array([0.0, radius, radius, 0.0]), np.array([-half, -half, half, half]))


def ball_triangles(radius: float) -> np.ndarray:
    """Return the triangles [m] (n, 3, 3) of a ball of a radius [m]."""
    polar = np.linspace(0.0, np.pi, CIRCLE // 2 + 1)
    radii = radius * np.sin(polar)
    radii[[0, -1]] = 0.0
    return round_triangles(radii, -radius * np.cos(polar))


def solids_meet(one: np.ndarray, two: np.ndarray) -> bool:
    """Return whether two closed solids of triangles [m] (n, 3, 3), normals outwards, reach into each other:
    an edge of one crosses a triangle of the other, or one is inside of the other.
    """
    if _crosses(one, two) or _crosses(two, one):
        return True
    return any(
        winding_number(inner.reshape(-1, 3)[:1], outer)[0] > 0.5
        for inner, outer in ((one, two), (two, one))
        if _within(inner, outer)
    )


def _within(inner: np.ndarray, outer: np.ndarray) -> bool:
    """Return whether the box around one solid is within that around another."""
    low, high = outer.min(axis=(0, 1)) + INTO, outer.max(axis=(0, 1)) - INTO
    return bool((inner.min(axis=(0, 1)) > low).all() and (inner.max(axis=(0, 1)) < high).all())


def _near(triangles: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Return the triangles [m] (n, 3, 3) whose boxes meet the box around others."""
    low, high = others.min(axis=(0, 1)), others.max(axis=(0, 1))
    meets = (triangles.max(axis=1) > low).all(axis=1) & (triangles.min(axis=1) < high).all(axis=1)
    return triangles[meets]


def _crosses(one: np.ndarray, two: np.ndarray) -> bool:
    """Return whether an edge of a solid crosses a triangle of another (`INTO`)."""
    one, two = _near(one, two), _near(two, one)
    if not len(one) or not len(two):
        return False
    first, second = _pairs_near(one, two)
    step = PAIRS // 3
    for begin in range(0, len(first), step):
        edges, faces = one[first[begin : begin + step]], two[second[begin : begin + step]]
        for k in range(3):
            if _pierced(edges[:, k], edges[:, (k + 1) % 3], faces).any():
                return True
    return False


def _pairs_near(one: np.ndarray, two: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the numbers (n,), (n,) of triangles of each whose boxes meet: a sweep along the axis in which
    they spread most.
    """
    low, high, lowest, highest = one.min(axis=1), one.max(axis=1), two.min(axis=1), two.max(axis=1)
    axis = int(np.argmax(np.ptp(np.concatenate([low, lowest]), axis=0)))
    order = np.argsort(lowest[:, axis])
    begins, longest = lowest[order, axis], float((highest - lowest)[:, axis].max())
    begin = np.searchsorted(begins, low[:, axis] - longest)
    end = np.searchsorted(begins, high[:, axis])
    count = end - begin
    first = np.repeat(np.arange(len(one)), count)
    second = order[np.arange(len(first)) - np.repeat(np.cumsum(count) - count, count) + begin[first]]
    meets = (high[first] > lowest[second]).all(axis=1) & (low[first] < highest[second]).all(axis=1)
    return first[meets], second[meets]


def _pierced(start: np.ndarray, end: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return whether each edge from `start` to `end` [m] (n, 3) passes through its triangle [m] (n, 3, 3),
    with more than `INTO` on both sides of it.

    Source: T. Moeller and B. Trumbore, "Fast, minimum storage ray/triangle intersection", J. Graphics Tools
    2, 21-28 (1997).
    """
    along = end - start
    u, v = faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0]
    normal = np.cross(along, v)
    scale = (u * normal).sum(axis=1)
    apart = start - faces[:, 0]
    upright = np.cross(apart, u)
    with np.errstate(divide="ignore", invalid="ignore"):
        a = (apart * normal).sum(axis=1) / scale
        b = (along * upright).sum(axis=1) / scale
        t = (v * upright).sum(axis=1) / scale
        plane = np.cross(u, v)
        depth = np.abs((along * plane).sum(axis=1)) / np.linalg.norm(plane, axis=1)
        inside = (a > 0.0) & (b > 0.0) & (a + b < 1.0)
        return inside & (t * depth > INTO) & ((1.0 - t) * depth > INTO)
