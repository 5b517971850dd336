"""What one triangle of a patch decides by itself: where a point above it is nearer to it than to any other.

A sphere that touches the plane of a triangle from the front at its foot q, of radius D, holds the points in
front of the plane, at height h and distance s from the foot along it, with s < w(h) = sqrt(2 D h - h^2).  So
a triangle can only come nearer if it rises in front of the plane, and only to feet that are close to it.
Each such *rival* asks for margins from the edges of the triangle: inside of all margins the triangle is the
nearest of its patch, between margin and edge it or one of its rivals is.  Flat and bulging patches have no
rivals; those of a hollow patch are close to its seams, where the margin is D tan(bend/2).  There are margins
for two radii: for points as far away as the grid reaches, and for spheres that touch, which are most.  Each
rival has its own of the second kind, so that only those beyond the edges close to a foot are tested.

The half circle w(h) is bounded from above by tangents, so that the largest margin over a rival is that of one
of its corners.
"""

import math
from collections.abc import Sequence

import numpy as np

from nutamill.base.kernel import kernel
from nutamill.charge.walls.mesh import Mesh
from nutamill.charge.walls.mesh_contact import beside
from nutamill.charge.walls.mesh_model import FaceColumn, MeshFaces, MeshGrid, MeshShape, rows_on_lines

NORMAL, HEIGHT, EDGES, MARGIN, NEAR_MARGIN = (int(column) for column in FaceColumn)

COLUMNS = 32
"""Numbers of a row of `MeshFaces` [1], the last four of which are not used: four lines of the cache."""

MARGINS = 6
"""Margins of a triangle [1]: from its edges, and from its corners towards the edges opposite."""

FROM_CORNERS = 4
"""Column of a polygon behind its height and its distances from three edges: from three corners."""

EDGE_WIDTH = 2e-6
"""Feet nearer to an edge count as on it, and every margin is at least this, over the reach [1]: it is more
than rounding can move a foot, and than w of a height of `LEVEL`."""

LEVEL = 1e-12
"""Heights over a plane that count as in it, over the reach [1]."""

MOST_RIVALS = 64
"""Rivals of one triangle [1]; where there are more, the triangle decides nothing by itself."""

SLOPES = np.geomspace(1e-4, 3.0, 80)
"""Angles of the tangents to the half circle, from the plane [rad]; the last ones fall."""


@kernel
def cut_polygon(polygon, n, column, other, level, out):
    """Write the part of a polygon where column `column` is at least `level`, or where there is an `other`
    column at least that, to `out`, and return the number of its corners.

    Rows of `polygon` are corners, columns functions that are linear over it; `other` is -1 where there is
    none.
    """
    m = 0
    for k in range(n):
        following = (k + 1) % n
        a = polygon[k, column] - (polygon[k, other] if other >= 0 else level)
        b = polygon[following, column] - (polygon[following, other] if other >= 0 else level)
        if a >= 0.0:
            for e in range(polygon.shape[1]):
                out[m, e] = polygon[k, e]
            m += 1
        if (a > 0.0 and b < 0.0) or (a < 0.0 and b > 0.0):
            share = a / (a - b)
            for e in range(polygon.shape[1]):
                out[m, e] = polygon[k, e] + share * (polygon[following, e] - polygon[k, e])
            m += 1
    return m


@kernel
def margin_against(polygon, n, way, offsets, slopes):
    """Return the margin [m] from an edge or corner, number `way` of them, that keeps feet clear of a polygon,
    corners as in `rival_margins`.

    `offsets` [m] and `slopes` [1] are those of the tangents to the half circle.
    """
    least = math.inf
    for k in range(offsets.shape[0]):
        most = -math.inf
        for q in range(n):
            most = max(most, offsets[k] + slopes[k] * polygon[q, 0] + polygon[q, 1 + way])
        least = min(least, most)
    return least


