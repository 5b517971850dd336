"""One step of the constrained mechanism, in two halves: `drift` to the next pose, `finish` with the loads
there.

Velocity Verlet on momentum and angular momentum with one constraint solve per step:

1. drift: ``p += v dt + a dt^2/2``, ``q = exp(w dt + alpha dt^2/2) q``;
2. loads and reactions there, velocity-dependent loads with the predicted ``v + a dt``;
3. kick: ``L1 = L0 + dt/2 (T0 + T1) + dt/2 (W1 - W0)``, T the load with reactions and external wrench W: the
   step gives exactly the impulse ``W1 dt``;
4. poses and velocities back onto the constraints, along the mass-orthogonal directions, with the same factor.

Angular momentum is stepped in world axes, in which that of a free body is constant to round-off.

Source: Hairer, Lubich and Wanner, Geometric Numerical Integration, 2006, section VII.5 (Verlet on the
rotation group) and section VII.1.4 (projection); Andersen, J. Comput. Phys. 52, 24-34, 1983 (Verlet with
positions and velocities on constraints).
"""

import math

from nutamill.base.frames import turn_quaternion
from nutamill.base.kernel import copy_numbers, kernel
from nutamill.mechanism.drives import advance_motors, driven_rate, evaluate_drives, store_drives
from nutamill.mechanism.equations import (
    factor_constraints,
    place_bodies,
    row_residuals,
    solve_reactions,
    update_kinematics,
    zero_ground,
)
from nutamill.mechanism.forces import add_force_works
from nutamill.mechanism.solve import add_row_reactions, divide_by_mass, solve_factored
from nutamill.mechanism.stops import advance_stops

OK, NOT_FINITE = 0, 1
"""Status of a step: fine; a number is no longer finite (the state is lost)."""

START_ROUNDS = 8
"""Newton rounds that bring an assembled pose onto its constraints [1]; each squares the gap."""

FRICTION_ROUNDS = 4
"""Solves at the start [1], so that friction and reactions agree; each shrinks the error by about the friction
coefficient.
"""


@kernel
def gather_momentum(bodies, inertia, velocity, angular_velocity, twist_out, momentum_out):
    """Write twists, and momentum [kg m/s] with angular momentum about the mass centre [kg m^2/s], (n_bodies +
    1, 6) each.
    """
    for b in range(bodies.shape[0]):
        I, w = inertia[b], angular_velocity[b]
        for k in range(3):
            twist_out[b, k] = velocity[b, k]
            twist_out[b, 3 + k] = w[k]
            momentum_out[b, k] = bodies[b].mass * velocity[b, k]
            momentum_out[b, 3 + k] = I[k, 0] * w[0] + I[k, 1] * w[1] + I[k, 2] * w[2]


@kernel
def project_positions(
    rows, gears, factors, inverse_mass_jacobian, gap, solution_out, move_out, position_out, quaternion_out
):
    """Move positions and attitudes by ``-M^-1 J^T S^-1 gap``, with the present `factors` (L, U, 1/D).

    `solution_out` (n_rows,) and `move_out` (n_bodies + 1, 6) are work space.
    """
    for i in range(solution_out.shape[0]):
        solution_out[i] = -gap[i]
    solve_factored(factors[0], factors[1], factors[2], solution_out)
    for b in range(move_out.shape[0]):
        for k in range(6):
            move_out[b, k] = 0.0
    add_row_reactions(rows, gears, inverse_mass_jacobian, solution_out, move_out)
    for b in range(move_out.shape[0] - 1):
        for k in range(3):
            position_out[b, k] += move_out[b, k]
        q = quaternion_out[b]
        turn_quaternion(q, move_out[b, 3], move_out[b, 4], move_out[b, 5], q)


