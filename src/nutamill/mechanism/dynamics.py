"""One step of the constrained mechanism, in two halves: `drift` to the next pose, `finish` with the loads found there.

Velocity Verlet on momentum and angular momentum with one constraint solve per step:

1. drift: ``p += v dt + a dt^2/2``, ``q = exp(w dt + alpha dt^2/2) q``;
2. loads and reactions there, velocity-dependent loads with the predicted ``v + a dt``;
3. kick: ``L1 = L0 + dt/2 (T0 + T1) + dt/2 (W1 - W0)``, T the load with reactions and external wrench W. W0 leaves and W1 counts
   in full: the step gives exactly the impulse ``W1 dt``;
4. poses and velocities back onto the constraints, along the mass-orthogonal directions, with the same factor.

Angular momentum is stepped in world axes, where a free body keeps it to round-off.

Source: Hairer, Lubich and Wanner, Geometric Numerical Integration, 2006, section VII.5 (Verlet on the rotation group) and
section VII.1.4 (projection); Andersen, J. Comput. Phys. 52, 24-34, 1983 (Verlet with positions and velocities on constraints).
"""

import math

from nutamill.frames import cross, rotation_matrix, turn_quaternion
from nutamill.kernel import kernel
from nutamill.mechanism.drive import evaluate_drives
from nutamill.mechanism.joints import bend_rows, place_rows, row_rate
from nutamill.mechanism.loads import apply_bushings, apply_given, apply_joint_friction, apply_springs
from nutamill.mechanism.solve import (
    add_row_reactions,
    divide_by_mass,
    divide_rows_by_mass,
    factor,
    form_schur,
    solve_factored,
)

OK, NOT_FINITE = 0, 1
"""Status of a step: fine; a number is no longer finite (the state is lost)."""

START_ROUNDS = 8
"""Newton rounds that bring an assembled pose onto its constraints; each squares the gap."""

FRICTION_ROUNDS = 4
"""Solves at the start, so that friction finds the reactions it belongs to; each shrinks the error by about the friction coefficient."""


@kernel
def copy_vector(source, out):
    """Copy a vector (n,)."""
    for i in range(out.shape[0]):
        out[i] = source[i]


@kernel
def copy_rows(source, out):
    """Copy an array (n, m)."""
    for i in range(out.shape[0]):
        for k in range(out.shape[1]):
            out[i, k] = source[i, k]


@kernel
def turn_inertia(R, I_body, I_out):
    """``R I R^T``: an inertia (3, 3) [kg m^2] or its inverse, from body axes to world axes."""
    for i in range(3):
        t0 = R[i, 0] * I_body[0, 0] + R[i, 1] * I_body[1, 0] + R[i, 2] * I_body[2, 0]
        t1 = R[i, 0] * I_body[0, 1] + R[i, 1] * I_body[1, 1] + R[i, 2] * I_body[2, 1]
        t2 = R[i, 0] * I_body[0, 2] + R[i, 1] * I_body[1, 2] + R[i, 2] * I_body[2, 2]
        for j in range(i, 3):
            value = t0 * R[j, 0] + t1 * R[j, 1] + t2 * R[j, 2]
            I_out[i, j] = value
            I_out[j, i] = value


@kernel
def place_bodies(bodies, quaternion, rotation_out, inertia_out, inverse_inertia_out):
    """Rotation matrices, inertias and inverse inertias in world axes, (n_bodies + 1, 3, 3) each, at given attitudes."""
    for b in range(bodies.shape[0]):
        R = rotation_out[b]
        rotation_matrix(quaternion[b], R)
        turn_inertia(R, bodies[b].inertia, inertia_out[b])
        turn_inertia(R, bodies[b].inverse_inertia, inverse_inertia_out[b])


@kernel
def gather_momentum(bodies, inertia, velocity, angular_velocity, twist_out, momentum_out):
    """Twists, and momentum [kg m/s] with angular momentum about the mass centre [kg m^2/s], (n_bodies + 1, 6) each."""
    for b in range(bodies.shape[0]):
        I, w = inertia[b], angular_velocity[b]
        for k in range(3):
            twist_out[b, k] = velocity[b, k]
            twist_out[b, 3 + k] = w[k]
            momentum_out[b, k] = bodies[b].mass * velocity[b, k]
            momentum_out[b, 3 + k] = I[k, 0] * w[0] + I[k, 1] * w[1] + I[k, 2] * w[2]


