"""From descriptions to arrays, and every check on them: `assemble`.

All faults of a mechanism are found and reported together.  What cannot be checked part by part (whether the
constraints depend on each other, and whether they contradict) is checked on the assembled Jacobian in
`constraints.py`.
"""

import numpy as np

from nutamill.base.errors import CaseError, Fault
from nutamill.mechanism.constraints import check_constraints
from nutamill.mechanism.model import (
    BODY,
    BUSHING,
    DRIVE,
    KNOT,
    NAME_WIDTH,
    SPRING,
    TORQUE,
    Mechanism,
    MechanismScratch,
    MechanismState,
)
from nutamill.mechanism.parts import GROUND, Body, Bushing, Drive, Joint, JointKind, Motor, Spring, Torque
from nutamill.mechanism.rows import Placement, constraint_tables, frame_along, records, unit

TURNING = (JointKind.REVOLUTE, JointKind.CYLINDRICAL)
"""Joint kinds a drive can turn."""

RUBBING = (*TURNING, JointKind.SPHERICAL, JointKind.UNIVERSAL, JointKind.POINT_ON_LINE)
"""Joint kinds that can have friction."""


def assemble(
    bodies: list[Body],
    joints: list[Joint],
    bushings: list[Bushing] = (),
    springs: list[Spring] = (),
    torques: list[Torque] = (),
    drives: list[Drive] = (),
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81),
    redundant: str = "refuse",
) -> tuple[Mechanism, MechanismState, MechanismScratch]:
    """Check a mechanism and turn it into arrays; parts are numbered in the order given.

    Parameters
    ----------
    bodies, joints, bushings, springs, torques, drives : the parts, world coordinates as assembled, SI
    gravity : acceleration [m/s^2], (3,), world axes
    redundant : "refuse" constraints that say the same twice, or "allow" them: they are solved, and the joints
        whose reactions they leave undetermined are marked in ``mechanism.joints.reaction_unique``

    Returns
    -------
    mechanism, state, scratch : constants, state as assembled (call `nutamill.mechanism.dynamics.start` next),
        work space

    Raises
    ------
    CaseError
        with every fault: unknown or repeated names, masses and inertias no body can have, missing axes, gaps
        in loops, redundant constraints (unless allowed) and contradictory ones
    """
    if redundant not in ("refuse", "allow"):
        raise CaseError(Fault("redundant", f'must be "refuse" or "allow", got {redundant!r}'))
    faults = (
        *name_faults(bodies, joints, bushings, springs, torques, drives),
        *body_faults(bodies),
        *joint_faults(joints),
        *load_faults(bushings, springs, torques),
        *drive_faults(joints, drives),
    )
    if faults:
        raise CaseError(*faults)
    place = Placement(bodies)
    joint_table, row_table, pair_table, labels, faults = constraint_tables(place, joints, drives)
    if faults:
        raise CaseError(*faults)
    drive_table, knot_table = drive_tables(place, joints, drives, len(row_table))
    mechanism = Mechanism(
        gravity=np.array(gravity, float),
        bodies=body_table(bodies),
        rows=row_table,
        pairs=pair_table,
        joints=joint_table,
        bushings=records(BUSHING, [bushing_record(place, bushing) for bushing in bushings]),
        springs=records(SPRING, [spring_record(place, spring) for spring in springs]),
        torques=records(TORQUE, [(place.index[torque.body], torque.moment) for torque in torques]),
        drives=drive_table,
        knots=knot_table,
        names=name_array(
            [part.name for part in bodies],
            [GROUND],
            *([part.name for part in parts] for parts in (joints, bushings, springs, drives)),
        ),
    )
    state, scratch = new_state(mechanism, place, bodies), new_scratch(mechanism)
    faults = check_constraints(mechanism, state, scratch, labels, redundant)
    if faults:
        raise CaseError(*faults)
    return mechanism, state, scratch


# ---- checks


