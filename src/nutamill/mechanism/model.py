"""The mechanism as arrays: constants (`Mechanism`), state (`MechanismState`) and work space.

Row `n_bodies` of every per-body array is the ground: zero velocity, infinite mass.  Names are fixed-width
text, so that the type of the struct does not depend on them.
"""

from typing import NamedTuple

import numpy as np

NAME_WIDTH = 64
"""Characters of a part's name."""

POINT, AXIS, GEAR_ROW = 0, 1, 2
"""Kinds of constraint rows: a point of b along an axis of a; an axis of a square to an axis of b; the
rotation of one joint as a ratio of that of another.
"""


BODY = np.dtype(
    [
        ("mass", "f8"),  # [kg]; the ground has 0
        ("inverse_mass", "f8"),  # [1/kg]; the ground has 0
        ("inertia", "f8", (3, 3)),  # about the mass centre [kg m^2], body axes
        ("inverse_inertia", "f8", (3, 3)),  # [1/(kg m^2)], body axes; the ground has 0
    ]
)
"""A body: mass and inertia."""

ROW = np.dtype(
    [
        ("kind", "i8"),  # POINT, AXIS or GEAR_ROW
        ("body_a", "i8"),
        ("body_b", "i8"),
        ("drive", "i8"),  # the drive that rotates axis_a or moves point_a along it, or -1
        ("point_a", "f8", (3,)),  # POINT: joint point on a from a's mass centre [m], axes of a
        ("point_b", "f8", (3,)),  # POINT: joint point on b from b's mass centre [m], axes of b
        ("axis_a", "f8", (3,)),  # unit vector of a [1], axes of a; of a drive: at drive angle zero
        ("axis_b", "f8", (3,)),  # AXIS: unit vector of b [1], axes of b
        ("quarter_a", "f8", (3,)),  # drive: direction of axis_a at drive angle 90 deg [1], axes of a
    ]
)
"""A scalar constraint; every joint and every prescribed rotation is a run of them."""

PAIR = np.dtype([("row", "i8"), ("other", "i8"), ("block", "i8"), ("other_block", "i8")])
"""Two rows (row >= other) that share a moving body, and its first column in the Jacobian of each (0: body a,
6: body b).
"""

JOINT = np.dtype(
    [
        ("body_a", "i8"),
        ("body_b", "i8"),
        ("first_row", "i8"),
        ("end_row", "i8"),  # one past the joint's last row
        ("points", "i8"),  # number of POINT rows, the joint's first; their reactions are forces
        ("turns", "i8"),  # 1: b turns about the joint's axis, and so does its friction; 0: about any axis
        ("slides", "i8"),  # 1: b slides along the joint's axis alone, and its friction is a force along it
        ("reaction_unique", "i8"),  # 1; 0 where redundant constraints share the reaction arbitrarily
        ("point_b", "f8", (3,)),  # the joint's point from b's mass centre [m], axes of b
        ("axis_a", "f8", (3,)),  # the joint's axis [1], axes of a; zero if it has none
        ("friction_coefficient", "f8"),  # [1]
        ("friction_radius", "f8"),  # [m]; 1 [1] in a joint that slides
        ("friction_constant", "f8"),  # [N m], or [N] in a joint that slides
        ("friction_viscous", "f8"),  # [N m s/rad], or [N s/m]
        ("friction_inertia", "f8"),  # moment of inertia that friction brakes [kg m^2], or mass/length [kg/m]
    ]
)
"""A joint: its rows, its point, its friction."""

BUSHING = np.dtype(
    [
        ("body_a", "i8"),
        ("body_b", "i8"),
        ("point_a", "f8", (3,)),  # the bushing's point from a's mass centre [m], axes of a
        ("point_b", "f8", (3,)),  # the same on b
        ("attitude_a", "f8", (4,)),  # quaternion from bushing axes to axes of a [1]
        ("attitude_b", "f8", (4,)),  # quaternion from bushing axes to axes of b [1], which agree at assembly
        ("stiffness", "f8", (6,)),  # three [N/m], three [N m/rad], bushing axes (third: the bushing's axis)
        ("damping", "f8", (6,)),  # three [N s/m], three [N m s/rad], bushing axes
    ]
)
"""A bushing: six stiffness and six damping rates between two bodies."""

SPRING = np.dtype(
    [
        ("body_a", "i8"),
        ("body_b", "i8"),
        ("point_a", "f8", (3,)),  # end on a from a's mass centre [m], axes of a
        ("point_b", "f8", (3,)),  # end on b from b's mass centre [m], axes of b
        ("stiffness", "f8"),  # [N/m]
        ("damping", "f8"),  # [N s/m]
        ("free_length", "f8"),  # [m]
    ]
)
"""A straight spring with a damper between two points."""