@kernel
def accelerate(bodies, inertia, inverse_inertia, twist, load, out):
    """Accelerations (n_bodies + 1, 6) [m/s^2, rad/s^2] from loads about the mass centres and twists.

    Newton and Euler: ``m a = F``, ``I alpha = M - w x I w``.
    """
    for b in range(load.shape[0]):
        I, t = inertia[b], twist[b]
        h0 = I[0, 0] * t[3] + I[0, 1] * t[4] + I[0, 2] * t[5]
        h1 = I[1, 0] * t[3] + I[1, 1] * t[4] + I[1, 2] * t[5]
        h2 = I[2, 0] * t[3] + I[2, 1] * t[4] + I[2, 2] * t[5]
        g0, g1, g2 = cross(t[3], t[4], t[5], h0, h1, h2)
        out[b, 0], out[b, 1], out[b, 2] = load[b, 0], load[b, 1], load[b, 2]
        out[b, 3], out[b, 4], out[b, 5] = load[b, 3] - g0, load[b, 4] - g1, load[b, 5] - g2
    divide_by_mass(bodies, inverse_inertia, out, out)


@kernel
def place(mechanism, state, scratch):
    """Rotations, inertias, row vectors, gaps and Jacobian at the present pose and `scratch.drive_motion`."""
    place_bodies(mechanism.bodies, state.quaternion, scratch.rotation, scratch.inertia, scratch.inverse_inertia)
    place_rows(
        mechanism.rows, state.position, scratch.rotation, scratch.drive_motion,
        scratch.row_vectors, scratch.gap, scratch.gap_rate, scratch.jacobian,
    )  # fmt: skip


@kernel
def factor_constraints(mechanism, scratch):
    """``M^-1 J^T``, ``J M^-1 J^T`` and its factor from the placed Jacobian."""
    divide_rows_by_mass(mechanism.rows, mechanism.bodies, scratch.inverse_inertia, scratch.jacobian, scratch.inverse_mass_jacobian)
    form_schur(mechanism.pairs, scratch.jacobian, scratch.inverse_mass_jacobian, scratch.schur)
    factor(scratch.schur, scratch.lower, scratch.upper, scratch.inverse_pivot)


@kernel
def apply_loads(mechanism, state, scratch):
    """Applied loads (friction apart) about the mass centres into `scratch.load`, with the velocities of `scratch.twist`."""
    twist, load, power = scratch.twist, scratch.load, scratch.power
    apply_given(mechanism.bodies, mechanism.gravity, mechanism.torques, state.wrench, load)
    apply_bushings(mechanism.bushings, state.position, state.quaternion, twist, load, power)
    apply_springs(mechanism.springs, state.position, state.quaternion, twist, mechanism.bushings.shape[0], load, power)


@kernel
def solve_reactions(mechanism, state, scratch):
    """Loads at the present pose and `scratch.twist`, and the row reactions that keep the constraints.

    Leaves Jacobian, gaps and factor in `scratch`, the reactions in `scratch.multiplier`, the load with reactions in
    `state.load`, and the accelerations in `state.acceleration`.
    """
    place(mechanism, state, scratch)
    apply_loads(mechanism, state, scratch)
    offset = mechanism.bushings.shape[0] + mechanism.springs.shape[0]
    apply_joint_friction(
        mechanism.joints, state.multiplier, state.quaternion, scratch.twist, offset,
        scratch.load, state.friction_moment, scratch.power,
    )  # fmt: skip
    bend_rows(mechanism.rows, scratch.row_vectors, scratch.twist, scratch.drive_motion, scratch.curvature)
    factor_constraints(mechanism, scratch)
    acceleration, reaction = state.acceleration, scratch.multiplier
    accelerate(mechanism.bodies, scratch.inertia, scratch.inverse_inertia, scratch.twist, scratch.load, acceleration)
    row_residuals(mechanism.rows, scratch.jacobian, acceleration, scratch.curvature, reaction)
    solve_factored(scratch.lower, scratch.upper, scratch.inverse_pivot, reaction)
    add_row_reactions(mechanism.rows, scratch.inverse_mass_jacobian, reaction, acceleration)
    copy_rows(scratch.load, state.load)
    add_row_reactions(mechanism.rows, scratch.jacobian, reaction, state.load)
    hold_ground(state.load)
    hold_ground(acceleration)


@kernel
def hold_ground(per_body):
    """Zero the ground's row of a per-body array (n_bodies + 1, 6)."""
    for k in range(6):
        per_body[per_body.shape[0] - 1, k] = 0.0


