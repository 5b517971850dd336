"""Joints as rows of two kinds: the gap, its Jacobian, and the part of its second derivative that does not
depend on accelerations.

POINT: ``e . (x_b - x_a) = s`` holds a point of b in the plane through a point of a, square to the axis e of
a; s is zero or the travel of a drive.  AXIS: ``u . z = 0`` holds an axis z of b square to an axis u of a; a
drive rotates u in a by its angle.

With J the Jacobian to the velocities (v_a, w_a, v_b, w_b) in world axes, a row's rate is ``J v + gap_rate``
and its second derivative ``J a - bias``.

Source: Haug, Computer Aided Kinematics and Dynamics of Mechanical Systems, 1989, section 9.4 ("dot-1" and
"dot-2" constraints), written for world axes.
"""

import math

from nutamill.base.frames import cross, rotate
from nutamill.base.kernel import kernel
from nutamill.mechanism.model import GEAR_ROW, POINT


@kernel
def put(at, a0, a1, a2, out):
    """Write a 3-vector into ``out[at:at + 3]``."""
    out[at], out[at + 1], out[at + 2] = a0, a1, a2


@kernel
def dot3(a, at_a, b, at_b):
    """Return the scalar product of ``a[at_a:at_a + 3]`` and ``b[at_b:at_b + 3]``."""
    return a[at_a] * b[at_b] + a[at_a + 1] * b[at_b + 1] + a[at_a + 2] * b[at_b + 2]


@kernel
def place_point_row(row, R_a, R_b, p_a, p_b, vectors_out):
    """Write the world vectors of a POINT row into `vectors_out` (12,): axis e [1], arms on a and on b [m],
    gap vector x_b - x_a [m].
    """
    e0, e1, e2 = rotate(R_a, row.axis_a[0], row.axis_a[1], row.axis_a[2])
    a0, a1, a2 = rotate(R_a, row.point_a[0], row.point_a[1], row.point_a[2])
    b0, b1, b2 = rotate(R_b, row.point_b[0], row.point_b[1], row.point_b[2])
    put(0, e0, e1, e2, vectors_out)
    put(3, a0, a1, a2, vectors_out)
    put(6, b0, b1, b2, vectors_out)
    put(9, p_b[0] + b0 - p_a[0] - a0, p_b[1] + b1 - p_a[1] - a1, p_b[2] + b2 - p_a[2] - a2, vectors_out)


@kernel
def point_row_jacobian(x, J_out):
    """Write the Jacobian (12,) of a POINT row from its world vectors `x`.

    The axis rotates with a, so that the arm of a ends at the point of b: the forces on a and b act at one
    point.
    """
    put(0, -x[0], -x[1], -x[2], J_out)
    c0, c1, c2 = cross(x[3] + x[9], x[4] + x[10], x[5] + x[11], x[0], x[1], x[2])
    put(3, -c0, -c1, -c2, J_out)
    put(6, x[0], x[1], x[2], J_out)
    c0, c1, c2 = cross(x[6], x[7], x[8], x[0], x[1], x[2])
    put(9, c0, c1, c2, J_out)


@kernel
def point_row_bias(x, twist_a, twist_b):
    """Return the required ``J a`` of a POINT row [m/s^2]: ``-(e'' . d + 2 e' . d' + e . d'')`` at zero
    accelerations.
    """
    p0, p1, p2 = cross(twist_a[3], twist_a[4], twist_a[5], x[3], x[4], x[5])
    q0, q1, q2 = cross(twist_b[3], twist_b[4], twist_b[5], x[6], x[7], x[8])
    d0 = twist_b[0] + q0 - twist_a[0] - p0
    d1 = twist_b[1] + q1 - twist_a[1] - p1
    d2 = twist_b[2] + q2 - twist_a[2] - p2
    p0, p1, p2 = cross(twist_a[3], twist_a[4], twist_a[5], p0, p1, p2)
    q0, q1, q2 = cross(twist_b[3], twist_b[4], twist_b[5], q0, q1, q2)
    e0, e1, e2 = cross(twist_a[3], twist_a[4], twist_a[5], x[0], x[1], x[2])
    f0, f1, f2 = cross(twist_a[3], twist_a[4], twist_a[5], e0, e1, e2)
    return -(
        f0 * x[9] + f1 * x[10] + f2 * x[11]
        + 2.0 * (e0 * d0 + e1 * d1 + e2 * d2)
        + x[0] * (q0 - p0) + x[1] * (q1 - p1) + x[2] * (q2 - p2)
    )  # fmt: skip


@kernel
def place_axis_row(row, angle, R_a, R_b, vectors_out):
    """Write the world vectors of an AXIS row into `vectors_out` (9,): u of a, u at 90 deg more of the drive's
    angle, z of b [1].
    """
    c, s = math.cos(angle), math.sin(angle)
    u0 = c * row.axis_a[0] + s * row.quarter_a[0]
    u1 = c * row.axis_a[1] + s * row.quarter_a[1]
    u2 = c * row.axis_a[2] + s * row.quarter_a[2]
    n0 = c * row.quarter_a[0] - s * row.axis_a[0]
    n1 = c * row.quarter_a[1] - s * row.axis_a[1]
    n2 = c * row.quarter_a[2] - s * row.axis_a[2]
    u0, u1, u2 = rotate(R_a, u0, u1, u2)
    n0, n1, n2 = rotate(R_a, n0, n1, n2)
    z0, z1, z2 = rotate(R_b, row.axis_b[0], row.axis_b[1], row.axis_b[2])
    put(0, u0, u1, u2, vectors_out)
    put(3, n0, n1, n2, vectors_out)
    put(6, z0, z1, z2, vectors_out)