@kernel
def clear_of_rival(shape, corners, f, whole, n, offsets, slopes, work_scratch, margins_out):
    """Raise margins of triangle `f` so that feet inside of them are clear of the polygon `whole` of a rival.

    It is cleared by one edge, by one corner, or by each edge for the points that are farthest beyond it:
    whatever leaves the most of the triangle.

    Parameters
    ----------
    whole, n : corners of the polygon as in `rival_margins`, and their number
    offsets, slopes : as in `margin_against`
    margins_out : from edges and corners [m] (6,)
    """
    part, rest, by_edges = work_scratch[1], work_scratch[2], work_scratch[3, 3]
    least, which, best, lost = math.inf, 0, 0.0, 0.0
    for k in range(3):
        length = shape.edge_length[shape.triangle_edges[f, k]]
        margin = margin_against(whole, n, k, offsets, slopes)
        if margin * length < least:
            least, which, best = margin * length, k, margin
        margin = margin_against(whole, n, 3 + k, offsets, slopes)
        # the corner opposite is cut off along a line parallel to the edge
        area = 0.5 * margin * abs(margin) * length / height_over_edge(shape, corners, f, k)
        if area < least:
            least, which, best = area, 3 + k, margin
        m = cut_polygon(whole, n, 1 + (k + 1) % 3, 1 + k, 0.0, part)
        m = cut_polygon(part, m, 1 + (k + 2) % 3, 1 + k, 0.0, rest)
        by_edges[k] = margin_against(rest, m, k, offsets, slopes) if m > 0 else -math.inf
        lost += max(by_edges[k], 0.0) * length
    if least <= lost:
        margins_out[which] = max(margins_out[which], best)
    else:
        for k in range(3):
            margins_out[k] = max(margins_out[k], by_edges[k])


@kernel(inline="always")
def height_over_edge(shape, corners, f, k):
    """Return the distance of the corner opposite edge `k` of triangle `f` from that edge [m]."""
    most = 0.0
    for q in range(3):
        v, e = shape.vertices[corners[f, q]], shape.triangle_edges[f, k]
        most = max(most, beside(shape, e, shape.triangle_side[f, k], v[0], v[1], v[2]))
    return most


@kernel
def rival_margins(
    shape, corners, f, t, reach, offsets, near_offsets, slopes, work_scratch, margins_out, near_out
):
    """Raise the margins of triangle `f` so that triangle `t` is no nearer inside of them, and return whether
    it can be nearer anywhere above `f`.

    Parameters
    ----------
    shape, corners : triangles, and the corners of each [1] (T, 3)
    reach : largest distance of a point from `f` [m]
    offsets, near_offsets, slopes : as in `margin_against`, for `reach` and for a sphere that touches
    work_scratch : space for three polygons and some rows (4, 12, 7): height over `f` [m], distances on the
        inner side of its edges and of the parallels to them through the corners [m] (3 each) of each corner
    margins_out : for points within reach [m] (6,)
    near_out : for spheres that touch, against this rival alone [m] (6,); -inf at first
    """
    whole, part = work_scratch[0], work_scratch[1]
    v = shape.edge_ends[shape.triangle_edges[f, 0], 0]
    highest = -math.inf
    for q in range(3):
        w = corners[t, q]
        x, y, z = shape.vertices[w, 0], shape.vertices[w, 1], shape.vertices[w, 2]
        part[q, 0] = (
            (x - shape.vertices[v, 0]) * shape.triangle_normal[f, 0]
            + (y - shape.vertices[v, 1]) * shape.triangle_normal[f, 1]
            + (z - shape.vertices[v, 2]) * shape.triangle_normal[f, 2]
        )
        highest = max(highest, part[q, 0])
        for k in range(3):
            part[q, 1 + k] = beside(shape, shape.triangle_edges[f, k], shape.triangle_side[f, k], x, y, z)
    if highest <= LEVEL * reach:
        return False
    for k in range(3):
        if max(part[0, 1 + k], max(part[1, 1 + k], part[2, 1 + k])) < -reach:
            return False
        for q in range(3):
            part[q, FROM_CORNERS + k] = height_over_edge(shape, corners, f, k) - part[q, 1 + k]
    n = cut_polygon(part, 3, 0, -1, LEVEL * reach, whole)
    for way in range(MARGINS):
        if margin_against(whole, n, way, offsets, slopes) <= 0.0:
            return False
    clear_of_rival(shape, corners, f, whole, n, offsets, slopes, work_scratch, margins_out)
    clear_of_rival(shape, corners, f, whole, n, near_offsets, slopes, work_scratch, near_out)
    return True


