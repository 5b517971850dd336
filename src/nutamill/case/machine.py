"""`Machine`: any mechanism as data, its bodies, joints, bushings, springs, drives and sensors one by
one.

Points and directions are in world axes, as assembled.  The engine knows nothing of a mill, and neither does
this file.
"""

import re
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import BeforeValidator, Field, model_validator

from nutamill.base.schema import (
    AddedMass,
    AnyAcceleration,
    AnyAngle,
    AnyInertia,
    AnySpeed,
    BushingStiffness,
    Coordinate,
    Damping,
    Frequency,
    Moment,
    Number,
    Table,
    Time,
    Velocity,
    refusal,
    spelled,
)
from nutamill.case.case_file import CaseFile, SnapshotPlan
from nutamill.case.connections import BushingRates, FrictionEntry
from nutamill.case.drive import DriveProgramme
from nutamill.case.machine_checks import findings


def _name(given: Any) -> Any:
    if not isinstance(given, str) or not re.fullmatch("[a-z][a-z0-9_]*", given):
        raise refusal(
            f"must begin with a small letter and hold small letters, digits and _ only, got {spelled(given)}"
        )
    return given


def _inertia(given: Any) -> Any:
    if isinstance(given, (list, tuple)) and len(given) in (3, 6):
        return given
    raise refusal("must be three moments of inertia, or six: xx, yy, zz, xy, xz, yz")


Name = Annotated[str, BeforeValidator(_name)]
Point = tuple[Coordinate, Coordinate, Coordinate]
Direction = tuple[Number, Number, Number]
Between = tuple[str, str]


class Turn(Table):
    """A rotation from world axes to the axes of a body as assembled."""

    axis: Direction
    """What it turns about; any length."""
    angle: AnyAngle
    """How far, by the right hand [rad]."""


class BodyEntry(Table):
    """A rigid body as assembled."""

    name: Name
    """Unique name; "ground" is the body that never moves."""
    mass: AddedMass
    """Mass [kg]."""
    inertia: Annotated[tuple[AnyInertia, ...], BeforeValidator(_inertia)]
    """About the mass centre in body axes [kg m^2]: three principal moments, or six, xx, yy, zz, xy, xz,
    yz.
    """
    position: Point
    """Mass centre, world [m]."""
    turn: Turn | None = None
    """Attitude; axes parallel to the world's if not given."""
    velocity: tuple[Velocity, Velocity, Velocity] = (0.0, 0.0, 0.0)
    """Velocity of the mass centre [m/s]."""
    angular_velocity: tuple[AnySpeed, AnySpeed, AnySpeed] = (0.0, 0.0, 0.0)
    """Angular velocity, world axes [rad/s]."""


class JointEntry(Table):
    """A kinematic constraint."""

    name: Name
    """Unique name."""
    kind: Literal["fixed", "revolute", "spherical", "universal", "cylindrical", "prismatic", "point_on_line"]
    """What it leaves free."""
    between: Between
    """Bodies a and b; the axis is fixed in a, the reaction is that on b."""
    point: Point
    """Joint point, world [m]."""
    point_b: Point | None = None
    """Where body b has its point, if the loop may not close [m]."""
    axis: Direction | None = None
    """Axis, world axes; any length."""
    second_axis: Direction | None = None
    """Universal: the axis fixed in b, square to the first."""
    friction: FrictionEntry | None = None
    """Friction, for joints that turn."""


class BushingPlace(Table):
    """Where a bushing is, and what it connects."""

    name: Name
    """Unique name."""
    between: Between
    """Bodies a and b; axes are fixed in a, the wrench is that on b."""
    point: Point
    """Bushing point, world [m]."""
    axis: Direction
    """Axis, world axes; any length."""


class BushingEntry(BushingRates, BushingPlace):  # a file begins with the keys of the last
    """A compliant connection, without load as assembled."""