@kernel
def project_velocities(mechanism, state, scratch):
    """Compute velocities from `scratch.momentum` and bring them onto the constraints at the present (already
    projected) pose.

    The gap rates are those of the present pose.  The correction runs along ``M^-1 J^T`` of the pose that was
    factored: only with the factor of the same pose is it the smallest motion that closes the rates, whatever
    the ratios of the masses.  The row impulses [N s or N m s] stay in `scratch.solution`.
    """
    twist, impulse = scratch.twist, scratch.solution
    divide_by_mass(mechanism.bodies, scratch.inverse_inertia, scratch.momentum, twist)
    for i in range(impulse.shape[0]):
        impulse[i] = -scratch.gap_rate[i]
    row_residuals(mechanism.rows, mechanism.gears, scratch.jacobian, twist, impulse, impulse)
    solve_factored(scratch.lower, scratch.upper, scratch.inverse_pivot, impulse)
    add_row_reactions(mechanism.rows, mechanism.gears, scratch.inverse_mass_jacobian, impulse, twist)
    zero_ground(twist)
    for b in range(twist.shape[0]):
        for k in range(3):
            state.velocity[b, k] = twist[b, k]
            state.angular_velocity[b, k] = twist[b, 3 + k]


@kernel
def report_reactions(mechanism, state, scratch):
    """Compute the reactions to report at the end of a step, `state.reaction`, with the factor of its solve.

    The external wrench is the mean over the step, so that it belongs to the middle of the step, and the
    solve at its end answers it half a step late.  To the reactions of the solve is added the answer to half
    the change of the wrench since the step before: linear extrapolation to the end, of second order.  The
    bodies do not feel it.  `scratch.solution` and `scratch.correction` are overwritten.
    """
    copy_numbers(scratch.multiplier, state.reaction)
    if same(state.wrench, state.earlier_wrench):
        return
    now, before, change, answer = state.wrench, state.earlier_wrench, scratch.correction, scratch.solution
    for b in range(change.shape[0]):
        for k in range(6):
            change[b, k] = 0.5 * (now[b, k] - before[b, k])
    for i in range(answer.shape[0]):
        answer[i] = 0.0
    row_residuals(mechanism.rows, mechanism.gears, scratch.inverse_mass_jacobian, change, answer, answer)
    solve_factored(scratch.lower, scratch.upper, scratch.inverse_pivot, answer)
    for i in range(answer.shape[0]):
        state.reaction[i] += answer[i]
    copy_numbers(now, before)


@kernel
def same(one, other):
    """Return whether two arrays (n, m) hold the same numbers."""
    for i in range(one.shape[0]):
        for k in range(one.shape[1]):
            if one[i, k] != other[i, k]:
                return False
    return True


@kernel
def store_solution(mechanism, state, scratch):
    """Store the results of the solve in the state: row reactions, drive motions and torques, dissipated
    powers, and the wrench contained in the load.
    """
    copy_numbers(scratch.multiplier, state.multiplier)
    copy_numbers(scratch.power, state.power)
    if mechanism.forces.shape[0] > 0:
        copy_numbers(scratch.force, state.force)
    copy_numbers(state.wrench, state.previous_wrench)
    gather_twists(state, scratch.twist)
    store_drives(
        mechanism.drives,
        state.position,
        state.quaternion,
        scratch.twist,
        state.acceleration,
        state.reaction,
        scratch.motor_torque,
        scratch.drive_motion,
        state.drive_torque,
        state.drive_motion,
    )


@kernel
def start(mechanism, state, scratch):
    """Bring the assembled state onto its constraints and solve once, in place, before the first step.

    Positions and attitudes move along mass-orthogonal directions until the gaps are at round-off, velocities
    likewise. `state.wrench` counts as acting already.

    Returns
    -------
    status : OK or NOT_FINITE
    """
    factors = scratch.lower, scratch.upper, scratch.inverse_pivot
    evaluate_drives(mechanism.drives, mechanism.knots, state.time[0], scratch.drive_motion)
    for _ in range(START_ROUNDS):
        update_kinematics(mechanism, state, scratch)
        factor_constraints(mechanism, scratch)
        project_positions(
            mechanism.rows,
            mechanism.gears,
            factors,
            scratch.inverse_mass_jacobian,
            scratch.gap,
            scratch.solution,
            scratch.correction,
            state.position,
            state.quaternion,
        )
    update_kinematics(mechanism, state, scratch)
    gather_momentum(
        mechanism.bodies,
        scratch.inertia,
        state.velocity,
        state.angular_velocity,
        scratch.start_twist,
        scratch.momentum,
    )
    project_velocities(mechanism, state, scratch)
    advance_stops(mechanism.stops, state.position, state.quaternion, scratch.twist, state.impact_speed)
    copy_numbers(state.wrench, state.earlier_wrench)
    for _ in range(FRICTION_ROUNDS):
        solve_reactions(mechanism, state, scratch)
        report_reactions(mechanism, state, scratch)
        store_solution(mechanism, state, scratch)
    return check_finite(state.velocity, state.acceleration)


