"""A multibody system to march from a script: parts in, motions and reactions by name out.

The state, the equations and the sensors are those of every run (`nutamill.mechanism.dynamics`); a `System`
only finds parts by their names.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from nutamill.base.errors import CaseError, Fault, StepError
from nutamill.mechanism.assembly import assemble
from nutamill.mechanism.dynamics import OK, march, start
from nutamill.mechanism.effective_mass import effective_mass
from nutamill.mechanism.energy import energies
from nutamill.mechanism.modes import Modes, modes, static_equilibrium
from nutamill.mechanism.number_checks import not_numbers
from nutamill.mechanism.parts import Body, Bushing, Drive, Force, Gear, Joint, Load, Spring, Stop, Torque
from nutamill.mechanism.probes import (
    bushing_wrench,
    gear_torque,
    joint_reaction,
    point_position,
    spring_length_pull,
    stop_force_gap,
)
from nutamill.mechanism.sensors import names_of
from nutamill.mechanism.stop_tables import step_faults


class Wrench(NamedTuple):
    """A force, a moment, and the point about which the moment is taken."""

    force: np.ndarray
    """Force [N], (3,)."""
    moment: np.ndarray
    """Moment about `point` [N m], (3,)."""
    point: np.ndarray
    """Point [m], (3,), world."""


class Energy(NamedTuple):
    """Mechanical energy of a system."""

    kinetic: float
    """Kinetic energy of the bodies [J]."""
    potential: float
    """Potential energy of gravity [J], zero with all mass centres at the world's origin."""
    elastic: float
    """Energy stored in bushings and springs [J]."""

    @property
    def total(self) -> float:
        """Sum of the three [J]."""
        return sum(self)


class StopContact(NamedTuple):
    """Force and gap of a stop."""

    force: float
    """Force that pushes the bodies apart [N]; zero where they do not touch."""
    gap: float
    """Distance between the surfaces [m], negative where they overlap."""


