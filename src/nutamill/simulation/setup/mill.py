"""A nutating mill as bodies, joints, bushings and a drive (MCA 2026, Table 4; rigid mounts: SAIMM 2025)."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from nutamill.base.errors import CaseError, Fault
from nutamill.case import Case
from nutamill.case.drawing import CARRIAGE, CHAMBER, CROSS, DRIVESHAFT, FRAME, SHAFT, Mounts, ShaftCoupling
from nutamill.mechanism.assembly import assemble
from nutamill.mechanism.model import Mechanism, MechanismScratch, MechanismState
from nutamill.mechanism.parts import GROUND, Body, Bushing, Drive, Joint, JointFriction, JointKind, Motor
from nutamill.mechanism.sensors import Sensor, SensorKind
from nutamill.result.fields import JOINTS, TURNING
from nutamill.simulation.setup.rigid_parts import (
    RigidPart,
    chamber_shell,
    compose,
    remove,
    rotated,
    whole_chamber,
)

Y_AXIS, Z_AXIS = (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)

FRAME_FIX, SHAFT_BEARING, DRIVESHAFT_BEARING = "frame_fix", "intermediate_shaft_bearing", "driveshaft_bearing"
LOAD_CELL, PIN_JOINT = "crank_pin_load_cell", "pin_joint"
CHAMBER_PIVOT, YOKE_PIVOT = "chamber_pivot", "yoke_pivot"
COUPLING, DRIVE, NUTATION_POINT = "shaft_coupling", "motor", "nutation_point"


class MillMechanism(NamedTuple):
    """The parts of a mill for `nutamill.mechanism.assembly.assemble`."""

    bodies: tuple[Body, ...]
    """The frame, then the moving parts."""
    joints: tuple[Joint, ...]
    """Rows 2 and 4 to 8 of MCA Table 4; with rigid mounts also the frame on the ground."""
    bushings: tuple[Bushing, ...]
    """Shaft coupling and, with flexible mounts, the mounts: rows 3 and 1."""
    drives: tuple[Drive, ...]
    """The motor."""
    gravity: tuple[float, float, float]
    """Acceleration of gravity [m/s^2], world axes."""


def chamber_rotation(case: Case) -> np.ndarray:
    """Return ``R_WC`` (3, 3) as assembled, at crank angle 0, with the lower end of the chamber towards +x."""
    angle = -case.mechanism.nutation_angle
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def chamber_quaternion(case: Case) -> tuple[float, float, float, float]:
    """Return ``q_WC`` (w, x, y, z) as assembled."""
    half = -case.mechanism.nutation_angle / 2
    return (math.cos(half), 0.0, math.sin(half), 0.0)


def bare_driveshaft(case: Case) -> RigidPart:
    """Return driveshaft and torque arm without carriage and balance, world axes from the nutation point."""
    shaft = case.driveshaft
    inertia = np.diag([shaft.inertia_transverse, shaft.inertia_transverse, shaft.inertia_axial])
    return RigidPart(shaft.mass, np.array([0.0, 0.0, -shaft.mass_centre_depth]), inertia)


def moving_parts(case: Case) -> dict[str, RigidPart]:
    """Return every part but the frame, in world axes from the nutation point, at crank angle 0."""
    mechanism, rotation = case.mechanism, chamber_rotation(case)
    crank_pin = np.array([mechanism.crank_radius, 0.0, -mechanism.nutation_point_to_crank])
    driveshaft = bare_driveshaft(case)
    for weight in case.balance.weights:
        position = np.array(
            [
                weight.radius * math.cos(weight.azimuth),
                weight.radius * math.sin(weight.azimuth),
                -weight.depth,
            ]
        )
        driveshaft = compose(driveshaft, RigidPart(weight.mass, position, np.zeros((3, 3))))
    intermediate = case.intermediate_shaft
    return {
        CHAMBER: rotated(whole_chamber(case.chamber), rotation),
        CROSS: RigidPart(case.bearing_cross.mass, np.zeros(3), case.bearing_cross.inertia * np.eye(3)),
        CARRIAGE: RigidPart(case.carriage.mass, crank_pin, case.carriage.inertia * np.eye(3)),
        DRIVESHAFT: driveshaft,
        SHAFT: RigidPart(
            intermediate.mass,
            np.array([0.0, 0.0, -case.shaft_coupling.depth]),
            np.diag(
                [intermediate.inertia_transverse, intermediate.inertia_transverse, intermediate.inertia_axial]
            ),
        ),
    }


def frame_part(case: Case) -> RigidPart:
    """Return the frame: the unribbed, empty machine on its mounts without its moving parts.

    The file gives mass, height of the mass centre and radii of gyration of the whole machine on the mounts.
    The moving parts are subtracted as averages over a revolution, so that the frame is symmetric about the
    driveshaft axis.
    """
    parts = {
        **moving_parts(case),
        CHAMBER: rotated(chamber_shell(case.chamber), chamber_rotation(case)),
        DRIVESHAFT: bare_driveshaft(case),
    }
    del parts[SHAFT]  # supported by the ground, not by the mounts
    frame, mass = case.frame, case.mechanism.total_mass
    mass_centre = np.array([0.0, 0.0, -case.mounts.depth + frame.mass_centre_height])
    whole = RigidPart(
        mass, mass_centre, mass * np.diag([frame.gyration_rocking**2] * 2 + [frame.gyration_yaw**2])
    )
    rest = mass - sum(part.mass for part in parts.values())
    if rest <= 0:
        raise CaseError(
            Fault(
                "mechanism.total_mass",
                f"leaves no mass for the frame, got {rest:.3g} kg",
                "Give the mass of the whole machine",
            )
        )
    about_axis = remove(whole, *(_averaged_over_a_revolution(part) for part in parts.values()))
    lowest = np.linalg.eigvalsh(about_axis.inertia)
    if lowest[0] <= 0 or lowest[2] > lowest[0] + lowest[1]:
        raise CaseError(
            Fault(
                "frame",
                "the radii of gyration of the whole machine leave the frame moments of inertia of "
                f"{lowest.round(3).tolist()} kg m^2,"
                " which no body has",
                "Give larger frame.gyration_rocking or frame.gyration_yaw",
            )
        )
    return about_axis


def _averaged_over_a_revolution(part: RigidPart) -> RigidPart:
    """Return the average of a part over a revolution about the z axis: mass centre on the axis, same axial
    and mean transverse inertia about it.
    """
    x, y, z = part.mass_centre
    inertia = part.inertia + part.mass * np.diag([(x * x + y * y) / 2, (x * x + y * y) / 2, x * x + y * y])
    transverse = (inertia[0, 0] + inertia[1, 1]) / 2
    return RigidPart(part.mass, np.array([0.0, 0.0, z]), np.diag([transverse, transverse, inertia[2, 2]]))


def mill_mechanism(case: Case) -> MillMechanism:
    """Return bodies, joints, bushings and drive of the mill of a case.

    The numbers in the comments are the rows of MCA 2026, Table 4.
    """
    mechanism = case.mechanism
    parts = {FRAME: frame_part(case), **moving_parts(case)}
    bodies = tuple(_body(name, part, case) for name, part in parts.items())
    crank_pin = tuple(parts[CARRIAGE].mass_centre)
    nutation_point = (0.0, 0.0, 0.0)
    bearing = tuple(parts[DRIVESHAFT].mass_centre * (0.0, 0.0, 1.0))
    coupling = (0.0, 0.0, -case.shaft_coupling.depth)
    chamber_x = tuple(chamber_rotation(case)[:, 0])
    friction = JointFriction(
        mechanism.joint_friction,
        mechanism.joint_friction_radius,
        mechanism.joint_friction_constant,
        mechanism.joint_friction_viscous,
    )
    joints = [
        Joint(SHAFT_BEARING, JointKind.REVOLUTE, GROUND, SHAFT, coupling, Z_AXIS),  # 2
        Joint(
            DRIVESHAFT_BEARING, JointKind.REVOLUTE, FRAME, DRIVESHAFT, bearing, Z_AXIS, friction=friction
        ),  # 4
        Joint(LOAD_CELL, JointKind.FIXED, DRIVESHAFT, CARRIAGE, crank_pin),  # 5
        Joint(
            PIN_JOINT, JointKind.POINT_ON_LINE, CARRIAGE, CHAMBER, crank_pin, Z_AXIS, friction=friction
        ),  # 6
        Joint(CHAMBER_PIVOT, JointKind.REVOLUTE, CROSS, CHAMBER, nutation_point, chamber_x),  # 7
        Joint(YOKE_PIVOT, JointKind.REVOLUTE, FRAME, CROSS, nutation_point, Y_AXIS),  # 8
    ]
    bushings = [Bushing(COUPLING, SHAFT, DRIVESHAFT, coupling, Z_AXIS, *_rates(case.shaft_coupling))]  # 3
    if mechanism.mounting == "rigid":
        joints.insert(0, Joint(FRAME_FIX, JointKind.FIXED, GROUND, FRAME, (0.0, 0.0, -case.mounts.depth)))
    else:
        for number, (x, y) in enumerate(case.mounts.points, start=1):  # 1
            point = (x, y, -case.mounts.depth)
            bushings.append(Bushing(f"mount_{number}", GROUND, FRAME, point, Z_AXIS, *_rates(case.mounts)))
    drive = Drive(DRIVE, DRIVESHAFT_BEARING, *case.drive.breakpoints(), _motor(case))
    return MillMechanism(bodies, tuple(joints), tuple(bushings), (drive,), (0.0, 0.0, -mechanism.gravity))


def assemble_mill(
    mill: MillMechanism, drives: Sequence[Drive] | None = None
) -> tuple[Mechanism, MechanismState, MechanismScratch]:
    """Assemble the parts of a mill, with other `drives` if given (`nutamill.mechanism.assembly.assemble`)."""
    return assemble(
        mill.bodies,
        mill.joints,
        mill.bushings,
        drives=mill.drives if drives is None else drives,
        gravity=mill.gravity,
    )


def _motor(case: Case) -> Motor | None:
    """Return the motor, or None for a prescribed rotation."""
    if (motor := case.drive.motor) is None:
        return None
    absent = [
        math.inf if value is None else value
        for value in (motor.torque, motor.power, motor.cut, motor.restored)
    ]
    return Motor(motor.gain, motor.gain / motor.integral_time, *absent)


def _rates(part: Mounts | ShaftCoupling) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return stiffness and damping in the order shear, axial, bending, torsion."""
    return (
        (part.shear_stiffness, part.axial_stiffness, part.bending_stiffness, part.torsion_stiffness),
        (part.shear_damping, part.axial_damping, part.bending_damping, part.torsion_damping),
    )


