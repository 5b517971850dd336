"""The grid of a mesh: which patches, and which triangles of each, a particle near a cell may touch."""

from collections.abc import Sequence

import numpy as np
from scipy import ndimage

from nutamill.base.kernel import kernel
from nutamill.charge.walls.mesh import Mesh
from nutamill.charge.walls.mesh_contact import nearest_on_triangle
from nutamill.charge.walls.mesh_model import MeshGrid, MeshShape

MOST_CELLS = 2_000_000
"""Cells in the grid of one mesh [1]; beyond, they are made larger than a particle."""

LIST_GAP = 0.5
"""How far a particle may move at least before the patches near it are listed anew, over the largest radius
[1].
"""

RINGS = 12
"""How far around a cell others are looked for that list another patch, in cells [1]."""


@kernel
def near_cells(
    shape, low, high, first_triangle, corner, size, cells, within, cell_out, triangle_out, apart_out
):
    """List the cells of a grid whose middle is within a distance of each triangle of a mesh.

    Parameters
    ----------
    shape : triangles of all meshes, as `MeshShape`
    low, high : corners of the box around each triangle of this mesh [m] (n, 3)
    first_triangle : number of its first triangle among all [1]
    corner, size, cells : of the grid, as in `MeshGrid`
    within : distance [m]
    cell_out, triangle_out, apart_out : cell, triangle and distance of the middle [m] of each pair, as many as
        there is room for

    Returns
    -------
    number of pairs
    """
    n, room = 0, cell_out.shape[0]
    n0, n1, n2 = cells[0], cells[1], cells[2]
    for t in range(low.shape[0]):
        i0 = max(0, int((low[t, 0] - within - corner[0]) / size))
        i1 = min(n0 - 1, int((high[t, 0] + within - corner[0]) / size))
        j0 = max(0, int((low[t, 1] - within - corner[1]) / size))
        j1 = min(n1 - 1, int((high[t, 1] + within - corner[1]) / size))
        k0 = max(0, int((low[t, 2] - within - corner[2]) / size))
        k1 = min(n2 - 1, int((high[t, 2] + within - corner[2]) / size))
        for i in range(i0, i1 + 1):
            for j in range(j0, j1 + 1):
                for k in range(k0, k1 + 1):
                    _, _, d0, d1, d2 = nearest_on_triangle(
                        shape,
                        first_triangle + t,
                        corner[0] + size * (i + 0.5),
                        corner[1] + size * (j + 0.5),
                        corner[2] + size * (k + 0.5),
                    )
                    apart = (d0 * d0 + d1 * d1 + d2 * d2) ** 0.5
                    if apart <= within:
                        if n < room:
                            cell_out[n] = (i * n1 + j) * n2 + k
                            triangle_out[n] = first_triangle + t
                            apart_out[n] = apart
                        n += 1
    return n


def mesh_grid(
    meshes: Sequence[Mesh], shape: MeshShape, first_patch: np.ndarray, largest_radius: float
) -> MeshGrid:
    """Return the grids of all meshes, one after the other.

    Parameters
    ----------
    meshes : in the order of their triangles in `shape`
    shape : their triangles
    first_patch : number of the first patch of each mesh [1] (G + 1,)
    largest_radius : of the particles [m]
    """
    behind = largest_radius * (1.0 + 1e-9)
    reach = largest_radius * (1.0 + LIST_GAP)
    corner, size, cells, parts = [], [], [], []
    first_triangle = 0
    for k, mesh in enumerate(meshes):
        low, high = mesh.vertices.min(axis=0) - reach, mesh.vertices.max(axis=0) + reach
        edge = max(largest_radius, float(np.prod(high - low) / MOST_CELLS) ** (1 / 3))
        count = np.ceil((high - low) / edge).astype(np.int64)
        parts.append(_one_grid(mesh, shape, first_triangle, first_patch[k], low, edge, count, reach))
        corner.append(low)
        size.append(edge)
        cells.append(count)
        first_triangle += len(mesh.faces)
    first_cell = np.cumsum([0, *(count.prod() for count in cells)])
    begin, patch, face, first, triangles, apart = _joined(parts)
    return MeshGrid(
        reach=reach,
        behind=behind,
        corner=np.array(corner, float).reshape(-1, 3),
        size=np.array(size, float),
        cells=np.array(cells, np.int64).reshape(-1, 3),
        first_cell=first_cell[:-1].astype(np.int64),
        begin=begin,
        patch=patch,
        face=face,
        first=first,
        triangles=triangles,
        apart=apart,
    )


