"""`Machine`: any machine as data, its bodies, joints, loads, drives, sensors and walls one by one, and the
charge between the walls.

Points and directions are in world axes, as assembled.  The engines know nothing of a mill, and neither does
this file.
"""

from typing import Annotated, Any, ClassVar, Literal, NamedTuple

from pydantic import BeforeValidator, Field, PrivateAttr, model_validator

from nutamill.base.errors import Fault
from nutamill.base.schema import (
    AddedMass,
    AnyAcceleration,
    AnyForce,
    AnyInertia,
    AnySpeed,
    BushingStiffness,
    Coordinate,
    Damping,
    Moment,
    Table,
    Velocity,
    refusal,
)
from nutamill.case.case_file import CaseFile
from nutamill.case.charge import ChargeRecipe, stand_ins
from nutamill.case.charge_checks import Vessel, idle_numbers
from nutamill.case.connections import BushingRates, FrictionEntry
from nutamill.case.drive import DriveProgramme
from nutamill.case.fmus import FmuEntry
from nutamill.case.loads import ForceEntry, GearEntry, LinearDriveEntry, StopEntry, UnbalanceMotorEntry
from nutamill.case.machine_checks import findings
from nutamill.case.materials import ContactLaws, Material
from nutamill.case.names import Direction, Name, Point, Turn
from nutamill.case.run import MachineRun
from nutamill.case.touching import Key, TouchingPair, touching_pairs
from nutamill.case.walls import RegionEntry, WallEntry


def _inertia(given: Any) -> Any:
    if isinstance(given, (list, tuple)) and len(given) in (3, 6):
        return given
    raise refusal("must be three moments of inertia, or six: xx, yy, zz, xy, xz, yz")


Between = tuple[str, str]


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


JointName = Literal[
    "fixed", "revolute", "spherical", "universal", "cylindrical", "prismatic", "point_on_line"
]


class JointEntry(Table):
    """A kinematic constraint."""

    name: Name
    """Unique name."""
    kind: JointName
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
    """Friction, for all kinds but fixed."""


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
    free_length: Coordinate | None = None
    """Length without force [m]; give it or the preload."""
    preload: AnyForce | None = None
    """Tension as assembled [N], negative if the spring pushes."""


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
    kind: Literal["position", "velocity", "acceleration", "attitude", "reaction", "spring", "charge"]
    """What is read; "reaction" writes that of a joint in other axes, "spring" length and tension, "charge"
    gives the point about which the moment of the charge on a body is recorded.
    """
    of: str
    """The body, or with "reaction" the joint, with "spring" the spring."""
    at: Point | None = None
    """Point of the body, world as assembled [m]; its mass centre if not given."""
    axes: str | None = None
    """Body in whose axes a velocity, acceleration or reaction is written; world axes if not given."""


class QuantityEntry(Table):
    """A named series taken of others, recorded beside them."""

    name: Name
    """Its name."""
    of: tuple[str, ...]
    """Series it is taken of, each with a minus sign before it where its negative is meant; quantities above
    it may be among them.
    """
    take: Literal["sum", "resultant", "product", "lag"] = "sum"
    """Sum, root of the sum of squares, product; or the lag of the direction (x - x0, y - y0) behind an angle,
    of angle, x, y, x0, y0.
    """
    zeroed: bool = False
    """Whether each series counts from its value at the start, as an instrument that is zeroed at rest."""


class FieldAxes(Table):
    """Axes of the charge's fields: a cylindrical grid around the regions, along the z axis of a body."""

    body: str | None = None
    """The body to whose axes the grid is fixed, or "ground"; the body of the first region if not given."""
    drive: str | None = None
    """Drive with whose angle the grid rotates about that z axis; none if not given."""


class Extent(NamedTuple):
    """What a march asks of any drive."""

    ramp_end: float
    """Time from which all driven speeds stay what they are [s]."""


