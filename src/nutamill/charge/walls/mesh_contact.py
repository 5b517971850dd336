"""A sphere against a patch of a triangle mesh: the deepest local minimum of the distance that belongs to the
patch.

A point of the mesh is touched only if it is a local minimum of the distance from the particle's centre to the
*whole* mesh.  A point of a face always is; one on an edge or a corner is only if the centre is in the
Voronoi region of that feature, that is, if no triangle around it comes nearer.  So an inner corner gives one
contact with each face and none with its edge, an outer edge or corner gives one, and a seam between triangles
of one plane none at all.  An edge or corner between patches belongs to one of them.

The tests of the regions are written once and take the same numbers whichever triangle asks, and this file is
compiled without rewriting of arithmetic: two patches can neither both claim a contact nor both leave it.

Sources: C. Ericson, "Real-Time Collision Detection", 2005, section 5.1 (Voronoi regions of a triangle); J. A.
Baerentzen and H. Aanaes, "Signed distance computation using the angle weighted pseudonormal", IEEE Trans.
Vis. Comput. Graph. 11 (2005) 243-253 (front and back).
"""

import math

from nutamill.base.kernel import kernel
from nutamill.charge.walls.mesh_model import FaceColumn
from nutamill.charge.walls.shapes import APART

FACE, EDGE, VERTEX = 0, 1, 2

NORMAL, HEIGHT, EDGES, MARGIN, NEAR_MARGIN = (int(column) for column in FaceColumn)

LONGEST_WALK = 16
"""Triangles a walk over a patch passes at most [1]."""


@kernel(inline="always")
def beside(shape, e, side, x, y, z):
    """Return the distance [m] by which (x, y, z) stands on the triangle's side of edge `e`, in the plane of
    its triangle `side` (0 or 1).
    """
    v, wing = shape.edge_ends[e, 0], shape.edge_wing
    d0, d1, d2 = x - shape.vertices[v, 0], y - shape.vertices[v, 1], z - shape.vertices[v, 2]
    return d0 * wing[e, side, 0] + d1 * wing[e, side, 1] + d2 * wing[e, side, 2]


@kernel(inline="always")
def along(shape, e, x, y, z):
    """Return the coordinate [m] of the foot of (x, y, z) along edge `e`, from its first corner."""
    v, way = shape.edge_ends[e, 0], shape.edge_direction
    d0, d1, d2 = x - shape.vertices[v, 0], y - shape.vertices[v, 1], z - shape.vertices[v, 2]
    return d0 * way[e, 0] + d1 * way[e, 1] + d2 * way[e, 2]


@kernel
def over_face(shape, t, x, y, z):
    """Return whether the foot of (x, y, z) in the plane of triangle `t` is on the triangle."""
    over = True
    for k in range(3):
        over = over and beside(shape, shape.triangle_edges[t, k], shape.triangle_side[t, k], x, y, z) >= 0.0
    return over


@kernel(inline="always")
def nearest_on_triangle(shape, t, x, y, z):
    """Return the nearest point of triangle `t`.

    Returns
    -------
    FACE, EDGE or VERTEX, number of the triangle, edge or corner, and the vector [m] (3) from the point to (x,
    y, z)
    """
    feature, index, best = FACE, t, math.inf
    b0, b1, b2 = 0.0, 0.0, 0.0
    for k in range(3):
        e = shape.triangle_edges[t, k]
        if beside(shape, e, shape.triangle_side[t, k], x, y, z) < 0.0:
            u, length, v = along(shape, e, x, y, z), shape.edge_length[e], shape.edge_ends[e, 0]
            if u >= length:
                v = shape.edge_ends[e, 1]
            d0, d1, d2 = x - shape.vertices[v, 0], y - shape.vertices[v, 1], z - shape.vertices[v, 2]
            inner = u > 0.0 and u < length
            if inner:
                way = shape.edge_direction
                d0, d1, d2 = d0 - u * way[e, 0], d1 - u * way[e, 1], d2 - u * way[e, 2]
            square = d0 * d0 + d1 * d1 + d2 * d2
            if square < best:
                feature, index, best = (EDGE, e, square) if inner else (VERTEX, v, square)
                b0, b1, b2 = d0, d1, d2
    if feature == FACE:
        n = shape.triangle_normal
        n0, n1, n2 = n[t, 0], n[t, 1], n[t, 2]
        height = x * n0 + y * n1 + z * n2 - shape.triangle_height[t]
        b0, b1, b2 = height * n0, height * n1, height * n2
    return feature, index, b0, b1, b2


