"""Nearest point on a surface: overlap and normal of a sphere, in the axes of the surface and in the world's.

Plane and cylinder are endless.  Cone and sphere cap end, without a rim: a contact counts only where the foot
of the perpendicular from the particle's centre is on the surface, and beyond the end the next surface takes
over (floor, cylinder, another cone, a cap that meets the cone in its tangent).  This is exact wherever two
surfaces meet in an inner corner, where each has its own contact, or smoothly.  An edge that stands out into
the charge belongs to a box or to a mesh, which know their edges.
"""

import math

from nutamill.base.frames import rotate
from nutamill.base.kernel import kernel
from nutamill.charge.walls.surface import SurfaceKind

PLANE = int(SurfaceKind.PLANE)
CYLINDER = int(SurfaceKind.CYLINDER)
BOX = int(SurfaceKind.BOX)
CONE = int(SurfaceKind.CONE)

APART = -1e30
"""Overlap where the foot of the perpendicular is not on the surface [m]: no contact, however large the
particle.
"""


@kernel(inline="always")
def plane_contact(z, r):
    """Return overlap [m] and normal [1] (3) of a sphere of radius `r` at height `z` [m] over z = 0."""
    return r - z, 0.0, 0.0, -1.0


@kernel(inline="always")
def cylinder_contact(x, y, r, bore):
    """Return overlap [m] and normal [1] (3) of a sphere of radius `r` at (x, y) [m] inside a cylinder of
    radius `bore` [m] about z.
    """
    distance = math.sqrt(x * x + y * y)
    inverse = 1.0 / (distance + 1e-300)
    return r + distance - bore, x * inverse, y * inverse, 0.0


@kernel(inline="always")
def box_contact(x, y, z, r, a, b, c):
    """Return overlap [m] and normal [1] (3) of a sphere of radius `r` at (x, y, z) [m] outside a box of half
    sizes (a, b, c) [m].

    Outside, the nearest point is the position clamped to the box: on a face, an edge or a corner.  A centre
    inside the box (far beyond any allowed overlap) is pushed out through the nearest face.
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
def cone_frame(distance, z, r0, r1, h):
    """Return height [m] over the side of a cone, positive inside, coordinate [m] along it from its end of
    radius `r0`, and its length [m].

    In the half-plane of the axis and a point at `distance` [m] from it and height `z` [m], the side is the
    line from (r0, 0) to (r1, h); ``((r1 - r0), h)/length`` runs along it and ``(-h, r1 - r0)/length`` into
    the cone.
    """
    length = math.sqrt((r1 - r0) * (r1 - r0) + h * h)
    over = (z * (r1 - r0) - (distance - r0) * h) / length
    along = ((distance - r0) * (r1 - r0) + z * h) / length
    return over, along, length


@kernel(inline="always")
def cone_contact(x, y, z, r, r0, r1, h):
    """Return overlap [m] and normal [1] (3) of a sphere of radius `r` at (x, y, z) [m] inside a cone, `r0` at
    z = 0 and `r1` at z = `h` [m].

    One end is part of it and the other not, so that two cones end to end never both count.
    """
    distance = math.sqrt(x * x + y * y)
    over, along, length = cone_frame(distance, z, r0, r1, h)
    # on the axis every direction is as good
    a = x / distance if distance > 0.0 else 1.0
    b = y / distance if distance > 0.0 else 0.0
    overlap = r - over if along >= 0.0 and along < length else APART
    return overlap, a * h / length, b * h / length, -(r1 - r0) / length


@kernel(inline="always")
def cap_contact(x, y, z, r, radius, angle):
    """Return overlap [m] and normal [1] (3) of a sphere of radius `r` at (x, y, z) [m] in a bowl: a sphere of
    `radius` [m] about the origin, within `angle` [rad] of -z."""
    distance = math.sqrt(x * x + y * y + z * z)
    inverse = 1.0 / (distance + 1e-300)
    overlap = r + distance - radius if -z >= distance * math.cos(angle) else APART
    return overlap, x * inverse, y * inverse, z * inverse


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
    return cap_contact(x, y, z, r, a, b)


@kernel(inline="always")
def surface_room(kind, x, y, z, r, a, b, c):
    """Return a positive number where a ball of radius `r` about (x, y, z) [m], surface axes, may hold a
    particle that touches the surface.

    The quick test of a whole chunk: an overlap, but for cone and cap, which end, with a margin of `r` at the
    end.
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
    return min(r + math.sqrt(x * x + y * y + z * z) - a, r - z - a * math.cos(b))


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
    for s in range(model.surface_kind.shape[0]):
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
