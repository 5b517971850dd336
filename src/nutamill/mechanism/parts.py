"""The parts of a mechanism as a person describes them: frozen data, SI, world coordinates as assembled.

`nutamill.mechanism.assembly.assemble` checks the parts and turns them into arrays.
"""

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

import numpy as np

GROUND = "ground"
"""Name of the body that never moves."""

Vector = tuple[float, float, float] | np.ndarray


class JointKind(IntEnum):
    """Motions of body b relative to body a that a joint leaves free."""

    FIXED = 0
    """None."""
    REVOLUTE = 1
    """Rotation about the axis."""
    SPHERICAL = 2
    """Rotation about the point."""
    UNIVERSAL = 3
    """Rotation about `axis` of a and about `second_axis` of b (Hooke joint)."""
    CYLINDRICAL = 4
    """Rotation about the axis and sliding along it."""
    PRISMATIC = 5
    """Sliding along the axis."""
    POINT_ON_LINE = 6
    """Any rotation; the point of b slides along the axis of a ("sphere and cylinder")."""


class JointRows(NamedTuple):
    """Scalar constraints and properties of a joint kind."""

    points: int
    """Directions in which the points of a and b stay together [1]: 3, or 2 if b slides along the axis."""
    axes: int
    """Rotations that the joint locks [1], 0 to 3."""
    turns: bool
    """Whether b turns about the joint's axis, so that a drive can drive it."""
    slides: bool
    """Whether b slides along the joint's axis and does nothing else, so that a drive can drive it."""
    rubs: bool
    """Whether the joint can have friction."""

    @property
    def needs_axis(self) -> bool:
        """Whether the joint has an axis: it slides along it, or locks some rotations but not all."""
        return self.points == 2 or self.axes in (1, 2)


JOINTS = {
    JointKind.FIXED: JointRows(points=3, axes=3, turns=False, slides=False, rubs=False),
    JointKind.REVOLUTE: JointRows(points=3, axes=2, turns=True, slides=False, rubs=True),
    JointKind.SPHERICAL: JointRows(points=3, axes=0, turns=False, slides=False, rubs=True),
    JointKind.UNIVERSAL: JointRows(points=3, axes=1, turns=False, slides=False, rubs=True),
    JointKind.CYLINDRICAL: JointRows(points=2, axes=2, turns=True, slides=False, rubs=True),
    JointKind.PRISMATIC: JointRows(points=2, axes=3, turns=False, slides=True, rubs=True),
    JointKind.POINT_ON_LINE: JointRows(points=2, axes=0, turns=False, slides=False, rubs=True),
}
"""The declaration of every joint kind: a new kind is a member of `JointKind` and a line here."""


@dataclass(frozen=True, slots=True)
class Body:
    """A rigid body as assembled."""

    name: str
    """Unique name."""
    mass: float
    """Mass [kg]."""
    inertia: np.ndarray
    """Inertia about the mass centre [kg m^2], (3, 3), body axes."""
    position: Vector
    """Mass centre [m], (3,), world."""
    quaternion: tuple[float, float, float, float] | np.ndarray = (1.0, 0.0, 0.0, 0.0)
    """Attitude q_WB (w, x, y, z) [1], (4,)."""
    velocity: Vector = (0.0, 0.0, 0.0)
    """Velocity of the mass centre [m/s], (3,), world axes."""
    angular_velocity: Vector = (0.0, 0.0, 0.0)
    """Angular velocity [rad/s], (3,), world axes."""


@dataclass(frozen=True, slots=True)
class JointFriction:
    """Friction of a joint: a part in proportion to its reaction, a constant part, and a viscous part.

    A moment, with coefficient x radius x reaction, in joints that turn; a force along the axis, with
    coefficient x reaction across the axis, in a PRISMATIC joint.
    """

    coefficient: float
    """Coefficient of friction [1]."""
    radius: float = 0.0
    """Radius at which it acts [m], in joints that turn."""
    constant: float = 0.0
    """Moment that does not depend on the reaction (seals) [N m], in joints that turn."""
    viscous: float = 0.0
    """Moment per relative angular velocity [N m s/rad], in joints that turn."""
    constant_force: float = 0.0
    """Force that does not depend on the reaction (seals) [N], in a PRISMATIC joint."""
    viscous_force: float = 0.0
    """Force per relative speed [N s/m], in a PRISMATIC joint."""


@dataclass(frozen=True, slots=True)
class Joint:
    """A kinematic constraint between two bodies."""

    name: str
    """Unique name."""
    kind: JointKind
    """Motions that it leaves free."""
    body_a: str
    """Name of body a; the axis is fixed in it."""
    body_b: str
    """Name of body b; reactions are those on b."""
    point: Vector
    """Joint point [m], (3,), world, as assembled."""
    axis: Vector | None = None
    """Joint axis [1], (3,), world axes, as assembled; any length. Kinds FIXED and SPHERICAL have none."""
    second_axis: Vector | None = None
    """UNIVERSAL: the axis fixed in b [1], (3,), square to `axis`."""
    friction: JointFriction | None = None
    """Friction, for all kinds but FIXED."""
    point_b: Vector | None = None
    """Joint point of body b [m], (3,), world, as assembled, where it may differ from `point`: a loop that
    may not close.
    """