class SpringEntry(Table):
    """A straight spring with a damper between two points."""

    name: Name
    """Unique name."""
    between: Between
    """Bodies a and b."""
    point_a: Point
    """End on a, world [m]."""
    point_b: Point
    """End on b, world [m]."""
    stiffness: BushingStiffness
    """Stiffness [N/m]."""
    damping: Damping = 0.0
    """Damping [N s/m]."""
    free_length: Coordinate
    """Length without force [m]."""


class TorqueEntry(Table):
    """A constant moment on a body."""

    name: Name
    """Unique name."""
    body: str
    """The body."""
    moment: tuple[Moment, Moment, Moment]
    """Moment, world axes [N m]."""


class DriveEntry(DriveProgramme):
    """A prescribed rotation of a joint."""

    name: Name
    """Unique name."""
    joint: str
    """A revolute or cylindrical joint: its body b turns relative to a, by the right hand about the joint's
    axis.
    """


class SensorEntry(Table):
    """What is read besides the reactions of all joints, the wrenches of all bushings and the drives, which
    always are.
    """

    name: Name
    """Name its series begin with."""
    kind: Literal["position", "velocity", "acceleration", "attitude", "reaction"]
    """What is read; "reaction" writes that of a joint in other axes."""
    of: str
    """The body, or with "reaction" the joint."""
    at: Point | None = None
    """Point of the body, world as assembled [m]; its mass centre if not given."""
    axes: str | None = None
    """Body in whose axes a velocity, acceleration or reaction is written; world axes if not given."""


class MachineRun(Table):
    """How long, how finely, and what is recorded."""

    until: Time
    """Simulated time at the end [s]."""
    dt: Time = 50e-6
    """Longest step [s]; the step divides the period of the series."""
    start: Literal["assembled", "rest"] = "assembled"
    """As assembled, with the velocities given; or from static equilibrium."""
    series_rate: Frequency = 1000.0
    """Rate of the recorded series [Hz]."""
    snapshots: SnapshotPlan = SnapshotPlan(rate=50.0, last=10.0)
    """Snapshots of all bodies."""
    checkpoint: Time = 1.0
    """Simulated time between checkpoints [s]; where that takes longer than ten minutes, more are saved
    between.
    """

    @property
    def end(self) -> float:
        """Simulated time at the end [s], under the name that runs of mills have for it."""
        return self.until


class Extent(NamedTuple):
    """What a march asks of any drive."""

    ramp_end: float
    """Time from which all driven speeds stay what they are [s]."""


class Machine(CaseFile):
    """Any mechanism, and how it is run; made by `load_case` from a file with ``[[bodies]]``, or in Python."""

    schema_version: Annotated[Literal[1], Field(alias="schema")] = 1
    """Version of the form of this file."""
    title: str = ""
    """What it is, in one line."""
    changed_from: str | None = None
    """Title of the case that this one was changed from, where its own title was made to say what was
    changed.
    """
    gravity: tuple[AnyAcceleration, AnyAcceleration, AnyAcceleration] = (0.0, 0.0, -9.81)
    """Acceleration of gravity, world axes [m/s^2]."""
    redundant: Literal["refuse", "allow"] = "refuse"
    """Redundant constraints: refused, or solved with their reactions marked as not unique."""
    bodies: tuple[BodyEntry, ...]
    """The bodies that move."""
    joints: tuple[JointEntry, ...] = ()
    """The joints."""
    bushings: tuple[BushingEntry, ...] = ()
    """The bushings."""
    springs: tuple[SpringEntry, ...] = ()
    """The springs."""
    torques: tuple[TorqueEntry, ...] = ()
    """Constant moments."""
    drives: tuple[DriveEntry, ...] = ()
    """The drives."""
    sensors: tuple[SensorEntry, ...] = ()
    """Further readings."""
    run: MachineRun

    @model_validator(mode="after")
    def _sound(self) -> "Machine":
        if contradictions := findings(self):
            raise refusal("parts of the mechanism contradict each other", findings=contradictions)
        return self

    @property
    def drive(self) -> Extent:
        """When the last drive has come to its last speed."""
        return Extent(max((drive.ramp_end for drive in self.drives), default=0.0))
