"""Loads: gravity, constant moments, bushings, springs, joint friction, and the external wrench.

Each load is a small function of two bodies; `apply_loads` sums them.  Every pair of opposite forces acts at
one point in space, so that loads conserve momentum and angular momentum.
"""

import math

from nutamill.base.frames import cross, quaternion_product, rotation_vector, turn_vector, turn_vector_back
from nutamill.base.kernel import kernel

FRICTION_ANGLE = 1e-4
"""Angle [rad] within which Coulomb friction stops a joint from the speed at which it has (tanh 1 = 76 % of)
its full moment.
"""


@kernel
def add_wrench(position, body_a, body_b, x0, x1, x2, f0, f1, f2, m0, m1, m2, load_out):
    """Add a wrench (force f [N], moment m [N m], about the world point x [m]) to body b and its opposite to
    body a.
    """
    c0, c1, c2 = cross(
        x0 - position[body_b, 0], x1 - position[body_b, 1], x2 - position[body_b, 2], f0, f1, f2
    )
    load_out[body_b, 0] += f0
    load_out[body_b, 1] += f1
    load_out[body_b, 2] += f2
    load_out[body_b, 3] += m0 + c0
    load_out[body_b, 4] += m1 + c1
    load_out[body_b, 5] += m2 + c2
    c0, c1, c2 = cross(
        x0 - position[body_a, 0], x1 - position[body_a, 1], x2 - position[body_a, 2], f0, f1, f2
    )
    load_out[body_a, 0] -= f0
    load_out[body_a, 1] -= f1
    load_out[body_a, 2] -= f2
    load_out[body_a, 3] -= m0 + c0
    load_out[body_a, 4] -= m1 + c1
    load_out[body_a, 5] -= m2 + c2


@kernel
def world_point(position, quaternion, body, point):
    """Return the world coordinates [m] of `point` (3,), given from the body's mass centre in body axes, as a
    3-tuple.
    """
    r0, r1, r2 = turn_vector(quaternion[body], point[0], point[1], point[2])
    return position[body, 0] + r0, position[body, 1] + r1, position[body, 2] + r2


@kernel
def point_velocity(twist, position, body, x0, x1, x2):
    """Return the velocity [m/s] of the material point of `body` at the world point x, as a 3-tuple."""
    t = twist[body]
    c0, c1, c2 = cross(
        t[3], t[4], t[5], x0 - position[body, 0], x1 - position[body, 1], x2 - position[body, 2]
    )
    return t[0] + c0, t[1] + c1, t[2] + c2


@kernel
def arm_acceleration(a, w0, w1, w2, r0, r1, r2):
    """Return the acceleration [m/s^2] at the end of an arm r of a body that turns at w, as a 3-tuple:
    ``a + alpha x r + w x (w x r)`` from acceleration and angular acceleration `a` (6,) of the body.
    """
    c0, c1, c2 = cross(w0, w1, w2, r0, r1, r2)
    c0, c1, c2 = cross(w0, w1, w2, c0, c1, c2)
    d0, d1, d2 = cross(a[3], a[4], a[5], r0, r1, r2)
    return a[0] + c0 + d0, a[1] + c1 + d1, a[2] + c2 + d2


@kernel
def point_acceleration_of(twist, acceleration, position, body, x0, x1, x2):
    """Return the acceleration [m/s^2] of the material point of `body` at the world point x, as a 3-tuple."""
    t, p = twist[body], position[body]
    return arm_acceleration(acceleration[body], t[3], t[4], t[5], x0 - p[0], x1 - p[1], x2 - p[2])


@kernel
def bushing_travel_of(bushing, position, quaternion):
    """Return the travel of a `BUSHING` record: displacement [m] 3 and rotation vector [rad] 3 of b relative
    to a, bushing axes fixed in a.
    """
    a, b = bushing.body_a, bushing.body_b
    x = world_point(position, quaternion, b, bushing.point_b)
    y = world_point(position, quaternion, a, bushing.point_a)
    e = quaternion_product(quaternion[a], bushing.attitude_a)
    f = quaternion_product(quaternion[b], bushing.attitude_b)
    d0, d1, d2 = turn_vector_back(e, x[0] - y[0], x[1] - y[1], x[2] - y[2])
    r = quaternion_product((e[0], -e[1], -e[2], -e[3]), f)
    t0, t1, t2 = rotation_vector(r[0], r[1], r[2], r[3])
    return d0, d1, d2, t0, t1, t2