@kernel(inline="always")
def in_region(shape, feature, index, patch, x, y, z):
    """Return whether the feature belongs to `patch` and (x, y, z) is in its Voronoi region."""
    if feature == FACE:
        return True
    if feature == EDGE:
        slack = shape.edge_slack[index]
        first, second = beside(shape, index, 0, x, y, z), beside(shape, index, 1, x, y, z)
        return shape.edge_owner[index] == patch and first < slack and second < slack
    if shape.vertex_owner[index] != patch:
        return False
    slack = shape.vertex_slack[index]
    for k in range(shape.vertex_first[index], shape.vertex_first[index + 1]):
        e = shape.vertex_edges[k]
        u = along(shape, e, x, y, z)
        if shape.edge_ends[e, 0] == index:
            if u > slack:
                return False
        elif u < shape.edge_length[e] - slack:
            return False
        # where patches meet, a centre straight above the corner of a face is the face's
        if slack == 0.0 and (
            over_face(shape, shape.edge_triangles[e, 0], x, y, z)
            or over_face(shape, shape.edge_triangles[e, 1], x, y, z)
        ):
            return False
    return True


@kernel
def feature_normal(shape, feature, index):
    """Return the normal of a face, or the mean normal of an edge or corner [1] (3), of any length."""
    if feature == FACE:
        n = shape.triangle_normal
    elif feature == EDGE:
        n = shape.edge_normal
    else:
        n = shape.vertex_normal
    return n[index, 0], n[index, 1], n[index, 2]


@kernel
def cell_of(grid, mesh, x, y, z):
    """Return the cell that holds (x, y, z) in the grid of a mesh, or -1."""
    size = grid.size[mesh]
    i = (x - grid.corner[mesh, 0]) / size
    j = (y - grid.corner[mesh, 1]) / size
    k = (z - grid.corner[mesh, 2]) / size
    n0, n1, n2 = grid.cells[mesh, 0], grid.cells[mesh, 1], grid.cells[mesh, 2]
    # also false where a coordinate is not a number
    if i >= 0.0 and i < n0 and j >= 0.0 and j < n1 and k >= 0.0 and k < n2:
        return grid.first_cell[mesh] + (int(i) * n1 + int(j)) * n2 + int(k)
    return -1


@kernel
def patch_in_cell(grid, cell, patch):
    """Return the place of a patch among those near a cell, or -1 where it is not near."""
    if cell >= 0:
        for q in range(grid.begin[cell], grid.begin[cell + 1]):
            if grid.patch[q] == patch:
                return q
    return -1


@kernel
def nearest_of_all(walls, patch, cell, square, x, y, z):
    """Return whether no other patch of the mesh comes nearer to (x, y, z), in `cell`, than the root of
    `square` [m^2].
    """
    grid = walls.grid
    for p in range(grid.begin[cell], grid.begin[cell + 1]):
        if grid.patch[p] != patch:
            for q in range(grid.first[p], grid.first[p + 1]):
                _, _, d0, d1, d2 = nearest_on_triangle(walls.shape, grid.triangles[q], x, y, z)
                if d0 * d0 + d1 * d1 + d2 * d2 < square:
                    return False
    return True