def _one_grid(mesh, shape, first_triangle, first_patch, low, size, cells, reach) -> tuple:
    """Return begin, patch, face, first, triangles and apart of the grid of one mesh, as in `MeshGrid`."""
    half = 0.5 * np.sqrt(3.0) * size * (1.0 + 1e-9)
    corners = mesh.corners
    box = corners.min(axis=1), corners.max(axis=1)
    fixed = (shape, *box, first_triangle, low, size, cells, reach + half)
    none = np.zeros(0, np.int32), np.zeros(0, np.int32), np.zeros(0, np.float32)
    n = near_cells(*fixed, *none)
    cell, triangle, away = np.empty(n, np.int32), np.empty(n, np.int32), np.empty(n, np.float32)
    near_cells(*fixed, cell, triangle, away)
    # by cell and patch; triangles in ascending order within, as they were listed
    key = cell.astype(np.int64) * mesh.n_patches + mesh.patch[triangle - first_triangle]
    order = np.argsort(key, kind="stable")
    key, cell, triangle, away = key[order], cell[order], triangle[order], away[order]
    first = np.flatnonzero(np.diff(key, prepend=-1))
    nearest = np.minimum.reduceat(away, first) if n else away
    hits = np.flatnonzero(away == np.repeat(nearest, np.diff(first, append=n)))[::-1]
    face = np.empty(len(first), np.int32)
    face[np.searchsorted(first, hits, side="right") - 1] = triangle[hits]
    n_cells = int(cells.prod())
    begin = np.searchsorted(cell[first], np.arange(n_cells + 1))
    patch = first_patch + key[first] % mesh.n_patches
    core = np.zeros(n_cells, bool)
    core[cell[away <= half * (1.0 + 1e-6)]] = True  # distances are in single precision
    # each triangle is in core cells; two points of two cells are nearer than their middles by a diagonal at
    # most
    apart = np.maximum(size * ndimage.distance_transform_edt(~core.reshape(cells)).ravel() - 2.0 * half, 0.0)
    apart = np.where(
        np.diff(begin) == 0, apart, _others_apart(begin, key[first] % mesh.n_patches, size, cells, reach)
    )
    return begin, patch, face, np.append(first, n), triangle, apart * (1.0 - 1e-6)


def _others_apart(begin, patch, size, cells, reach) -> np.ndarray:
    """Return a distance [m] that all patches but the one which a cell lists have at least from every point of
    it, 0 for cells that list several or none.

    A straight way from a cell to a patch that none of the cells around it lists leaves them first, and is
    still out of reach of the patch there.
    """
    listed = np.diff(begin)
    sole = np.where(listed == 1, patch[np.minimum(begin[:-1], len(patch) - 1)] + 1, 0).reshape(cells)
    listed, away = listed.reshape(cells), np.zeros(cells)
    for number, box in enumerate(ndimage.find_objects(sole), 1):
        if box is None:
            continue
        around = tuple(slice(max(0, s.start - RINGS), s.stop + RINGS) for s in box)
        own = sole[around] == number
        others = (listed[around] > 0) & ~own
        steps = np.full(own.shape, RINGS + 1)
        if others.any():
            to_others = ndimage.distance_transform_cdt(~others, "chessboard")
            steps = np.minimum(steps, to_others)
        away[around][own] = reach + size * (steps[own] - 1)
    return away.ravel()


def _joined(parts) -> tuple[np.ndarray, ...]:
    """Join the arrays of several grids to one set, places in one array shifted by what comes before."""
    begins, patches, faces, firsts, triangles, aparts = zip(*parts, strict=True) if parts else ([],) * 6
    near = np.cumsum([0, *(len(patch) for patch in patches)])
    listed = np.cumsum([0, *(len(triangle) for triangle in triangles)])
    zero = [np.zeros(1)]
    return (
        np.concatenate(zero + [b[1:] + near[k] for k, b in enumerate(begins)]).astype(np.int32),
        np.concatenate([np.zeros(0), *patches]).astype(np.int32),
        np.concatenate([np.zeros(0), *faces]).astype(np.int32),
        np.concatenate(zero + [f[1:] + listed[k] for k, f in enumerate(firsts)]).astype(np.int32),
        np.concatenate([np.zeros(0), *triangles]).astype(np.int32),
        np.concatenate([np.zeros(0), *aparts]).astype(np.float32),
    )
