"""`[[fmus]]`: models of other programs (FMI 2 and 3, co-simulation) that drive a joint or move a body."""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from nutamill.base.library import similar
from nutamill.base.schema import Table, refusal, spelled
from nutamill.case.names import Name, Point, Turn

if TYPE_CHECKING:
    from nutamill.case.machine import Machine

LARGEST_VECTOR_NAMES = 4
"""Variables of the longest vector, a quaternion [1]."""


def _variable(given: Any) -> Any:
    if not isinstance(given, str) or not given.strip() or given.strip() == "-":
        raise refusal(
            f"must be the name of a variable of the FMU, got {spelled(given)}",
            'Write e.g. "M", or "-M" for its negative',
        )
    return given.strip()


def _component(given: Any) -> Any:
    return "" if given == "" else _variable(given)


def _start_value(given: Any) -> Any:
    finite = not isinstance(given, float) or math.isfinite(given)
    if not isinstance(given, (bool, int, float, str)) or not finite:
        raise refusal(f"must be a finite number, true, false or text, got {spelled(given)}", "")
    return given


Variable = Annotated[str, BeforeValidator(_variable)]
"""Name of a variable, with a minus sign before it for its negative."""
Component = Annotated[str, BeforeValidator(_component)]
"""A `Variable`, or empty text where the FMU has none for this component: it is then zero."""
Three = tuple[Component, Component, Component]
Attitude = Annotated[tuple[Component, ...], Field(min_length=3, max_length=LARGEST_VECTOR_NAMES)]
StartValue = Annotated[bool | int | float | str, BeforeValidator(_start_value)]
"""Value of a start value or a parameter."""


class FmuDrive(Table):
    """A drive whose torque or force an FMU gives, or whose motion a controller gets."""

    drive: str
    """Name of the drive or linear drive; "motor" in a mill as drawn."""
    torque: Variable | None = None
    """Output: torque on body b of the drive's joint about its axis [N m], or force along it [N]; not
    given for an FMU that only feeds another one.
    """
    speed: Variable | None = None
    """Input: mean speed of the joint over the step [rad/s or m/s]."""
    angle: Variable | None = None
    """Input: mean angle over the step, not wrapped [rad], or travel [m]."""
    set_speed: Variable | None = None
    """Input: speed that the programme of the drive asks for [rad/s or m/s]."""


class FmuBody(Table):
    """A body that moves as an FMU computes, and what the FMU gets of the charge on it.

    Vectors are in the axes of the FMU, about the reference point.  A name that is left empty, or a vector
    that is left out, stands for zero; velocity and acceleration that are left out are taken from the change
    of what is given.
    """

    body: str
    """Name of the body. Its mass and inertia are used to judge the window only."""
    origin: Point = (0.0, 0.0, 0.0)
    """Where the FMU's origin is, world [m]."""
    turn: Turn | None = None
    """Rotation from world axes to the axes of the FMU; parallel if not given."""
    point: Point | None = None
    """Reference point of the FMU on the body, world as assembled [m]; the mass centre if not given."""
    position: Three
    """Outputs: the reference point from the origin [m]."""
    attitude: Attitude | None = None
    """Outputs: rotation of the body's axes from those of the FMU; it does not turn if not given."""
    attitude_as: Literal["quaternion", "rotation_vector", "cardan_xyz"] = "quaternion"
    """What the attitude is: w, x, y, z; a rotation vector [rad]; or angles about the body's x axis, then its
    new y, then its new z [rad].
    """
    velocity: Three | None = None
    """Outputs: velocity of the reference point [m/s]."""
    angular_velocity: Three | None = None
    """Outputs: angular velocity [rad/s]."""
    acceleration: Three | None = None
    """Outputs: acceleration of the reference point [m/s^2]."""
    angular_acceleration: Three | None = None
    """Outputs: angular acceleration [rad/s^2]."""
    force: Three | None = None
    """Inputs: mean force of the charge over the step [N]."""
    moment: Three | None = None
    """Inputs: its mean moment about the reference point [N m]."""


class FmuEntry(Table):
    """A model of another program as an FMU for co-simulation."""

    name: Name
    """Name of the instance."""
    file: str
    """The FMU, relative to the case file."""
    sha256: str = ""
    """Digest of its content, filled in when the case is read."""
    start: dict[str, StartValue] = Field(default_factory=dict)
    """Start values and parameters by the FMU's names, in its units."""
    links: dict[str, Variable] = Field(default_factory=dict)
    """Inputs by name, each with the output of another FMU, "controller.y", that it is set to.  One below it
    gives what it gave in the window before.
    """
    units: dict[str, str] = Field(default_factory=dict)
    """Units of mapped variables for which the FMU declares none; SI without either."""
    drives: tuple[FmuDrive, ...] = ()
    """Drives whose torque it gives."""
    bodies: tuple[FmuBody, ...] = ()
    """Bodies that it moves: a foreign machine."""


Finding = tuple[tuple[Any, ...], str, str]


