"""Read the state: motions of bodies and points, reactions, bushing wrenches, drive torques, energies.

Every function needs the state alone (reactions are those of its last solve), so it may be called after a restored checkpoint.
"""

from nutamill.frames import cross, turn_vector, turn_vector_back
from nutamill.kernel import kernel
from nutamill.mechanism.joints import put
from nutamill.mechanism.loads import bushing_travel_of, bushing_wrench_of, spring_pull, world_point
from nutamill.mechanism.model import POINT


@kernel
def body_motion(state, body, motion_out):
    """Position, quaternion, velocity, angular velocity, acceleration, angular acceleration of a body's mass centre.

    `motion_out` (19,) in the order of `nutamill.frames.MOTION_SIZE`, SI, world axes.
    """
    for k in range(3):
        motion_out[k] = state.position[body, k]
        motion_out[7 + k] = state.velocity[body, k]
        motion_out[10 + k] = state.angular_velocity[body, k]
        motion_out[13 + k] = state.acceleration[body, k]
        motion_out[16 + k] = state.acceleration[body, 3 + k]
    for k in range(4):
        motion_out[3 + k] = state.quaternion[body, k]


@kernel
def joint_reaction(mechanism, state, scratch, joint, out):
    """Wrench joint number `joint` exerts on its body b about the joint's point on b, friction moment included.

    A drive of the joint is not part of it: see `drive_torque`.

    `out` (6,): force [N], moment [N m], world axes.  `scratch` is not used.
    """
    table = mechanism.joints[joint]
    for k in range(3):
        out[k], out[3 + k] = 0.0, state.friction_moment[joint, k]
    for i in range(table.first_row, table.end_row):
        row, strength = mechanism.rows[i], state.multiplier[i]
        e0, e1, e2 = turn_vector(state.quaternion[row.body_a], row.axis_a[0], row.axis_a[1], row.axis_a[2])
        at = 0
        if row.kind != POINT:
            z0, z1, z2 = turn_vector(state.quaternion[row.body_b], row.axis_b[0], row.axis_b[1], row.axis_b[2])
            e0, e1, e2 = cross(z0, z1, z2, e0, e1, e2)
            at = 3
        out[at] += strength * e0
        out[at + 1] += strength * e1
        out[at + 2] += strength * e2


@kernel
def bushing_wrench(mechanism, state, scratch, bushing, out):
    """Wrench of bushing number `bushing` on its body b about its point on b: force [N], moment [N m], (6,).

    Bushing axes fixed in a: those of a itself where the bushing's axis is a's z.  `scratch.twist` is overwritten.
    """
    gather_twists(state, scratch.twist)
    f0, f1, f2, m0, m1, m2, power = bushing_wrench_of(mechanism.bushings[bushing], state.position, state.quaternion, scratch.twist)
    put(out, 0, f0, f1, f2)
    put(out, 3, m0, m1, m2)


@kernel
def bushing_travel(mechanism, state, scratch, bushing, out):
    """Displacement [m] and rotation vector [rad] of b relative to a at bushing number `bushing`, (6,), axes as `bushing_wrench`.

    Zero at assembly.  `scratch` is not used.
    """
    d0, d1, d2, t0, t1, t2 = bushing_travel_of(mechanism.bushings[bushing], state.position, state.quaternion)
    put(out, 0, d0, d1, d2)
    put(out, 3, t0, t1, t2)


@kernel
def drive_torque(mechanism, state, drive):
    """Torque [N m] of drive number `drive` on its joint's body b about the joint's axis."""
    return state.multiplier[mechanism.drives[drive].row]


@kernel
def drive_angle_speed(state, drive):
    """Angle [rad] and speed [rad/s] of drive number `drive`, as a pair."""
    return state.drive_motion[drive, 0], state.drive_motion[drive, 1]


@kernel
def point_position(state, body, point):
    """World position [m] of a `point` (3,) given from the body's mass centre in body axes, as a 3-tuple."""
    return world_point(state.position, state.quaternion, body, point)


