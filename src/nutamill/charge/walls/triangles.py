"""Geometry of triangles as plain arrays: edges, areas, distances, winding numbers, and the cells of a grid
near a triangle.

Meshes are made once, before a run; nothing here is compiled.
"""

import numpy as np

AT_ONCE = 400_000
"""Pairs of point and triangle that one pass of `winding_number` holds in memory [1]."""


def normals_and_areas(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return unit normals [1] (n, 3) by the right-hand rule, and areas [m^2] (n,), of triangles with
    `corners` [m] (n, 3, 3).
    """
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    twice = np.linalg.norm(across, axis=1)
    return across / np.maximum(twice, 1e-300)[:, None], 0.5 * twice


def signed_volumes(corners: np.ndarray) -> np.ndarray:
    """Return the volumes [m^3] (n,) of the tetrahedra of triangles `corners` [m] (n, 3, 3) with the origin.
    Their sum is the volume enclosed.
    """
    return np.einsum("ni,ni->n", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0


def directed_edges(faces: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the edges of a mesh without their direction, and which of them each triangle has.

    Returns
    -------
    edges [1] (E, 2), lower corner first; edge of side k (from corner k to the next) of each triangle [1] (T,
    3); True where the side runs from the lower to the higher corner (T, 3)
    """
    sides = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2)
    edges, index = np.unique(np.sort(sides.reshape(-1, 2), axis=1), axis=0, return_inverse=True)
    return edges, index.reshape(-1, 3), sides[:, :, 0] < sides[:, :, 1]


def triangle_distance(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Return the distance [m] (n,) of `points` [m] (n, 3) from one triangle `corners` [m] (3, 3)."""
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    normal /= np.linalg.norm(normal)
    outside = np.zeros(len(points), bool)
    nearest = np.full(len(points), np.inf)
    for k in range(3):
        begin, way = corners[k], corners[(k + 1) % 3] - corners[k]
        gap = points - begin
        outside |= gap @ np.cross(normal, way) < 0.0
        share = np.clip(gap @ way / (way @ way), 0.0, 1.0)
        nearest = np.minimum(nearest, np.linalg.norm(gap - share[:, None] * way, axis=1))
    return np.where(outside, nearest, np.abs((points - corners[0]) @ normal))


def winding_number(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Return how often the triangles `corners` [m] (T, 3, 3) wind about each of the `points` [m] (n, 3):
    their solid angle over 4 pi [1] (n,).

    Of a closed mesh with its normals outwards: 1 inside, 0 outside.
    Source: A. van Oosterom and J. Strackee, "The solid angle of a plane triangle", IEEE Trans. Biomed. Eng.
    30 (1983) 125-126, eq. 8.
    """
    out = np.empty(len(points))
    step = max(1, AT_ONCE // max(1, len(corners)))
    for first in range(0, len(points), step):
        a, b, c = (corners[None, :, k] - points[first : first + step, None] for k in range(3))
        la, lb, lc = (np.linalg.norm(side, axis=2) for side in (a, b, c))
        above = np.einsum("pti,pti->pt", a, np.cross(b, c))
        ab, bc, ca = ((u * v).sum(axis=2) for u, v in ((a, b), (b, c), (c, a)))
        below = la * lb * lc + ab * lc + bc * la + ca * lb
        out[first : first + step] = np.arctan2(above, below).sum(axis=1) / (2.0 * np.pi)
    return out


def cells_near(
    corners: np.ndarray, corner: np.ndarray, size: float, cells: np.ndarray, reach: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the cells of a grid whose middle may be within `reach` of a triangle.

    Parameters
    ----------
    corners : of the triangle [m] (3, 3)
    corner, size, cells : low corner [m] (3,), edge of a cell [m] and number of cells along each axis (3,) of
        the grid
    reach : [m]

    Returns
    -------
    numbers of the cells, the last axis fastest [1] (k,), and the distance of their middles from the triangle
    [m] (k,), at most `reach`
    """
    low = np.clip(np.floor((corners.min(axis=0) - reach - corner) / size).astype(int), 0, cells - 1)
    high = np.clip(np.floor((corners.max(axis=0) + reach - corner) / size).astype(int), 0, cells - 1)
    axes = [np.arange(a, b + 1) for a, b in zip(low, high, strict=True)]
    i, j, k = (axis.ravel() for axis in np.meshgrid(*axes, indexing="ij"))
    apart = triangle_distance(corner + size * (np.stack([i, j, k], axis=1) + 0.5), corners)
    near = apart <= reach
    return ((i * cells[1] + j) * cells[2] + k)[near], apart[near]