@dataclass(frozen=True, slots=True)
class Bushing:
    """A compliant connection, unloaded as assembled."""

    name: str
    """Unique name."""
    body_a: str
    """Name of body a; the bushing's axes are fixed in it."""
    body_b: str
    """Name of body b; the bushing's wrench is that on b."""
    point: Vector
    """Bushing point [m], (3,), world, as assembled."""
    axis: Vector
    """Bushing axis [1], (3,), world axes, as assembled."""
    stiffness: tuple[float, float, float, float]
    """Shear [N/m], axial [N/m], bending [N m/rad], torsion [N m/rad]."""
    damping: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    """Shear [N s/m], axial [N s/m], bending [N m s/rad], torsion [N m s/rad]."""


@dataclass(frozen=True, slots=True)
class Spring:
    """A straight spring and damper between two points."""

    name: str
    """Unique name."""
    body_a: str
    """Name of body a."""
    body_b: str
    """Name of body b."""
    point_a: Vector
    """End on a [m], (3,), world, as assembled."""
    point_b: Vector
    """End on b [m], (3,), world, as assembled."""
    stiffness: float
    """Stiffness [N/m]."""
    damping: float
    """Damping [N s/m]."""
    free_length: float | None = None
    """Length without force [m]; None if `preload` is given."""
    preload: float | None = None
    """Tension as assembled [N], negative if the spring pushes; None if `free_length` is given."""


@dataclass(frozen=True, slots=True)
class Torque:
    """A constant moment on a body."""

    name: str
    """Unique name."""
    body: str
    """Name of the body."""
    moment: Vector
    """Moment [N m], (3,), world axes."""


@dataclass(frozen=True, slots=True)
class Force:
    """A force at a point of a body, constant or a table over time; its direction does not turn with the
    body.
    """

    name: str
    """Unique name."""
    body: str
    """Name of the body."""
    forces: Vector | tuple[Vector, ...]
    """Force [N], (3,), or forces at the times of `times`, (n, 3), world axes."""
    times: tuple[float, ...] | np.ndarray | None = None
    """Knots [s], (n,), from 0, increasing; linear between, constant after the last. None for a constant
    force.
    """
    point: Vector | None = None
    """Point at which it acts [m], (3,), world, as assembled; the mass centre if not given."""


@dataclass(frozen=True, slots=True)
class Motor:
    """A speed-controlled motor: proportional and integral action on the speed, within limits of torque and
    power; of a PRISMATIC joint: of force and power.
    """

    gain: float
    """Torque per error of the speed [N m s/rad], or force [N s/m]."""
    integral_gain: float
    """Rate of the torque per error of the speed [N m/rad], or of the force [N/m]."""
    torque_limit: float = math.inf
    """Largest torque [N m] or force [N] either way."""
    power_limit: float = math.inf
    """Largest product of torque or force and speed either way [W]."""
    cut: float = math.inf
    """Time from which it gives no torque or force [s]."""
    restored: float = math.inf
    """Time from which it gives torque or force again [s]."""


@dataclass(frozen=True, slots=True)
class Drive:
    """A motion of a joint's body b relative to its body a, prescribed or by a motor: the rotation about the
    axis of a REVOLUTE or CYLINDRICAL joint, the travel along the axis of a PRISMATIC one.
    """

    name: str
    """Unique name."""
    joint: str
    """Name of a REVOLUTE, CYLINDRICAL or PRISMATIC joint."""
    times: tuple[float, ...] | np.ndarray
    """Knots [s], (n,), from 0, increasing."""
    speeds: tuple[float, ...] | np.ndarray
    """Speeds at the knots [rad/s or m/s], (n,); linear between, constant after the last. Angle and travel are
    zero at the first knot.
    """
    motor: Motor | None = None
    """Motor whose set point these speeds are; None for a prescribed motion."""


@dataclass(frozen=True, slots=True)
class Stop:
    """A one-sided stop without friction: a sphere of body b against a plane or a sphere of body a."""

    name: str
    """Unique name."""
    body_a: str
    """Name of the body with the plane or the other sphere."""
    body_b: str
    """Name of the body with the sphere."""
    point_a: Vector
    """A point of the plane, or the centre of the sphere of a [m], (3,), world, as assembled."""
    point_b: Vector
    """Centre of the sphere of b [m], (3,), world, as assembled."""
    stiffness: float
    """Force per overlap [N/m]."""
    restitution: float
    """Speed of rebound over speed of impact [1], 0.05 to 1."""
    normal: Vector | None = None
    """Normal of the plane towards b [1], (3,), world axes, as assembled; any length. None for a sphere."""
    radius_a: float | None = None
    """Radius of the sphere of a [m]; None for a plane."""
    radius_b: float = 0.0
    """Radius of the sphere of b [m]; zero for a point."""


@dataclass(frozen=True, slots=True)
class Gear:
    """A ratio between the rotations of two joints: a pair of gears, a belt, a chain, without slip or play.

    Each rotation is that of the joint's body b relative to its body a.  If both joints have one body a, as
    two shafts in one housing, the ratio is that of the teeth: negative for outer gears, positive for belts
    and inner gears.  The gear passes torque alone; tooth forces and belt tensions do not load the bearings.
    """

    name: str
    """Unique name."""
    input: str
    """Name of a REVOLUTE or CYLINDRICAL joint."""
    output: str
    """Name of another."""
    ratio: float
    """Rotation of the output over that of the input [1], negative if they turn opposite ways."""


Part = Body | Joint | Bushing | Spring | Torque | Force | Drive | Gear | Stop
"""Any part of a mechanism."""

Load = Bushing | Spring | Torque | Force | Stop
"""A part that exerts forces or moments and constrains nothing."""
