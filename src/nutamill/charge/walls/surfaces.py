"""Contact of a sphere with a surface of any kind but a mesh, in the axes of the surface and in the world's;
the place of each surface.
"""

import math

from nutamill.base.frames import rotate
from nutamill.base.kernel import kernel
from nutamill.charge.walls.shapes import (
    box_contact,
    cap_contact,
    cone_contact,
    cone_frame,
    cylinder_contact,
    plane_contact,
    round_contact,
    round_room,
)
from nutamill.charge.walls.surface import SurfaceKind

PLANE = int(SurfaceKind.PLANE)
CYLINDER = int(SurfaceKind.CYLINDER)
BOX = int(SurfaceKind.BOX)
CONE = int(SurfaceKind.CONE)
SPHERE_CAP = int(SurfaceKind.SPHERE_CAP)


@kernel(inline="always")
def surface_contact(kind, x, y, z, r, a, b, c):
    """Return overlap [m] and normal [1] (3), in surface axes, of a sphere of radius `r` at (x, y, z) [m] in
    surface axes.

    The normal points from the particle to the surface.  `kind` is a `SurfaceKind`, but for MESH_PATCH; a, b,
    c are its sizes.
    """
    if kind == PLANE:
        return plane_contact(z, r)
    if kind == CYLINDER:
        return cylinder_contact(x, y, r, a)
    if kind == BOX:
        return box_contact(x, y, z, r, a, b, c)
    if kind == CONE:
        return cone_contact(x, y, z, r, a, b, c)
    if kind == SPHERE_CAP:
        return cap_contact(x, y, z, r, a, b)
    return round_contact(kind, x, y, z, r, a, b)


@kernel(inline="always")
def surface_room(kind, x, y, z, r, a, b, c):
    """Return a positive number where a ball of radius `r` about (x, y, z) [m], surface axes, may hold a
    particle that touches the surface.

    The quick test of a whole chunk: an overlap, for surfaces that end with a margin of `r`.
    """
    if kind == PLANE:
        return r - z
    if kind == CYLINDER:
        return r + math.sqrt(x * x + y * y) - a
    if kind == BOX:
        return box_contact(x, y, z, r, a, b, c)[0]
    if kind == CONE:
        over, along, length = cone_frame(math.sqrt(x * x + y * y), z, a, b, c)
        return min(r - over, min(r + along, r + length - along))
    if kind == SPHERE_CAP:
        return min(r - abs(math.sqrt(x * x + y * y + z * z) - a), r - z - a * math.cos(b))
    return round_room(kind, x, y, z, r, a, b)


@kernel(inline="always")
def surface_overlap(kind, sizes, surface_poses, s, x0, x1, x2, r):
    """Return overlap [m] and normal [1] (3), world axes, of a sphere of radius `r` at (x0, x1, x2) [m] with
    surface `s`.

    `kind` is its `SurfaceKind`, `sizes` [m] (S, 3) of all surfaces as in `ChargeModel`, `surface_poses` (S,
    12) as from `place_surfaces`. Inlined, with whole arrays: a slice or a struct handed over in the loop over
    contacts costs more than the arithmetic.
    """
    d0, d1, d2 = x0 - surface_poses[s, 0], x1 - surface_poses[s, 1], x2 - surface_poses[s, 2]
    a = surface_poses[s, 3] * d0 + surface_poses[s, 6] * d1 + surface_poses[s, 9] * d2
    b = surface_poses[s, 4] * d0 + surface_poses[s, 7] * d1 + surface_poses[s, 10] * d2
    c = surface_poses[s, 5] * d0 + surface_poses[s, 8] * d1 + surface_poses[s, 11] * d2
    overlap, na, nb, nc = surface_contact(kind, a, b, c, r, sizes[s, 0], sizes[s, 1], sizes[s, 2])
    return (
        overlap,
        surface_poses[s, 3] * na + surface_poses[s, 4] * nb + surface_poses[s, 5] * nc,
        surface_poses[s, 6] * na + surface_poses[s, 7] * nb + surface_poses[s, 8] * nc,
        surface_poses[s, 9] * na + surface_poses[s, 10] * nb + surface_poses[s, 11] * nc,
    )


@kernel(inline="always")
def surface_near(kinds, sizes, surface_poses, s, x0, x1, x2, r):
    """Return what `surface_room` does, for surface `s` and a ball of radius `r` about (x0, x1, x2) [m],
    world. Arrays are those of `surface_overlap`.
    """
    d0, d1, d2 = x0 - surface_poses[s, 0], x1 - surface_poses[s, 1], x2 - surface_poses[s, 2]
    a = surface_poses[s, 3] * d0 + surface_poses[s, 6] * d1 + surface_poses[s, 9] * d2
    b = surface_poses[s, 4] * d0 + surface_poses[s, 7] * d1 + surface_poses[s, 10] * d2
    c = surface_poses[s, 5] * d0 + surface_poses[s, 8] * d1 + surface_poses[s, 11] * d2
    return surface_room(kinds[s], a, b, c, r, sizes[s, 0], sizes[s, 1], sizes[s, 2])


@kernel
def place_surfaces(model, bodies, surface_poses_out):
    """Write origin [m] (3) and rotation [1] (9) of every surface, world axes, to `surface_poses_out` (S, 12).

    ``bodies[b, 0:12]`` is mass centre [m] (3) and rotation matrix [1] (9) of body b.
    """
    place_of = model.mesh.place_of
    for s in range(model.surface_kind.shape[0]):
        # the patches of a mesh follow each other, and are where the first one is
        if s > 0 and place_of[s] >= 0 and place_of[s] == place_of[s - 1]:
            for k in range(12):
                surface_poses_out[s, k] = surface_poses_out[s - 1, k]
            continue
        body = bodies[model.surface_body[s]]
        R = body[3:12].reshape((3, 3))
        origin = model.surface_origin[s]
        o0, o1, o2 = rotate(R, origin[0], origin[1], origin[2])
        surface_poses_out[s, 0], surface_poses_out[s, 1], surface_poses_out[s, 2] = (
            body[0] + o0,
            body[1] + o1,
            body[2] + o2,
        )
        for j in range(3):
            Q = model.surface_rotation[s]
            a, b, c = rotate(R, Q[0, j], Q[1, j], Q[2, j])
            surface_poses_out[s, 3 + j], surface_poses_out[s, 6 + j], surface_poses_out[s, 9 + j] = a, b, c
