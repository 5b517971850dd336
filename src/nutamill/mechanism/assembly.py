"""From the parts of a mechanism to the arrays of the engine: `assemble`.

`assemble` reports all faults of a mechanism together.  `checks.py` looks at the parts one by one,
`constraints.py` at the assembled Jacobian: whether constraints depend on each other or contradict each other.
"""

from collections.abc import Sequence

import numpy as np

from nutamill.base.errors import CaseError
from nutamill.mechanism.checks import part_faults
from nutamill.mechanism.constraints import check_constraints
from nutamill.mechanism.model import (
    BODY,
    BUSHING,
    DRIVE,
    FORCE,
    FORCE_KNOT,
    KNOT,
    NAME_WIDTH,
    SPRING,
    TORQUE,
    Mechanism,
    MechanismScratch,
    MechanismState,
)
from nutamill.mechanism.parts import (
    GROUND,
    JOINTS,
    Body,
    Bushing,
    Drive,
    Force,
    Gear,
    Joint,
    Motor,
    Spring,
    Stop,
    Torque,
)
from nutamill.mechanism.rows import Placement, constraint_tables, frame_along, gear_tables, records
from nutamill.mechanism.stop_tables import set_frequencies, stop_table


def assemble(
    bodies: Sequence[Body],
    joints: Sequence[Joint],
    bushings: Sequence[Bushing] = (),
    springs: Sequence[Spring] = (),
    torques: Sequence[Torque] = (),
    drives: Sequence[Drive] = (),
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81),
    redundant: str = "refuse",
    forces: Sequence[Force] = (),
    gears: Sequence[Gear] = (),
    stops: Sequence[Stop] = (),
) -> tuple[Mechanism, MechanismState, MechanismScratch]:
    """Check a mechanism and turn it into arrays.

    Parts are numbered in the order given.

    Parameters
    ----------
    bodies, joints, bushings, springs, torques, drives, forces, gears, stops : the parts, world coordinates as
        assembled, SI
    gravity : acceleration [m/s^2], (3,), world axes
    redundant : "refuse" constraints that depend on others, or "allow" them: they are solved, and
        ``mechanism.joints.reaction_unique`` marks the joints whose reactions they leave undetermined

    Returns
    -------
    mechanism, state, scratch : constants, state as assembled (call `nutamill.mechanism.dynamics.start` next),
        work space

    Raises
    ------
    CaseError
        with every fault: unknown or repeated names, numbers that are not finite, masses and inertias that no
        rigid body has, missing axes, gaps in loops, redundant constraints (unless allowed) and contradictory
        ones
    """
    groups = {
        "body": bodies,
        "joint": joints,
        "bushing": bushings,
        "spring": springs,
        "drive": drives,
        "torque": torques,
        "force": forces,
        "gear": gears,
        "stop": stops,
    }
    faults = part_faults(groups, gravity, redundant)
    if faults:
        raise CaseError(*faults)
    placement = Placement(bodies)
    joint_table, row_table, pair_table, labels, faults = constraint_tables(placement, joints, drives, gears)
    if faults:
        raise CaseError(*faults)
    drive_table, knot_table = drive_tables(placement, joints, drives, len(row_table))
    force_table, force_knot_table = force_tables(placement, forces)
    gear_table, side_table, gear_pair_table = gear_tables(placement, joints, gears, row_table)
    mechanism = Mechanism(
        gravity=np.array(gravity, float),
        bodies=body_table(bodies),
        rows=row_table,
        pairs=pair_table,
        joints=joint_table,
        bushings=records(BUSHING, [bushing_record(placement, bushing) for bushing in bushings]),
        springs=records(SPRING, [spring_record(placement, spring) for spring in springs]),
        torques=records(TORQUE, [(placement.index[torque.body], torque.moment) for torque in torques]),
        drives=drive_table,
        knots=knot_table,
        forces=force_table,
        force_knots=force_knot_table,
        gears=gear_table,
        gear_sides=side_table,
        gear_pairs=gear_pair_table,
        stops=stop_table(placement, stops),
        names=name_array(groups),
    )
    state, scratch = new_state(mechanism, placement, bodies), new_scratch(mechanism)
    faults = check_constraints(mechanism, state, scratch, labels, redundant)
    if faults:
        raise CaseError(*faults)
    set_frequencies(mechanism, state, scratch)
    return mechanism, state, scratch