@kernel(inline="always")
def face_below(rows, across, face, x, y, z):
    """Find the triangle of a patch that the foot of (x, y, z) is on, by a walk from triangle `face`.

    Returns
    -------
    its number, or -1 where the walk finds none; the distances of the foot from its edges [m] (3)
    """
    before = -1
    for _ in range(LONGEST_WALK):
        a = from_edge(rows, face, 0, x, y, z)
        b = from_edge(rows, face, 1, x, y, z)
        c = from_edge(rows, face, 2, x, y, z)
        lowest = min(a, min(b, c))
        if lowest >= 0.0:
            return face, a, b, c
        other = across[face, 0 if a == lowest else 1 if b == lowest else 2]
        # two triangles that send the foot to each other: it is over their edge
        if other < 0 or other == before:
            break
        before, face = face, other
    return -1, 0.0, 0.0, 0.0


@kernel(inline="always")
def from_edge(rows, face, k, x, y, z):
    """Return the distance [m] of the foot of (x, y, z) from edge `k` of a triangle, positive on its side."""
    at = EDGES + 4 * k
    return rows[face, at] * x + rows[face, at + 1] * y + rows[face, at + 2] * z - rows[face, at + 3]


@kernel(inline="always")
def decides_alone(rows, row, column, a, b, c):
    """Return whether a foot that is `a`, `b` and `c` [m] from the edges of a triangle keeps the distances, as
    of `FaceColumn.MARGIN`, that stand in a row from `column` on.
    """
    return (
        a >= rows[row, column]
        and b >= rows[row, column + 1]
        and c >= rows[row, column + 2]
        and -a >= rows[row, column + 3]
        and -b >= rows[row, column + 4]
        and -c >= rows[row, column + 5]
    )


@kernel(inline="always")
def margin_left(rows, row, column, a, b, c):
    """Return by how much a foot keeps the distances as of `decides_alone` [m], negative where it does not."""
    least = min(a - rows[row, column], min(b - rows[row, column + 1], c - rows[row, column + 2]))
    most = max(a + rows[row, column + 3], max(b + rows[row, column + 4], c + rows[row, column + 5]))
    return min(least, -most)


@kernel
def search(shape, patch, triangles, begin, end, x, y, z, r):
    """Find the contact of a sphere of radius `r` at (x, y, z) [m] among ``triangles[begin:end]`` of a patch.

    Returns
    -------
    square of the distance of the deepest contact [m^2], `r` squared where there is none; the vector to it [m]
    (3); square of the distance of the nearest point [m^2], its triangle; whether it is seen from behind, and
    then the direction to the front (3)
    """
    front, least, nearest = r * r, math.inf, -1
    behind = False
    f0, f1, f2 = 0.0, 0.0, 0.0
    b0, b1, b2 = 0.0, 0.0, 0.0
    for q in range(begin, end):
        feature, index, d0, d1, d2 = nearest_on_triangle(shape, triangles[q], x, y, z)
        square = d0 * d0 + d1 * d1 + d2 * d2
        if square < least:
            least, nearest, behind = square, triangles[q], False
        if (square == least or square < front) and in_region(shape, feature, index, patch, x, y, z):
            n0, n1, n2 = feature_normal(shape, feature, index)
            side = d0 * n0 + d1 * n1 + d2 * n2
            if side > 0.0:
                if square < front:
                    front = square
                    f0, f1, f2 = -d0, -d1, -d2
            elif square == least and not behind:
                behind = True
                # a centre on the face itself has no direction but the face's
                b0, b1, b2 = (d0, d1, d2) if side < 0.0 else (-n0, -n1, -n2)
    return front, f0, f1, f2, least, nearest, behind, b0, b1, b2


