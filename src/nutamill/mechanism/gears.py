"""Gears and belts: the rotation of one joint is a ratio times that of another.

A gear is one constraint row over up to four bodies.  The row's own Jacobian has the two bodies of the output
joint, a second one those of the input joint; it stands behind the Jacobians of all rows, in the order of the
gears.  The gap is ``angle_out - ratio angle_in``, whole revolutions counted.

Source: Haug, Computer Aided Kinematics and Dynamics of Mechanical Systems, 1989, section 3.4 (gear sets).
"""

from nutamill.base.frames import cross
from nutamill.base.kernel import kernel
from nutamill.mechanism.drives import driven_angle, driven_axis
from nutamill.mechanism.joints import put


@kernel
def place_gears(gears, sides, first, quaternion, angle_out, gap_out, gap_rate_out, jacobian_out):
    """Write gap [rad], explicit rate and both Jacobians of every gear at a pose.

    Parameters
    ----------
    gears, sides : `GEAR` records (n_gears,), and the `SIDE` records of input and output of each, (2 n_gears,)
    first : place of the first second Jacobian in `jacobian_out`: the number of rows
    angle_out : angle of each side [rad], (2 n_gears,); holds the former ones, so that whole revolutions are
        counted
    """
    for g in range(gears.shape[0]):
        i, ratio = gears[g].row, gears[g].ratio
        for side in (2 * g, 2 * g + 1):
            angle_out[side] = driven_angle(sides[side], quaternion, angle_out[side])
        gap_out[i] = angle_out[2 * g + 1] - ratio * angle_out[2 * g]
        gap_rate_out[i] = 0.0
        place_side(sides[2 * g + 1], quaternion, 1.0, jacobian_out[i])
        place_side(sides[2 * g], quaternion, -ratio, jacobian_out[first + g])


@kernel
def place_side(side, quaternion, factor, J_out):
    """Write the Jacobian (12,) of `factor` times the relative angular velocity of a `SIDE` about its axis."""
    e0, e1, e2 = driven_axis(side, quaternion)
    put(0, 0.0, 0.0, 0.0, J_out)
    put(3, -factor * e0, -factor * e1, -factor * e2, J_out)
    put(6, 0.0, 0.0, 0.0, J_out)
    put(9, factor * e0, factor * e1, factor * e2, J_out)


@kernel
def bias_gears(gears, sides, quaternion, twist, bias_out):
    """Write the required ``J a`` of every gear's row [rad/s^2]."""
    for g in range(gears.shape[0]):
        drift = side_drift(sides[2 * g], quaternion, twist)
        bias_out[gears[g].row] = gears[g].ratio * drift - side_drift(sides[2 * g + 1], quaternion, twist)


@kernel
def side_drift(side, quaternion, twist):
    """Return ``e' . (w_b - w_a)`` of a `SIDE` [rad/s^2]: the relative angular acceleration about its axis
    that is due to the turning of the axis.
    """
    e0, e1, e2 = driven_axis(side, quaternion)
    a, b = twist[side.body_a], twist[side.body_b]
    c0, c1, c2 = cross(a[3], a[4], a[5], e0, e1, e2)
    return c0 * (b[3] - a[3]) + c1 * (b[4] - a[4]) + c2 * (b[5] - a[5])