TORQUE = np.dtype([("body", "i8"), ("moment", "f8", (3,))])
"""A constant moment [N m] on a body, world axes."""

FORCE = np.dtype(
    [
        ("body", "i8"),
        ("point", "f8", (3,)),  # from the mass centre [m], body axes
        ("first_knot", "i8"),
        ("end_knot", "i8"),
    ]
)
"""A given force: its body, its point, its run of knots."""

FORCE_KNOT = np.dtype([("time", "f8"), ("force", "f8", (3,))])
"""A knot of a given force: time [s] and force [N], world axes."""

DRIVE = np.dtype(
    [
        ("row", "i8"),  # its constraint row; -1 for a motor
        ("first_knot", "i8"),
        ("end_knot", "i8"),
        ("body_a", "i8"),
        ("body_b", "i8"),
        ("axis_a", "f8", (3,)),  # the joint's axis [1], axes of a
        ("zero_a", "f8", (3,)),  # direction of zero_b at angle zero [1], axes of a
        ("zero_b", "f8", (3,)),  # a direction of b square to the axis [1], axes of b
        ("slides", "i8"),  # 1: b slides along the axis; 0: it turns about it
        ("point_a", "f8", (3,)),  # joint point on a from a's mass centre [m], axes of a
        ("point_b", "f8", (3,)),  # joint point on b from b's mass centre [m], axes of b
        ("gain", "f8"),  # motor: torque per error of the speed [N m s/rad], or force [N s/m]
        ("integral_gain", "f8"),  # motor: rate of the torque per error of the speed [N m/rad or N/m]
        ("torque_limit", "f8"),  # motor: largest torque [N m] or force [N]
        ("power_limit", "f8"),  # motor: largest torque or force times speed [W]
        ("cut", "f8"),  # motor: time from which it gives no torque [s]
        ("restored", "f8"),  # motor: time from which it gives torque again [s]
    ]
)
"""A drive: the constraint row of a prescribed motion or the numbers of a motor, and its run of knots."""

KNOT = np.dtype([("time", "f8"), ("speed", "f8"), ("angle", "f8")])
"""A knot of a drive: time [s], speed of b relative to a about or along the joint's axis [rad/s or m/s], and
angle [rad] or travel [m], zero at the first.
"""


STOP = np.dtype(
    [
        ("body_a", "i8"),
        ("body_b", "i8"),
        ("point_a", "f8", (3,)),  # on the plane, or centre of the sphere, from a's mass centre [m], axes of a
        ("point_b", "f8", (3,)),  # centre of the sphere from b's mass centre [m], axes of b
        ("plane", "i8"),  # 1: a has a plane; 0: a sphere
        ("normal", "f8", (3,)),  # of the plane, towards b [1], axes of a
        ("radius", "f8"),  # distance at which they touch [m]: of the sphere of b, or the sum of both radii
        ("stiffness", "f8"),  # [N/m]
        ("damping", "f8"),  # the number that gives its restitution [1]
        ("frequency", "f8"),  # of stiffness and mass as assembled [rad/s]; 0 where joints hold the bodies
    ]
)
"""A one-sided stop."""

GEAR = np.dtype(
    [
        ("row", "i8"),  # its constraint row; the row's bodies are those of the output joint
        ("body_a", "i8"),  # bodies of the input joint
        ("body_b", "i8"),
        ("ratio", "f8"),  # rotation of the output over that of the input [1]
    ]
)
"""A gear: its row and the bodies of its second Jacobian."""

SIDE = np.dtype(
    [
        ("body_a", "i8"),
        ("body_b", "i8"),
        ("axis_a", "f8", (3,)),  # the joint's axis [1], axes of a
        ("zero_a", "f8", (3,)),  # direction of zero_b at angle zero [1], axes of a
        ("zero_b", "f8", (3,)),  # a direction of b square to the axis [1], axes of b
    ]
)
"""The joint on one side of a gear."""

GEAR_PAIR = np.dtype(
    [
        ("row", "i8"),
        ("other", "i8"),
        ("jacobian", "i8"),  # place of the Jacobian of `row`: the row's own or its gear's second
        ("other_jacobian", "i8"),
        ("block", "i8"),
        ("other_block", "i8"),
    ]
)
"""Two Jacobians that share a moving body, one at least the second of a gear, and the body's first column in
each (0: body a, 6: body b).
"""


