"""Natural frequencies of a machine: at rest, at speed, with the charge's mass of a mill, and the speeds to
avoid.
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

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
ORDERS = (1.0, 2.0)
"""Excitations per turn: unbalance, and the ripple of the universal joint."""

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


class Avoid(NamedTuple):
    """A driveshaft speed that meets a natural frequency."""

    speed: float
    """Driveshaft speed [rad/s]."""
    order: float
    """Excitations per turn [1]."""
    frequency: float
    """Natural frequency there [Hz]."""
    damping_ratio: float
    """Share of critical damping there [1]."""
    label: str
    """Which mode it is."""


class Campbell(NamedTuple):
    """Natural frequencies over speed, each column one mode followed by its shape."""

    speeds: np.ndarray
    """Driveshaft speeds [rad/s], (n_speeds,)."""
    frequency: np.ndarray
    """Natural frequencies [Hz], (n_speeds, n_modes)."""
    damping_ratio: np.ndarray
    """Shares of critical damping [1], (n_speeds, n_modes)."""
    labels: tuple[str, ...]
    """What each mode is like at the first speed."""
    avoid: tuple[Avoid, ...]
    """Where the orders 1 and 2 meet them, slowest first."""
    working: float
    """Driveshaft speed of the case [rad/s]."""


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


def campbell(
    case: Case | Machine, fastest: float | None = None, count: int = 8, charge: bool = False
) -> Campbell:
    """Compute the natural frequencies of a machine from rest to a speed, and the speeds at which it is
    excited once or twice per period.

    Parameters
    ----------
    fastest : highest speed of the drive [rad/s]; 1.2 times the case's if None
    count : number of speeds
    charge : as in `machine_modes`

    Raises
    ------
    CaseError : a machine without a drive that turns, or one of which `machine_modes` has none
    """
    working = turning_drive(case.machine).speed
    speeds = np.linspace(0.0, 1.2 * working if fastest is None else fastest, count)
    first = machine_modes(case, 0.0, charge)
    n = len(first.frequency)
    frequency, damping = np.empty((count, n)), np.empty((count, n))
    frequency[0], damping[0], before = first.frequency, first.damping_ratio, first
    for k, speed in enumerate(speeds[1:], start=1):
        vibrations = machine_modes(case, speed, charge)
        if len(vibrations.frequency) != n:
            raise CaseError(
                Fault(
                    "campbell",
                    f"the number of modes changes with the speed: {n} at rest, "
                    f"{len(vibrations.frequency)} at {rpm(speed):.4g} rpm",
                    "Choose a lower speed",
                )
            )
        order = linear_sum_assignment(-_likeness(before, vibrations))[1]
        before = MachineModes(
            speed,
            vibrations.frequency[order],
            vibrations.damping_ratio[order],
            vibrations.shape[..., order],
            vibrations.share[..., order],
            vibrations.bodies,
        )
        frequency[k], damping[k] = before.frequency, before.damping_ratio
    # at rest forward and backward whirls are the same shape: the labels are those of the last speed
    labels = tuple(before.label(k) for k in range(n))
    return Campbell(
        speeds,
        frequency,
        damping,
        labels,
        tuple(sorted(_crossings(speeds, frequency, damping, labels))),
        working,
    )


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


def _likeness(before: MachineModes, after: MachineModes) -> np.ndarray:
    """Compute the modal assurance criterion of two sets of shapes, less the relative distance of the
    frequencies, (n, n).

    Source: Allemang, Sound and Vibration 37(8), 14-21, 2003.
    """
    a, b = (part.shape.reshape(-1, part.shape.shape[-1]) for part in (before, after))
    mac = np.abs(a.conj().T @ b) ** 2 / np.outer((np.abs(a) ** 2).sum(axis=0), (np.abs(b) ** 2).sum(axis=0))
    return mac - np.abs(np.log(after.frequency[None, :] / before.frequency[:, None]))


def _crossings(speeds: np.ndarray, frequency: np.ndarray, damping: np.ndarray, labels: tuple[str, ...]):
    """Yield the speeds where order times speed equals a natural frequency, linear between speeds."""
    for order in ORDERS:
        for k, label in enumerate(labels):
            over = frequency[:, k] - order * speeds / (2.0 * np.pi)
            for i in np.flatnonzero((over[:-1] > 0.0) & (over[1:] <= 0.0)):
                s = over[i] / (over[i] - over[i + 1])
                at = [
                    float(row[i] + s * (row[i + 1] - row[i]))
                    for row in (speeds, frequency[:, k], damping[:, k])
                ]
                yield Avoid(at[0], order, at[1], at[2], label)


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


def avoid_lines(diagram: Campbell) -> list[str]:
    """Format the speeds to avoid as a table."""
    rows = [
        f"speeds to avoid up to {rpm(diagram.speeds[-1]):.4g} rpm",
        f"{'rpm':>8}  order  {'Hz':>8}  {'damping':>8}  motion",
    ]
    for at in diagram.avoid:
        rows.append(
            f"{rpm(at.speed):8.1f}  {at.order:4.0f}x  {at.frequency:8.3f}  "
            f"{100 * at.damping_ratio:6.2f} %  {at.label}"
        )
    return rows
