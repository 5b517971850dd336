"""Drives: angle, speed and acceleration of a prescribed rotation, torque and motion of a controlled motor;
the same with travel and force where b slides along the axis.
"""

import math

from nutamill.base.frames import cross, turn_vector
from nutamill.base.kernel import kernel
from nutamill.mechanism.loads import add_wrench, point_acceleration_of, point_velocity, world_point


@kernel
def last_knot_before(knots, first, end, t):
    """Return the index of the last knot in ``[first, end)`` that is not later than `t` [s], or `first`."""
    low, high = first, end
    while high - low > 1:
        middle = (low + high) // 2
        if knots[middle].time <= t:
            low = middle
        else:
            high = middle
    return low


@kernel
def drive_motion(drive, knots, t):
    """Return angle [rad], speed [rad/s] and acceleration [rad/s^2] of a `DRIVE` record at time `t` [s].

    Speed is linear between knots and constant after the last; the angle is its exact integral.
    At a knot the acceleration is that of the interval that begins there.
    """
    k = last_knot_before(knots, drive.first_knot, drive.end_knot, t)
    knot = knots[k]
    s = t - knot.time
    acceleration = 0.0
    if k + 1 < drive.end_knot:
        acceleration = (knots[k + 1].speed - knot.speed) / (knots[k + 1].time - knot.time)
    speed = knot.speed + acceleration * s
    return knot.angle + 0.5 * s * (knot.speed + speed), speed, acceleration


@kernel
def evaluate_drives(drives, knots, t, motion_out):
    """Write angle, speed and acceleration of every drive at `t` [s] into `motion_out` (n_drives, 3)."""
    for d in range(drives.shape[0]):
        motion_out[d, 0], motion_out[d, 1], motion_out[d, 2] = drive_motion(drives[d], knots, t)


@kernel
def driven_axis(drive, quaternion):
    """Return the axis of a `DRIVE` record in world axes [1], as a 3-tuple."""
    return turn_vector(quaternion[drive.body_a], drive.axis_a[0], drive.axis_a[1], drive.axis_a[2])


@kernel
def driven_rate(drive, position, quaternion, twist):
    """Return the speed of b relative to a about the axis of a `DRIVE` record [rad/s], or along it [m/s], from
    the twists (n_bodies + 1, 6).
    """
    e0, e1, e2 = driven_axis(drive, quaternion)
    if drive.slides == 1:
        x0, x1, x2 = world_point(position, quaternion, drive.body_b, drive.point_b)
        v = point_velocity(twist, position, drive.body_b, x0, x1, x2)
        u = point_velocity(twist, position, drive.body_a, x0, x1, x2)
        return e0 * (v[0] - u[0]) + e1 * (v[1] - u[1]) + e2 * (v[2] - u[2])
    a, b = twist[drive.body_a], twist[drive.body_b]
    return e0 * (b[3] - a[3]) + e1 * (b[4] - a[4]) + e2 * (b[5] - a[5])


@kernel
def driven_acceleration(drive, position, quaternion, twist, acceleration):
    """Return the time derivative of `driven_rate` [rad/s^2 or m/s^2] for `acceleration` (n_bodies + 1, 6).

    Of a point that slides: its acceleration less that of the point of a below it and the Coriolis term.
    """
    e0, e1, e2 = driven_axis(drive, quaternion)
    a, b = acceleration[drive.body_a], acceleration[drive.body_b]
    if drive.slides == 0:
        return e0 * (b[3] - a[3]) + e1 * (b[4] - a[4]) + e2 * (b[5] - a[5])
    x0, x1, x2 = world_point(position, quaternion, drive.body_b, drive.point_b)
    b0, b1, b2 = point_acceleration_of(twist, acceleration, position, drive.body_b, x0, x1, x2)
    a0, a1, a2 = point_acceleration_of(twist, acceleration, position, drive.body_a, x0, x1, x2)
    v = point_velocity(twist, position, drive.body_b, x0, x1, x2)
    u = point_velocity(twist, position, drive.body_a, x0, x1, x2)
    w = twist[drive.body_a]
    c0, c1, c2 = cross(w[3], w[4], w[5], v[0] - u[0], v[1] - u[1], v[2] - u[2])
    return e0 * (b0 - a0 - 2.0 * c0) + e1 * (b1 - a1 - 2.0 * c1) + e2 * (b2 - a2 - 2.0 * c2)


@kernel
def driven_travel(drive, position, quaternion):
    """Return the travel of b relative to a along the axis of a `DRIVE` record that slides [m]."""
    e0, e1, e2 = driven_axis(drive, quaternion)
    x0, x1, x2 = world_point(position, quaternion, drive.body_b, drive.point_b)
    y0, y1, y2 = world_point(position, quaternion, drive.body_a, drive.point_a)
    return e0 * (x0 - y0) + e1 * (x1 - y1) + e2 * (x2 - y2)