@kernel
def drift(mechanism, state, scratch, dt):
    """Make the first half of a step: positions and attitudes to the end of `dt` [s] under the present
    velocities and accelerations.

    Exactly the motion of `nutamill.base.frames.pose_in_window` at ``s = dt``.  Velocities, accelerations and
    time stay those of the start.  `finish` must follow with the same `scratch`.
    """
    place_bodies(
        mechanism.bodies, state.quaternion, scratch.rotation, scratch.inertia, scratch.inverse_inertia
    )
    gather_momentum(
        mechanism.bodies,
        scratch.inertia,
        state.velocity,
        state.angular_velocity,
        scratch.start_twist,
        scratch.momentum,
    )
    h = 0.5 * dt * dt
    for b in range(state.position.shape[0] - 1):
        p, q, v, w, a = (
            state.position[b],
            state.quaternion[b],
            state.velocity[b],
            state.angular_velocity[b],
            state.acceleration[b],
        )
        for k in range(3):
            p[k] = p[k] + dt * v[k] + h * a[k]
        turn_quaternion(q, dt * w[0] + h * a[3], dt * w[1] + h * a[4], dt * w[2] + h * a[5], q)


@kernel
def finish(mechanism, state, scratch, dt):
    """Make the second half of a step of `dt` [s]: loads with `state.wrench`, reactions, kick, projection,
    ledgers, time.

    `state.wrench` (n_bodies + 1, 6) is the mean over the step: the bodies receive exactly ``wrench dt``.

    Returns
    -------
    status : OK or NOT_FINITE
    """
    half = 0.5 * dt
    state.time[0] += dt
    evaluate_drives(mechanism.drives, mechanism.knots, state.time[0], scratch.drive_motion)
    for b in range(state.position.shape[0] - 1):
        for k in range(6):
            scratch.twist[b, k] = scratch.start_twist[b, k] + dt * state.acceleration[b, k]
            scratch.momentum[b, k] += half * (
                state.load[b, k] + state.wrench[b, k] - state.previous_wrench[b, k]
            )
    solve_reactions(mechanism, state, scratch)
    for b in range(state.position.shape[0] - 1):
        for k in range(6):
            scratch.momentum[b, k] += half * state.load[b, k]
    project_positions(
        mechanism.rows,
        mechanism.gears,
        (scratch.lower, scratch.upper, scratch.inverse_pivot),
        scratch.inverse_mass_jacobian,
        scratch.gap,
        scratch.solution,
        scratch.correction,
        state.position,
        state.quaternion,
    )
    update_kinematics(mechanism, state, scratch)
    project_velocities(mechanism, state, scratch)
    add_works(mechanism, state, scratch, dt)
    add_losses(state, scratch.power, dt)
    report_reactions(mechanism, state, scratch)
    advance_motors(
        mechanism.drives,
        state.position,
        state.quaternion,
        scratch.twist,
        state.time[0],
        scratch.drive_motion,
        dt,
        state.motor_integral,
    )
    if mechanism.stops.shape[0] > 0:
        advance_stops(mechanism.stops, state.position, state.quaternion, scratch.twist, state.impact_speed)
    store_solution(mechanism, state, scratch)
    return check_finite(state.velocity, state.acceleration)


