"""The equations of motion at one instant: poses to Jacobians and inertias, loads, accelerations and
reactions.

``M a = F + J^T lambda`` with ``J a = bias``, solved by elimination of a.

Source: Haug, Computer Aided Kinematics and Dynamics of Mechanical Systems, 1989, section 11.3; Featherstone,
Rigid Body Dynamics Algorithms, 2008, section 3.2.
"""

from nutamill.base.frames import cross, rotation_matrix
from nutamill.base.kernel import copy_numbers, kernel
from nutamill.mechanism.drives import apply_motors
from nutamill.mechanism.forces import apply_forces
from nutamill.mechanism.gears import bias_gears, place_gears
from nutamill.mechanism.joints import bias_rows, place_rows, row_rate
from nutamill.mechanism.loads import apply_bushings, apply_given, apply_joint_friction, apply_springs
from nutamill.mechanism.solve import (
    add_row_reactions,
    divide_by_mass,
    divide_rows_by_mass,
    factor,
    form_schur,
    solve_factored,
)
from nutamill.mechanism.stops import apply_stops


@kernel
def rotate_inertia(R, I_body, I_out):
    """Write ``R I R^T``: an inertia (3, 3) [kg m^2] or its inverse, from body axes to world axes."""
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
    """Write rotation matrices, inertias and inverse inertias in world axes, (n_bodies + 1, 3, 3) each, at
    given attitudes.
    """
    for b in range(bodies.shape[0]):
        R = rotation_out[b]
        rotation_matrix(quaternion[b], R)
        rotate_inertia(R, bodies[b].inertia, inertia_out[b])
        rotate_inertia(R, bodies[b].inverse_inertia, inverse_inertia_out[b])


@kernel
def accelerate(bodies, inertia, inverse_inertia, twist, load, out):
    """Write accelerations (n_bodies + 1, 6) [m/s^2, rad/s^2] from loads about the mass centres and twists.

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
def update_kinematics(mechanism, state, scratch):
    """Compute rotations, inertias, row vectors, gaps and Jacobian at the present pose and
    `scratch.drive_motion`.
    """
    place_bodies(
        mechanism.bodies, state.quaternion, scratch.rotation, scratch.inertia, scratch.inverse_inertia
    )
    place_rows(
        mechanism.rows, state.position, scratch.rotation, scratch.drive_motion,
        scratch.row_vectors, scratch.gap, scratch.gap_rate, scratch.jacobian,
    )  # fmt: skip
    if mechanism.gears.shape[0] > 0:
        place_gears(
            mechanism.gears, mechanism.gear_sides, mechanism.rows.shape[0], state.quaternion,
            state.gear_angle, scratch.gap, scratch.gap_rate, scratch.jacobian,
        )  # fmt: skip


@kernel
def factor_constraints(mechanism, scratch):
    """Compute ``M^-1 J^T``, ``J M^-1 J^T`` and its factor from the present Jacobian."""
    divide_rows_by_mass(
        mechanism.rows,
        mechanism.bodies,
        scratch.inverse_inertia,
        scratch.jacobian,
        scratch.inverse_mass_jacobian,
    )
    n_rows = mechanism.rows.shape[0]
    if mechanism.gears.shape[0] > 0:
        divide_rows_by_mass(
            mechanism.gears,
            mechanism.bodies,
            scratch.inverse_inertia,
            scratch.jacobian[n_rows:],
            scratch.inverse_mass_jacobian[n_rows:],
        )
    form_schur(
        mechanism.pairs,
        mechanism.gear_pairs,
        scratch.jacobian,
        scratch.inverse_mass_jacobian,
        scratch.schur,
    )
    factor(scratch.schur, scratch.lower, scratch.upper, scratch.inverse_pivot)


@kernel
def apply_loads(mechanism, state, scratch):
    """Compute the applied loads (friction apart) about the mass centres, with the velocities of
    `scratch.twist`, into `scratch.load`.
    """
    twist, load, power = scratch.twist, scratch.load, scratch.power
    apply_given(mechanism.bodies, mechanism.gravity, mechanism.torques, state.wrench, load)
    apply_bushings(mechanism.bushings, state.position, state.quaternion, twist, load, power)
    apply_springs(
        mechanism.springs, state.position, state.quaternion, twist, mechanism.bushings.shape[0], load, power
    )
    apply_motors(
        mechanism.drives,
        state.position,
        state.quaternion,
        twist,
        state.time[0],
        scratch.drive_motion,
        state.motor_integral,
        load,
        scratch.motor_torque,
    )
    if mechanism.forces.shape[0] > 0:
        apply_forces(
            mechanism.forces, mechanism.force_knots, state.quaternion, state.time[0], load, scratch.force
        )
    if mechanism.stops.shape[0] > 0:
        first = mechanism.bushings.shape[0] + mechanism.springs.shape[0] + mechanism.joints.shape[0]
        apply_stops(
            mechanism.stops, state.position, state.quaternion, twist, state.impact_speed, first, load, power
        )


@kernel
def row_residuals(rows, gears, jacobian, motion, target, out):
    """Write ``target - J motion`` row by row into `out` (n_rows,).

    `motion` (n_bodies + 1, 6) holds twists or accelerations.
    """
    for i in range(rows.shape[0]):
        out[i] = target[i] - row_rate(jacobian[i], motion[rows[i].body_a], motion[rows[i].body_b])
    for g in range(gears.shape[0]):
        J, a, b = jacobian[rows.shape[0] + g], gears[g].body_a, gears[g].body_b
        out[gears[g].row] -= row_rate(J, motion[a], motion[b])


@kernel
def zero_ground(per_body_out):
    """Set the ground's row of a per-body array (n_bodies + 1, 6) to zero."""
    for k in range(6):
        per_body_out[per_body_out.shape[0] - 1, k] = 0.0


@kernel
def solve_reactions(mechanism, state, scratch):
    """Compute the loads at the present pose and `scratch.twist`, and the row reactions that satisfy the
    constraints.

    Leaves Jacobian, gaps and factor in `scratch`, the reactions in `scratch.multiplier`, the load with
    reactions in `state.load`, and the accelerations in `state.acceleration`.
    """
    update_kinematics(mechanism, state, scratch)
    apply_loads(mechanism, state, scratch)
    offset = mechanism.bushings.shape[0] + mechanism.springs.shape[0]
    apply_joint_friction(
        mechanism.joints, state.multiplier, state.position, state.quaternion, scratch.twist, offset,
        scratch.load, state.friction, scratch.power,
    )  # fmt: skip
    bias_rows(mechanism.rows, scratch.row_vectors, scratch.twist, scratch.drive_motion, scratch.bias)
    if mechanism.gears.shape[0] > 0:
        bias_gears(mechanism.gears, mechanism.gear_sides, state.quaternion, scratch.twist, scratch.bias)
    factor_constraints(mechanism, scratch)
    acceleration, reaction = state.acceleration, scratch.multiplier
    accelerate(
        mechanism.bodies, scratch.inertia, scratch.inverse_inertia, scratch.twist, scratch.load, acceleration
    )
    row_residuals(mechanism.rows, mechanism.gears, scratch.jacobian, acceleration, scratch.bias, reaction)
    solve_factored(scratch.lower, scratch.upper, scratch.inverse_pivot, reaction)
    add_row_reactions(mechanism.rows, mechanism.gears, scratch.inverse_mass_jacobian, reaction, acceleration)
    copy_numbers(scratch.load, state.load)
    add_row_reactions(mechanism.rows, mechanism.gears, scratch.jacobian, reaction, state.load)
    zero_ground(state.load)
    zero_ground(acceleration)
