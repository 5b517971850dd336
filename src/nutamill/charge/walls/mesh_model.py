"""Meshed walls as arrays: triangles with their edges and corners, and a grid of those near each cell.

``V`` is the number of corners, ``E`` of edges, ``T`` of triangles, ``P`` of patches and ``N`` of grid cells,
over all meshes of a charge. A mesh that several bodies carry, or one body several times, is stored once.
"""

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


class MeshGrid(NamedTuple):
    """One grid of cubes for each patch: the triangles a particle in a cell may touch."""

    reach: float
    """Triangles nearer than this to any point of a cell are listed in it [m]."""
    corner: np.ndarray
    """Low corner [m] (P, 3), surface axes."""
    size: np.ndarray
    """Edge of a cell [m] (P,)."""
    cells: np.ndarray
    """Cells along each axis [1], int64 (P, 3)."""
    first_cell: np.ndarray
    """Place of the first cell of each patch [1], int64 (P,)."""
    begin: np.ndarray
    """Place of the first triangle of each cell in `triangles` [1], int32 (N + 1,)."""
    triangles: np.ndarray
    """Triangles of each cell [1], int32."""
    apart: np.ndarray
    """A distance the patch has at least from every point of a cell [m], float32 (N,)."""


class MeshWalls(NamedTuple):
    """All meshed surfaces of a charge."""

    patch_of: np.ndarray
    """Patch of each surface [1], int64 (S,); -1 where the surface is no mesh."""
    siblings: np.ndarray
    """First patch of the same mesh, and the one after its last [1], int64 (P, 2)."""
    shape: MeshShape
    """Triangles, edges and corners."""
    grid: MeshGrid
    """Where they are."""
