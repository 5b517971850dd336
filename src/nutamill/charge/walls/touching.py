"""Quick tests of a whole chunk against one exact surface: which particles touch it. Normals and overlaps are
computed for those alone.
"""

import math

from nutamill.base.kernel import kernel
from nutamill.charge.walls.shapes import cone_frame, round_profile
from nutamill.charge.walls.surface import SurfaceKind

PLANE = int(SurfaceKind.PLANE)
CYLINDER = int(SurfaceKind.CYLINDER)
BOX = int(SurfaceKind.BOX)
CONE = int(SurfaceKind.CONE)
SPHERE_CAP = int(SurfaceKind.SPHERE_CAP)


@kernel(fast=True)
def touch_plane(x, radius, lo, n, pose, out):
    """Write a positive number to ``out[l]`` where particle ``lo + l`` touches the plane `pose` (12,)."""
    a, b, c = pose[5], pose[8], pose[11]
    x0, x1, x2, r = x[0, lo : lo + n], x[1, lo : lo + n], x[2, lo : lo + n], radius[lo : lo + n]
    at = a * pose[0] + b * pose[1] + c * pose[2]
    for i in range(n):
        out[i] = r[i] + at - (a * x0[i] + b * x1[i] + c * x2[i])


@kernel(fast=True)
def touch_cylinder(x, radius, lo, n, pose, bore, out):
    """Test a chunk as `touch_plane`, for the inside of a cylinder of radius `bore` [m]."""
    o0, o1, o2 = pose[0], pose[1], pose[2]
    a, b, c = pose[5], pose[8], pose[11]
    x0, x1, x2, r = x[0, lo : lo + n], x[1, lo : lo + n], x[2, lo : lo + n], radius[lo : lo + n]
    for i in range(n):
        d0, d1, d2 = x0[i] - o0, x1[i] - o1, x2[i] - o2
        along = a * d0 + b * d1 + c * d2
        free = bore - r[i]
        out[i] = d0 * d0 + d1 * d1 + d2 * d2 - along * along - free * free


@kernel(fast=True)
def touch_box(x, radius, lo, n, pose, size, out):
    """Test a chunk as `touch_plane`, for the outside of a box of half sizes `size` (3,) [m]."""
    o0, o1, o2 = pose[0], pose[1], pose[2]
    a0, a1, a2, b0, b1, b2, c0, c1, c2 = (
        pose[3],
        pose[6],
        pose[9],
        pose[4],
        pose[7],
        pose[10],
        pose[5],
        pose[8],
        pose[11],
    )
    h0, h1, h2 = size[0], size[1], size[2]
    x0, x1, x2, r = x[0, lo : lo + n], x[1, lo : lo + n], x[2, lo : lo + n], radius[lo : lo + n]
    for i in range(n):
        d0, d1, d2 = x0[i] - o0, x1[i] - o1, x2[i] - o2
        g0 = abs(a0 * d0 + a1 * d1 + a2 * d2) - h0
        g1 = abs(b0 * d0 + b1 * d1 + b2 * d2) - h1
        g2 = abs(c0 * d0 + c1 * d1 + c2 * d2) - h2
        g0 = g0 if g0 > 0.0 else 0.0
        g1 = g1 if g1 > 0.0 else 0.0
        g2 = g2 if g2 > 0.0 else 0.0
        out[i] = r[i] * r[i] - (g0 * g0 + g1 * g1 + g2 * g2)


@kernel(fast=True)
def touch_cone(x, radius, lo, n, pose, size, out):
    """Write a positive number to ``out[l]`` where particle ``lo + l`` touches the inside of a cone of `size`
    (3,) [m], at `pose` (12,).
    """
    o0, o1, o2 = pose[0], pose[1], pose[2]
    a, b, c = pose[5], pose[8], pose[11]
    r0, r1, h = size[0], size[1], size[2]
    x0, x1, x2, r = x[0, lo : lo + n], x[1, lo : lo + n], x[2, lo : lo + n], radius[lo : lo + n]
    for i in range(n):
        d0, d1, d2 = x0[i] - o0, x1[i] - o1, x2[i] - o2
        z = a * d0 + b * d1 + c * d2
        distance = math.sqrt(max(d0 * d0 + d1 * d1 + d2 * d2 - z * z, 0.0))
        over, along, length = cone_frame(distance, z, r0, r1, h)
        # rounding of the distance must not lose a contact at the ends: the exact test comes after
        within = min(along, length - along) + 1e-6 * length
        out[i] = min(r[i] - over, within)


@kernel(fast=True)
def touch_cap(x, radius, lo, n, pose, size, out):
    """Test a chunk as `touch_cone`, for the inside of a sphere cap of radius ``size[0]`` [m] and angle
    ``size[1]`` [rad].
    """
    o0, o1, o2 = pose[0], pose[1], pose[2]
    a, b, c = pose[5], pose[8], pose[11]
    bore, rim = size[0], math.cos(size[1]) - 1e-6
    x0, x1, x2, r = x[0, lo : lo + n], x[1, lo : lo + n], x[2, lo : lo + n], radius[lo : lo + n]
    for i in range(n):
        d0, d1, d2 = x0[i] - o0, x1[i] - o1, x2[i] - o2
        distance = math.sqrt(d0 * d0 + d1 * d1 + d2 * d2)
        z = a * d0 + b * d1 + c * d2
        out[i] = min(r[i] - abs(distance - bore), -z - distance * rim)


@kernel(fast=True)
def touch_round(x, radius, lo, n, pose, kind, size, out):
    """Write a positive number to ``out[l]`` where particle ``lo + l`` touches a DISC, TUBE, ROD or BALL, by
    `kind`, of `size` (3,) [m], at `pose` (12,).
    """
    o0, o1, o2 = pose[0], pose[1], pose[2]
    a, b, c = pose[5], pose[8], pose[11]
    low, high, bottom, top, thickness = round_profile(kind, size[0], size[1])
    x0, x1, x2, r = x[0, lo : lo + n], x[1, lo : lo + n], x[2, lo : lo + n], radius[lo : lo + n]
    for i in range(n):
        d0, d1, d2 = x0[i] - o0, x1[i] - o1, x2[i] - o2
        z = a * d0 + b * d1 + c * d2
        distance = math.sqrt(max(d0 * d0 + d1 * d1 + d2 * d2 - z * z, 0.0))
        across = max(max(low - distance, distance - high), 0.0)
        up = max(max(bottom - z, z - top), 0.0)
        reach = r[i] + thickness
        out[i] = reach * reach - (across * across + up * up)


@kernel
def touch_surface(model, x, radius, lo, n, s, pose, out):
    """Choose the test for surface `s`, which is no mesh, at `pose` (12,): positive ``out[l]`` where particle
    ``lo + l`` touches.
    """
    kind, size = model.surface_kind[s], model.surface_size[s]
    if kind == PLANE:
        touch_plane(x, radius, lo, n, pose, out)
    elif kind == CYLINDER:
        touch_cylinder(x, radius, lo, n, pose, size[0], out)
    elif kind == BOX:
        touch_box(x, radius, lo, n, pose, size, out)
    elif kind == CONE:
        touch_cone(x, radius, lo, n, pose, size, out)
    elif kind == SPHERE_CAP:
        touch_cap(x, radius, lo, n, pose, size, out)
    else:
        touch_round(x, radius, lo, n, pose, kind, size, out)