@kernel
def project_positions(rows, factors, inverse_mass_jacobian, gap, solution, move, position_out, quaternion_out):
    """Move positions and attitudes by ``-M^-1 J^T S^-1 gap``, with the present `factors` (L, U, 1/D).

    `solution` (n_rows,) and `move` (n_bodies + 1, 6) are work space.
    """
    for i in range(solution.shape[0]):
        solution[i] = -gap[i]
    solve_factored(factors[0], factors[1], factors[2], solution)
    for b in range(move.shape[0]):
        for k in range(6):
            move[b, k] = 0.0
    add_row_reactions(rows, inverse_mass_jacobian, solution, move)
    for b in range(move.shape[0] - 1):
        for k in range(3):
            position_out[b, k] += move[b, k]
        q = quaternion_out[b]
        turn_quaternion(q, move[b, 3], move[b, 4], move[b, 5], q)


@kernel
def project_velocities(mechanism, state, scratch):
    """Velocities from `scratch.momentum`, brought onto the constraints at the present (already projected) pose.

    The row impulses [N s or N m s] stay in `scratch.solution`; their share of the momentum acts at the joints' present points.
    """
    bodies, rows, twist, impulse = mechanism.bodies, mechanism.rows, scratch.twist, scratch.solution
    divide_by_mass(bodies, scratch.inverse_inertia, scratch.momentum, twist)
    for i in range(impulse.shape[0]):
        impulse[i] = -scratch.gap_rate[i]
    row_residuals(rows, scratch.jacobian, twist, impulse, impulse)
    solve_factored(scratch.lower, scratch.upper, scratch.inverse_pivot, impulse)
    add_row_reactions(rows, scratch.jacobian, impulse, scratch.momentum)
    hold_ground(scratch.momentum)
    divide_by_mass(bodies, scratch.inverse_inertia, scratch.momentum, twist)
    for b in range(twist.shape[0]):
        for k in range(3):
            state.velocity[b, k] = twist[b, k]
            state.angular_velocity[b, k] = twist[b, 3 + k]


@kernel
def keep_solution(state, scratch):
    """Take over what the solve found: reactions, drive motions, dissipated powers, and the wrench contained in the load."""
    copy_vector(scratch.multiplier, state.multiplier)
    copy_vector(scratch.power, state.power)
    copy_rows(scratch.drive_motion, state.drive_motion)
    copy_rows(state.wrench, state.previous_wrench)


@kernel
def start(mechanism, state, scratch):
    """Bring the assembled state onto its constraints and solve once, in place; call it before the first step.

    Positions and attitudes move along mass-orthogonal directions until the gaps are at round-off, velocities likewise.
    `state.wrench` counts as acting already.

    Returns
    -------
    status : OK or NOT_FINITE
    """
    factors = scratch.lower, scratch.upper, scratch.inverse_pivot
    evaluate_drives(mechanism.drives, mechanism.knots, state.time[0], scratch.drive_motion)
    for _ in range(START_ROUNDS):
        place(mechanism, state, scratch)
        factor_constraints(mechanism, scratch)
        project_positions(
            mechanism.rows, factors, scratch.inverse_mass_jacobian, scratch.gap, scratch.solution, scratch.correction,
            state.position, state.quaternion,
        )  # fmt: skip
    place(mechanism, state, scratch)
    gather_momentum(mechanism.bodies, scratch.inertia, state.velocity, state.angular_velocity, scratch.start_twist, scratch.momentum)
    project_velocities(mechanism, state, scratch)
    for _ in range(FRICTION_ROUNDS):
        solve_reactions(mechanism, state, scratch)
        keep_solution(state, scratch)
    return check_finite(state.velocity, state.acceleration)


@kernel
def drift(mechanism, state, scratch, dt):
    """First half of a step: positions and attitudes to the end of `dt` [s], under the present velocities and accelerations.

    Exactly the motion of `nutamill.frames.pose_in_window` at ``s = dt``.  Velocities, accelerations and time stay those of the
    start.  `finish` must follow with the same `scratch`.
    """
    place_bodies(mechanism.bodies, state.quaternion, scratch.rotation, scratch.inertia, scratch.inverse_inertia)
    gather_momentum(mechanism.bodies, scratch.inertia, state.velocity, state.angular_velocity, scratch.start_twist, scratch.momentum)
    h = 0.5 * dt * dt
    for b in range(state.position.shape[0] - 1):
        p, q, v, w, a = state.position[b], state.quaternion[b], state.velocity[b], state.angular_velocity[b], state.acceleration[b]
        for k in range(3):
            p[k] = p[k] + dt * v[k] + h * a[k]
        turn_quaternion(q, dt * w[0] + h * a[3], dt * w[1] + h * a[4], dt * w[2] + h * a[5], q)


