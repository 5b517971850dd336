"""Prescribed rotations: angle, speed and acceleration of a drive at a time."""

from nutamill.kernel import kernel


@kernel
def last_knot_before(knots, first, end, t):
    """Index of the last knot in ``[first, end)`` that is not later than `t` [s]; `first` if all are."""
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
    """Angle [rad], speed [rad/s] and acceleration [rad/s^2] of a `DRIVE` record at time `t` [s].

    Speed is linear between knots and constant after the last; the angle is its exact integral.
    At a knot the acceleration is that of the interval which begins there.
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
