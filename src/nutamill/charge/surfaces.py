"""Nearest point on a surface: overlap and normal of a sphere, in the axes of the surface and in the world's."""

import math

from nutamill.charge.model import SurfaceKind
from nutamill.frames import rotate
from nutamill.kernel import kernel

PLANE = int(SurfaceKind.PLANE)
CYLINDER = int(SurfaceKind.CYLINDER)


@kernel(inline="always")
def plane_contact(z, r):
    """Overlap [m] and normal [1] (3) of a sphere of radius `r` at height `z` [m] over the plane z = 0."""
    return r - z, 0.0, 0.0, -1.0


@kernel(inline="always")
def cylinder_contact(x, y, r, bore):
    """Overlap [m] and normal [1] (3) of a sphere of radius `r` at (x, y) [m] inside a cylinder of radius `bore` [m] about z."""
    distance = math.sqrt(x * x + y * y)
    inverse = 1.0 / (distance + 1e-300)
    return r + distance - bore, x * inverse, y * inverse, 0.0


@kernel(inline="always")
def box_contact(x, y, z, r, a, b, c):
    """Overlap [m] and normal [1] (3) of a sphere of radius `r` at (x, y, z) [m] outside a box of half sizes (a, b, c) [m].

    Outside, the nearest point is the position clamped to the box: on a face, an edge or a corner.  A centre inside the box (far
    beyond any allowed overlap) is pushed out through the nearest face.
    """
    px = min(max(x, -a), a)
    py = min(max(y, -b), b)
    pz = min(max(z, -c), c)
    dx, dy, dz = px - x, py - y, pz - z
    distance = math.sqrt(dx * dx + dy * dy + dz * dz)
    if distance > 0.0:
        inverse = 1.0 / distance
        return r - distance, dx * inverse, dy * inverse, dz * inverse
    ga, gb, gc = a - abs(x), b - abs(y), c - abs(z)
    if ga <= gb and ga <= gc:
        return r + ga, -math.copysign(1.0, x), 0.0, 0.0
    if gb <= gc:
        return r + gb, 0.0, -math.copysign(1.0, y), 0.0
    return r + gc, 0.0, 0.0, -math.copysign(1.0, z)


@kernel(inline="always")
def surface_contact(kind, x, y, z, r, a, b, c):
    """Overlap [m] and normal [1] (3), in surface axes, of a sphere of radius `r` at (x, y, z) [m] in surface axes.

    The normal points from the particle to the surface.  `kind` is a `SurfaceKind`; a, b, c [m] are its sizes.
    """
    if kind == PLANE:
        return plane_contact(z, r)
    if kind == CYLINDER:
        return cylinder_contact(x, y, r, a)
    return box_contact(x, y, z, r, a, b, c)


@kernel(inline="always")
def surface_overlap(kinds, sizes, placed, s, x0, x1, x2, r):
    """Overlap [m] and normal [1] (3), world axes, of a sphere of radius `r` at (x0, x1, x2) [m] with surface `s`.

    `kinds` (S,) and `sizes` [m] (S, 3) of the surfaces as in `ChargeModel`, `placed` (S, 12) as from `place_surfaces`.  Inlined, with
    whole arrays: a slice or a struct handed over in the loop over contacts costs more than the arithmetic.
    """
    d0, d1, d2 = x0 - placed[s, 0], x1 - placed[s, 1], x2 - placed[s, 2]
    a = placed[s, 3] * d0 + placed[s, 6] * d1 + placed[s, 9] * d2
    b = placed[s, 4] * d0 + placed[s, 7] * d1 + placed[s, 10] * d2
    c = placed[s, 5] * d0 + placed[s, 8] * d1 + placed[s, 11] * d2
    overlap, na, nb, nc = surface_contact(kinds[s], a, b, c, r, sizes[s, 0], sizes[s, 1], sizes[s, 2])
    return (
        overlap,
        placed[s, 3] * na + placed[s, 4] * nb + placed[s, 5] * nc,
        placed[s, 6] * na + placed[s, 7] * nb + placed[s, 8] * nc,
        placed[s, 9] * na + placed[s, 10] * nb + placed[s, 11] * nc,
    )


@kernel
def place_surfaces(model, bodies, placed):
    """Origin [m] (3) and rotation [1] (9) of every surface, world axes, to `placed` (S, 12).

    ``bodies[b, 0:12]`` is mass centre [m] (3) and rotation matrix [1] (9) of body b.
    """
    for s in range(model.surface_kind.shape[0]):
        body = bodies[model.surface_body[s]]
        R = body[3:12].reshape((3, 3))
        origin = model.surface_origin[s]
        o0, o1, o2 = rotate(R, origin[0], origin[1], origin[2])
        placed[s, 0], placed[s, 1], placed[s, 2] = body[0] + o0, body[1] + o1, body[2] + o2
        for j in range(3):
            Q = model.surface_rotation[s]
            a, b, c = rotate(R, Q[0, j], Q[1, j], Q[2, j])
            placed[s, 3 + j], placed[s, 6 + j], placed[s, 9 + j] = a, b, c
