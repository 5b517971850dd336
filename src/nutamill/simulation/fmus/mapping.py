"""From the names of `[[fmus]]` to places: what each FMU gets and gives, checked as a whole before a run."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from nutamill.base.errors import CaseError, Fault, NotInstalledError
from nutamill.base.frames import rotation_matrix_of
from nutamill.base.units import Kind
from nutamill.case.fmus import FmuBody, FmuEntry
from nutamill.case.machine import Machine
from nutamill.case.placement import quaternion_of
from nutamill.simulation.fmus.archive import check_digest
from nutamill.simulation.fmus.description import FmuDescription, read_description
from nutamill.simulation.fmus.signals import Names, Signal, Start

ABSENT = -1
"""Place of a variable that the FMU does not have: the last of an array, which holds zero."""


class DrivePlan(NamedTuple):
    """Places of the variables of a drive."""

    drive: int
    """Index of the drive in the mechanism [1]."""
    torque: int
    """Output [1]."""
    speed: int
    """Input [1]."""
    angle: int
    """Input [1]."""
    set_speed: int
    """Input [1]."""


class BodyPlan(NamedTuple):
    """Places of the variables of a body, and the axes of the FMU."""

    body: int
    """Index of the body in the mechanism [1]."""
    carrier: str
    """Its name."""
    origin: np.ndarray
    """Origin of the FMU [m], (3,), world."""
    turn: np.ndarray | None
    """Quaternion from the axes of the FMU to world axes; None where they are parallel."""
    arm: np.ndarray | None
    """Reference point from the mass centre [m], (3,), axes of the body; None for the mass centre."""
    position: list[int]
    """Outputs [1]."""
    attitude: list[int]
    """Outputs [1]; empty for a body that does not turn."""
    attitude_as: str
    """What they are (`nutamill.case.fmus.FmuBody.attitude_as`)."""
    rates: dict[str, list[int]]
    """Outputs [1] of velocity, angular_velocity, acceleration and angular_acceleration that are given."""
    force: list[int]
    """Inputs [1]."""
    moment: list[int]
    """Inputs [1]."""
    start: np.ndarray
    """Position and quaternion as assembled (7,)."""


class LinkPlan(NamedTuple):
    """An input that is set to an output of another FMU."""

    input: int
    """Place of the input [1]."""
    fmu: int
    """Index of that FMU [1]."""
    output: int
    """Place of its output [1]."""


class FmuPlan(NamedTuple):
    """One FMU of a run."""

    name: str
    """Name of the instance."""
    where: str
    """Key of its table, for messages."""
    description: FmuDescription
    """What it is."""
    sha256: str
    """Digest of its content."""
    starts: list[Start]
    """Start values and parameters."""
    inputs: list[Signal]
    """Variables that are set at every window."""
    outputs: list[Signal]
    """Variables that are read at every window."""
    drives: list[DrivePlan]
    """Drives that it drives."""
    bodies: list[BodyPlan]
    """Bodies that it moves."""
    links: list[LinkPlan]
    """Inputs from other FMUs."""


def fmu_plans(machine: Machine) -> list[FmuPlan]:
    """Return the FMUs of a machine with all names as places.

    Raises
    ------
    CaseError : every fault of every FMU and of its mapping
    NotInstalledError : FMPy is missing
    """
    faults: list[Fault] = []
    described: dict[str, FmuDescription] = {}
    names: dict[str, Names] = {}
    for entry in machine.fmus:
        where = f"fmus.{entry.name}"
        try:
            check_digest(Path(entry.file), entry.sha256, f"{where}.file")
            described[entry.name] = read_description(Path(entry.file), f"{where}.file")
            names[entry.name] = Names(described[entry.name], entry.units, where)
        except NotInstalledError:
            raise
        except CaseError as error:
            faults += error.faults
    plans = [
        _plan(machine, entry, described[entry.name], names) for entry in machine.fmus if entry.name in names
    ]
    faults += [fault for checked in names.values() for fault in checked.faults]
    for plan in plans:
        if machine.run.coupling == "iterated" and plan.bodies and not plan.description.can_roll_back:
            what = f'the FMU "{plan.name}" cannot go back to the start of a window'
            faults.append(Fault("run.coupling", what, 'Write run.coupling = "staggered"'))
    if faults:
        raise CaseError(*dict.fromkeys(faults))
    return plans


def _plan(machine: Machine, entry: FmuEntry, description: FmuDescription, names: dict[str, Names]) -> FmuPlan:
    """Return the plan of one FMU. Faults stay with its names."""
    own, where = names[entry.name], f"fmus.{entry.name}"
    sliding = [drive.name for drive in machine.linear_drives]
    order = [drive.name for drive in machine.drives] + sliding
    drives = []
    for given in entry.drives:
        key = f"{where}.drives.{given.drive}"
        kinds = (Kind.TORQUE, Kind.SPEED, Kind.ANGLE)
        force, speed, angle = (Kind.FORCE, Kind.VELOCITY, Kind.LENGTH) if given.drive in sliding else kinds
        drives.append(
            DrivePlan(
                order.index(given.drive),
                own.output(given.torque or "", force, f"{key}.torque"),
                own.input(given.speed or "", speed, f"{key}.speed"),
                own.input(given.angle or "", angle, f"{key}.angle"),
                own.input(given.set_speed or "", speed, f"{key}.set_speed"),
            )
        )
    bodies = [_body(machine, given, own, f"{where}.bodies.{given.body}") for given in entry.bodies]
    links = []
    for target, source in entry.links.items():
        fmu, _, output = source.removeprefix("-").partition(".")
        sign, key = "-" if source.startswith("-") else "", f"{where}.links.{target}"
        if fmu in names:
            at = names[fmu].output(sign + output, None, key)
            own.check_link(target, names[fmu], output, key)
            index = [other.name for other in machine.fmus].index(fmu)
            links.append(LinkPlan(own.input(target, None, key), index, at))
    starts = [own.start(name, value, f"{where}.start.{name}") for name, value in entry.start.items()]
    return FmuPlan(
        entry.name,
        where,
        description,
        entry.sha256,
        [start for start in starts if start is not None],
        own.inputs,
        own.outputs,
        drives,
        bodies,
        links,
    )


def _body(machine: Machine, given: FmuBody, names: Names, where: str) -> BodyPlan:
    """Return the plan of a body. Faults stay with the names."""
    number = [body.name for body in machine.bodies].index(given.body)
    body = machine.bodies[number]
    start = np.concatenate([np.array(body.position, float), quaternion_of(body.turn)])
    arm = None
    if given.point is not None:
        arm = rotation_matrix_of(start[3:]).T @ (np.array(given.point) - start[:3])
    angles = Kind.ANGLE if given.attitude_as != "quaternion" else None
    kinds = {
        "velocity": Kind.VELOCITY,
        "angular_velocity": Kind.SPEED,
        "acceleration": Kind.ACCELERATION,
        "angular_acceleration": Kind.RAMP,
    }

    def outputs(key: str, kind: Kind | None) -> list[int]:
        return [names.output(name, kind, f"{where}.{key}") for name in getattr(given, key) or ()]

    def inputs(key: str, kind: Kind) -> list[int]:
        return [names.input(name, kind, f"{where}.{key}") for name in getattr(given, key) or ()]

    return BodyPlan(
        number,
        given.body,
        np.array(given.origin, float),
        None if given.turn is None else quaternion_of(given.turn),
        arm,
        outputs("position", Kind.LENGTH),
        outputs("attitude", angles),
        given.attitude_as,
        {key: outputs(key, kind) for key, kind in kinds.items() if getattr(given, key) is not None},
        inputs("force", Kind.FORCE),
        inputs("moment", Kind.TORQUE),
        start,
    )
