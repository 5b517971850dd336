"""A case in other units of length, mass and time, powers of two of the old, gives the same bits, scaled: no
law holds an absolute constant.
"""

from typing import NamedTuple

import numpy as np

from nutamill.mechanism.parts import (
    GROUND,
    Body,
    Bushing,
    Drive,
    Joint,
    JointFriction,
    JointKind,
    Motor,
    Spring,
)
from nutamill.mechanism.system import System

Z = (0.0, 0.0, 1.0)


class Units(NamedTuple):
    """What one unit of length, mass and time of a case is in those of the first."""

    length: float = 1.0
    mass: float = 1.0
    time: float = 1.0

    def of(self, length=0, mass=0, time=0) -> float:
        """Return the factor of a quantity of these dimensions."""
        return self.length**length * self.mass**mass * self.time**time


OTHER = Units(2.0**-7, 2.0**11, 2.0**5)
"""Powers that no product of dimensions of a law brings back to one."""


def rubbing_machine(units: Units) -> System:
    """A motor turns a crank that carries a pendulum: friction in both joints, a spring, a mount, gravity."""
    m, kg, inertia = units.of(1), units.of(0, 1), units.of(2, 1)
    force, moment, rate = units.of(1, 1, -2), units.of(2, 1, -2), units.of(0, 0, -1)
    friction = JointFriction(0.05, 0.01 * m, 0.003 * moment, 0.001 * moment / rate)
    end = (0.11 * m, 0.02 * m, 0.0)
    bodies = [
        Body("frame", 5.0 * kg, np.diag([0.3, 0.2, 0.4]) * inertia, (0.0, 0.0, -0.3 * m)),
        Body("crank", 0.7 * kg, np.diag([0.003, 0.004, 0.005]) * inertia, (0.05 * m, 0.0, 0.0)),
        Body("bob", 0.4 * kg, np.diag([0.002, 0.001, 0.002]) * inertia, (0.11 * m, 0.02 * m, -0.13 * m)),
    ]
    joints = [
        Joint("bearing", JointKind.REVOLUTE, "frame", "crank", (0.0, 0.0, 0.0), Z, friction=friction),
        Joint("pin", JointKind.SPHERICAL, "crank", "bob", end, friction=friction),
    ]
    stiff, bend = force / m, moment
    loads = [
        Bushing(
            "mount",
            GROUND,
            "frame",
            (0.0, 0.0, -0.4 * m),
            Z,
            (9e3 * stiff, 2e4 * stiff, 400 * bend, 300 * bend),
            (20 * stiff / rate, 30 * stiff / rate, bend / rate, bend / rate),
        ),
        Spring(
            "spring",
            GROUND,
            "bob",
            (0.3 * m, 0.1 * m, -0.2 * m),
            bodies[2].position,
            30.0 * stiff,
            0.4 * stiff / rate,
            0.2 * m,
        ),
    ]
    motor = Motor(0.05 * moment / rate, 0.2 * moment, 0.4 * moment, 2.0 * moment * rate)
    drives = [Drive("motor", "bearing", (0.0, 0.3 / rate), (0.0, 25.0 * rate), motor)]
    return System(bodies, joints, loads, drives, gravity=(0.0, 0.0, -9.81 * units.of(1, 0, -2)))


def test_mechanism_in_other_units_gives_the_same_bits():
    one, other = rubbing_machine(Units()), rubbing_machine(OTHER)
    one.march(0.2, 1e-3)
    other.march(0.2 * OTHER.time, 1e-3 * OTHER.time)
    speed = np.abs(one.state.angular_velocity[1:3]).max(axis=1)
    assert (speed > 1.0).all() and (one.state.loss > 0.0).all()
    for name, factor in {
        "position": OTHER.of(1),
        "quaternion": 1.0,
        "velocity": OTHER.of(1, 0, -1),
        "angular_velocity": OTHER.of(0, 0, -1),
        "friction_moment": OTHER.of(2, 1, -2),
        "drive_torque": OTHER.of(2, 1, -2),
        "loss": OTHER.of(2, 1, -2),
    }.items():
        assert (getattr(other.state, name) == factor * getattr(one.state, name)).all(), name
