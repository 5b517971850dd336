"""Natural frequencies of a machine: at rest, at speed, with the charge's mass of a mill."""

from typing import NamedTuple

import numpy as np

from nutamill.base.errors import CaseError, Fault
from nutamill.base.units import rpm
from nutamill.case import Case, Machine
from nutamill.case.drawing import FRAME, SHAFT
from nutamill.design.machine_sheet import UNSTABLE
from nutamill.design.weights import with_charge_mass
from nutamill.mechanism.free_motion import free_motion
from nutamill.mechanism.modes import Modes, mass_matrix, modes, static_equilibrium
from nutamill.mechanism.parts import Drive
from nutamill.mechanism.running_modes import running_modes
from nutamill.simulation.setup.altered import turning_drive, without_friction
from nutamill.simulation.setup.mechanism import assemble_machine, mechanism_parts, refuse_unsupported

ANGLES = 6
"""Crank angles over which the coefficients of the turning mill are averaged [1]: exact up to the fifth
order.
"""

SMALL = 0.05
"""Share of the kinetic energy [1] below which a motion of a body is not named."""

WIDEST = 61
"""Characters of the motion of a mode in a table, so that it fits 80 columns [1]."""

MOTIONS = ("sway x", "sway y", "bounce", "rocking about x", "rocking about y", "yaw")
"""Names of the six motions of a frame."""


class MachineModes(NamedTuple):
    """Vibrations of a mill or of any mechanism, slowest first; oscillations only."""

    speed: float
    """Driveshaft speed [rad/s]; 0 at rest."""
    frequency: np.ndarray
    """Undamped natural frequencies [Hz], (n,)."""
    damping_ratio: np.ndarray
    """Shares of critical damping [1], (n,)."""
    shape: np.ndarray
    """Complex displacements of the mass centres and turns of the bodies [m, rad], (n_bodies, 6, n), world
    axes; the largest is 1.
    """
    share: np.ndarray
    """Shares of each body's translation and rotation in the kinetic energy [1], (n_bodies, 2, n)."""
    bodies: tuple[str, ...]
    """Names of the bodies."""

    def label(self, k: int) -> str:
        """Describe mode `k`: of a mill by the motion of the frame or the torsion of the drive train, else by
        the body that moves most.
        """
        if not {FRAME, SHAFT} <= set(self.bodies):
            return self._motions(k)[0][1]
        if self.bodies[int(self.share[:, :, k].sum(axis=1).argmax())] == SHAFT:
            return "torsion of the drive train"
        frame = self.bodies.index(FRAME)
        # at 0.2 m from the mass centre, about where the mounts and the crank are, a turn moves as much as a
        # displacement
        size = np.abs(self.shape[frame, :, k]) * [1.0, 1.0, 1.0, 0.2, 0.2, 0.2]
        motion = MOTIONS[int(size.argmax())]
        x, y = (
            (self.shape[frame, 0:2, k] if motion.startswith("sway") else self.shape[frame, 3:5, k])
            if size[[0, 1, 3, 4]].any()
            else (0, 0)
        )
        if motion in ("bounce", "yaw") or min(abs(x), abs(y)) < 0.5 * max(abs(x), abs(y)):
            return motion
        way = (np.conj(x) * y).imag
        whirl = (
            ""
            if abs(way) < 0.5 * abs(x) * abs(y)
            else (", forward whirl" if way < 0.0 else ", backward whirl")
        )
        return motion.split()[0] + whirl

    def movers(self, k: int) -> str:
        """Describe which bodies move in mode `k`, by their share of the kinetic energy."""
        return ", ".join(f"{motion} {100 * part:.0f} %" for part, motion in self._motions(k) if part >= SMALL)

    def _motions(self, k: int) -> list[tuple[float, str]]:
        """Return the share of each body's translation and rotation in the kinetic energy of mode `k` [1], and
        its name, largest first.
        """
        motions = [
            (float(self.share[b, way, k]), f"{name.replace('_', ' ')} {'turns' if way else 'moves'}")
            for b, name in enumerate(self.bodies)
            for way in (0, 1)
        ]
        return sorted(motions, reverse=True)


