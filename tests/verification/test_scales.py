"""A case in other units of length, mass and time, powers of two of the old, gives the same bits, scaled: no
law holds an absolute constant.
"""

import itertools
from typing import NamedTuple

import numpy as np
import pytest
from contact_bench import plain

from nutamill.charge.face import Charge
from nutamill.charge.laws.composition import NORMAL, ROLLING, TANGENTIAL, contact_law, law_numbers
from nutamill.charge.laws.pair import PairLaw
from nutamill.charge.particles.particles import spheres
from nutamill.charge.walls.surface import Surface, SurfaceKind
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

X, Z = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)


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
    """A motor turns a crank with a pendulum and a slide: friction in all joints, a spring, a mount."""
    m, kg, inertia = units.of(1), units.of(0, 1), units.of(2, 1)
    force, moment, rate = units.of(1, 1, -2), units.of(2, 1, -2), units.of(0, 0, -1)
    friction = JointFriction(0.05, 0.01 * m, 0.003 * moment, 0.001 * moment / rate)
    rubbing = JointFriction(0.05, constant_force=0.03 * force, viscous_force=0.01 * force / m / rate)
    end = (0.11 * m, 0.02 * m, 0.0)
    bodies = [
        Body("frame", 5.0 * kg, np.diag([0.3, 0.2, 0.4]) * inertia, (0.0, 0.0, -0.3 * m)),
        Body("crank", 0.7 * kg, np.diag([0.003, 0.004, 0.005]) * inertia, (0.05 * m, 0.0, 0.0)),
        Body("bob", 0.4 * kg, np.diag([0.002, 0.001, 0.002]) * inertia, (0.11 * m, 0.02 * m, -0.13 * m)),
        Body("slide", 0.1 * kg, np.diag([2e-4, 2e-4, 1e-4]) * inertia, (0.12 * m, 0.02 * m, 0.0)),
    ]
    joints = [
        Joint("bearing", JointKind.REVOLUTE, "frame", "crank", (0.0, 0.0, 0.0), Z, friction=friction),
        Joint("pin", JointKind.SPHERICAL, "crank", "bob", end, friction=friction),
        Joint("rail", JointKind.PRISMATIC, "crank", "slide", end, X, friction=rubbing),
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
        "drive_torque": OTHER.of(2, 1, -2),
        "loss": OTHER.of(2, 1, -2),
    }.items():
        assert (getattr(other.state, name) == factor * getattr(one.state, name)).all(), name


def falling_balls(units: Units) -> Charge:
    """Balls of two sizes fall and roll into a corner and onto each other; standard law, single precision."""
    m, speed, rate = units.of(1), units.of(1, 0, -1), units.of(0, 0, -1)
    steel = PairLaw(2e4 * units.of(0, 1, -2), 0.0, 0.0, 0.8, 0.15, False, 0.4, 0.3, 0.02, 0.2, 0.4)
    rng = np.random.default_rng(3)
    grid = np.stack(np.meshgrid(range(2), range(2), range(2), indexing="ij"), -1).reshape(-1, 3)
    centres = (0.011 * grid + [0.006, 0.006, 0.0055] + 4e-4 * rng.random((8, 3))) * m
    diameters = np.where(np.arange(8) % 3 == 0, 0.008, 0.01) * m
    walls = [
        Surface("floor", SurfaceKind.PLANE, 0, 0),
        Surface(
            "side",
            SurfaceKind.PLANE,
            0,
            0,
            rotation=np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]),
        ),
    ]
    return Charge(
        spheres(diameters).placed(centres),
        [7850.0 * units.of(-3, 1)],
        steel,
        walls,
        dt=8e-6 * units.time,
        gravity=(-2.0 * units.of(1, 0, -2), 1.0 * units.of(1, 0, -2), -9.81 * units.of(1, 0, -2)),
        velocities=speed * rng.normal(size=(8, 3)) * 0.2,
        spins=rate * rng.normal(size=(8, 3)) * 20.0,
    )