def name_array(groups) -> np.ndarray:
    """Return all names as one array of fixed-width text, the ground after the bodies."""
    names = {kind: [part.name for part in parts] for kind, parts in groups.items()}
    names["body"].append(GROUND)
    return np.array([name for group in names.values() for name in group], dtype=f"<U{NAME_WIDTH}")


def body_table(bodies) -> np.recarray:
    """Return masses and inertias, ground last."""
    ground = 0.0, 0.0, np.zeros((3, 3)), np.zeros((3, 3))
    return records(
        BODY,
        [
            *((body.mass, 1.0 / body.mass, body.inertia, np.linalg.inv(body.inertia)) for body in bodies),
            ground,
        ],
    )


def bushing_record(placement, bushing) -> tuple:
    """Return the record of a bushing, its axes fixed in both bodies."""
    a, b, frame = bushing.body_a, bushing.body_b, frame_along(bushing.axis)
    return (
        placement.index[a],
        placement.index[b],
        placement.local_point(a, bushing.point),
        placement.local_point(b, bushing.point),
        placement.attitude_in(a, frame),
        placement.attitude_in(b, frame),
        six_rates(*bushing.stiffness),
        six_rates(*bushing.damping),
    )


def six_rates(shear, axial, bending, torsion) -> tuple:
    """Return the rates along and about the three bushing axes."""
    return shear, shear, axial, bending, bending, torsion


def spring_record(placement, spring) -> tuple:
    """Return the record of a spring, its ends in body axes.

    A preload stands for the free length that gives it as assembled; that of a spring wound with initial
    tension may be negative.
    """
    a, b, free_length = spring.body_a, spring.body_b, spring.free_length
    if free_length is None:
        length = np.linalg.norm(np.subtract(spring.point_b, spring.point_a))
        free_length = length - spring.preload / spring.stiffness
    ends = placement.local_point(a, spring.point_a), placement.local_point(b, spring.point_b)
    return placement.index[a], placement.index[b], *ends, spring.stiffness, spring.damping, free_length


def drive_tables(placement, joints, drives, n_rows) -> tuple[np.recarray, np.recarray]:
    """Return the drives and the knots of all drives. The last rows belong to the drives without a motor."""
    by_name = {joint.name: joint for joint in joints}
    table: list[tuple] = []
    knots: list[tuple] = []
    row = n_rows - sum(drive.motor is None for drive in drives)
    for drive in drives:
        t, w = np.asarray(drive.times, float), np.asarray(drive.speeds, float)
        angle = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(t) * (w[1:] + w[:-1]))])
        joint = by_name[drive.joint]
        a, b = joint.body_a, joint.body_b
        x, _, z = frame_along(joint.axis).T
        axes = placement.local_axis(a, z), placement.local_axis(a, x), placement.local_axis(b, x)
        on_b = joint.point if joint.point_b is None else joint.point_b
        arms = placement.local_point(a, joint.point), placement.local_point(b, on_b)
        motor = drive.motor or Motor(0.0, 0.0)
        numbers = (
            motor.gain,
            motor.integral_gain,
            motor.torque_limit,
            motor.power_limit,
            motor.cut,
            motor.restored,
        )
        own_row = row if drive.motor is None else -1
        table.append(
            (
                own_row,
                len(knots),
                len(knots) + len(t),
                placement.index[a],
                placement.index[b],
                *axes,
                int(JOINTS[joint.kind].slides),
                *arms,
                *numbers,
            )
        )
        knots.extend(zip(t, w, angle, strict=True))
        row += drive.motor is None
    return records(DRIVE, table), records(KNOT, knots)