@kernel(inline="always")
def contact_from(walls, patch, face, x, y, z, r):
    """Return the contact of a sphere of radius `r` at (x, y, z) [m] with a patch, surface axes.

    The search begins at triangle `face` of the patch, and the result is the same wherever it begins.  A
    centre behind the mesh, if the patch is the nearest part of it, is pushed out to the front: overlap beyond
    `r`.  Inlined: what one triangle decides, most contacts, costs less than a call with all arrays of the
    walls.

    Returns
    -------
    overlap [m] and normal [1] (3); a distance that the patch has at least [m], the triangle to begin at next
    time
    """
    over, a, b, c = face_below(walls.faces.rows, walls.faces.across, face, x, y, z)
    height = height_over(walls.faces.rows, over, x, y, z) if over >= 0 else 0.0
    near = height <= walls.grid.behind
    within = height > 0.0 and height <= walls.grid.reach
    if within and decides_alone(walls.faces.rows, over, NEAR_MARGIN if near else MARGIN, a, b, c):
        overlap, n0, n1, n2, away = contact_over(walls.faces.rows, over, height, r)
        return overlap, n0, n1, n2, away, over
    if within and min(a, min(b, c)) >= walls.faces.edge_width:
        first = nearest_plane(walls.faces, over, height, near, a, b, c, x, y, z)
        if first != over and first >= 0:  # the foot has crossed a seam
            height = height_over(walls.faces.rows, first, x, y, z)
            a = from_edge(walls.faces.rows, first, 0, x, y, z)
            b = from_edge(walls.faces.rows, first, 1, x, y, z)
            c = from_edge(walls.faces.rows, first, 2, x, y, z)
            touches = height > 0.0 and height <= walls.grid.behind
            if touches and decides_alone(walls.faces.rows, first, NEAR_MARGIN, a, b, c):
                over = first
        if first == over:
            overlap, n0, n1, n2, away = contact_over(walls.faces.rows, over, height, r)
            return overlap, n0, n1, n2, away, over
        overlap, n0, n1, n2, away, nearest = contact_among_rivals(
            walls.shape, walls.faces, patch, over, x, y, z, r
        )
        if nearest >= 0:
            return overlap, n0, n1, n2, away, nearest
    return contact_in_cell(walls, patch, face, x, y, z, r)


@kernel(inline="always")
def height_over(rows, face, x, y, z):
    """Return the height of (x, y, z) over the plane of a triangle [m]."""
    n0, n1, n2 = rows[face, NORMAL], rows[face, NORMAL + 1], rows[face, NORMAL + 2]
    return x * n0 + y * n1 + z * n2 - rows[face, HEIGHT]


@kernel(inline="always")
def contact_over(rows, face, height, r):
    """Return overlap [m], normal [1] (3) and distance [m] of a sphere of radius `r` at a `height` [m] over a
    triangle.
    """
    d0, d1, d2 = height * rows[face, NORMAL], height * rows[face, NORMAL + 1], height * rows[face, NORMAL + 2]
    square = d0 * d0 + d1 * d1 + d2 * d2
    distance = math.sqrt(square)
    if square < r * r:
        return r - distance, -d0 / distance, -d1 / distance, -d2 / distance, distance
    return APART, 0.0, 0.0, 0.0, distance


@kernel
def nearest_plane(faces, over, height, near, a, b, c, x, y, z):
    """Return which of triangle `over` and its rivals has the plane nearest to (x, y, z), a point `height` [m]
    over it, or -1 where no rivals are listed.

    A rival whose plane is farther away is no nearer. With `near`, the height is at most
    `MeshGrid.behind`, and margins hold: `a`, `b` and `c` are the distances of the foot from the edges [m].
    """
    margins = faces.rival_margins
    begin, end = faces.rivals_begin[over], faces.rivals_begin[over + 1]
    first, least = over if end > begin else -1, height + faces.edge_width
    for q in range(begin, end):
        rival = faces.rivals[q]
        cleared = near and decides_alone(margins, q, 0, a, b, c)
        if cleared or rival == over:
            continue
        away = abs(height_over(faces.rows, rival, x, y, z))
        if away < least:
            first, least = rival, away
    return first


