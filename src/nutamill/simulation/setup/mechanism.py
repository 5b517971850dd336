"""The parts of a machine as parts of the mechanism engine, and its sensors."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from nutamill.base.errors import StepError
from nutamill.base.required import required
from nutamill.case.drive import DriveProgramme
from nutamill.case.loads import ForceEntry, LinearDriveEntry, StopEntry, UnbalanceMotorEntry
from nutamill.case.machine import BodyEntry, BushingEntry, JointEntry, Machine
from nutamill.case.machine_checks import GROUND
from nutamill.case.placement import quaternion_of
from nutamill.mechanism.assembly import assemble
from nutamill.mechanism.model import Mechanism, MechanismScratch, MechanismState
from nutamill.mechanism.parts import (
    Body,
    Bushing,
    Drive,
    Force,
    Gear,
    Joint,
    JointFriction,
    JointKind,
    Motor,
    Spring,
    Stop,
    Torque,
)
from nutamill.mechanism.sensors import COLUMNS, Sensor, SensorKind
from nutamill.mechanism.unbalance import UnbalanceMotor

KINDS = {
    "position": SensorKind.POINT_POSITION,
    "velocity": SensorKind.POINT_VELOCITY,
    "acceleration": SensorKind.POINT_ACCELERATION,
    "attitude": SensorKind.BODY_ATTITUDE,
    "reaction": SensorKind.JOINT_REACTION,
    "spring": SensorKind.SPRING,
}
"""Kinds of sensors by their names in case files."""


OUTSIDE_MOTOR = Motor(0.0, 0.0)
"""Motor whose torque comes from outside: without gains its torque is its integral part, which an exchange
with an FMU writes at every window.
"""


class MechanismParts(NamedTuple):
    """The parts of a mechanism, by the names of the arguments of `nutamill.mechanism.assembly.assemble`."""

    bodies: list[Body]
    """The bodies."""
    joints: list[Joint]
    """The joints."""
    bushings: list[Bushing]
    """The bushings."""
    springs: list[Spring]
    """The springs."""
    torques: list[Torque]
    """Constant moments."""
    drives: list[Drive]
    """The drives."""
    forces: list[Force]
    """Constant and tabulated forces."""
    gears: list[Gear]
    """Ratios between the rotations of two joints."""
    stops: list[Stop]
    """One-sided stops."""


def mechanism_parts(machine: Machine) -> MechanismParts:
    """Return the parts of a machine as parts of the engine, those of unbalance motors after the others."""
    motors = [_unbalance_motor(entry).parts() for entry in machine.unbalance_motors]
    given = {entry.drive for fmu in machine.fmus for entry in fmu.drives if entry.torque}
    return MechanismParts(
        [_body(entry) for entry in machine.bodies] + [rotor for rotor, _, _ in motors],
        [_joint(entry) for entry in machine.joints] + [bearing for _, bearing, _ in motors],
        [_bushing(entry) for entry in machine.bushings],
        [
            Spring(
                entry.name,
                *entry.between,
                entry.point_a,
                entry.point_b,
                entry.stiffness,
                entry.damping,
                entry.free_length,
                entry.preload,
            )
            for entry in machine.springs
        ],
        [Torque(entry.name, entry.body, entry.moment) for entry in machine.torques],
        [
            Drive(
                entry.name,
                entry.joint,
                *entry.breakpoints(),
                OUTSIDE_MOTOR if entry.name in given else _motor(entry),
            )
            for entry in machine.drives
        ]
        + [
            replace(drive, motor=OUTSIDE_MOTOR) if drive.name in given else drive
            for drive in map(_linear_drive, machine.linear_drives)
        ]
        + [drive for _, _, drive in motors],
        [_force(entry) for entry in machine.forces],
        [Gear(entry.name, entry.input, entry.output, entry.ratio) for entry in machine.gears],
        [_stop(entry) for entry in machine.stops],
    )


def assemble_machine(
    machine: Machine, drives: Sequence[Drive] | None = None
) -> tuple[Mechanism, MechanismState, MechanismScratch]:
    """Assemble the mechanism of a machine, with other `drives` if given: constants, state as assembled, work
    space. Raises CaseError with every fault.
    """
    parts = mechanism_parts(machine)
    if drives is not None:
        parts = parts._replace(drives=list(drives))
    return assemble(**parts._asdict(), gravity=machine.gravity, redundant=machine.redundant)


def refuse_unsupported(machine: Machine) -> None:
    """Raise StepError for bodies that no joint, bushing, spring or stop connects to the ground, directly or
    through others, where gravity or a load moves them: there is no equilibrium to look for.
    """
    if not any(machine.gravity) and not machine.forces and not machine.torques:
        return
    pairs = [joint.between for joint in machine.joints]
    pairs += [bushing.between for bushing in machine.bushings]
    pairs += [spring.between for spring in machine.springs]
    pairs += [stop.between for stop in machine.stops]
    held, before = {GROUND}, 0
    while len(held) > before:
        before = len(held)
        held.update(body for pair in pairs if held.intersection(pair) for body in pair)
    if loose := [body.name for body in machine.bodies if body.name not in held]:
        raise StepError(
            f"static equilibrium: nothing holds {', '.join(loose)}. Connect it to the ground by a joint, a "
            "bushing, a spring or a stop."
        )


def machine_sensors(machine: Machine) -> list[tuple[Sensor, list[str]]]:
    """Return the sensors of every run of a machine, each with the names of its series: all joints, all
    bushings, all drives, then the sensors of the file.
    """
    sensors: list[tuple[Sensor, list[str]]] = []

    def add(sensor: Sensor, prefix: str, parts: Sequence[str] | None = None) -> None:
        sensors.append((sensor, [f"{prefix}_{part}" for part in parts or COLUMNS[sensor.kind]]))

    motors = [motor.name for motor in machine.unbalance_motors]
    for joint in [*(entry.name for entry in machine.joints), *motors]:
        name = f"joint_{joint}"
        add(Sensor(name, SensorKind.JOINT_REACTION, joint), name)
    for bushing in machine.bushings:
        name = f"bushing_{bushing.name}"
        travel = (*(f"travel_{axis}" for axis in "xyz"), *(f"turn_{axis}" for axis in "xyz"))
        add(Sensor(name, SensorKind.BUSHING_WRENCH, bushing.name), name)
        add(Sensor(f"{name}_travel", SensorKind.BUSHING_TRAVEL, bushing.name), name, travel)
    for drive in [*(entry.name for entry in machine.drives), *motors]:
        name = f"drive_{drive}"
        add(Sensor(name, SensorKind.DRIVE, drive), name)
    for slide in machine.linear_drives:
        name = f"linear_drive_{slide.name}"
        add(Sensor(name, SensorKind.LINEAR_DRIVE, slide.name), name)
    for gear in machine.gears:
        add(Sensor(f"gear_{gear.name}", SensorKind.GEAR, gear.name), f"gear_{gear.name}")
    for stop in machine.stops:
        add(Sensor(f"stop_{stop.name}", SensorKind.STOP, stop.name), f"stop_{stop.name}")
    for entry in machine.sensors:
        if entry.kind == "charge":  # read from the charge, not from the mechanism
            continue
        name, kind = f"{entry.name}_{entry.kind}", KINDS[entry.kind]
        # a column of a vector or a quaternion ends in the name of the component: x, vx, ax, qw
        whole = kind in (SensorKind.JOINT_REACTION, SensorKind.SPRING)
        parts = None if whole else tuple(part[-1] for part in COLUMNS[kind])
        add(Sensor(name, kind, entry.of, point=entry.at, axes_body=entry.axes), name, parts)
    return sensors


def _motor(entry: DriveProgramme) -> Motor | None:
    """Return the motor, or None for a prescribed rotation."""
    if (motor := entry.motor) is None:
        return None
    absent = [
        math.inf if value is None else value
        for value in (motor.torque, motor.power, motor.cut, motor.restored)
    ]
    return Motor(motor.gain, motor.gain / motor.integral_time, *absent)


def _body(entry: BodyEntry) -> Body:
    inertia = np.diag(entry.inertia[:3])
    for (i, j), product in zip(((0, 1), (0, 2), (1, 2)), entry.inertia[3:], strict=False):
        inertia[i, j] = inertia[j, i] = product
    return Body(
        entry.name,
        entry.mass,
        inertia,
        entry.position,
        tuple(quaternion_of(entry.turn)),
        entry.velocity,
        entry.angular_velocity,
    )


def _joint(entry: JointEntry) -> Joint:
    law = entry.friction
    friction = None if law is None else JointFriction(*law.numbers)
    kind = JointKind[entry.kind.upper()]
    return Joint(
        entry.name, kind, *entry.between, entry.point, entry.axis, entry.second_axis, friction, entry.point_b
    )


def _bushing(entry: BushingEntry) -> Bushing:
    return Bushing(entry.name, *entry.between, entry.point, entry.axis, entry.stiffness, entry.damping)


def _force(entry: ForceEntry) -> Force:
    if entry.table is None:
        return Force(entry.name, entry.body, required(entry.force), point=entry.at)
    times, forces = zip(*entry.table, strict=True)
    return Force(entry.name, entry.body, forces, times, entry.at)


def _stop(entry: StopEntry) -> Stop:
    return Stop(
        entry.name,
        *entry.between,
        entry.point_a,
        entry.point_b,
        entry.stiffness,
        entry.restitution,
        entry.normal,
        entry.radius_a,
        entry.radius_b or 0.0,
    )


def _linear_drive(entry: LinearDriveEntry) -> Drive:
    motor, given = None, entry.motor
    if given is not None:
        limits = (
            math.inf if value is None else value
            for value in (given.force, given.power, given.cut, given.restored)
        )
        motor = Motor(given.gain, given.gain / given.integral_time, *limits)
    times, speeds = zip(*entry.speeds, strict=True)
    return Drive(entry.name, entry.joint, times, speeds, motor)


def _unbalance_motor(entry: UnbalanceMotorEntry) -> UnbalanceMotor:
    return UnbalanceMotor(
        entry.name,
        entry.body,
        entry.point,
        entry.axis,
        entry.towards,
        entry.mass,
        entry.eccentricity,
        *entry.breakpoints(),
        entry.inertia,
        _motor(entry),
    )