@kernel
def add_works(mechanism, state, scratch, dt):
    """Add the works of drives, wrenches, constant moments and given forces over the step just made: impulse
    times mean velocity.

    A drive's impulse is the mean of its two reactions times `dt`, plus the impulse of the velocity
    projection.
    """
    drives, torques, before, after = mechanism.drives, mechanism.torques, scratch.start_twist, scratch.twist
    for d in range(drives.shape[0]):
        i = drives[d].row
        if i < 0:
            rate = driven_rate(drives[d], state.position, state.quaternion, after)
            state.drive_work[d] += (
                0.5
                * dt
                * (state.drive_torque[d] + scratch.motor_torque[d])
                * 0.5
                * (state.drive_motion[d, 1] + rate)
            )
            continue
        impulse = 0.5 * dt * (state.multiplier[i] + scratch.multiplier[i]) + scratch.solution[i]
        state.drive_work[d] += impulse * 0.5 * (state.drive_motion[d, 1] + scratch.drive_motion[d, 1])
    for b in range(before.shape[0]):
        for k in range(6):
            state.wrench_work[b] += 0.5 * dt * state.wrench[b, k] * (before[b, k] + after[b, k])
    for i in range(torques.shape[0]):
        b = torques[i].body
        for k in range(3):
            state.torque_work[i] += 0.5 * dt * torques[i].moment[k] * (before[b, 3 + k] + after[b, 3 + k])
    if mechanism.forces.shape[0] > 0:
        add_force_works(mechanism.forces, state.force, scratch.force, before, after, dt, state.force_work)


@kernel
def add_losses(state, power, dt):
    """Add the losses of bushings, springs, joints and stops over the step just made [J], by the trapezoid
    rule of their powers.
    """
    for i in range(power.shape[0]):
        state.loss[i] += 0.5 * dt * (state.power[i] + power[i])


@kernel
def check_finite(velocity, acceleration):
    """Return OK, or NOT_FINITE if any acceleration or velocity is NaN or infinite."""
    total = 0.0
    for b in range(velocity.shape[0]):
        for k in range(3):
            total += abs(velocity[b, k]) + abs(acceleration[b, k]) + abs(acceleration[b, 3 + k])
    return OK if math.isfinite(total) else NOT_FINITE


@kernel
def step(mechanism, state, scratch, dt):
    """Make one step of `dt` [s] under a constant `state.wrench` and return OK or NOT_FINITE."""
    drift(mechanism, state, scratch, dt)
    return finish(mechanism, state, scratch, dt)


@kernel
def march(mechanism, state, scratch, dt, n_steps):
    """Make `n_steps` steps of `dt` [s] under a constant `state.wrench` and return OK, or NOT_FINITE from the
    step that failed.
    """
    for _ in range(n_steps):
        drift(mechanism, state, scratch, dt)
        status = finish(mechanism, state, scratch, dt)
        if status != OK:
            return status
    return OK


@kernel
def solve_again(mechanism, state, scratch):
    """Solve again at the present pose and velocities with the present `state.wrench`, which then counts as
    acting already.

    To repeat a step from its start with another wrench: restore the state, set the wrench, call this, then
    `drift`.
    """
    evaluate_drives(mechanism.drives, mechanism.knots, state.time[0], scratch.drive_motion)
    gather_twists(state, scratch.twist)
    solve_reactions(mechanism, state, scratch)
    copy_numbers(scratch.multiplier, state.reaction)
    store_solution(mechanism, state, scratch)


@kernel
def gather_twists(state, twist_out):
    """Write velocity and angular velocity of every body side by side, (n_bodies + 1, 6) [m/s, rad/s], world
    axes.
    """
    for b in range(twist_out.shape[0]):
        for k in range(3):
            twist_out[b, k] = state.velocity[b, k]
            twist_out[b, 3 + k] = state.angular_velocity[b, k]


@kernel
def body_motion(state, body, motion_out):
    """Write position, quaternion, velocity, angular velocity, acceleration and angular acceleration of a
    body's mass centre into `motion_out` (19,), in the order of `nutamill.base.frames.MOTION_SIZE`, SI, world
    axes.
    """
    for k in range(3):
        motion_out[k] = state.position[body, k]
        motion_out[7 + k] = state.velocity[body, k]
        motion_out[10 + k] = state.angular_velocity[body, k]
        motion_out[13 + k] = state.acceleration[body, k]
        motion_out[16 + k] = state.acceleration[body, 3 + k]
    for k in range(4):
        motion_out[3 + k] = state.quaternion[body, k]