@kernel
def moment_from_rotation_energy(t0, t1, t2, g0, g1, g2):
    r"""Return the moment (3-tuple) conjugate to a rotation vector t, from the gradient g of an energy to t.

    .. math:: M = g + \tfrac12 t \times g + c\, t \times (t \times g), \quad
              c = \frac{1}{\theta^2} - \frac{1 + \cos\theta}{2\theta\sin\theta}

    the transposed inverse of the left Jacobian of the rotation group: an energy of the rotation vector then
    gives exactly the moment whose work is its change.

    Source: Chirikjian, Stochastic Models, Information Theory, and Lie Groups, volume 2, 2012, chapter 10
    (Jacobians of SO(3)).
    """
    square = t0 * t0 + t1 * t1 + t2 * t2
    if square > 0.01:
        angle = math.sqrt(square)
        # (1 + cos)/sin = 1/tan(angle/2), which stays finite at 180 deg
        c = 1.0 / square - 0.5 / (angle * math.tan(0.5 * angle))
    else:  # series; the next term is below 1e-14 of the first
        c = 1.0 / 12.0 + square * (1.0 / 720.0 + square * (1.0 / 30240.0 + square / 1209600.0))
    a0, a1, a2 = cross(t0, t1, t2, g0, g1, g2)
    b0, b1, b2 = cross(t0, t1, t2, a0, a1, a2)
    return g0 + 0.5 * a0 + c * b0, g1 + 0.5 * a1 + c * b1, g2 + 0.5 * a2 + c * b2


@kernel
def bushing_wrench_of(bushing, position, quaternion, twist):
    """Return the wrench of a `BUSHING` record on body b about its point on b, in bushing axes, and the power
    it dissipates.

    Elastic part: minus the gradient of ``sum k travel^2 / 2``, exactly.  Viscous part: proportional to the
    velocity of b's point and the angular velocity, both relative to a.

    Returns
    -------
    force [N] 3, moment [N m] 3, power [W]
    """
    a, b = bushing.body_a, bushing.body_b
    k, c = bushing.stiffness, bushing.damping
    d0, d1, d2, t0, t1, t2 = bushing_travel_of(bushing, position, quaternion)
    e = quaternion_product(quaternion[a], bushing.attitude_a)
    x0, x1, x2 = world_point(position, quaternion, b, bushing.point_b)
    v_b = point_velocity(twist, position, b, x0, x1, x2)
    v_a = point_velocity(twist, position, a, x0, x1, x2)
    v0, v1, v2 = turn_vector_back(e, v_b[0] - v_a[0], v_b[1] - v_a[1], v_b[2] - v_a[2])
    w0, w1, w2 = turn_vector_back(
        e, twist[b, 3] - twist[a, 3], twist[b, 4] - twist[a, 4], twist[b, 5] - twist[a, 5]
    )
    m0, m1, m2 = moment_from_rotation_energy(t0, t1, t2, k[3] * t0, k[4] * t1, k[5] * t2)
    power = (
        c[0] * v0 * v0 + c[1] * v1 * v1 + c[2] * v2 * v2 + c[3] * w0 * w0 + c[4] * w1 * w1 + c[5] * w2 * w2
    )
    return (
        -k[0] * d0 - c[0] * v0,
        -k[1] * d1 - c[1] * v1,
        -k[2] * d2 - c[2] * v2,
        -m0 - c[3] * w0,
        -m1 - c[4] * w1,
        -m2 - c[5] * w2,
        power,
    )


@kernel
def apply_bushings(bushings, position, quaternion, twist, load_out, power_out):
    """Add every bushing's wrench to `load_out` (n_bodies + 1, 6).

    Write the power it dissipates [W] into the first numbers of `power_out`.
    """
    for i in range(bushings.shape[0]):
        bushing = bushings[i]
        f0, f1, f2, m0, m1, m2, power = bushing_wrench_of(bushing, position, quaternion, twist)
        power_out[i] = power
        e = quaternion_product(quaternion[bushing.body_a], bushing.attitude_a)
        f0, f1, f2 = turn_vector(e, f0, f1, f2)
        m0, m1, m2 = turn_vector(e, m0, m1, m2)
        x0, x1, x2 = world_point(position, quaternion, bushing.body_b, bushing.point_b)
        add_wrench(position, bushing.body_a, bushing.body_b, x0, x1, x2, f0, f1, f2, m0, m1, m2, load_out)


