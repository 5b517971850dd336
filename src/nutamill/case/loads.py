"""Forces, stops, gears, linear drives and unbalance motors of a machine, as its file gives them."""

from nutamill.base.schema import (
    AnyForce,
    Force,
    Inertia,
    Length,
    LinearGain,
    Mass,
    Number,
    Power,
    Share,
    StartTime,
    Stiffness,
    Table,
    Time,
    Velocity,
)
from nutamill.case.drive import DriveProgramme
from nutamill.case.names import Direction, Name, Point

ForceVector = tuple[AnyForce, AnyForce, AnyForce]


class ForceEntry(Table):
    """A force at a point of a body, constant or over time; its direction does not turn with the body."""

    name: Name
    """Unique name."""
    body: str
    """The body."""
    at: Point | None = None
    """Point at which it acts, world as assembled [m]; the mass centre if not given."""
    force: ForceVector | None = None
    """Constant force, world axes [N]; give it or the table."""
    table: tuple[tuple[StartTime, ForceVector], ...] | None = None
    """Pairs of time [s] and force [N], times from 0 and rising: linear between, constant after the last."""


class StopEntry(Table):
    """A one-sided stop without friction: a sphere of body b against a plane or a sphere of body a."""

    name: Name
    """Unique name."""
    between: tuple[str, str]
    """Bodies a and b; the ground may be body a."""
    point_a: Point
    """A point of the plane, or the centre of the sphere of a, world [m]."""
    normal: Direction | None = None
    """Normal of the plane towards b, world axes; any length. Give it or radius_a."""
    radius_a: Length | None = None
    """Radius of the sphere of a [m]."""
    point_b: Point
    """Centre of the sphere of b, world [m]."""
    radius_b: Length | None = None
    """Radius of the sphere of b [m]; a point if not given."""
    stiffness: Stiffness
    """Force per overlap [N/m]."""
    restitution: Share
    """Speed of rebound over speed of impact [1], 0.05 to 1."""


class GearEntry(Table):
    """A ratio between the rotations of two joints: gears, a belt, a chain, without slip or play."""

    name: Name
    """Unique name."""
    input: str
    """A revolute or cylindrical joint."""
    output: str
    """Another."""
    ratio: Number
    """Rotation of the output over that of the input [1], each of body b relative to body a; negative if they
    turn opposite ways.
    """


class LinearMotor(Table):
    """A motor that is asked for the speed of a linear drive, in place of a prescribed travel."""

    force: Force | None = None
    """Largest force [N]; no limit if left out."""
    power: Power | None = None
    """Largest power [W]; no limit if left out."""
    gain: LinearGain
    """Force of the speed controller per error of the speed [N s/m]."""
    integral_time: Time = 0.2
    """Time in which its integral part adds as much again [s]."""
    cut: StartTime | None = None
    """When the supply is switched off [s]; never if left out."""
    restored: Time | None = None
    """When the supply is back [s]; never if left out."""


class LinearDriveEntry(Table):
    """A travel along a prismatic joint, prescribed or by a motor."""

    name: Name
    """Unique name, also among the drives that turn."""
    joint: str
    """A prismatic joint: its body b slides relative to a along the joint's axis."""
    speeds: tuple[tuple[StartTime, Velocity], ...]
    """Pairs of time [s] and speed [m/s], times from 0 and rising: linear between, constant after the last."""
    motor: LinearMotor | None = None
    """The motor that is to reach the speeds; without it the travel is prescribed, whatever force it takes."""

    @property
    def ramp_end(self) -> float:
        """Time from which the speed stays what it is [s]."""
        moving = [n for n, (_, speed) in enumerate(self.speeds) if speed != self.speeds[-1][1]]
        return self.speeds[moving[-1] + 1][0] if moving else 0.0


class UnbalanceMotorEntry(DriveProgramme):
    """A rotor with a mass off its axis on a body, and the drive that turns it."""

    name: Name
    """Unique name, also among bodies, joints and drives: that of its rotor, its bearing and its drive."""
    body: str
    """The body that carries it."""
    point: Point
    """Point of the axis opposite the eccentric mass, world [m]."""
    axis: Direction
    """Axis about which it turns by the right hand, world axes; any length."""
    towards: Direction
    """Direction from the axis to the eccentric mass as assembled, square to the axis; any length."""
    mass: Mass
    """Mass of the rotor [kg]."""
    eccentricity: Length
    """Distance of its mass centre from the axis [m]."""
    inertia: Inertia | None = None
    """About its own mass centre, in every direction [kg m^2]; that of a ball whose radius is the eccentricity
    if not given.
    """