def name_faults(bodies, joints, bushings, springs, torques, drives):
    """Names that are missing, repeated, too long, or refer to nothing."""
    for kind, parts in (
        ("body", bodies),
        ("joint", joints),
        ("bushing", bushings),
        ("spring", springs),
        ("torque", torques),
        ("drive", drives),
    ):
        seen = {GROUND} if kind == "body" else set()
        for part in parts:
            if not part.name or len(part.name) > NAME_WIDTH:
                yield Fault(
                    f"{kind} {part.name!r}",
                    f"a name must have 1 to {NAME_WIDTH} characters, got {len(part.name)}",
                )
            if part.name in seen:
                yield Fault(
                    f"{kind} {part.name!r}", "names must be unique, got this one twice", "Rename one of them"
                )
            seen.add(part.name)
    known = {GROUND, *(body.name for body in bodies)}
    for kind, parts in (("joint", joints), ("bushing", bushings), ("spring", springs)):
        for part in parts:
            for side in (part.body_a, part.body_b):
                if side not in known:
                    yield Fault(
                        f"{kind} {part.name!r}",
                        f"must join known bodies, got {side!r}",
                        f"Known are {', '.join(sorted(known))}",
                    )
            if part.body_a == part.body_b:
                yield Fault(
                    f"{kind} {part.name!r}", f"must join two different bodies, got {part.body_a!r} twice"
                )
    for torque in torques:
        if torque.body not in known - {GROUND}:
            yield Fault(f"torque {torque.name!r}", f"must act on a known body, got {torque.body!r}")
    for drive in drives:
        if drive.joint not in {joint.name for joint in joints}:
            yield Fault(f"drive {drive.name!r}", f"must turn a known joint, got {drive.joint!r}")


def body_faults(bodies):
    """Masses, inertias and attitudes no rigid body can have."""
    for body in bodies:
        where = f"body {body.name!r}"
        if not body.mass > 0.0:
            yield Fault(where, f"mass must be positive, got {body.mass:g} kg")
        inertia = np.asarray(body.inertia, float)
        if inertia.shape != (3, 3) or not np.all(np.isfinite(inertia)):
            yield Fault(where, f"inertia must be 3 x 3 finite numbers, got shape {inertia.shape}")
            continue
        if not np.allclose(inertia, inertia.T, rtol=0.0, atol=1e-12 * np.abs(inertia).max()):
            yield Fault(where, "inertia must be symmetric")
            continue
        small, middle, large = np.linalg.eigvalsh(inertia)
        text = f"principal values {small:g}, {middle:g}, {large:g} kg m^2"
        if not small > 0.0:
            yield Fault(where, f"inertia must be positive definite, got {text}")
        elif large > (small + middle) * (1.0 + 1e-9):
            yield Fault(
                where,
                f"the largest principal inertia must not exceed the sum of the others, got {text}",
                "No mass distribution has this inertia",
            )
        length = np.linalg.norm(body.quaternion)
        if abs(length - 1.0) > 1e-6:
            yield Fault(where, f"quaternion must have length 1, got {length:g}")


def joint_faults(joints):
    """Axes that are missing, zero or not square; friction that makes no sense."""
    for joint in joints:
        where = f"joint {joint.name!r}"
        needs_axis = joint.kind not in (JointKind.FIXED, JointKind.SPHERICAL)
        if needs_axis and (joint.axis is None or not np.linalg.norm(joint.axis) > 0.0):
            yield Fault(
                where, f"a {joint.kind.name} joint needs an axis of non-zero length, got {joint.axis}"
            )
            continue
        if joint.kind == JointKind.UNIVERSAL:
            if joint.second_axis is None or not np.linalg.norm(joint.second_axis) > 0.0:
                yield Fault(
                    where, "a UNIVERSAL joint needs a second axis of non-zero length, fixed in body b"
                )
                continue
            cosine = unit(joint.axis) @ unit(joint.second_axis)
            if abs(cosine) > 1e-9:
                yield Fault(
                    where,
                    f"the two axes must be square to each other, got {np.degrees(np.arccos(cosine)):.6g} deg",
                )
        if joint.friction is not None:
            law = joint.friction
            if joint.kind not in RUBBING:
                yield Fault(where, f"a {joint.kind.name} joint does not turn, so it must have no friction")
            if min(law.coefficient, law.radius, law.constant, law.viscous) < 0.0:
                yield Fault(where, f"friction values must not be negative, got {law}")