class System:
    """Rigid bodies, joints, loads and drives, ready to march; SI, world coordinates as assembled.

    Parameters
    ----------
    bodies : the moving bodies; `nutamill.mechanism.parts.GROUND` is the body that never moves
    joints : constraints between two bodies
    loads : bushings, springs, constant torques, given forces and stops
    drives : motions of joints, prescribed or by a motor
    gravity : acceleration [m/s^2], (3,), world axes
    redundant : "refuse" constraints that depend on others, or "allow" them (their reactions are not unique)
    gears : ratios between the rotations of two joints

    Attributes
    ----------
    mechanism, state, scratch : the arrays of the engine, for its kernels

    Raises
    ------
    CaseError : with every fault of the parts
    StepError : the first accelerations are not finite
    """

    def __init__(
        self,
        bodies: Sequence[Body],
        joints: Sequence[Joint] = (),
        loads: Sequence[Load] = (),
        drives: Sequence[Drive] = (),
        gravity: tuple[float, float, float] = (0.0, 0.0, -9.81),
        redundant: str = "refuse",
        gears: Sequence[Gear] = (),
    ):
        kinds = (Bushing, Spring, Torque, Force, Stop)
        unknown = [load for load in loads if not isinstance(load, kinds)]
        if unknown:
            what = ", ".join(type(load).__name__ for load in unknown)
            raise CaseError(
                Fault("loads", f"not a load, got {what}", "Give Bushing, Spring, Torque, Force or Stop")
            )
        self.mechanism, self.state, self.scratch = assemble(
            bodies,
            joints,
            [load for load in loads if isinstance(load, Bushing)],
            [load for load in loads if isinstance(load, Spring)],
            [load for load in loads if isinstance(load, Torque)],
            drives,
            gravity,
            redundant,
            [load for load in loads if isinstance(load, Force)],
            gears,
            [load for load in loads if isinstance(load, Stop)],
        )
        self._names = names_of(self.mechanism)
        if start(self.mechanism, self.state, self.scratch) != OK:
            raise StepError(
                "first accelerations: they are not finite. Look at the masses and inertias of the bodies."
            )

    @property
    def time(self) -> float:
        """Time [s]."""
        return float(self.state.time[0])

    def step(self, dt: float) -> None:
        """Make one step of `dt` [s]. Raises as `march` does."""
        self.march(dt, dt)

    def march(self, duration: float, dt: float) -> None:
        """March on for `duration` [s] in equal steps of at most `dt` [s].

        Raises
        ------
        CaseError : a duration or a step that is not positive, or a step too long for the contact of a stop
        StepError : the motion is not finite, and the system is lost
        """
        faults = [
            Fault(name, f"not a positive number, got {value!r}", "Give seconds")
            for name, value in (("duration", duration), ("dt", dt))
            if not_numbers(value, ()) or not value > 0.0
        ]
        if faults:
            raise CaseError(*faults)
        steps = max(1, math.ceil(duration / dt * (1.0 - 1e-12)))
        if faults := step_faults(self.mechanism, "dt", duration / steps):
            raise CaseError(*faults)
        if march(self.mechanism, self.state, self.scratch, duration / steps, steps) != OK:
            raise StepError(
                f"t = {self.time:.6g} s: the motion is not finite. Take a shorter step and look at "
                "stiffnesses and small inertias."
            )

    def rest(self, hold_drives: bool = True) -> None:
        """Move the bodies to static equilibrium under weights, loads and applied wrenches.

        Parameters
        ----------
        hold_drives : lock the present angles of the drives; otherwise driven joints turn freely

        Raises
        ------
        StepError : there is no equilibrium
        """
        static_equilibrium(self.mechanism, self.state, self.scratch, hold_drives=hold_drives)

    def modes(self, loose: str = "refuse") -> Modes:
        """Compute the small vibrations about the present pose, drives locked.

        Call `rest` first.

        Parameters
        ----------
        loose : "refuse" motions without a restoring force, or "keep" them as modes of frequency zero

        Raises
        ------
        CaseError : the motions without a restoring force
        """
        return modes(self.mechanism, self.state, self.scratch, loose)

    def apply(self, body: str, force: Sequence[float], moment: Sequence[float] = (0.0, 0.0, 0.0)) -> None:
        """Apply a force [N] at the mass centre of a body and a moment [N m], world axes, to every step from
        now on. They take the place of those applied before.
        """
        faults = [
            Fault(name, f"it is {wrong}", "Give a vector in world axes")
            for name, value in (("force", force), ("moment", moment))
            if (wrong := not_numbers(value, (3,)))
        ]
        if faults:
            raise CaseError(*faults)
        index = self._index("body", body)
        # what is applied is constant, not the mean of something that changes: nothing to extrapolate
        self.state.wrench[index] = self.state.earlier_wrench[index] = [*force, *moment]

    def position(self, body: str) -> np.ndarray:
        """Return the mass centre of a body [m], (3,), world."""
        return self.state.position[self._index("body", body)].copy()

    def attitude(self, body: str) -> np.ndarray:
        """Return the quaternion (w, x, y, z) of a body from its axes to world axes [1], (4,)."""
        return self.state.quaternion[self._index("body", body)].copy()

    def velocity(self, body: str) -> np.ndarray:
        """Return the velocity of the mass centre of a body [m/s], (3,), world axes."""
        return self.state.velocity[self._index("body", body)].copy()

    def angular_velocity(self, body: str) -> np.ndarray:
        """Return the angular velocity of a body [rad/s], (3,), world axes."""
        return self.state.angular_velocity[self._index("body", body)].copy()

    def reaction(self, joint: str) -> Wrench:
        """Return the wrench that a joint exerts on its body b about the joint's point on b, world axes.

        The friction of the joint is part of it, the torque of a drive is not (`torque`).
        """
        return self._wrench("joint", joint, self.mechanism.joints, joint_reaction, ())

    def load(self, bushing: str) -> Wrench:
        """Return the wrench that a bushing exerts on its body b about its point on b, force and moment in
        bushing axes.
        """
        return self._wrench("bushing", bushing, self.mechanism.bushings, bushing_wrench, (self.scratch,))

    def torque(self, drive: str) -> float:
        """Return the torque of a drive on body b of its joint about the joint's axis [N m], or its force
        along it [N].
        """
        return float(self.state.drive_torque[self._index("drive", drive)])

    def effective_mass(
        self, body: str, point: Sequence[float], direction: Sequence[float] | None = None
    ) -> float:
        """Return the mass [kg] with which a body answers a push at a world point [m] (3,), through its joints
        and prescribed rotations. It is infinite where they hold the point.

        Parameters
        ----------
        direction : of the push (3,), world axes; None for the direction in which the mass is least
        """
        index = self._index("body", body)
        return effective_mass(self.mechanism, self.state, self.scratch, index, point, direction)

    def gear_torque(self, gear: str) -> float:
        """Return the torque of a gear on body b of its output about the output's axis [N m].

        Body b of the input feels minus the ratio times this torque.
        """
        return float(gear_torque(self.mechanism, self.state, self._index("gear", gear)))

    def contact(self, stop: str) -> StopContact:
        """Return force and gap of a stop."""
        index = self._index("stop", stop)
        return StopContact(*stop_force_gap(self.mechanism, self.state, self.scratch, index))

    def tension(self, spring: str) -> float:
        """Return the tension of a spring and its damper [N], negative if it pushes."""
        index = self._index("spring", spring)
        return float(spring_length_pull(self.mechanism, self.state, self.scratch, index)[1])

    def energy(self) -> Energy:
        """Return the present mechanical energy."""
        out = np.zeros(3)
        energies(self.mechanism, self.state, self.scratch, out)
        return Energy(*out.tolist())

    def _wrench(self, kind, name, table, probe, scratch) -> Wrench:
        index, out = self._index(kind, name), np.zeros(6)
        probe(self.mechanism, self.state, *scratch, index, out)
        point = point_position(self.state, table[index].body_b, table[index].point_b)
        return Wrench(out[:3], out[3:], np.array(point))

    def _index(self, kind: str, name: str) -> int:
        names = self._names[kind]
        if name not in names:
            known = ", ".join(names) or "none"
            raise CaseError(Fault(f"{kind} {name!r}", f"unknown {kind}", f"Known are {known}"))
        return names.index(name)