def test_charge_in_other_units_gives_the_same_bits():
    one, other = falling_balls(Units()), falling_balls(OTHER)
    for charge in (one, other):
        charge.step(5000)
    assert (one.largest_overlap > 0.0).all()
    assert (other.positions == OTHER.of(1) * one.positions).all()
    assert (other.velocities == OTHER.of(1, 0, -1) * one.velocities).all()
    assert (other.spins == OTHER.of(0, 0, -1) * one.spins).all()
    assert (other.wrenches[:, :3] == OTHER.of(1, 1, -2) * one.wrenches[:, :3]).all()
    ours, theirs = one.reading(), other.reading()
    assert (theirs.energy == OTHER.of(2, 1, -2) * ours.energy).all()


STATES = {
    "in motion": (2e-5, 0.3, 20.0, 1e-6, 1e-3),
    "at rest": (2e-5, 0.0, 0.0, 0.0, 0.0),
    "as good as at rest": (2e-5, 1e-6, 1e-6, 0.0, 0.0),
    "as good as apart": (1e-16, 0.0, 0.0, 2e-15, 1e-15),
}
"""Overlap [m], slip [m/s], spin [rad/s], lengths of the tangential [m] and of the rolling spring [rad]."""


def one_contact(names, units: Units, state) -> np.ndarray:
    """Force, moment and memory of a contact under any law, in units of the first case."""
    law = contact_law(*names, "area")
    pair = PairLaw(
        1e4 * units.of(0, 1, -2),
        0.0,
        0.0,
        0.7,
        0.2,
        True,
        0.5,
        0.4,
        0.1,
        0.3,
        0.4,
        unloading_ratio=3.0,
        contact_modulus=1e7 * units.of(-1, 1, -2),
        contact_shear_modulus=4e6 * units.of(-1, 1, -2),
        cohesive_pressure=1e4 * units.of(-1, 1, -2),
        tangential_damping=0.3,
        rolling_stiffness=0.02 * units.of(2, 1, -2),
    )
    overlap, slip, spin, spring, rolled = (np.float32(number) for number in state)
    stored = units.of(1) if names[1] == "displacement" else units.of(1, 1, -2)
    m, speed, rate = units.of(1), units.of(1, 0, -1), units.of(0, 0, -1)

    def vector(size, *direction):
        return tuple(np.float32(size * part) for part in direction)

    force, _, moment, spring, rolled, sliding, history, powers = plain(
        law,
        vector(1.0, 0.0, 0.6, 0.8),
        np.float32(overlap * m),
        vector(slip * speed, 1.0, 0.5, -0.4),
        vector(spin * rate, 0.3, 1.0, 0.2),
        vector(spring * stored, 1.0, -0.8, 0.6),
        vector(rolled, 1.0, 0.8, -0.6),
        np.float32(0.0),
        np.float32(0.5 * overlap * m),
        np.float32(1e-3 * units.of(0, 1)),
        np.float32(2e-3 * m),
        vector(m, 4e-3, 6e-3),
        tuple(np.float32(number) for number in law_numbers(law, pair)),
        np.float32(2e-6 * units.time),
    )
    energy = units.of(2, 1, -2)
    parts = (force, units.of(1, 1, -2)), (moment, energy), (spring, stored), (rolled, 1.0)
    parts += ((sliding, history / m), 1.0), (powers, energy * rate)
    return np.concatenate([np.array(part) / np.float32(factor) for part, factor in parts])


@pytest.mark.parametrize("names", list(itertools.product(NORMAL, TANGENTIAL, ROLLING)), ids="-".join)
def test_contact_in_other_units_gives_the_same_bits(names):
    for name, state in STATES.items():
        with np.errstate(all="raise", under="ignore"):
            one, other = (one_contact(names, units, state) for units in (Units(), OTHER))
        assert np.isfinite(one).all()
        assert (one == other).all(), name
