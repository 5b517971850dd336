"""Nearest point on each shape: overlap and normal of a sphere, in the axes of the surface.

Plane and cylinder are endless.  Cone, sphere cap, disc and tube end, without a rim: a contact counts only
where the foot of the perpendicular from the particle's centre is on the surface, and beyond the end the next
surface takes over (floor, tube, another cone, a cap that meets the cone in its tangent).  This is exact
wherever two surfaces meet in an inner corner, where each has its own contact, or smoothly.

Cap, disc and tube also end in depth, so that vessels can stand side by side: a centre one radius or more
behind them has no contact.  Box, rod and ball are solids with the charge outside, and know their edges.
"""

import math

from nutamill.base.kernel import kernel
from nutamill.charge.walls.surface import SurfaceKind

DISC = int(SurfaceKind.DISC)
TUBE = int(SurfaceKind.TUBE)
ROD = int(SurfaceKind.ROD)

APART = -1e30
"""Overlap where a surface that ends has no contact, however large the particle [m]."""


@kernel
def shell_overlap(overlap, r, beside):
    """Return `overlap` [m] of a sphere of radius `r` [m] with a thin wall, or `APART` where its centre is not
    `beside` the wall, or is `r` or more behind it.
    """
    return overlap if beside and overlap < 2.0 * r else APART


@kernel(inline="always")
def from_axis(x, y):
    """Return the distance [m] of (x, y) [m] from the z axis, and the direction away from the axis [1] (2)."""
    distance = math.sqrt(x * x + y * y)
    # on the axis every direction is as good
    return distance, x / distance if distance > 0.0 else 1.0, y / distance if distance > 0.0 else 0.0


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
    distance, a, b = from_axis(x, y)
    over, along, length = cone_frame(distance, z, r0, r1, h)
    overlap = r - over if along >= 0.0 and along < length else APART
    return overlap, a * h / length, b * h / length, -(r1 - r0) / length


@kernel(inline="always")
def cap_contact(x, y, z, r, radius, angle):
    """Return overlap [m] and normal [1] (3) of a sphere of radius `r` at (x, y, z) [m] in a bowl: a sphere of
    `radius` [m] about the origin, within `angle` [rad] of -z."""
    distance = math.sqrt(x * x + y * y + z * z)
    inverse = 1.0 / (distance + 1e-300)
    overlap = shell_overlap(r + distance - radius, r, -z >= distance * math.cos(angle))
    return overlap, x * inverse, y * inverse, z * inverse


@kernel(inline="always")
def round_profile(kind, a, b):
    """Return the rectangle that turns about z to make a DISC, TUBE, ROD or BALL of sizes `a`, `b` [m].

    Returns
    -------
    lowest and highest distance from the axis, lowest and highest height [m], and the thickness about it [m]:
    a ball is a point with its radius as thickness
    """
    if kind == DISC:
        return 0.0, a, 0.0, 0.0, 0.0
    if kind == TUBE:
        return a, a, 0.0, b, 0.0
    if kind == ROD:
        return 0.0, a, -b, b, 0.0
    return 0.0, 0.0, 0.0, 0.0, a


@kernel
def round_contact(kind, x, y, z, r, a, b):
    """Return overlap [m] and normal [1] (3) of a sphere of radius `r` at (x, y, z) [m] with a DISC, TUBE, ROD
    or BALL of sizes `a`, `b` [m].

    In the half-plane of the axis and the sphere's centre, a rod is a box and a ball a point.  The lower end
    of a tube is part of it and the upper is not, so that two tubes end to end never both count.
    """
    distance, u, v = from_axis(x, y)
    if kind == DISC:
        return shell_overlap(r - z, r, distance <= a), 0.0, 0.0, -1.0
    if kind == TUBE:
        return shell_overlap(r + distance - a, r, z >= 0.0 and z < b), u, v, 0.0
    _, side, _, top, thickness = round_profile(kind, a, b)
    overlap, out, _, up = box_contact(distance, 0.0, z, r + thickness, side, math.inf, top)
    return overlap, out * u, out * v, up


@kernel
def round_room(kind, x, y, z, r, a, b):
    """Return a positive number where a ball of radius `r` about (x, y, z) [m] may hold a particle that
    touches a DISC, TUBE, ROD or BALL of sizes `a`, `b` [m].
    """
    distance = math.sqrt(x * x + y * y)
    low, high, bottom, top, thickness = round_profile(kind, a, b)
    across = max(low - distance, distance - high, 0.0)
    up = max(bottom - z, z - top, 0.0)
    return r + thickness - math.sqrt(across * across + up * up)