def machine_fmu_findings(case: "Machine") -> Iterator[Finding]:
    """Yield contradictions of the FMUs of a machine with its parts: key, what is wrong, what to write."""
    drives = {drive.name: drive.motor is not None for drive in case.drives}
    drives |= {drive.name: drive.motor is not None for drive in case.linear_drives}
    yield from fmu_findings(case.fmus, drives, [body.name for body in case.bodies])
    yield from _foreign_findings(case, {entry.body for fmu in case.fmus for entry in fmu.bodies})


def fmu_findings(fmus: tuple[FmuEntry, ...], drives: dict[str, bool], bodies: list[str]) -> Iterator[Finding]:
    """Yield contradictions of FMUs with the drives there are, by whether each has a motor, and with the
    bodies that an FMU may move.
    """
    driven: set[str] = set()
    moved: set[str] = set()
    names: set[str] = set()
    for number, fmu in enumerate(fmus):
        key = ("fmus", number)
        if fmu.name in names:
            yield (*key, "name"), f'is the name of two FMUs, got "{fmu.name}"', "Rename one of the two"
        names.add(fmu.name)
        torques = any(entry.torque for entry in fmu.drives)
        if not (torques or fmu.bodies or any(linked(other, fmu.name) for other in fmus)):
            what = "has no use: it gives no torque, moves no body and feeds no other FMU"
            yield key, what, "Add [[fmus.drives]] with a torque, or [[fmus.bodies]]"
        if fmu.drives and fmu.bodies:
            hint = "Export drive and bodies as two FMUs"
            yield (*key, "drives"), "belong to an FMU that also moves bodies", hint
        for n, entry in enumerate(fmu.drives):
            where = (*key, "drives", n, "drive")
            if entry.drive not in drives:
                yield where, f'no drive is called "{entry.drive}"', similar(entry.drive, list(drives))
            elif entry.torque is None:
                continue
            elif drives[entry.drive]:
                yield where, f'the drive "{entry.drive}" has a motor of its own', "Leave its motor out"
            elif entry.drive in driven:
                yield where, f'the drive "{entry.drive}" gets its torque from two FMUs', ""
            driven.add(entry.drive)
        for n, moving in enumerate(fmu.bodies):
            place = (*key, "bodies", n)
            if moving.body not in bodies:
                yield (*place, "body"), f'no body is called "{moving.body}"', similar(moving.body, bodies)
            elif moving.body in moved:
                yield (*place, "body"), f'the body "{moving.body}" is moved by two FMUs', ""
            moved.add(moving.body)
            if moving.attitude is not None:
                needed = 4 if moving.attitude_as == "quaternion" else 3
                if len(moving.attitude) != needed:
                    what = f"needs {needed} names for {moving.attitude_as}, got {len(moving.attitude)}"
                    yield (*place, "attitude"), what, ""
        others = [other.name for other in fmus if other.name != fmu.name]
        for name, source in fmu.links.items():
            if source.lstrip("-").partition(".")[0] not in others:
                what = f'no other FMU gives "{source}"'
                yield (*key, "links", name), what, 'Write e.g. "controller.y", with the name of another FMU'


def linked(fmu: FmuEntry, source: str) -> bool:
    """Return whether an FMU is linked to an output of the FMU called `source`."""
    return any(link.lstrip("-").startswith(f"{source}.") for link in fmu.links.values())


def _foreign_findings(case: "Machine", moved: set[str]) -> Iterator[Finding]:
    """Yield what cannot be done with bodies that FMUs move."""
    if not moved:
        return
    movers = [number for number, fmu in enumerate(case.fmus) if fmu.bodies]
    if len(movers) > 1:
        yield ("fmus", movers[1]), "a second FMU moves bodies", "Join both machines in one FMU"
    for where in ("joints", "bushings", "springs", "stops"):
        for number, part in enumerate(getattr(case, where)):
            if moved & set(part.between):
                what = f'connects "{(moved & set(part.between)).pop()}", which an FMU moves'
                yield (where, number, "between"), what, "Put the connection into the FMU"
    for where in ("torques", "forces", "unbalance_motors"):
        for number, part in enumerate(getattr(case, where)):
            if part.body in moved:
                what = f'acts on "{part.body}", which an FMU moves'
                yield (where, number, "body"), what, "Put the load into the FMU"
    for where in ("walls", "regions"):
        for number, part in enumerate(getattr(case, where)):
            if part.body not in (*moved, "ground"):
                what = f'is on "{part.body}", which the FMU does not move'
                hint = "A charge has its walls on bodies of the FMU and on the ground"
                yield (where, number, "body"), what, hint
    if case.run.start == "rest":
        hint = 'Write run.start = "assembled"; the FMU begins where it begins'
        yield ("run", "start"), '"rest" cannot be computed for a machine that an FMU moves', hint
    if case.run.coupling == "iterated" and any(fmu.drives for fmu in case.fmus):
        what = '"iterated" is not made for a drive of an FMU beside bodies of one'
        yield ("run", "coupling"), what, 'Write run.coupling = "staggered"'
