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
from nutamill.charge.walls.shapes import APART

FACE, EDGE, VERTEX = 0, 1, 2


@kernel
def beside(shape, e, side, x, y, z):
    """Return the distance [m] by which (x, y, z) stands on the triangle's side of edge `e`, in the plane of
    its triangle `side` (0 or 1).
    """
    v, wing = shape.edge_ends[e, 0], shape.edge_wing
    d0, d1, d2 = x - shape.vertices[v, 0], y - shape.vertices[v, 1], z - shape.vertices[v, 2]
    return d0 * wing[e, side, 0] + d1 * wing[e, side, 1] + d2 * wing[e, side, 2]


@kernel
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


@kernel
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
        n, v = shape.triangle_normal, shape.edge_ends[shape.triangle_edges[t, 0], 0]
        n0, n1, n2 = n[t, 0], n[t, 1], n[t, 2]
        height = (
            (x - shape.vertices[v, 0]) * n0
            + (y - shape.vertices[v, 1]) * n1
            + (z - shape.vertices[v, 2]) * n2
        )
        b0, b1, b2 = height * n0, height * n1, height * n2
    return feature, index, b0, b1, b2


@kernel
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
def cell_of(grid, patch, x, y, z):
    """Return the cell that holds (x, y, z) in the grid of a patch, or -1."""
    size = grid.size[patch]
    i = (x - grid.corner[patch, 0]) / size
    j = (y - grid.corner[patch, 1]) / size
    k = (z - grid.corner[patch, 2]) / size
    n0, n1, n2 = grid.cells[patch, 0], grid.cells[patch, 1], grid.cells[patch, 2]
    # also false where a coordinate is not a number
    if i >= 0.0 and i < n0 and j >= 0.0 and j < n1 and k >= 0.0 and k < n2:
        return grid.first_cell[patch] + (int(i) * n1 + int(j)) * n2 + int(k)
    return -1


@kernel
def nearest_of_all(walls, patch, square, x, y, z):
    """Return whether no other patch of the mesh comes nearer to (x, y, z) than the root of `square` [m^2]."""
    for p in range(walls.siblings[patch, 0], walls.siblings[patch, 1]):
        cell = cell_of(walls.grid, p, x, y, z)
        if p != patch and cell >= 0:
            for q in range(walls.grid.begin[cell], walls.grid.begin[cell + 1]):
                _, _, d0, d1, d2 = nearest_on_triangle(walls.shape, walls.grid.triangles[q], x, y, z)
                if d0 * d0 + d1 * d1 + d2 * d2 < square:
                    return False
    return True


@kernel
def patch_contact(walls, patch, x, y, z, r):
    """Return overlap [m] and normal [1] (3) of a sphere of radius `r` at (x, y, z) [m] with a patch, surface
    axes.

    A centre behind the mesh, if the patch is the nearest part of it, is pushed out to the front: overlap
    beyond `r`.
    """
    shape, grid = walls.shape, walls.grid
    cell = cell_of(grid, patch, x, y, z)
    if cell < 0:
        return APART, 0.0, 0.0, 0.0
    front, back = r * r, grid.reach * grid.reach
    touched, behind = False, False
    f0, f1, f2 = 0.0, 0.0, 0.0
    b0, b1, b2 = 0.0, 0.0, 0.0
    for q in range(grid.begin[cell], grid.begin[cell + 1]):
        feature, index, d0, d1, d2 = nearest_on_triangle(shape, grid.triangles[q], x, y, z)
        square = d0 * d0 + d1 * d1 + d2 * d2
        if (square < front or square < back) and in_region(shape, feature, index, patch, x, y, z):
            n0, n1, n2 = feature_normal(shape, feature, index)
            side = d0 * n0 + d1 * n1 + d2 * n2
            if side > 0.0 and square < front:
                touched, front = True, square
                f0, f1, f2 = -d0, -d1, -d2
            elif side <= 0.0 and square < back:
                behind, back = True, square
                # a centre on the face itself has no direction but the face's
                b0, b1, b2 = (d0, d1, d2) if side < 0.0 else (-n0, -n1, -n2)
    if touched:
        distance = math.sqrt(front)
        return r - distance, f0 / distance, f1 / distance, f2 / distance
    if behind and nearest_of_all(walls, patch, back, x, y, z):
        inverse = 1.0 / (math.sqrt(b0 * b0 + b1 * b1 + b2 * b2) + 1e-300)
        return r + math.sqrt(back), b0 * inverse, b1 * inverse, b2 * inverse
    return APART, 0.0, 0.0, 0.0


@kernel
def mesh_overlap(walls, surface_poses, s, x0, x1, x2, r):
    """Return what `surface_overlap` does, for a surface `s` that is a patch of a mesh."""
    d0, d1, d2 = x0 - surface_poses[s, 0], x1 - surface_poses[s, 1], x2 - surface_poses[s, 2]
    a = surface_poses[s, 3] * d0 + surface_poses[s, 6] * d1 + surface_poses[s, 9] * d2
    b = surface_poses[s, 4] * d0 + surface_poses[s, 7] * d1 + surface_poses[s, 10] * d2
    c = surface_poses[s, 5] * d0 + surface_poses[s, 8] * d1 + surface_poses[s, 11] * d2
    overlap, na, nb, nc = patch_contact(walls, walls.patch_of[s], a, b, c, r)
    return (
        overlap,
        surface_poses[s, 3] * na + surface_poses[s, 4] * nb + surface_poses[s, 5] * nc,
        surface_poses[s, 6] * na + surface_poses[s, 7] * nb + surface_poses[s, 8] * nc,
        surface_poses[s, 9] * na + surface_poses[s, 10] * nb + surface_poses[s, 11] * nc,
    )


@kernel
def mesh_near(walls, surface_poses, s, x0, x1, x2, r):
    """Return what `surface_near` does, for a surface `s` that is a patch of a mesh: `r` less a distance the
    patch has at least.
    """
    grid, p = walls.grid, walls.patch_of[s]
    d0, d1, d2 = x0 - surface_poses[s, 0], x1 - surface_poses[s, 1], x2 - surface_poses[s, 2]
    cell = 0
    for k in range(3):
        c = surface_poses[s, 3 + k] * d0 + surface_poses[s, 6 + k] * d1 + surface_poses[s, 9 + k] * d2
        # a point outside the grid is at least as far from the patch as the nearest point of the grid is
        position = min(max((c - grid.corner[p, k]) / grid.size[p], 0.0), grid.cells[p, k] - 1.0)
        cell = cell * grid.cells[p, k] + int(position)
    return r - grid.apart[grid.first_cell[p] + cell]


@kernel
def touch_mesh(walls, x, lo, n, s, pose, out):
    """Write a positive number to ``out[l]`` where particle ``lo + l`` is in a cell with triangles of surface
    `s`, at `pose` (12,).
    """
    grid, p = walls.grid, walls.patch_of[s]
    for i in range(n):
        d0, d1, d2 = x[0, lo + i] - pose[0], x[1, lo + i] - pose[1], x[2, lo + i] - pose[2]
        a = pose[3] * d0 + pose[6] * d1 + pose[9] * d2
        b = pose[4] * d0 + pose[7] * d1 + pose[10] * d2
        c = pose[5] * d0 + pose[8] * d1 + pose[11] * d2
        cell = cell_of(grid, p, a, b, c)
        out[i] = grid.begin[cell + 1] - grid.begin[cell] if cell >= 0 else 0