@kernel
def find_rivals(
    shape,
    corners,
    patch,
    grid,
    mesh,
    first,
    end,
    offsets,
    near_offsets,
    slopes,
    mark_scratch,
    work_scratch,
    rows_out,
    counts_out,
    rivals_out,
    margins_out,
):
    """Set the margins of the triangles `first` to `end` of a mesh, and list their rivals.

    Parameters
    ----------
    shape, corners, patch : triangles, the corners (T, 3) and the patch (T,) of each [1]
    grid, mesh : the grids, and the number of this mesh
    offsets, near_offsets, slopes : as in `rival_margins`
    mark_scratch : work space, int32 (T,), -1 at first
    work_scratch : as in `rival_margins`
    rows_out : margins are added to `MeshFaces.rows`
    counts_out : number of rivals of each triangle [1] (T,); 0 where there are too many
    rivals_out : rivals of one triangle after the other, as many as there is room for, (room,)
    margins_out : margins of each of them, as `MeshFaces.rival_margins` (room, 6)

    Returns
    -------
    number of rivals
    """
    reach, size, total = grid.reach, grid.size[mesh], 0
    room = rivals_out.shape[0]
    low, high, near = work_scratch[3, 0], work_scratch[3, 1], work_scratch[3, 2]
    cells = grid.cells[mesh]
    for f in range(first, end):
        # cells that a point above the triangle, within reach, may be in
        for k in range(3):
            up = reach * shape.triangle_normal[f, k]
            a, b = math.inf, -math.inf
            for q in range(3):
                at = shape.vertices[corners[f, q], k] - grid.corner[mesh, k]
                a, b = min(a, min(at, at + up)), max(b, max(at, at + up))
            low[k] = max(0.0, a / size - 1e-6)
            high[k] = min(cells[k] - 1.0, b / size + 1e-6)
        start = total
        crowded = False
        for i in range(int(low[0]), int(high[0]) + 1):
            for j in range(int(low[1]), int(high[1]) + 1):
                for k in range(int(low[2]), int(high[2]) + 1):
                    cell = grid.first_cell[mesh] + (i * cells[1] + j) * cells[2] + k
                    for p in range(grid.begin[cell], grid.begin[cell + 1]):
                        if grid.patch[p] != patch[f]:
                            continue
                        for q in range(grid.first[p], grid.first[p + 1]):
                            t = grid.triangles[q]
                            if mark_scratch[t] == f:
                                continue
                            mark_scratch[t] = f
                            for e in range(MARGINS):
                                near[e] = math.inf if t == f else -math.inf
                            rival = t == f or rival_margins(
                                shape,
                                corners,
                                f,
                                t,
                                reach,
                                offsets,
                                near_offsets,
                                slopes,
                                work_scratch,
                                rows_out[f, MARGIN:NEAR_MARGIN],
                                near,
                            )
                            if rival and t != f:
                                for e in range(MARGINS):
                                    rows_out[f, NEAR_MARGIN + e] = max(rows_out[f, NEAR_MARGIN + e], near[e])
                            if rival and not crowded:
                                # in ascending order
                                place = total
                                total += 1
                                if total <= room:
                                    while place > start and rivals_out[place - 1] > t:
                                        rivals_out[place] = rivals_out[place - 1]
                                        for e in range(MARGINS):
                                            margins_out[place, e] = margins_out[place - 1, e]
                                        place -= 1
                                    rivals_out[place] = t
                                    for e in range(MARGINS):
                                        margins_out[place, e] = near[e]
                                crowded = total - start > MOST_RIVALS
        if crowded:
            total = start
            for k in range(MARGINS):
                rows_out[f, MARGIN + k] = rows_out[f, NEAR_MARGIN + k] = math.inf
        counts_out[f] = total - start
    return total