@kernel
def axis_row_jacobian(x, J_out):
    """Write the Jacobian (12,) of an AXIS row, ``(w_b - w_a) . (z x u)``, from its world vectors `x`."""
    c0, c1, c2 = cross(x[6], x[7], x[8], x[0], x[1], x[2])
    put(0, 0.0, 0.0, 0.0, J_out)
    put(3, -c0, -c1, -c2, J_out)
    put(6, 0.0, 0.0, 0.0, J_out)
    put(9, c0, c1, c2, J_out)


@kernel
def axis_row_bias(x, speed, acceleration, twist_a, twist_b):
    """Return the required ``J a`` of an AXIS row [rad/s^2]: ``-(u'' . z + 2 u' . z' + u . z'')`` at zero
    angular accelerations.

    `speed` [rad/s] and `acceleration` [rad/s^2] are those of the row's drive, zero without one.
    """
    r0, r1, r2 = cross(twist_a[3], twist_a[4], twist_a[5], x[0], x[1], x[2])
    rr0, rr1, rr2 = cross(twist_a[3], twist_a[4], twist_a[5], r0, r1, r2)
    n0, n1, n2 = cross(twist_a[3], twist_a[4], twist_a[5], x[3], x[4], x[5])
    z0, z1, z2 = cross(twist_b[3], twist_b[4], twist_b[5], x[6], x[7], x[8])
    zz0, zz1, zz2 = cross(twist_b[3], twist_b[4], twist_b[5], z0, z1, z2)
    u0 = rr0 + 2.0 * speed * n0 + acceleration * x[3] - speed * speed * x[0]
    u1 = rr1 + 2.0 * speed * n1 + acceleration * x[4] - speed * speed * x[1]
    u2 = rr2 + 2.0 * speed * n2 + acceleration * x[5] - speed * speed * x[2]
    return -(
        u0 * x[6] + u1 * x[7] + u2 * x[8]
        + 2.0 * ((r0 + speed * x[3]) * z0 + (r1 + speed * x[4]) * z1 + (r2 + speed * x[5]) * z2)
        + x[0] * zz0 + x[1] * zz1 + x[2] * zz2
    )  # fmt: skip


@kernel
def place_rows(rows, position, rotation, drive_motion, vectors_out, gap_out, gap_rate_out, jacobian_out):
    """Write world vectors, gaps [m or rad], explicit rates [m/s or rad/s] and Jacobians of all rows but those
    of gears at a pose and at the drives' motions.
    """
    for i in range(rows.shape[0]):
        row, x, J = rows[i], vectors_out[i], jacobian_out[i]
        R_a, R_b = rotation[row.body_a], rotation[row.body_b]
        gap_rate_out[i] = 0.0
        if row.kind == POINT:
            place_point_row(row, R_a, R_b, position[row.body_a], position[row.body_b], x)
            point_row_jacobian(x, J)
            gap_out[i] = dot3(x, 0, x, 9)
            if row.drive >= 0:
                gap_out[i] -= drive_motion[row.drive, 0]
                gap_rate_out[i] = -drive_motion[row.drive, 1]
            continue
        if row.kind == GEAR_ROW:
            continue
        angle = drive_motion[row.drive, 0] if row.drive >= 0 else 0.0
        place_axis_row(row, angle, R_a, R_b, x)
        axis_row_jacobian(x, J)
        gap_out[i] = dot3(x, 0, x, 6)
        if row.drive >= 0:
            gap_rate_out[i] = drive_motion[row.drive, 1] * dot3(x, 3, x, 6)


@kernel
def bias_rows(rows, vectors, twist, drive_motion, bias_out):
    """Write the required ``J a`` of every row but those of gears [m/s^2 or rad/s^2], from its world vectors
    and the twists of the bodies.
    """
    for i in range(rows.shape[0]):
        row = rows[i]
        t_a, t_b = twist[row.body_a], twist[row.body_b]
        if row.kind == POINT:
            bias_out[i] = point_row_bias(vectors[i], t_a, t_b)
            if row.drive >= 0:
                bias_out[i] += drive_motion[row.drive, 2]
            continue
        if row.kind == GEAR_ROW:
            continue
        speed, acceleration = 0.0, 0.0
        if row.drive >= 0:
            speed, acceleration = drive_motion[row.drive, 1], drive_motion[row.drive, 2]
        bias_out[i] = axis_row_bias(vectors[i], speed, acceleration, t_a, t_b)


@kernel
def row_rate(J, twist_a, twist_b):
    """Return ``J v`` of one row (12,) with the twists (6,) of its two bodies [m/s or rad/s]."""
    rate = 0.0
    for k in range(6):
        rate += J[k] * twist_a[k] + J[6 + k] * twist_b[k]
    return rate
