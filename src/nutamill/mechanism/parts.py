"""What a mechanism is made of, as a person describes it: frozen data, SI, world coordinates as assembled.

`nutamill.mechanism.assembly.assemble` checks these and turns them into arrays.
"""

import math
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

GROUND = "ground"
"""Name of the body that never moves."""

Vector = tuple[float, float, float] | np.ndarray


class JointKind(IntEnum):
    """What a joint lets body b do relative to body a."""

    FIXED = 0
    """Nothing."""
    REVOLUTE = 1
    """Turn about the axis."""
    SPHERICAL = 2
    """Turn about the point."""
    UNIVERSAL = 3
    """Turn about `axis` of a and about `second_axis` of b (Hooke joint)."""
    CYLINDRICAL = 4
    """Turn about and slide along the axis."""
    PRISMATIC = 5
    """Slide along the axis."""
    POINT_ON_LINE = 6
    """Turn freely; the point of b slides on the line of a along the axis ("sphere and cylinder")."""


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
    """Friction moment of a joint: coefficient x radius x reaction, a constant part, and a viscous part."""

    coefficient: float
    """Coefficient of friction [1]."""
    radius: float
    """Radius at which it acts [m]."""
    constant: float = 0.0
    """Moment that does not depend on the reaction (seals) [N m]."""
    viscous: float = 0.0
    """Moment per relative angular velocity [N m s/rad]."""


@dataclass(frozen=True, slots=True)
class Joint:
    """A kinematic constraint between two bodies."""

    name: str
    """Unique name."""
    kind: JointKind
    """What it lets b do relative to a."""
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
    """Friction, for joints that turn."""
    point_b: Vector | None = None
    """Where body b has its point [m], (3,), world, as assembled, if it may differ from `point` (a loop that
    may not close).
    """


@dataclass(frozen=True, slots=True)
class Bushing:
    """A compliant connection, without load as assembled."""

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
    free_length: float
    """Length without force [m]."""


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
class Motor:
    """A motor whose speed is not prescribed but controlled: proportional and integral action on the speed,
    within its limits.
    """

    gain: float
    """Torque per error of the speed [N m s/rad]."""
    integral_gain: float
    """Rate of the torque per error of the speed [N m/rad]."""
    torque_limit: float = math.inf
    """Largest torque either way [N m]."""
    power_limit: float = math.inf
    """Largest product of torque and speed either way [W]."""
    cut: float = math.inf
    """Time from which it gives no torque [s]."""
    restored: float = math.inf
    """Time from which it works again [s]."""


@dataclass(frozen=True, slots=True)
class Drive:
    """What turns a joint's body b relative to its body a about the joint's axis: a prescribed rotation, or a
    motor asked for it.
    """

    name: str
    """Unique name."""
    joint: str
    """Name of a REVOLUTE or CYLINDRICAL joint."""
    times: tuple[float, ...] | np.ndarray
    """Knots [s], (n,), from 0, increasing."""
    speeds: tuple[float, ...] | np.ndarray
    """Speeds at the knots [rad/s], (n,); linear between, constant after the last. The angle is zero at the
    first knot.
    """
    motor: Motor | None = None
    """The motor that is to reach these speeds; a prescribed rotation if None."""
