"""Vectors, quaternions, poses, twists and wrenches, as scalar kernels.

Conventions (docs/conventions.md): a quaternion ``q_WB`` is (w, x, y, z) with ``p_W = R_WB p_B``; angular
velocities are written in world axes; a wrench is (force, moment) about a named point.  Vectors are 3-tuples
or three floats: an array return costs about a hundred times more inside a loop.

Source: W. R. Hamilton's algebra in the form of Diebel, "Representing Attitude", 2006, equations 109, 125 and
253.
"""

import math

import numpy as np

from nutamill.base.kernel import kernel


@kernel(inline="always")
def cross(a0, a1, a2, b0, b1, b2):
    """Return the vector product a x b, as a 3-tuple."""
    return a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0


@kernel(inline="always")
def add3(a, b):
    """Return ``a + b`` of two 3-tuples."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@kernel(inline="always")
def sub3(a, b):
    """Return ``a - b`` of two 3-tuples."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@kernel(inline="always")
def scale3(factor, a):
    """Return ``factor a`` of a number and a 3-tuple."""
    return factor * a[0], factor * a[1], factor * a[2]


@kernel(inline="always")
def dot3(a, b):
    """Return the scalar product of two 3-tuples."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel(inline="always")
def cross3(a, b):
    """Return the vector product ``a x b`` of two 3-tuples."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@kernel(inline="always")
def velocity_at(v, w, r):
    """Return the velocity ``v + w x r`` of a point at `r` from the one that has `v`, of a body with spin `w`,
    as 3-tuples.
    """
    return (
        v[0] + w[1] * r[2] - w[2] * r[1],
        v[1] + w[2] * r[0] - w[0] * r[2],
        v[2] + w[0] * r[1] - w[1] * r[0],
    )


@kernel(inline="always")
def rotate(R, a0, a1, a2):
    """Return ``R a``, as a 3-tuple: `a` from body axes to the axes `R` (3, 3) leads to."""
    return (
        R[0, 0] * a0 + R[0, 1] * a1 + R[0, 2] * a2,
        R[1, 0] * a0 + R[1, 1] * a1 + R[1, 2] * a2,
        R[2, 0] * a0 + R[2, 1] * a1 + R[2, 2] * a2,
    )


@kernel(inline="always")
def rotation_numbers(w, x, y, z):
    """Return the nine numbers of the rotation matrix of a unit quaternion, row by row."""
    return (
        1.0 - 2.0 * (y * y + z * z),
        2.0 * (x * y - w * z),
        2.0 * (x * z + w * y),
        2.0 * (x * y + w * z),
        1.0 - 2.0 * (x * x + z * z),
        2.0 * (y * z - w * x),
        2.0 * (x * z - w * y),
        2.0 * (y * z + w * x),
        1.0 - 2.0 * (x * x + y * y),
    )


@kernel
def rotation_matrix(q, R_out):
    """Write the rotation matrix ``R_WB`` (3, 3) of the unit quaternion ``q_WB`` (4,)."""
    (
        R_out[0, 0],
        R_out[0, 1],
        R_out[0, 2],
        R_out[1, 0],
        R_out[1, 1],
        R_out[1, 2],
        R_out[2, 0],
        R_out[2, 1],
        R_out[2, 2],
    ) = rotation_numbers(q[0], q[1], q[2], q[3])


def rotation_matrix_of(quaternion: np.ndarray) -> np.ndarray:
    """Return the rotation matrix ``R_WB`` (3, 3) of a unit quaternion ``q_WB`` (4,)."""
    rotation = np.empty((3, 3))
    rotation_matrix(quaternion, rotation)
    return rotation


@kernel(inline="always")
def half_angle_series(square):
    """Return sin(angle/2)/angle [1/rad] and cos(angle/2) from the angle's square [rad^2]. Below 1 rad the
    error is below 3e-17.
    """
    s = square
    odd = 1 / 645120.0 - s * (1 / 185794560.0 - s * (1 / 81749606400.0 - s / 51011754393600.0))
    even = 1 / 46080.0 - s * (
        1 / 10321920.0 - s * (1 / 3715891200.0 - s * (1 / 1961990553600.0 - s / 1428329123020800.0))
    )
    return 0.5 - s * (1 / 48.0 - s * (1 / 3840.0 - s * odd)), 1.0 - s * (1 / 8.0 - s * (1 / 384.0 - s * even))