def load_faults(bushings, springs, torques):
    """Rates that are negative, axes of zero length, springs without direction, moments that are not three
    numbers.
    """
    for bushing in bushings:
        where = f"bushing {bushing.name!r}"
        if len(bushing.stiffness) != 4 or len(bushing.damping) != 4:
            yield Fault(where, "stiffness and damping must be four numbers: shear, axial, bending, torsion")
        elif min(*bushing.stiffness, *bushing.damping) < 0.0:
            yield Fault(
                where,
                f"stiffness and damping must not be negative, got {bushing.stiffness} and {bushing.damping}",
            )
        if not np.linalg.norm(bushing.axis) > 0.0:
            yield Fault(where, f"axis must have a length, got {bushing.axis}")
    for spring in springs:
        where = f"spring {spring.name!r}"
        if min(spring.stiffness, spring.damping, spring.free_length) < 0.0:
            yield Fault(where, "stiffness, damping and free length must not be negative")
        if not np.linalg.norm(np.subtract(spring.point_b, spring.point_a)) > 0.0:
            yield Fault(
                where,
                "the two ends must be apart: the force needs a direction",
                "Use a bushing for a spring of no length",
            )
    for torque in torques:
        if np.shape(torque.moment) != (3,):
            yield Fault(f"torque {torque.name!r}", f"moment must be three numbers, got {torque.moment}")


def drive_faults(joints, drives):
    """Drives of joints that do not turn, and tables of speed that are no function of time."""
    kinds = {joint.name: joint.kind for joint in joints}
    for drive in drives:
        where = f"drive {drive.name!r}"
        kind = kinds.get(drive.joint, JointKind.REVOLUTE)
        if kind not in TURNING:
            yield Fault(
                where, f"must turn a REVOLUTE or CYLINDRICAL joint, got {drive.joint!r}, which is {kind.name}"
            )
        times, speeds = np.asarray(drive.times, float), np.asarray(drive.speeds, float)
        if times.ndim != 1 or times.shape != speeds.shape or times.size == 0:
            yield Fault(
                where,
                f"times and speeds must be two lists of one length, got shapes {times.shape} and "
                f"{speeds.shape}",
            )
        elif times[0] != 0.0 or np.any(np.diff(times) <= 0.0):
            yield Fault(where, "times must begin at 0 and increase")
        if (
            drive.motor is not None
            and min(
                drive.motor.gain, drive.motor.integral_gain, drive.motor.torque_limit, drive.motor.power_limit
            )
            < 0
        ):
            yield Fault(where, f"gains and limits of a motor must not be negative, got {drive.motor}")


# ---- tables


def name_array(*groups) -> np.ndarray:
    """Names as fixed-width text, in one line."""
    return np.array([name for group in groups for name in group], dtype=f"<U{NAME_WIDTH}")


def body_table(bodies) -> np.recarray:
    """Masses and inertias, ground last."""
    ground = 0.0, 0.0, np.zeros((3, 3)), np.zeros((3, 3))
    return records(
        BODY,
        [
            *((body.mass, 1.0 / body.mass, body.inertia, np.linalg.inv(body.inertia)) for body in bodies),
            ground,
        ],
    )


def bushing_record(place, bushing) -> tuple:
    """A bushing with its axes fixed in both bodies."""
    a, b, frame = bushing.body_a, bushing.body_b, frame_along(bushing.axis)
    return (
        place.index[a],
        place.index[b],
        place.local_point(a, bushing.point),
        place.local_point(b, bushing.point),
        place.attitude_in(a, frame),
        place.attitude_in(b, frame),
        six_rates(*bushing.stiffness),
        six_rates(*bushing.damping),
    )


def six_rates(shear, axial, bending, torsion) -> tuple:
    """Rates along and about the three bushing axes."""
    return shear, shear, axial, bending, bending, torsion


def spring_record(place, spring) -> tuple:
    """A spring with its ends in body axes."""
    a, b = spring.body_a, spring.body_b
    ends = place.local_point(a, spring.point_a), place.local_point(b, spring.point_b)
    return place.index[a], place.index[b], *ends, spring.stiffness, spring.damping, spring.free_length