class Machine(CaseFile):
    """Any machine, and how it is run; made by `load_case` from a file with ``[[bodies]]``, or in Python."""

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
    forces: tuple[ForceEntry, ...] = ()
    """Constant and tabulated forces."""
    stops: tuple[StopEntry, ...] = ()
    """One-sided stops."""
    gears: tuple[GearEntry, ...] = ()
    """Ratios between the rotations of two joints."""
    drives: tuple[DriveEntry, ...] = ()
    """The drives."""
    linear_drives: tuple[LinearDriveEntry, ...] = ()
    """The drives along prismatic joints."""
    unbalance_motors: tuple[UnbalanceMotorEntry, ...] = ()
    """Unbalance motors."""
    fmus: tuple[FmuEntry, ...] = ()
    """Models of other programs that drive joints or move bodies."""
    sensors: tuple[SensorEntry, ...] = ()
    """Further readings."""
    walls: tuple[WallEntry, ...] = ()
    """Walls of the charge, each carried by a body or by the ground."""
    regions: tuple[RegionEntry, ...] = ()
    """Regions that charge is put into at the start."""
    charge: ChargeRecipe = ChargeRecipe(kind="none")
    """The charge, if there is one."""
    materials: dict[str, Material] = Field(default_factory=dict)
    """Materials of charge and walls, by name."""
    contact: ContactLaws = ContactLaws(pairs={})
    """How they touch."""
    quantities: tuple[QuantityEntry, ...] = ()
    """Named series taken of others."""
    fields: FieldAxes = FieldAxes()
    """Axes of the fields of the charge."""
    run: MachineRun

    # meshes and FMUs are identified by their content, wherever the files are
    files: ClassVar[dict[str, Any]] = {"walls": {"__all__": {"file"}}, "fmus": {"__all__": {"file"}}}

    _written: dict[str, str] = PrivateAttr(default_factory=dict)

    def key_of_wall(self, name: str) -> str:
        """Return the key of the table that a wall was written as in the file of the case, for messages."""
        return self._written.get(name, f"walls.{name}")

    def stored_wall(self, name: str) -> str:
        """Return the name under which a result holds the mesh of a wall."""
        numbers = {wall.name: f"walls[{number}]" for number, wall in enumerate(self.walls)}
        return self._written.get(name, numbers[name])

    @model_validator(mode="after")
    def _sound(self) -> "Machine":
        if contradictions := findings(self):
            raise refusal("parts of the machine contradict each other", findings=contradictions)
        return self

    @property
    def machine(self) -> "Machine":
        """The machine itself, as `nutamill.case.mill.Case.machine`."""
        return self

    @property
    def drawing(self) -> None:
        """The drawing of a mill that stands for these parts: there is none."""
        return None

    @property
    def wall_materials(self) -> dict[Key, str]:
        """Material of every wall that the charge can touch, by its key."""
        return {("walls", number, "material"): wall.material for number, wall in enumerate(self.walls)}

    @property
    def vessels(self) -> dict[str, Vessel]:
        """What charge is put into, by name: the regions."""
        meshed = any(wall.shape == "mesh" for wall in self.walls)
        return {
            region.name: Vessel(f"region {region.name}", region.volume, region.width, meshed)
            for region in self.regions
        }

    @property
    def touching(self) -> tuple[TouchingPair, ...]:
        """Pairs of materials that can touch: those of the charge, then each of them with every wall."""
        return touching_pairs(self)

    @property
    def warnings(self) -> list[Fault]:
        """What is possible but odd about the machine."""
        return [*stand_ins(self.charge), *(idle_numbers(self) if self.charge.parts else [])]

    @property
    def period(self) -> str | None:
        """Drive over whose whole turns means are taken, or None where they are over time."""
        return self.run.period or self.fields.drive

    @property
    def turn_series(self) -> str | None:
        """Series with the angle of that drive, or None where there is none."""
        return None if self.period is None else drive_series(self, self.period, "angle")

    @property
    def drive(self) -> Extent:
        """When the last drive has come to its last speed."""
        ends = [drive.ramp_end for drive in (*self.drives, *self.unbalance_motors)]
        return Extent(max([*ends, *(drive.ramp_end for drive in self.linear_drives)], default=0.0))


def drive_series(machine: Machine, drive: str, what: str) -> str:
    """Return the series with the angle or the speed of a drive: a quantity that is just that, or its own."""
    return series_called(machine, f"drive_{drive}_{what}")


def series_called(machine: Machine, own: str) -> str:
    """Return what a series of a part is called in a record: a quantity that is just that, or its own name."""
    same = (entry.name for entry in machine.quantities if entry.of == (own,) and not entry.zeroed)
    return next(same, own)