def _body(name: str, part: RigidPart, case: Case) -> Body:
    """Return a part as a body: chamber and cross have the axes of the chamber, the others world axes."""
    if name not in (CHAMBER, CROSS):
        return Body(name, part.mass, part.inertia, tuple(part.mass_centre))
    rotation = chamber_rotation(case)
    return Body(
        name,
        part.mass,
        rotation.T @ part.inertia @ rotation,
        tuple(part.mass_centre),
        chamber_quaternion(case),
    )


def mill_sensors(case: Case) -> list[Sensor]:
    """Return the sensors of every run of a mill; `nutamill.simulation.setup.readout` makes the series of
    them.

    Forces at the crank are in driveshaft axes (x from the axis to the pin), forces at the nutation point in
    world axes.
    """
    sensors = [
        Sensor(DRIVE, SensorKind.DRIVE, DRIVE),
        Sensor(LOAD_CELL, SensorKind.JOINT_REACTION, LOAD_CELL, axes_body=DRIVESHAFT),
        Sensor(PIN_JOINT, SensorKind.JOINT_REACTION, PIN_JOINT, axes_body=DRIVESHAFT),
        Sensor(CHAMBER_PIVOT, SensorKind.JOINT_REACTION, CHAMBER_PIVOT),
        Sensor(COUPLING, SensorKind.BUSHING_WRENCH, COUPLING),
        Sensor(NUTATION_POINT, SensorKind.POINT_POSITION, CROSS, point=(0.0, 0.0, 0.0)),
    ]
    joints = [joint for joint in JOINTS if joint != FRAME_FIX or case.mechanism.mounting == "rigid"]
    sensors += [Sensor(f"{joint}_reaction", SensorKind.JOINT_REACTION, joint) for joint in joints]
    sensors += [Sensor(f"{body}_attitude", SensorKind.BODY_ATTITUDE, body) for body in TURNING]
    if case.mechanism.mounting == "flexible":
        for number in range(1, case.mounts.count + 1):
            sensors.append(Sensor(f"mount_{number}", SensorKind.BUSHING_WRENCH, f"mount_{number}"))
            sensors.append(Sensor(f"mount_{number}_travel", SensorKind.BUSHING_TRAVEL, f"mount_{number}"))
    tilted = chamber_rotation(case)
    points = {
        name: tilted @ sensor.at if sensor.body in (CHAMBER, CROSS) else sensor.at
        for name, sensor in case.sensors.items()
    }
    return sensors + [
        Sensor(
            name, SensorKind.POINT_ACCELERATION, sensor.body, point=tuple(points[name]), axes_body=sensor.body
        )
        for name, sensor in case.sensors.items()
    ]