class Mechanism(NamedTuple):
    """The constants of a mechanism: record arrays, one record per part, in the order given."""

    gravity: np.ndarray
    """Gravity [m/s^2], (3,), world axes."""
    bodies: np.ndarray
    """`BODY` records [SI], (n_bodies + 1,), ground last."""
    rows: np.ndarray
    """`ROW` records [SI], (n_rows,): those of the joints, of the gears, of the drives."""
    pairs: np.ndarray
    """`PAIR` records [1], (n_pairs,), sorted by row."""
    joints: np.ndarray
    """`JOINT` records [SI], (n_joints,)."""
    bushings: np.ndarray
    """`BUSHING` records [SI], (n_bushings,)."""
    springs: np.ndarray
    """`SPRING` records [SI], (n_springs,)."""
    torques: np.ndarray
    """`TORQUE` records [SI], (n_torques,)."""
    drives: np.ndarray
    """`DRIVE` records [1], (n_drives,)."""
    knots: np.ndarray
    """`KNOT` records of all drives [SI], (n_knots,)."""
    forces: np.ndarray
    """`FORCE` records [SI], (n_forces,)."""
    force_knots: np.ndarray
    """`FORCE_KNOT` records of all given forces [SI], (n_force_knots,)."""
    gears: np.ndarray
    """`GEAR` records [SI], (n_gears,)."""
    gear_sides: np.ndarray
    """`SIDE` records of input and output of each gear [1], (2 n_gears,)."""
    gear_pairs: np.ndarray
    """`GEAR_PAIR` records [1], (n_gear_pairs,)."""
    stops: np.ndarray
    """`STOP` records [SI], (n_stops,)."""
    names: np.ndarray
    """Fixed-width names [1] of bodies (ground last), joints, bushings, springs, drives, torques, forces,
    gears, stops, in this order, (n_parts,).
    """


class MechanismState(NamedTuple):
    """The state of a mechanism; a copy of these arrays restores a run bit for bit."""

    time: np.ndarray
    """Time [s], (1,)."""
    position: np.ndarray
    """Mass centres [m], (n_bodies + 1, 3), world."""
    quaternion: np.ndarray
    """Attitudes q_WB (w, x, y, z) [1], (n_bodies + 1, 4)."""
    velocity: np.ndarray
    """Velocities of the mass centres [m/s], (n_bodies + 1, 3), world axes."""
    angular_velocity: np.ndarray
    """Angular velocities [rad/s], (n_bodies + 1, 3), world axes."""
    acceleration: np.ndarray
    """Acceleration of the mass centre [m/s^2] and angular acceleration [rad/s^2], (n_bodies + 1, 6), world
    axes.
    """
    load: np.ndarray
    """Force [N] and moment about the mass centre [N m] behind `acceleration`, reactions included, (n_bodies +
    1, 6), world axes.
    """
    multiplier: np.ndarray
    """Reaction of each constraint row on its body b [N or N m], (n_rows,), along the row's axis."""
    reaction: np.ndarray
    """Reaction of each constraint row to report [N or N m], (n_rows,): `multiplier` with the external wrench
    at `time` in place of its mean over the step (`nutamill.mechanism.dynamics.report_reactions`).
    """
    friction: np.ndarray
    """Friction each joint exerts on its body b, (n_joints, 3), world axes: a moment [N m]; the force [N] of a
    joint that slides.
    """
    drive_motion: np.ndarray
    """Angle [rad], speed [rad/s], acceleration [rad/s^2] of each drive, (n_drives, 3); travel [m] and its
    derivatives where it slides.
    """
    drive_torque: np.ndarray
    """Torque of each drive on its joint's body b about the axis [N m], or force along it [N], (n_drives,)."""
    motor_integral: np.ndarray
    """Integral part of each motor's torque [N m] or force [N], (n_drives,)."""
    impact_speed: np.ndarray
    """Largest closing speed of the contact of each stop so far, or the present one of an open stop [m/s],
    (n_stops,).
    """
    gear_angle: np.ndarray
    """Rotations of input and output of each gear [rad], (2 n_gears,)."""
    force: np.ndarray
    """Force [N] and moment about the body's mass centre [N m] of each given force, (n_forces, 6), world
    axes.
    """
    wrench: np.ndarray
    """External force [N] and moment about the moving mass centre [N m], mean over the step, (n_bodies + 1,
    6), world axes.
    """
    previous_wrench: np.ndarray
    """The external wrench contained in `load`, (n_bodies + 1, 6), as `wrench`."""
    earlier_wrench: np.ndarray
    """The external wrench of the step before, (n_bodies + 1, 6), as `wrench`."""
    power: np.ndarray
    """Power dissipated at `time` by each bushing, then each spring, joint and stop [W], (n_bushings +
    n_springs + n_joints + n_stops,).
    """
    drive_work: np.ndarray
    """Work each drive did on the mechanism [J], (n_drives,), cumulative."""
    wrench_work: np.ndarray
    """Work the external wrench did on each body [J], (n_bodies + 1,), cumulative."""
    torque_work: np.ndarray
    """Work each constant moment did [J], (n_torques,), cumulative."""
    force_work: np.ndarray
    """Work each given force did [J], (n_forces,), cumulative."""
    loss: np.ndarray
    """Energy that each bushing, then each spring, joint and stop dissipated [J], in the order of `power`,
    cumulative.
    """