def force_tables(placement, forces) -> tuple[np.recarray, np.recarray]:
    """Return the given forces and the knots of all of them. A constant force has one knot."""
    table: list[tuple] = []
    knots: list[tuple] = []
    for force in forces:
        first = len(knots)
        if force.times is None:
            knots.append((0.0, force.forces))
        else:
            knots.extend(zip(force.times, force.forces, strict=True))
        index = placement.index[force.body]
        point = placement.position[index] if force.point is None else force.point
        table.append((index, placement.local_point(force.body, point), first, len(knots)))
    return records(FORCE, table), records(FORCE_KNOT, knots)


def new_state(mechanism, placement, bodies) -> MechanismState:
    """Return the state as assembled, ledgers at zero."""
    n, n_rows, n_joints = len(bodies) + 1, len(mechanism.rows), len(mechanism.joints)
    n_bushings, n_springs, n_drives = len(mechanism.bushings), len(mechanism.springs), len(mechanism.drives)
    n_stops = len(mechanism.stops)
    velocity, angular_velocity = np.zeros((n, 3)), np.zeros((n, 3))
    for i, body in enumerate(bodies):
        velocity[i], angular_velocity[i] = body.velocity, body.angular_velocity
    return MechanismState(
        time=np.zeros(1),
        position=placement.position.copy(),
        quaternion=placement.quaternion.copy(),
        velocity=velocity,
        angular_velocity=angular_velocity,
        acceleration=np.zeros((n, 6)),
        load=np.zeros((n, 6)),
        multiplier=np.zeros(n_rows),
        reaction=np.zeros(n_rows),
        friction=np.zeros((n_joints, 3)),
        drive_motion=np.zeros((n_drives, 3)),
        drive_torque=np.zeros(n_drives),
        motor_integral=np.zeros(n_drives),
        impact_speed=np.zeros(n_stops),
        gear_angle=np.zeros(2 * len(mechanism.gears)),
        force=np.zeros((len(mechanism.forces), 6)),
        wrench=np.zeros((n, 6)),
        previous_wrench=np.zeros((n, 6)),
        earlier_wrench=np.zeros((n, 6)),
        power=np.zeros(n_bushings + n_springs + n_joints + n_stops),
        drive_work=np.zeros(n_drives),
        wrench_work=np.zeros(n),
        torque_work=np.zeros(len(mechanism.torques)),
        force_work=np.zeros(len(mechanism.forces)),
        loss=np.zeros(n_bushings + n_springs + n_joints + n_stops),
    )


def new_scratch(mechanism: Mechanism) -> MechanismScratch:
    """Return fresh work space for a mechanism."""
    n, n_rows = len(mechanism.bodies), len(mechanism.rows)
    n_jacobians = n_rows + len(mechanism.gears)
    square = {name: np.zeros((n, 3, 3)) for name in ("rotation", "inertia", "inverse_inertia")}
    six = {name: np.zeros((n, 6)) for name in ("twist", "start_twist", "momentum", "load", "correction")}
    twelve = {name: np.zeros((n_jacobians, 12)) for name in ("jacobian", "inverse_mass_jacobian")}
    matrix = {name: np.zeros((n_rows, n_rows)) for name in ("schur", "lower", "upper")}
    row = {
        name: np.zeros(n_rows)
        for name in ("gap", "gap_rate", "bias", "inverse_pivot", "solution", "multiplier")
    }
    return MechanismScratch(
        **square,
        **six,
        **twelve,
        **matrix,
        **row,
        row_vectors=np.zeros((n_rows, 12)),
        drive_motion=np.zeros((len(mechanism.drives), 3)),
        motor_torque=np.zeros(len(mechanism.drives)),
        force=np.zeros((len(mechanism.forces), 6)),
        power=np.zeros(
            len(mechanism.bushings) + len(mechanism.springs) + len(mechanism.joints) + len(mechanism.stops)
        ),
    )
