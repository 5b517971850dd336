"""Isolation: which share of the shaking force of a machine what it stands on passes on to the floor, over
speed.
"""

from typing import NamedTuple

import numpy as np

from nutamill.analysis.mounts import floor_series
from nutamill.analysis.orders import track
from nutamill.base.errors import CaseError, Fault
from nutamill.base.units import rpm
from nutamill.case import Case, Machine
from nutamill.design.empty import empty_series, once_per_turn, steady_series
from nutamill.design.modes import machine_modes
from nutamill.design.weights import with_charge_mass
from nutamill.simulation.setup.altered import angle_series, bolted, driven, supports, turning_drive

SLOW = 20.0
"""Time of the ramp to full speed [s]: slow beside the decay of the vibrations of soft mounts."""


class Isolation(NamedTuple):
    """Transmissibility of the mounts and the shaft coupling over speed."""

    speed: np.ndarray
    """Driveshaft speeds [rad/s], (n,)."""
    transmitted: np.ndarray
    """Amplitude of the horizontal force on the floor once per turn [N], (n,)."""
    shaking: np.ndarray
    """The same with the frame bolted to the floor [N], (n,)."""
    single: np.ndarray
    """Transmissibility of one mass on a spring with frequency and damping of the lowest mode [1], (n,)."""

    @property
    def transmissibility(self) -> np.ndarray:
        """Force on the floor over the shaking force [1], (n,)."""
        return self.transmitted / self.shaking


def transmissibility(ratio: np.ndarray, damping_ratio: float) -> np.ndarray:
    """Compute the force transmitted by one mass on spring and damper over the exciting force [1], at `ratio`
    of frequencies [1].

    Source: Inman, Engineering Vibration, 4th ed., 2014, section 2.4.
    """
    spread = (2.0 * damping_ratio * ratio) ** 2
    return np.sqrt((1.0 + spread) / ((1.0 - ratio**2) ** 2 + spread))


def isolation(case: Case | Machine, charge: bool = False) -> Isolation:
    """Compute the force on the floor of the empty machine on a slow run-up, and the shaking force of the same
    machine bolted down.

    Parameters
    ----------
    charge : with the mass of the charge fixed to the chamber's base

    Raises
    ------
    CaseError : a machine without bushings to the ground, or without a drive that turns
    """
    machine = (with_charge_mass(case) if charge else case).machine
    if not supports(machine):
        what = "must stand on bushings, nothing else is between it and the ground"
        hint = "A machine bolted down passes on the whole force. Set mechanism.mounting=flexible for a mill"
        raise CaseError(Fault(machine.name, what, hint))
    full = turning_drive(machine).speed
    shaking = shaking_unbalance(machine, full)
    series = empty_series(driven(machine, SLOW, ramp=full / SLOW))
    force, angle = floor_series(series, machine), series[angle_series(machine)]
    sides = [track(series["time"], angle, force[:, k], (1.0,)) for k in (0, 1)]
    transmitted = np.sqrt(0.5 * (sides[0].amplitude[0] ** 2 + sides[1].amplitude[0] ** 2))
    speed = sides[0].speed
    lowest = machine_modes(machine)
    single = transmissibility(speed / (2.0 * np.pi * lowest.frequency[0]), float(lowest.damping_ratio[0]))
    return Isolation(speed, transmitted, abs(shaking) * speed**2, single)


def shaking_unbalance(machine: Machine, speed: float) -> complex:
    """Compute the unbalance of a whole machine [kg m]: force on the floor once per period, bolted down, over
    speed squared. Its direction towards the pin of a mill is real.

    ``F_x = Re(U speed^2 exp(i angle))`` for a mass on the side of the crank pin.
    """
    fixed = bolted(machine)
    series = steady_series(fixed, speed)
    c = once_per_turn(series[angle_series(fixed)], floor_series(series, fixed))
    return complex(0.5 * (c[0] + 1j * c[1]) / speed**2)  # the part that turns forward


def isolation_lines(answer: Isolation, count: int = 8) -> list[str]:
    """Format the transmissibility at some speeds as a table."""
    rows = ["force on the floor once per turn, over the shaking force of the mill bolted down"]
    rows.append(f"{'rpm':>8} {'floor (N)':>10} {'shaking (N)':>12} {'passed on':>10} {'one mass':>9}")
    for speed in np.linspace(answer.speed[0], answer.speed[-1], count + 1)[1:]:
        k = int(np.abs(answer.speed - speed).argmin())
        numbers = (
            f"{answer.transmitted[k]:10.4g} {answer.shaking[k]:12.4g} {answer.transmissibility[k]:10.3f} "
            f"{answer.single[k]:9.3f}"
        )
        rows.append(f"{rpm(answer.speed[k]):8.1f} {numbers}")
    return rows
