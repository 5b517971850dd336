"""Meshed walls as arrays: triangles with their edges and corners, and a grid of those near each cell.

``V`` is the number of corners, ``E`` of edges, ``T`` of triangles, ``P`` of patches and ``N`` of grid cells,
over all meshes of a charge. A mesh that several bodies carry, or one body several times, is stored once.
"""

from enum import IntEnum
from typing import NamedTuple

import numpy as np


class MeshShape(NamedTuple):
    """Triangles and the features they share; normals point to the charge."""

    vertices: np.ndarray
    """Corners [m] (V, 3), surface axes."""
    vertex_normal: np.ndarray
    """Normal at each corner, weighted by angle [1] (V, 3), surface axes."""
    vertex_owner: np.ndarray
    """Patch a contact at the corner belongs to [1], int32 (V,)."""
    vertex_slack: np.ndarray
    """Slack of the corner's region [m] (V,); 0 where patches meet."""
    vertex_first: np.ndarray
    """Place of the first edge of each corner in `vertex_edges` [1], int32 (V + 1,)."""
    vertex_edges: np.ndarray
    """Edges of each corner [1], int32 (2 E,)."""
    edge_ends: np.ndarray
    """Corner the edge begins and ends at [1], int32 (E, 2)."""
    edge_direction: np.ndarray
    """Direction from begin to end [1] (E, 3), surface axes."""
    edge_length: np.ndarray
    """Length [m] (E,)."""
    edge_wing: np.ndarray
    """Unit vector in the plane of each of its two triangles, at right angles to the edge, into the triangle
    [1] (E, 2, 3), surface axes.
    """
    edge_normal: np.ndarray
    """Sum of the normals of its two triangles [1] (E, 3), surface axes."""
    edge_triangles: np.ndarray
    """Its two triangles [1], int32 (E, 2)."""
    edge_owner: np.ndarray
    """Patch a contact at the edge belongs to [1], int32 (E,)."""
    edge_slack: np.ndarray
    """Slack of the edge's region [m] (E,); 0 where patches meet."""
    triangle_edges: np.ndarray
    """Its three edges [1], int32 (T, 3)."""
    triangle_side: np.ndarray
    """Whether it is the first or the second triangle of each of its edges [1], int32 (T, 3)."""
    triangle_normal: np.ndarray
    """Unit normal [1] (T, 3), surface axes."""
    triangle_height: np.ndarray
    """Height of the triangle's plane over the origin, along the normal [m] (T,)."""


class FaceColumn(IntEnum):
    """Columns of `MeshFaces.rows`."""

    NORMAL = 0
    """Unit normal [1] (3), surface axes."""
    HEIGHT = 3
    """Height of the plane over the origin, along the normal [m]."""
    EDGES = 4
    """For each of the three edges, its wing [1] (3) and the coordinate of the edge along it [m]."""
    MARGIN = 16
    """Where no other triangle of the patch can be nearer to a point at most `MeshGrid.reach` above this one:
    the least distances of its foot from the edges [m] (3), and the largest ones, negative [m] (3), which keep
    it clear of the corners opposite.
    """
    NEAR_MARGIN = 22
    """The same for a point at most `MeshGrid.behind` above [m] (6): that of a sphere that touches."""


def rows_on_lines(n: int, columns: int) -> np.ndarray:
    """Return rows (n, columns) of zeros, each of whole lines of the cache if `columns` is a multiple of 8."""
    raw = np.zeros(n * columns + 8)
    offset = -raw.ctypes.data % 64 // raw.itemsize
    return raw[offset : offset + n * columns].reshape(n, columns)


class MeshFaces(NamedTuple):
    """What one triangle alone decides: where a point above it needs no look at its neighbours."""

    rows: np.ndarray
    """A row for each triangle, as `FaceColumn` (T, 32)."""
    across: np.ndarray
    """Triangle of the same patch across each edge [1], -1 where there is none, int32 (T, 3)."""
    rivals_begin: np.ndarray
    """Place of the first rival of each triangle in `rivals` [1], int32 (T + 1,)."""
    rivals: np.ndarray
    """Triangles of the patch that may be nearer to a point above the triangle than itself, and itself, in
    ascending order [1], int32; none where there are too many.
    """
    rival_margins: np.ndarray
    """Of each rival: distances as `FaceColumn.NEAR_MARGIN`, where it alone is no nearer [m], float32,
    (rivals, 6).
    """
    edge_width: float
    """A foot nearer than this to an edge counts as on it [m]."""


class MeshGrid(NamedTuple):
    """One grid of cubes for each mesh: the patches, and the triangles of each, that are near each cell.

    ``G`` is the number of meshes, ``N`` of cells, ``Q`` of pairs of a cell and a patch near it.
    """

    reach: float
    """Triangles nearer than this to any point of a cell are listed in it [m]."""
    behind: float
    """A centre deeper than this behind a mesh is not pushed out [m]."""
    corner: np.ndarray
    """Low corner [m] (G, 3), surface axes."""
    size: np.ndarray
    """Edge of a cell [m] (G,)."""
    cells: np.ndarray
    """Cells along each axis [1], int64 (G, 3)."""
    first_cell: np.ndarray
    """Place of the first cell of each mesh [1], int64 (G,)."""
    begin: np.ndarray
    """Place of the first patch of each cell [1], int32 (N + 1,)."""
    patch: np.ndarray
    """Patches near each cell, in ascending order [1], int32 (Q,)."""
    face: np.ndarray
    """The triangle of each of them that is nearest to the middle of the cell [1], int32 (Q,)."""
    first: np.ndarray
    """Place of the first triangle of each of them in `triangles` [1], int32 (Q + 1,)."""
    triangles: np.ndarray
    """Triangles of each of them, in ascending order [1], int32."""
    apart: np.ndarray
    """A distance that all patches which are not listed near a cell have at least from every point of it [m],
    float32 (N,); `reach` is one, too.
    """


class MeshPlaces(NamedTuple):
    """Where meshes are: a mesh at one place of one body, ``I`` of them."""

    body: np.ndarray
    """Carrying body [1], int64 (I,)."""
    mesh: np.ndarray
    """Mesh [1], int64 (I,)."""
    first: np.ndarray
    """Place of its first patch in `surface` [1], int64 (I + 1,)."""
    surface: np.ndarray
    """Surface of each patch [1], int64; -1 where the patch is no surface of the charge."""


class MeshWalls(NamedTuple):
    """All meshed surfaces of a charge."""

    patch_of: np.ndarray
    """Patch of each surface [1], int64 (S,); -1 where the surface is no mesh."""
    place_of: np.ndarray
    """Place of each surface among `places` [1], int64 (S,); -1 where the surface is no mesh."""
    mesh_of: np.ndarray
    """Mesh of each patch [1], int64 (P,)."""
    first_patch: np.ndarray
    """First patch of each mesh [1], int64 (G + 1,)."""
    shape: MeshShape
    """Triangles, edges and corners."""
    faces: MeshFaces
    """Triangles by themselves."""
    grid: MeshGrid
    """Where the triangles are."""
    places: MeshPlaces
    """Where the meshes are."""