@kernel
def contact_among_rivals(shape, faces, patch, over, x, y, z, r):
    """Return what `contact_from` does, for a point over triangle `over`, by a search of its rivals alone.

    The last number is -1 where they do not decide.
    """
    begin, end = faces.rivals_begin[over], faces.rivals_begin[over + 1]
    if end > begin:
        front, f0, f1, f2, least, nearest, behind, _, _, _ = search(
            shape, patch, faces.rivals, begin, end, x, y, z, r
        )
        distance = math.sqrt(least)
        if least >= r * r and not behind:
            return APART, 0.0, 0.0, 0.0, distance, nearest
        if front == least:
            return r - distance, f0 / distance, f1 / distance, f2 / distance, distance, nearest
    return APART, 0.0, 0.0, 0.0, 0.0, -1


@kernel
def contact_in_cell(walls, patch, face, x, y, z, r):
    """Return what `contact_from` does, by a search of all triangles that the cell of (x, y, z) lists."""
    grid = walls.grid
    cell = cell_of(grid, walls.mesh_of[patch], x, y, z)
    q = patch_in_cell(grid, cell, patch)
    if q < 0:
        return APART, 0.0, 0.0, 0.0, grid.reach, face
    front, f0, f1, f2, least, nearest, behind, b0, b1, b2 = search(
        walls.shape, patch, grid.triangles, grid.first[q], grid.first[q + 1], x, y, z, r
    )
    away = min(math.sqrt(least), grid.reach)
    if front < r * r:
        distance = math.sqrt(front)
        return r - distance, f0 / distance, f1 / distance, f2 / distance, away, nearest
    if behind and least < grid.behind * grid.behind:
        if nearest_of_all(walls, patch, cell, least, x, y, z):
            inverse = 1.0 / (math.sqrt(b0 * b0 + b1 * b1 + b2 * b2) + 1e-300)
            return r + math.sqrt(least), b0 * inverse, b1 * inverse, b2 * inverse, 0.0, nearest
        # another part of the mesh is nearer now and may not be so later
        away = 0.0
    return APART, 0.0, 0.0, 0.0, away, nearest


@kernel(inline="always")
def to_surface(surface_poses, s, x0, x1, x2):
    """Return the place [m] (3) of a point (x0, x1, x2) [m], world, in the axes of surface `s`."""
    d0, d1, d2 = x0 - surface_poses[s, 0], x1 - surface_poses[s, 1], x2 - surface_poses[s, 2]
    return (
        surface_poses[s, 3] * d0 + surface_poses[s, 6] * d1 + surface_poses[s, 9] * d2,
        surface_poses[s, 4] * d0 + surface_poses[s, 7] * d1 + surface_poses[s, 10] * d2,
        surface_poses[s, 5] * d0 + surface_poses[s, 8] * d1 + surface_poses[s, 11] * d2,
    )


@kernel(inline="always")
def to_world(surface_poses, s, a, b, c):
    """Return the direction (a, b, c) in the axes of surface `s` in world axes (3)."""
    return (
        surface_poses[s, 3] * a + surface_poses[s, 4] * b + surface_poses[s, 5] * c,
        surface_poses[s, 6] * a + surface_poses[s, 7] * b + surface_poses[s, 8] * c,
        surface_poses[s, 9] * a + surface_poses[s, 10] * b + surface_poses[s, 11] * c,
    )


@kernel
def mesh_overlap(walls, surface_poses, s, x0, x1, x2, r):
    """Return what `surface_overlap` does, for a surface `s` that is a patch of a mesh."""
    a, b, c = to_surface(surface_poses, s, x0, x1, x2)
    patch = walls.patch_of[s]
    q = patch_in_cell(walls.grid, cell_of(walls.grid, walls.mesh_of[patch], a, b, c), patch)
    if q < 0:
        return APART, 0.0, 0.0, 0.0
    overlap, na, nb, nc, _, _ = contact_from(walls, patch, walls.grid.face[q], a, b, c, r)
    n0, n1, n2 = to_world(surface_poses, s, na, nb, nc)
    return overlap, n0, n1, n2