@kernel(inline="always")
def turned_by_half_angle(q, a, b, d, c):
    """Return the attitude `q` (4,) rotated by the quaternion (c, a, b, d), renormalised, as a 4-tuple."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    qw = c * w - a * x - b * y - d * z
    qx = c * x + a * w + b * z - d * y
    qy = c * y - a * z + b * w + d * x
    qz = c * z + a * y - b * x + d * w
    n = 1.0 / math.sqrt(qw * qw + qx * qx + qy * qy + qz * qz)
    return qw * n, qx * n, qy * n, qz * n


@kernel
def turn_quaternion(q, t0, t1, t2, q_out):
    """Rotate the attitude `q` by the rotation vector t [rad] in world axes, and renormalise: ``q_out = exp(t)
    q``.

    `q` and `q_out` may be the same array.
    """
    square = t0 * t0 + t1 * t1 + t2 * t2
    if square < 1.0:
        scale, c = half_angle_series(square)
    else:
        angle = math.sqrt(square)
        scale, c = math.sin(0.5 * angle) / angle, math.cos(0.5 * angle)
    q_out[0], q_out[1], q_out[2], q_out[3] = turned_by_half_angle(q, scale * t0, scale * t1, scale * t2, c)


MOTION_SIZE = 19
"""Numbers in a body's motion over a window: position 3, quaternion 4, velocity 3, angular velocity 3,
acceleration 3, angular acceleration 3, all of the mass centre, in world axes, at the start of the window."""


@kernel
def pose_in_window(motion, s, p_out, q_out):
    """Write the pose of a body `s` seconds after the start of a window of constant acceleration and angular
    acceleration.

    ``p = p0 + v0 s + a s^2/2``, ``q = exp(w0 s + alpha s^2/2) q0``: the same drift as the mechanism's step,
    so that the walls arrive where the mechanism is at the end of the window.

    Parameters
    ----------
    motion : (19,), see `MOTION_SIZE`
    s : time since the start of the window [s]
    p_out, q_out : position [m] (3,) of the mass centre and quaternion (4,) of the body
    """
    h = 0.5 * s * s
    for k in range(3):
        p_out[k] = motion[k] + s * motion[7 + k] + h * motion[13 + k]
    turn_quaternion(
        motion[3:7],
        s * motion[10] + h * motion[16],
        s * motion[11] + h * motion[17],
        s * motion[12] + h * motion[18],
        q_out,
    )


@kernel
def twist_in_window(motion, s, v_out, w_out):
    """Write the velocity [m/s] (3,) of the mass centre and the angular velocity [rad/s] (3,) of a body `s`
    seconds into a window.
    """
    for k in range(3):
        v_out[k] = motion[7 + k] + s * motion[13 + k]
        w_out[k] = motion[10 + k] + s * motion[16 + k]


@kernel(inline="always")
def shift_moment(m0, m1, m2, f0, f1, f2, r0, r1, r2):
    """Return the moment of a wrench about Q from its moment about P: ``M_Q = M_P + r x F``, with ``r = p_QP``
    from Q to P.
    """
    c0, c1, c2 = cross(r0, r1, r2, f0, f1, f2)
    return m0 + c0, m1 + c1, m2 + c2


@kernel(inline="always")
def turn_vector(q, a0, a1, a2):
    """Return ``R a`` from the quaternion `q` (4,) itself, as a 3-tuple: `a` from body axes to world axes."""
    t0, t1, t2 = 2.0 * (q[2] * a2 - q[3] * a1), 2.0 * (q[3] * a0 - q[1] * a2), 2.0 * (q[1] * a1 - q[2] * a0)
    return (
        a0 + q[0] * t0 + q[2] * t2 - q[3] * t1,
        a1 + q[0] * t1 + q[3] * t0 - q[1] * t2,
        a2 + q[0] * t2 + q[1] * t1 - q[2] * t0,
    )


@kernel(inline="always")
def turn_vector_back(q, a0, a1, a2):
    """Return ``R^T a`` from the quaternion `q` (4,) itself, as a 3-tuple: from world axes to body axes."""
    t0, t1, t2 = 2.0 * (q[3] * a1 - q[2] * a2), 2.0 * (q[1] * a2 - q[3] * a0), 2.0 * (q[2] * a0 - q[1] * a1)
    return (
        a0 + q[0] * t0 - q[2] * t2 + q[3] * t1,
        a1 + q[0] * t1 - q[3] * t0 + q[1] * t2,
        a2 + q[0] * t2 - q[1] * t1 + q[2] * t0,
    )


@kernel
def quaternion_product(a, b):
    """Return the product ``a b`` of two quaternions (4,), as a 4-tuple: first rotate by `b`, then by `a`."""
    return (
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    )


@kernel
def rotation_vector(w, x, y, z):
    """Return the rotation vector [rad] of a unit quaternion, as a 3-tuple of length at most pi: the inverse
    of `turn_quaternion`.
    """
    sine = math.sqrt(x * x + y * y + z * z)
    if w < 0.0:  # q and -q are the same attitude; take the shorter turn
        w, x, y, z = -w, -x, -y, -z
    # 2 asin(s)/s by its series near zero: the error is below 1e-17 there
    scale = 2.0 * math.atan2(sine, w) / sine if sine > 1e-4 else 2.0 + sine * sine / 3.0
    return scale * x, scale * y, scale * z