def mesh_faces(shape: MeshShape, grid: MeshGrid, patch: np.ndarray, meshes: Sequence[Mesh]) -> MeshFaces:
    """Return what each triangle decides by itself.

    Parameters
    ----------
    shape, grid : of all meshes
    patch : patch of each triangle [1] (T,)
    meshes : in the order of their triangles
    """
    n = len(shape.triangle_normal)
    edges, side = shape.triangle_edges, shape.triangle_side
    begin = shape.edge_ends[edges][:, :, 0]
    wings = shape.edge_wing[edges, side]
    others = shape.edge_triangles[edges, 1 - side]
    rows = rows_on_lines(n, COLUMNS)
    rows[:, NORMAL:HEIGHT] = shape.triangle_normal
    rows[:, HEIGHT] = shape.triangle_height
    for k in range(3):
        rows[:, EDGES + 4 * k : EDGES + 4 * k + 3] = wings[:, k]
        rows[:, EDGES + 4 * k + 3] = (wings[:, k] * shape.vertices[begin[:, k]]).sum(axis=1)
    rows[:, MARGIN : NEAR_MARGIN + MARGINS] = EDGE_WIDTH * grid.reach
    corners = np.concatenate([np.zeros((0, 3), int), *_numbered_corners(meshes)])
    counts, room = np.zeros(n, np.int32), 24 * n + MOST_RIVALS
    rivals, margins, listed = np.zeros(room, np.int32), np.zeros((room, MARGINS), np.float32), 0
    tangents = np.tan(SLOPES / 2.0), 1.0 / np.tan(SLOPES)
    mark_scratch, work_scratch = np.full(n, -1, np.int32), np.zeros((4, 12, 1 + MARGINS))
    first = 0
    for k, mesh in enumerate(meshes):
        end = first + len(mesh.faces)
        fixed = (
            shape,
            corners,
            patch,
            grid,
            k,
            first,
            end,
            grid.reach * tangents[0],
            grid.behind * tangents[0],
            tangents[1],
            mark_scratch,
            work_scratch,
            rows,
            counts,
        )
        more = find_rivals(*fixed, rivals[listed:], margins[listed:])
        if listed + more > len(rivals):
            rivals = np.concatenate([rivals[:listed], np.zeros(more + room, np.int32)])
            margins = np.concatenate([margins[:listed], np.zeros((more + room, MARGINS), np.float32)])
            mark_scratch[first:end] = -1
            find_rivals(*fixed, rivals[listed:], margins[listed:])
        listed += more
        first = end
    # a margin to spare against rounding, also to single precision
    rows[:, MARGIN : NEAR_MARGIN + MARGINS] += EDGE_WIDTH * grid.reach
    spared = margins[:listed] + np.float32(EDGE_WIDTH * grid.reach)
    heights = _heights_over_edges(shape, corners, rows)
    for column in (MARGIN, NEAR_MARGIN):
        rows[:, column + 3 : column + 6] -= heights
    spared[:, 3:] -= heights[np.repeat(np.arange(n), counts)]
    return MeshFaces(
        rows=rows,
        rivals_begin=np.concatenate([[0], np.cumsum(counts)]).astype(np.int32),
        rivals=rivals[:listed].copy(),
        across=np.where(patch[others] == patch[:, None], others, -1).astype(np.int32),
        rival_margins=np.nextafter(spared, np.float32(np.inf)),
        edge_width=EDGE_WIDTH * grid.reach,
    )


def _heights_over_edges(shape, corners, rows) -> np.ndarray:
    """Return the distance of the corner opposite each edge of the triangles from that edge [m] (T, 3)."""
    at = shape.vertices[corners]
    wings = rows[:, EDGES:MARGIN].reshape(-1, 3, 4)
    from_edges = np.einsum("tqx,tkx->tqk", at, wings[:, :, :3]) - wings[:, None, :, 3]
    return from_edges.max(axis=1)


def _numbered_corners(meshes) -> list[np.ndarray]:
    """Return the corners of the triangles of each mesh [1] (n, 3), counted over all meshes."""
    before = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    return [mesh.faces + before[k] for k, mesh in enumerate(meshes)]