class MechanismScratch(NamedTuple):
    """Work space of one step; nothing in it has to survive a step."""

    rotation: np.ndarray
    """Rotation matrices R_WB [1], (n_bodies + 1, 3, 3)."""
    inertia: np.ndarray
    """Inertia about the mass centre [kg m^2], (n_bodies + 1, 3, 3), world axes."""
    inverse_inertia: np.ndarray
    """Inverse of `inertia` [1/(kg m^2)], (n_bodies + 1, 3, 3), world axes."""
    twist: np.ndarray
    """Velocity [m/s] and angular velocity [rad/s] of which loads are computed, (n_bodies + 1, 6), world axes.
    """
    start_twist: np.ndarray
    """Velocity and angular velocity at the start of the step, (n_bodies + 1, 6), as `twist`."""
    momentum: np.ndarray
    """Momentum [kg m/s] and angular momentum about the mass centre [kg m^2/s], (n_bodies + 1, 6), world
    axes.
    """
    load: np.ndarray
    """Applied force [N] and moment about the mass centre [N m], (n_bodies + 1, 6), world axes."""
    correction: np.ndarray
    """Inverse mass times row reactions, per body: acceleration or displacement [SI], (n_bodies + 1, 6), world
    axes.
    """
    jacobian: np.ndarray
    """Rows (v_a, w_a, v_b, w_b) of the constraint rates [1 or m], then those of the inputs of gears, (n_rows
    + n_gears, 12), world axes.
    """
    inverse_mass_jacobian: np.ndarray
    """Inverse mass times the transposed Jacobian, (n_rows + n_gears, 12) [1/kg or m/(kg m^2)], world axes."""
    row_vectors: np.ndarray
    """World vectors of each row [1 or m], (n_rows, 12): POINT axis, arm a, arm b, gap; AXIS axis a, the
    same 90 deg of the drive later, axis b.
    """
    gap: np.ndarray
    """Value of each constraint [m or rad], (n_rows,)."""
    gap_rate: np.ndarray
    """Explicit time derivative of each constraint [rad/s], (n_rows,)."""
    bias: np.ndarray
    """Required value of J a [m/s^2 or rad/s^2], (n_rows,)."""
    schur: np.ndarray
    """J M^-1 J^T [SI], (n_rows, n_rows), lower triangle; destroyed by the factorisation."""
    lower: np.ndarray
    """Unit lower factor L [1], (n_rows, n_rows)."""
    upper: np.ndarray
    """L transposed [1], (n_rows, n_rows), so that both solves run along rows."""
    inverse_pivot: np.ndarray
    """1 / D of the factor L D L^T [SI], (n_rows,); 0 for a dependent row."""
    solution: np.ndarray
    """Right-hand side, then solution, of the constraint solve [SI], (n_rows,)."""
    multiplier: np.ndarray
    """Row reactions of the new solve [N or N m], (n_rows,)."""
    drive_motion: np.ndarray
    """Angle [rad], speed [rad/s], acceleration [rad/s^2] of each drive at the end of the step, prescribed or
    the set point of a motor, (n_drives, 3).
    """
    motor_torque: np.ndarray
    """Torque of each motor at the end of the step [N m], (n_drives,)."""
    force: np.ndarray
    """Wrench of each given force at the end of the step [N, N m], (n_forces, 6), as in the state."""
    power: np.ndarray
    """Power dissipated at the end of the step by each bushing, spring, joint, stop [W], as in the state."""


class SensorTable(NamedTuple):
    """The sensors of a mechanism and the columns that `read_sensors` writes."""

    kind: np.ndarray
    """`SensorKind` [1], (n_sensors,)."""
    target: np.ndarray
    """Index of the joint, bushing, spring, drive, gear, stop or body [1], (n_sensors,)."""
    first_column: np.ndarray
    """First column of each sensor [1], (n_sensors + 1,)."""
    point: np.ndarray
    """Point from the body's mass centre [m], (n_sensors, 3), body axes."""
    axes_body: np.ndarray
    """Body in whose axes the vectors are written [1], (n_sensors,); the ground stands for world axes."""
    column: np.ndarray
    """Names of the columns [1], (n_columns,)."""