@kernel
def spring_pull(spring, position, quaternion, twist):
    """Return length [m], tension [N] and dissipated power [W] of a `SPRING` record, and the direction from
    its end on a to that on b.

    Tension ``stiffness (length - free_length) + damping d(length)/dt``.
    """
    x0, x1, x2 = world_point(position, quaternion, spring.body_b, spring.point_b)
    y0, y1, y2 = world_point(position, quaternion, spring.body_a, spring.point_a)
    length = math.sqrt((x0 - y0) ** 2 + (x1 - y1) ** 2 + (x2 - y2) ** 2)
    n0, n1, n2 = (x0 - y0) / length, (x1 - y1) / length, (x2 - y2) / length
    v = point_velocity(twist, position, spring.body_b, x0, x1, x2)
    u = point_velocity(twist, position, spring.body_a, y0, y1, y2)
    rate = n0 * (v[0] - u[0]) + n1 * (v[1] - u[1]) + n2 * (v[2] - u[2])
    pull = spring.stiffness * (length - spring.free_length) + spring.damping * rate
    return length, pull, spring.damping * rate * rate, n0, n1, n2


@kernel
def apply_springs(springs, position, quaternion, twist, offset, load_out, power_out):
    """Add every spring's force to `load_out` (n_bodies + 1, 6).

    Write the power its damper dissipates [W] into `power_out` from `offset` on.
    """
    for i in range(springs.shape[0]):
        spring = springs[i]
        _length, pull, power, n0, n1, n2 = spring_pull(spring, position, quaternion, twist)
        power_out[offset + i] = power
        x0, x1, x2 = world_point(position, quaternion, spring.body_b, spring.point_b)
        add_wrench(
            position,
            spring.body_a,
            spring.body_b,
            x0,
            x1,
            x2,
            -pull * n0,
            -pull * n1,
            -pull * n2,
            0.0,
            0.0,
            0.0,
            load_out,
        )


@kernel
def friction_per_speed(joint, reaction, speed):
    """Return the friction moment over the relative angular velocity [N m s/rad] of a `JOINT` record that
    carries the force `reaction` [N].

    Of a joint that slides it is the friction force over the relative speed [N s/m].

    ``M tanh(speed / rest) + viscous speed`` with ``M = coefficient radius reaction + constant``, divided by
    `speed` [rad/s]: Coulomb friction, regularised near rest.  The speed ``rest = sqrt(2 FRICTION_ANGLE M /
    inertia)`` is that from which M stops the inertia [kg m^2] within `FRICTION_ANGLE`, so that it follows
    the scales of the machine.  In a joint that slides the radius is 1, M a force, and the inertia the braked
    mass over a length of the bodies, so that M stops it within `FRICTION_ANGLE` times this length.

    Source: the load-dependent plus load-independent moment of rolling bearings (Palmgren, Ball and Roller
    Bearing Engineering, 1959), with a viscous term.
    """
    moment = joint.friction_coefficient * joint.friction_radius * reaction + joint.friction_constant
    if moment == 0.0:
        return joint.friction_viscous
    rest = math.sqrt(2.0 * FRICTION_ANGLE * moment / joint.friction_inertia)
    ratio = speed / rest
    rise = math.tanh(ratio) / ratio if ratio > 1e-6 else 1.0
    return moment * rise / rest + joint.friction_viscous


@kernel
def joint_force(joint, multiplier):
    """Return the magnitude [N] of the force that a `JOINT` record carried in the last solve: the reactions of
    its POINT rows, along axes square to each other.
    """
    square = 0.0
    for i in range(joint.first_row, joint.first_row + joint.points):
        square += multiplier[i] * multiplier[i]
    return math.sqrt(square)


