"""Read the state: motions of points, reactions, bushing wrenches, drive torques.

Every function reads the state alone, so that it may be called after a restored checkpoint.  Reactions are
those of the last solve.
"""

from nutamill.base.frames import cross, turn_vector
from nutamill.base.kernel import kernel
from nutamill.mechanism.dynamics import gather_twists
from nutamill.mechanism.joints import put
from nutamill.mechanism.loads import (
    arm_acceleration,
    bushing_travel_of,
    bushing_wrench_of,
    spring_pull,
    world_point,
)
from nutamill.mechanism.model import POINT
from nutamill.mechanism.stops import stop_contact, stop_force


@kernel
def joint_reaction(mechanism, state, joint, out):
    """Write the wrench that joint number `joint` exerts on its body b about the joint's point on b, friction
    included: force [N] and moment [N m] into `out` (6,), world axes.

    The torque of a drive of the joint is no part of it (`drive_torque`).
    """
    table = mechanism.joints[joint]
    rubs = 0 if table.slides == 1 else 3
    for k in range(3):
        out[k], out[3 + k] = 0.0, 0.0
    for k in range(3):
        out[rubs + k] = state.friction[joint, k]
    for i in range(table.first_row, table.end_row):
        row, strength = mechanism.rows[i], state.reaction[i]
        e0, e1, e2 = turn_vector(state.quaternion[row.body_a], row.axis_a[0], row.axis_a[1], row.axis_a[2])
        at = 0
        if row.kind != POINT:
            z0, z1, z2 = turn_vector(
                state.quaternion[row.body_b], row.axis_b[0], row.axis_b[1], row.axis_b[2]
            )
            e0, e1, e2 = cross(z0, z1, z2, e0, e1, e2)
            at = 3
        out[at] += strength * e0
        out[at + 1] += strength * e1
        out[at + 2] += strength * e2


@kernel
def bushing_wrench(mechanism, state, scratch, bushing, out):
    """Write the wrench of bushing number `bushing` on its body b about its point on b: force [N] and moment
    [N m] into `out` (6,).

    Axes are those of the bushing, fixed in a.  `scratch.twist` is overwritten.
    """
    gather_twists(state, scratch.twist)
    f0, f1, f2, m0, m1, m2, _power = bushing_wrench_of(
        mechanism.bushings[bushing], state.position, state.quaternion, scratch.twist
    )
    put(0, f0, f1, f2, out)
    put(3, m0, m1, m2, out)


@kernel
def bushing_travel(mechanism, state, bushing, out):
    """Write displacement [m] and rotation vector [rad] of b relative to a at bushing number `bushing` into
    `out` (6,), axes of the bushing. Both are zero as assembled.
    """
    d0, d1, d2, t0, t1, t2 = bushing_travel_of(mechanism.bushings[bushing], state.position, state.quaternion)
    put(0, d0, d1, d2, out)
    put(3, t0, t1, t2, out)


@kernel
def spring_length_pull(mechanism, state, scratch, spring):
    """Return length [m] and tension [N] of spring number `spring`, as a pair.

    The call overwrites `scratch.twist`.
    """
    gather_twists(state, scratch.twist)
    length, pull, _power, _n0, _n1, _n2 = spring_pull(
        mechanism.springs[spring], state.position, state.quaternion, scratch.twist
    )
    return length, pull


@kernel
def drive_torque(mechanism, state, drive):
    """Return the torque [N m] of drive number `drive` on its joint's body b about the joint's axis, or the
    force [N] along it.
    """
    return state.drive_torque[drive]


@kernel
def stop_force_gap(mechanism, state, scratch, stop):
    """Return the force [N] with which stop number `stop` pushes its bodies apart, and its gap [m], negative
    where they overlap, as a pair. The call overwrites `scratch.twist`.
    """
    gather_twists(state, scratch.twist)
    record = mechanism.stops[stop]
    gap, closing, _n0, _n1, _n2, _x0, _x1, _x2 = stop_contact(
        record, state.position, state.quaternion, scratch.twist
    )
    return stop_force(record, gap, closing, state.impact_speed[stop]), gap


@kernel
def gear_torque(mechanism, state, gear):
    """Return the torque [N m] of gear number `gear` on body b of its output about the output's axis.

    Body b of the input feels minus the ratio times this torque about the input's axis, and each body a the
    opposite.
    """
    return state.reaction[mechanism.gears[gear].row]


@kernel
def drive_angle_speed(state, drive):
    """Return angle [rad] and speed [rad/s] of drive number `drive`, or travel [m] and speed [m/s], as a
    pair.
    """
    return state.drive_motion[drive, 0], state.drive_motion[drive, 1]


@kernel
def point_position(state, body, point):
    """Return the world position [m] of a `point` (3,) given from the body's mass centre in body axes, as a
    3-tuple.
    """
    return world_point(state.position, state.quaternion, body, point)


@kernel
def point_velocity_of(state, body, point):
    """Return the velocity [m/s] in world axes of a `point` (3,) given from the body's mass centre in body
    axes, as a 3-tuple.
    """
    r0, r1, r2 = turn_vector(state.quaternion[body], point[0], point[1], point[2])
    v, w = state.velocity[body], state.angular_velocity[body]
    c0, c1, c2 = cross(w[0], w[1], w[2], r0, r1, r2)
    return v[0] + c0, v[1] + c1, v[2] + c2


@kernel
def point_acceleration(state, body, point):
    """Return the acceleration [m/s^2] in world axes of a `point` (3,) given from the body's mass centre in
    body axes, as a 3-tuple.

    ``a + alpha x r + w x (w x r)``; gravity is not part of it.
    """
    r0, r1, r2 = turn_vector(state.quaternion[body], point[0], point[1], point[2])
    w = state.angular_velocity[body]
    return arm_acceleration(state.acceleration[body], w[0], w[1], w[2], r0, r1, r2)