@kernel
def finish(mechanism, state, scratch, dt):
    """Second half of a step: loads with `state.wrench`, reactions, kick, projection, ledgers; time advances by `dt` [s].

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
            scratch.momentum[b, k] += half * (state.load[b, k] + state.wrench[b, k] - state.previous_wrench[b, k])
    solve_reactions(mechanism, state, scratch)
    for b in range(state.position.shape[0] - 1):
        for k in range(6):
            scratch.momentum[b, k] += half * state.load[b, k]
    project_positions(
        mechanism.rows, (scratch.lower, scratch.upper, scratch.inverse_pivot), scratch.inverse_mass_jacobian, scratch.gap,
        scratch.solution, scratch.correction, state.position, state.quaternion,
    )  # fmt: skip
    place(mechanism, state, scratch)
    project_velocities(mechanism, state, scratch)
    add_works(mechanism, state, scratch, dt)
    add_losses(mechanism, state, scratch.power, dt)
    keep_solution(state, scratch)
    return check_finite(state.velocity, state.acceleration)


@kernel
def row_residuals(rows, jacobian, motion, target, out):
    """``target - J motion`` row by row into `out` (n_rows,); `motion` (n_bodies + 1, 6) are twists or accelerations."""
    for i in range(rows.shape[0]):
        out[i] = target[i] - row_rate(jacobian[i], motion[rows[i].body_a], motion[rows[i].body_b])


@kernel
def add_works(mechanism, state, scratch, dt):
    """Works of drives, wrenches and constant moments over the step just made: impulse times mean velocity.

    A drive's impulse is the mean of its two reactions times `dt`, plus the impulse of the velocity projection.
    """
    drives, torques, before, after = mechanism.drives, mechanism.torques, scratch.start_twist, scratch.twist
    for d in range(drives.shape[0]):
        i = drives[d].row
        impulse = 0.5 * dt * (state.multiplier[i] + scratch.multiplier[i]) + scratch.solution[i]
        state.drive_work[d] += impulse * 0.5 * (state.drive_motion[d, 1] + scratch.drive_motion[d, 1])
    for b in range(before.shape[0]):
        for k in range(6):
            state.wrench_work[b] += 0.5 * dt * state.wrench[b, k] * (before[b, k] + after[b, k])
    for i in range(torques.shape[0]):
        b = torques[i].body
        for k in range(3):
            state.torque_work[i] += 0.5 * dt * torques[i].moment[k] * (before[b, 3 + k] + after[b, 3 + k])


@kernel
def add_losses(mechanism, state, power, dt):
    """Losses of bushings, springs and joints over the step just made [J], by the trapezoid rule of their powers."""
    n_bushings, n_springs = mechanism.bushings.shape[0], mechanism.springs.shape[0]
    for i in range(n_bushings):
        state.bushing_loss[i] += 0.5 * dt * (state.power[i] + power[i])
    for i in range(n_springs):
        at = n_bushings + i
        state.spring_loss[i] += 0.5 * dt * (state.power[at] + power[at])
    for i in range(mechanism.joints.shape[0]):
        at = n_bushings + n_springs + i
        state.joint_loss[i] += 0.5 * dt * (state.power[at] + power[at])


@kernel
def check_finite(velocity, acceleration):
    """OK, or NOT_FINITE if any acceleration or velocity is NaN or infinite."""
    total = 0.0
    for b in range(velocity.shape[0]):
        for k in range(3):
            total += abs(velocity[b, k]) + abs(acceleration[b, k]) + abs(acceleration[b, 3 + k])
    return OK if math.isfinite(total) else NOT_FINITE


@kernel
def step(mechanism, state, scratch, dt):
    """One step of `dt` [s] under a constant `state.wrench`; returns OK or NOT_FINITE."""
    drift(mechanism, state, scratch, dt)
    return finish(mechanism, state, scratch, dt)


@kernel
def march(mechanism, state, scratch, dt, n_steps):
    """`n_steps` steps of `dt` [s] under a constant `state.wrench`; returns OK or NOT_FINITE, and stops at the latter."""
    for _ in range(n_steps):
        drift(mechanism, state, scratch, dt)
        status = finish(mechanism, state, scratch, dt)
        if status != OK:
            return status
    return OK