@kernel
def driven_angle(drive, quaternion, near):
    """Return the angle of b relative to a about the axis of a `DRIVE` record [rad]: of all that differ by
    whole revolutions, the one nearest to `near`.
    """
    e0, e1, e2 = driven_axis(drive, quaternion)
    x0, x1, x2 = turn_vector(quaternion[drive.body_a], drive.zero_a[0], drive.zero_a[1], drive.zero_a[2])
    y0, y1, y2 = turn_vector(quaternion[drive.body_b], drive.zero_b[0], drive.zero_b[1], drive.zero_b[2])
    c0, c1, c2 = cross(x0, x1, x2, y0, y1, y2)
    angle = math.atan2(e0 * c0 + e1 * c1 + e2 * c2, x0 * y0 + x1 * y1 + x2 * y2)
    return angle + 2.0 * math.pi * math.floor((near - angle) / (2.0 * math.pi) + 0.5)


@kernel
def motor_limit(drive, t, speed):
    """Return the largest torque [N m] of a motor at time `t` [s] and `speed` [rad/s].

    It is zero while the power is cut.
    """
    if drive.cut <= t < drive.restored:
        return 0.0
    if drive.power_limit < drive.torque_limit * abs(speed):
        return drive.power_limit / abs(speed)
    return drive.torque_limit


@kernel
def motor_torque(drive, t, target, speed, integral):
    """Return the torque [N m] of a motor at `speed` [rad/s] whose set point is the speed `target` [rad/s].

    Proportional to the error, plus the `integral` part [N m], within the limits: a drive with a speed
    controller and a limit of current and power.  Source: Leonhard, Control of Electrical Drives, 3rd ed.,
    2001, section 7.2 (speed control by a PI controller with a limited output).
    """
    limit = motor_limit(drive, t, speed)
    return max(-limit, min(limit, drive.gain * (target - speed) + integral))


@kernel
def next_integral(drive, t, target, speed, integral, dt):
    """Return the integral part [N m] a step of `dt` [s] later.

    It does not change while the torque is at a limit that it would push further, and is zero after a cut.
    """
    limit = motor_limit(drive, t, speed)
    if limit == 0.0:
        return 0.0
    error = target - speed
    demand = drive.gain * error + integral
    if abs(demand) >= limit and demand * error > 0.0:
        return integral
    return max(-limit, min(limit, integral + dt * drive.integral_gain * error))


@kernel
def apply_motors(drives, position, quaternion, twist, t, target, integral, load_out, torque_out):
    """Add every motor's torque or force to `load_out` (n_bodies + 1, 6) and write it into `torque_out`
    (n_drives,) [N m or N]. Prescribed motions have zero.

    `target` (n_drives, 3) is the output of `evaluate_drives`.
    """
    for d in range(drives.shape[0]):
        torque_out[d] = 0.0
        if drives[d].row >= 0:
            continue
        drive, a, b = drives[d], drives[d].body_a, drives[d].body_b
        speed = driven_rate(drive, position, quaternion, twist)
        torque = motor_torque(drive, t, target[d, 1], speed, integral[d])
        torque_out[d] = torque
        e0, e1, e2 = driven_axis(drive, quaternion)
        if drive.slides == 1:
            x0, x1, x2 = world_point(position, quaternion, b, drive.point_b)
            add_wrench(
                position, a, b, x0, x1, x2, torque * e0, torque * e1, torque * e2, 0.0, 0.0, 0.0, load_out
            )
            continue
        load_out[b, 3] += torque * e0
        load_out[b, 4] += torque * e1
        load_out[b, 5] += torque * e2
        load_out[a, 3] -= torque * e0
        load_out[a, 4] -= torque * e1
        load_out[a, 5] -= torque * e2


@kernel
def advance_motors(drives, position, quaternion, twist, t, target, dt, integral_out):
    """Update the integral parts (n_drives,) [N m] of all motors over the step of `dt` [s] that ends at time
    `t` with `twist`.
    """
    for d in range(drives.shape[0]):
        if drives[d].row < 0:
            speed = driven_rate(drives[d], position, quaternion, twist)
            integral_out[d] = next_integral(drives[d], t, target[d, 1], speed, integral_out[d], dt)


@kernel
def store_drives(
    drives,
    position,
    quaternion,
    twist,
    acceleration,
    reaction,
    motor_torques,
    target,
    torque_out,
    motion_out,
):
    """Write the torque [N m] or force [N] of every drive, and its angle, speed and acceleration: the
    prescribed ones, or those of a motor's joint.

    Parameters
    ----------
    twist, acceleration : of the bodies, (n_bodies + 1, 6)
    reaction, motor_torques : reactions of the constraint rows to report, and torques or forces of the motors
    target : output of `evaluate_drives`, (n_drives, 3)
    motion_out : (n_drives, 3); holds the former angle of a motor, so that whole revolutions are counted
    """
    for d in range(drives.shape[0]):
        drive, motion = drives[d], motion_out[d]
        if drive.row >= 0:
            torque_out[d] = reaction[drive.row]
            for k in range(3):
                motion[k] = target[d, k]
        else:
            torque_out[d] = motor_torques[d]
            if drive.slides == 1:
                motion[0] = driven_travel(drive, position, quaternion)
            else:
                motion[0] = driven_angle(drive, quaternion, motion[0])
            motion[1] = driven_rate(drive, position, quaternion, twist)
            motion[2] = driven_acceleration(drive, position, quaternion, twist, acceleration)