@kernel
def turning_friction(joint, reaction, quaternion, twist, load_out, friction_out):
    """Add the friction moment of a `JOINT` record that carries the force `reaction` [N] to `load_out`, write
    that on b into `friction_out` (3,) [N m], and return the power it dissipates [W].

    In joints that turn about an axis it acts about the axis, in others against the whole relative angular
    velocity.
    """
    a, b = joint.body_a, joint.body_b
    w0, w1, w2 = twist[b, 3] - twist[a, 3], twist[b, 4] - twist[a, 4], twist[b, 5] - twist[a, 5]
    if joint.turns == 1:
        e0, e1, e2 = turn_vector(quaternion[a], joint.axis_a[0], joint.axis_a[1], joint.axis_a[2])
        about = e0 * w0 + e1 * w1 + e2 * w2
        w0, w1, w2 = about * e0, about * e1, about * e2
    speed = math.sqrt(w0 * w0 + w1 * w1 + w2 * w2)
    rate = friction_per_speed(joint, reaction, speed)
    friction_out[0], friction_out[1], friction_out[2] = -rate * w0, -rate * w1, -rate * w2
    for k in range(3):
        load_out[b, 3 + k] += friction_out[k]
        load_out[a, 3 + k] -= friction_out[k]
    return rate * speed * speed


@kernel
def sliding_friction(joint, reaction, position, quaternion, twist, load_out, friction_out):
    """Add the friction force of a `JOINT` record that slides and carries the force `reaction` [N] across its
    axis to `load_out`, write that on b into `friction_out` (3,) [N], and return the power it dissipates [W].

    It acts along the axis at the joint's point on b, on both bodies.
    """
    a, b = joint.body_a, joint.body_b
    x0, x1, x2 = world_point(position, quaternion, b, joint.point_b)
    v = point_velocity(twist, position, b, x0, x1, x2)
    u = point_velocity(twist, position, a, x0, x1, x2)
    e0, e1, e2 = turn_vector(quaternion[a], joint.axis_a[0], joint.axis_a[1], joint.axis_a[2])
    speed = e0 * (v[0] - u[0]) + e1 * (v[1] - u[1]) + e2 * (v[2] - u[2])
    rate = friction_per_speed(joint, reaction, abs(speed))
    force = -rate * speed
    friction_out[0], friction_out[1], friction_out[2] = force * e0, force * e1, force * e2
    add_wrench(position, a, b, x0, x1, x2, force * e0, force * e1, force * e2, 0.0, 0.0, 0.0, load_out)
    return rate * speed * speed


@kernel
def apply_joint_friction(
    joints, multiplier, position, quaternion, twist, offset, load_out, friction_out, power_out
):
    """Add every joint's friction to `load_out`.

    Write the moment [N m] or, of a joint that slides, the force [N] on b into `friction_out` (n_joints, 3),
    and the power it dissipates [W] into `power_out` from `offset` on.  The load-dependent part takes the
    joint's reaction of the last solve (`multiplier`).
    """
    for j in range(joints.shape[0]):
        joint = joints[j]
        friction_out[j, 0], friction_out[j, 1], friction_out[j, 2], power_out[offset + j] = 0.0, 0.0, 0.0, 0.0
        if (
            joint.friction_coefficient == 0.0
            and joint.friction_constant == 0.0
            and joint.friction_viscous == 0.0
        ):
            continue
        force = joint_force(joint, multiplier)
        if joint.slides == 1:
            power_out[offset + j] = sliding_friction(
                joint, force, position, quaternion, twist, load_out, friction_out[j]
            )
        else:
            power_out[offset + j] = turning_friction(
                joint, force, quaternion, twist, load_out, friction_out[j]
            )


@kernel
def apply_given(bodies, gravity, torques, wrench, load_out):
    """Set `load_out` (n_bodies + 1, 6) [N, N m] to weights, external wrenches and constant moments about the
    mass centres.
    """
    for b in range(load_out.shape[0]):
        for k in range(3):
            load_out[b, k] = bodies[b].mass * gravity[k] + wrench[b, k]
            load_out[b, 3 + k] = wrench[b, 3 + k]
    for i in range(torques.shape[0]):
        for k in range(3):
            load_out[torques[i].body, 3 + k] += torques[i].moment[k]