def machine_modes(case: Case | Machine, speed: float = 0.0, charge: bool = False) -> MachineModes:
    """Compute the modes of any machine with its drives held at rest, or about running at a steady speed.

    At speed the coefficients of the motion are averaged over `ANGLES` angles of the drive, with what stands
    on springs at its place of rest (`nutamill.mechanism.running_modes`).  Joint friction is left out.

    Parameters
    ----------
    speed : speed of the drive [rad/s], of a mill of its driveshaft
    charge : add the mass of the charge as a ring fixed to the chamber's base

    Raises
    ------
    CaseError : a machine without anything that can vibrate, with a body that nothing holds, or without a
        drive that turns; an equilibrium that is unstable
    StepError : there is no equilibrium near the assembled pose, or no steady motion to vibrate about
    """
    if not speed >= 0.0:
        raise CaseError(Fault("speed", f"must be zero or more, got {speed:g} rad/s"))
    machine = without_friction((with_charge_mass(case) if charge else case).machine)
    refuse_unsupported(machine)
    drives = _at_speed(machine, speed) if speed > 0.0 else None
    mechanism, state, scratch = assemble_machine(machine, drives)
    names = tuple(body.name for body in mechanism_parts(machine).bodies)
    if drives is None:
        static_equilibrium(mechanism, state, scratch)
        vibrations = modes(mechanism, state, scratch)
    else:
        free, rate = free_motion(mechanism, state, scratch)
        static_equilibrium(mechanism, state, scratch)
        times = np.arange(ANGLES) / ANGLES * 2.0 * np.pi / speed
        vibrations, _ = running_modes(mechanism, state, scratch, free, rate, times)
    if np.any(vibrations.damping_ratio <= UNSTABLE):
        raise CaseError(
            Fault("modes", "the equilibrium is unstable", "Assemble the mechanism near a stable one")
        )
    return _named(vibrations, mass_matrix(mechanism, scratch), names, speed)


def _at_speed(machine: Machine, speed: float) -> list[Drive]:
    """Return the drives of a machine with the one that turns it at a steady speed [rad/s].

    Raises
    ------
    CaseError : no drive, or others beside it, whose speed the answer does not know
    """
    turning, drives = turning_drive(machine), mechanism_parts(machine).drives
    if others := [drive.name for drive in drives if drive.name != turning.name]:
        what = f"must be the speed of all that moves, and {', '.join(others)} moves beside {turning.name}"
        raise CaseError(Fault("speed", what, "Leave it out for the modes at rest"))
    return [Drive(turning.name, drives[0].joint, (0.0, 1.0), (speed, speed))]


def _named(vibrations: Modes, mass: np.ndarray, names: tuple[str, ...], speed: float) -> MachineModes:
    """Return the oscillations among the modes, with each body's share of the kinetic energy."""
    chosen = np.flatnonzero(vibrations.damping_ratio < 1.0)
    if np.any(vibrations.frequency < 1e-3):
        raise CaseError(
            Fault(
                "modes",
                "a motion of the machine has no stiffness",
                "Give mounts and shaft_coupling stiffness in that direction",
            )
        )
    if not len(chosen):
        what = "nothing is free to vibrate with the drives held"
        raise CaseError(Fault("modes", what, "Modes are those of bodies on springs or bushings"))
    shape = vibrations.shape[:, :, chosen]
    flat = shape.reshape(-1, len(chosen))
    energy = (flat.conj() * (mass @ flat)).real.reshape(len(names), 2, 3, -1).sum(axis=2)
    return MachineModes(
        speed,
        vibrations.frequency[chosen],
        vibrations.damping_ratio[chosen],
        shape,
        energy / energy.sum(axis=(0, 1)),
        names,
    )


def modes_lines(vibrations: MachineModes) -> list[str]:
    """Format the modes as a table of at most 80 columns, each with the parts that move most."""
    state = "at rest" if vibrations.speed == 0.0 else f"at {rpm(vibrations.speed):.4g} rpm"
    rows = [f"modes {state}", f"{'Hz':>8} {'damping':>8}  motion"]
    for k, (frequency, ratio) in enumerate(zip(vibrations.frequency, vibrations.damping_ratio, strict=True)):
        label, movers = vibrations.label(k), vibrations.movers(k)
        motion = movers if movers.startswith(label) else f"{label}: {movers}"
        while len(motion) > WIDEST and ", " in motion:
            motion = motion.rpartition(", ")[0]
        rows.append(
            f"{frequency:8.3f} {round(100 * ratio, 2) + 0.0:6.2f} %  {motion}"
        )  # + 0.0: no minus zero
    return rows