def drive_tables(place, joints, drives, n_rows) -> tuple[np.recarray, np.recarray]:
    """Drives, those without a motor holding the last rows in turn, and the knots of all drives in a line."""
    by_name = {joint.name: joint for joint in joints}
    table, knots = [], []
    row = n_rows - sum(drive.motor is None for drive in drives)
    for drive in drives:
        t, w = np.asarray(drive.times, float), np.asarray(drive.speeds, float)
        angle = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(t) * (w[1:] + w[:-1]))])
        joint = by_name[drive.joint]
        a, b = joint.body_a, joint.body_b
        x, _, z = frame_along(joint.axis).T
        axes = place.local_axis(a, z), place.local_axis(a, x), place.local_axis(b, x)
        motor = drive.motor or Motor(0.0, 0.0)
        numbers = (
            motor.gain,
            motor.integral_gain,
            motor.torque_limit,
            motor.power_limit,
            motor.cut,
            motor.restored,
        )
        held = row if drive.motor is None else -1
        table.append((held, len(knots), len(knots) + len(t), place.index[a], place.index[b], *axes, *numbers))
        knots.extend(zip(t, w, angle, strict=True))
        row += drive.motor is None
    return records(DRIVE, table), records(KNOT, knots)


def new_state(mechanism, place, bodies) -> MechanismState:
    """The state as assembled, ledgers at zero."""
    n, n_rows, n_joints = len(bodies) + 1, len(mechanism.rows), len(mechanism.joints)
    n_bushings, n_springs, n_drives = len(mechanism.bushings), len(mechanism.springs), len(mechanism.drives)
    velocity, angular_velocity = np.zeros((n, 3)), np.zeros((n, 3))
    for i, body in enumerate(bodies):
        velocity[i], angular_velocity[i] = body.velocity, body.angular_velocity
    return MechanismState(
        time=np.zeros(1),
        position=place.position.copy(),
        quaternion=place.quaternion.copy(),
        velocity=velocity,
        angular_velocity=angular_velocity,
        acceleration=np.zeros((n, 6)),
        load=np.zeros((n, 6)),
        multiplier=np.zeros(n_rows),
        friction_moment=np.zeros((n_joints, 3)),
        drive_motion=np.zeros((n_drives, 3)),
        drive_torque=np.zeros(n_drives),
        motor_integral=np.zeros(n_drives),
        wrench=np.zeros((n, 6)),
        previous_wrench=np.zeros((n, 6)),
        power=np.zeros(n_bushings + n_springs + n_joints),
        drive_work=np.zeros(n_drives),
        wrench_work=np.zeros(n),
        torque_work=np.zeros(len(mechanism.torques)),
        bushing_loss=np.zeros(n_bushings),
        spring_loss=np.zeros(n_springs),
        joint_loss=np.zeros(n_joints),
    )


def new_scratch(mechanism: Mechanism) -> MechanismScratch:
    """Fresh work space for a mechanism."""
    n, n_rows = len(mechanism.bodies), len(mechanism.rows)
    square = {name: np.zeros((n, 3, 3)) for name in ("rotation", "inertia", "inverse_inertia")}
    six = {name: np.zeros((n, 6)) for name in ("twist", "start_twist", "momentum", "load", "correction")}
    twelve = {name: np.zeros((n_rows, 12)) for name in ("jacobian", "inverse_mass_jacobian", "row_vectors")}
    matrix = {name: np.zeros((n_rows, n_rows)) for name in ("schur", "lower", "upper")}
    row = {
        name: np.zeros(n_rows)
        for name in ("gap", "gap_rate", "curvature", "inverse_pivot", "solution", "multiplier")
    }
    return MechanismScratch(
        **square,
        **six,
        **twelve,
        **matrix,
        **row,
        drive_motion=np.zeros((len(mechanism.drives), 3)),
        motor_torque=np.zeros(len(mechanism.drives)),
        power=np.zeros(len(mechanism.bushings) + len(mechanism.springs) + len(mechanism.joints)),
    )
