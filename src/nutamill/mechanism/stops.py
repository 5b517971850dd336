"""One-sided stops: a sphere of body b against a plane or a sphere of body a, compliant and without friction.

The force of an overlap d that closes at v is

    F = k d (1 + c v / v_i),  never pulling,

with v_i the speed at which the contact closed and c a number of the restitution alone (`stop_tables`).  It
begins and ends at zero, and the rebound of a mass is exactly the restitution times v_i, whatever mass,
stiffness and speed.  Where v_i is small against the present motion, as at rest on a stop, it gives way to the
largest closing speed of the contact and to half of w d, with w the frequency of mass and stiffness: no impact
without other loads reaches that, and c v / v_i stays a moderate damping.

Source: Hunt and Crossley, J. Appl. Mech. 42, 440-445, 1975 (damping in proportion to the overlap).
"""

import math

from nutamill.base.frames import turn_vector
from nutamill.base.kernel import kernel
from nutamill.mechanism.loads import add_wrench, point_velocity, world_point


@kernel
def stop_contact(stop, position, quaternion, twist):
    """Return gap [m] and closing speed [m/s] of a `STOP` record, the normal from a to b, and the centre of
    the sphere on b [m], in whose line the force acts.
    """
    x0, x1, x2 = world_point(position, quaternion, stop.body_b, stop.point_b)
    y0, y1, y2 = world_point(position, quaternion, stop.body_a, stop.point_a)
    d0, d1, d2 = x0 - y0, x1 - y1, x2 - y2
    if stop.plane == 1:
        n0, n1, n2 = turn_vector(quaternion[stop.body_a], stop.normal[0], stop.normal[1], stop.normal[2])
        distance = n0 * d0 + n1 * d1 + n2 * d2
    else:
        distance = math.sqrt(d0 * d0 + d1 * d1 + d2 * d2)
        n0, n1, n2 = d0 / distance, d1 / distance, d2 / distance
    v = point_velocity(twist, position, stop.body_b, x0, x1, x2)
    u = point_velocity(twist, position, stop.body_a, x0, x1, x2)
    closing = n0 * (u[0] - v[0]) + n1 * (u[1] - v[1]) + n2 * (u[2] - v[2])
    return distance - stop.radius, closing, n0, n1, n2, x0, x1, x2


@kernel
def stop_force(stop, gap, closing, impact_speed):
    """Return the force [N] of a `STOP` record that pushes its bodies apart.

    `impact_speed` is the largest closing speed of the contact so far [m/s].
    """
    if gap >= 0.0:
        return 0.0
    scale = max(impact_speed, closing, -0.5 * stop.frequency * gap)
    share = closing / scale if scale > 0.0 else 0.0
    return -stop.stiffness * gap * max(0.0, 1.0 + stop.damping * share)


@kernel
def apply_stops(stops, position, quaternion, twist, impact_speed, offset, load_out, power_out):
    """Add the force of every stop to `load_out` (n_bodies + 1, 6).

    Write the power it dissipates [W] into `power_out` from `offset` on.

    `impact_speed` (n_stops,) is as in `stop_force`.
    """
    for i in range(stops.shape[0]):
        stop = stops[i]
        gap, closing, n0, n1, n2, x0, x1, x2 = stop_contact(stop, position, quaternion, twist)
        power_out[offset + i] = 0.0
        if gap >= 0.0:
            continue
        f = stop_force(stop, gap, closing, impact_speed[i])
        power_out[offset + i] = (f + stop.stiffness * gap) * closing
        add_wrench(
            position,
            stop.body_a,
            stop.body_b,
            x0,
            x1,
            x2,
            f * n0,
            f * n1,
            f * n2,
            0.0,
            0.0,
            0.0,
            load_out,
        )


@kernel
def advance_stops(stops, position, quaternion, twist, impact_speed_out):
    """Update the largest closing speed of every contact (n_stops,) [m/s] after a step.

    That of an open stop is the present one, at which it may close in the next step.
    """
    for i in range(stops.shape[0]):
        gap, closing, _n0, _n1, _n2, _x0, _x1, _x2 = stop_contact(stops[i], position, quaternion, twist)
        before = impact_speed_out[i] if gap < 0.0 else 0.0
        impact_speed_out[i] = max(before, closing, 0.0)