@kernel
def point_velocity_of(state, body, point):
    """Velocity [m/s] in world axes of a `point` (3,) given from the body's mass centre in body axes, as a 3-tuple."""
    r0, r1, r2 = turn_vector(state.quaternion[body], point[0], point[1], point[2])
    v, w = state.velocity[body], state.angular_velocity[body]
    c0, c1, c2 = cross(w[0], w[1], w[2], r0, r1, r2)
    return v[0] + c0, v[1] + c1, v[2] + c2


@kernel
def point_acceleration(state, body, point):
    """Acceleration [m/s^2] in world axes of a `point` (3,) given from the body's mass centre in body axes, as a 3-tuple.

    ``a + alpha x r + w x (w x r)``; gravity is not part of it.
    """
    r0, r1, r2 = turn_vector(state.quaternion[body], point[0], point[1], point[2])
    a, w = state.acceleration[body], state.angular_velocity[body]
    c0, c1, c2 = cross(w[0], w[1], w[2], r0, r1, r2)
    c0, c1, c2 = cross(w[0], w[1], w[2], c0, c1, c2)
    d0, d1, d2 = cross(a[3], a[4], a[5], r0, r1, r2)
    return a[0] + c0 + d0, a[1] + c1 + d1, a[2] + c2 + d2


@kernel
def gather_twists(state, twist_out):
    """Velocity and angular velocity of every body side by side, (n_bodies + 1, 6) [m/s, rad/s], world axes."""
    for b in range(twist_out.shape[0]):
        for k in range(3):
            twist_out[b, k] = state.velocity[b, k]
            twist_out[b, 3 + k] = state.angular_velocity[b, k]


@kernel
def kinetic_energy(mechanism, state):
    """Kinetic energy of all bodies [J]."""
    total = 0.0
    for b in range(mechanism.bodies.shape[0] - 1):
        v, w, I = state.velocity[b], state.angular_velocity[b], mechanism.bodies[b].inertia
        w0, w1, w2 = turn_vector_back(state.quaternion[b], w[0], w[1], w[2])
        total += 0.5 * mechanism.bodies[b].mass * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
        total += 0.5 * (w0 * w0 * I[0, 0] + w1 * w1 * I[1, 1] + w2 * w2 * I[2, 2])
        total += w0 * w1 * I[0, 1] + w0 * w2 * I[0, 2] + w1 * w2 * I[1, 2]
    return total


@kernel
def potential_energy(mechanism, state):
    """Potential energy of gravity of all bodies [J], zero with the mass centres at the world's origin."""
    total = 0.0
    for b in range(mechanism.bodies.shape[0] - 1):
        for k in range(3):
            total -= mechanism.bodies[b].mass * mechanism.gravity[k] * state.position[b, k]
    return total


@kernel
def bushing_energy(mechanism, state, bushing):
    """Elastic energy [J] of bushing number `bushing`: half of stiffness times travel squared."""
    k = mechanism.bushings[bushing].stiffness
    d0, d1, d2, t0, t1, t2 = bushing_travel_of(mechanism.bushings[bushing], state.position, state.quaternion)
    return 0.5 * (k[0] * d0 * d0 + k[1] * d1 * d1 + k[2] * d2 * d2 + k[3] * t0 * t0 + k[4] * t1 * t1 + k[5] * t2 * t2)


@kernel
def energies(mechanism, state, scratch):
    """Kinetic, potential and elastic energy [J] (bushings and springs), as a 3-tuple.  `scratch.twist` is overwritten."""
    elastic = 0.0
    for i in range(mechanism.bushings.shape[0]):
        elastic += bushing_energy(mechanism, state, i)
    gather_twists(state, scratch.twist)
    for i in range(mechanism.springs.shape[0]):
        spring = mechanism.springs[i]
        length, pull, power, n0, n1, n2 = spring_pull(spring, state.position, state.quaternion, scratch.twist)
        elastic += 0.5 * spring.stiffness * (length - spring.free_length) ** 2
    return kinetic_energy(mechanism, state), potential_energy(mechanism, state), elastic
