"""An unbalance motor as parts: an eccentric rotor, its bearing on a body, and the drive that turns it.

It has no equation of its own.  Its force on the body, its torque, the power it takes from its drive and its
answer to the motion of the body are those of a rotor in a joint.
"""

from dataclasses import dataclass

import numpy as np

from nutamill.base.errors import CaseError, Fault
from nutamill.mechanism.number_checks import not_numbers
from nutamill.mechanism.parts import Body, Drive, Joint, JointKind, Motor, Vector


@dataclass(frozen=True, slots=True)
class UnbalanceMotor:
    """A rotor with a mass off its axis, driven relative to the body that carries it."""

    name: str
    """Unique name; that of its body, its joint and its drive, too."""
    body: str
    """Name of the body that carries it."""
    point: Vector
    """Point of the axis opposite the eccentric mass [m], (3,), world, as assembled."""
    axis: Vector
    """Axis about which it turns by the right hand [1], (3,), world axes, as assembled; any length."""
    towards: Vector
    """Direction from the axis to the eccentric mass as assembled [1], (3,), square to the axis; any
    length.
    """
    mass: float
    """Mass of the rotor [kg]."""
    eccentricity: float
    """Distance of its mass centre from the axis [m]."""
    times: tuple[float, ...] | np.ndarray
    """Knots of the drive [s], as of a `Drive`."""
    speeds: tuple[float, ...] | np.ndarray
    """Speeds at the knots [rad/s], as of a `Drive`."""
    inertia: float | None = None
    """Moment of inertia about its own mass centre, in every direction [kg m^2]; that of a ball whose radius
    is the eccentricity if not given.
    """
    motor: Motor | None = None
    """Motor whose set point the speeds are; None for a prescribed rotation."""

    def parts(self) -> tuple[Body, Joint, Drive]:
        """Return rotor, bearing and drive.

        Raises
        ------
        CaseError : with every number that no rotor has
        """
        faults = [*self._faults()]
        if faults:
            raise CaseError(*faults)
        towards = np.asarray(self.towards, float) / np.linalg.norm(self.towards)
        centre = np.asarray(self.point, float) + self.eccentricity * towards
        inertia = 0.4 * self.mass * self.eccentricity**2 if self.inertia is None else self.inertia
        return (
            Body(self.name, self.mass, inertia * np.eye(3), centre),
            Joint(self.name, JointKind.REVOLUTE, self.body, self.name, self.point, self.axis),
            Drive(self.name, self.name, self.times, self.speeds, self.motor),
        )

    def _faults(self):
        where = f"unbalance motor {self.name!r}"
        shapes = {"point": (3,), "axis": (3,), "towards": (3,), "mass": (), "eccentricity": ()}
        if self.inertia is not None:
            shapes["inertia"] = ()
        wrong = {name: not_numbers(getattr(self, name), shape) for name, shape in shapes.items()}
        if any(wrong.values()):
            yield from (Fault(where, f"{name} is {what}") for name, what in wrong.items() if what)
            return
        for name in shapes:
            value = getattr(self, name)
            if name in ("axis", "towards") and not np.linalg.norm(value) > 0.0:
                yield Fault(where, f"{name} has no length, got {value}")
            elif shapes[name] == () and not value > 0.0:
                yield Fault(where, f"{name} is not positive, got {value:g}")
        size = np.linalg.norm(self.axis) * np.linalg.norm(self.towards)
        if size > 0.0 and abs(np.dot(self.axis, self.towards)) > 1e-9 * size:
            yield Fault(where, f"towards is not square to the axis, got {self.towards} and {self.axis}")
