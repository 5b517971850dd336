"""The Campbell diagram: natural frequencies over speed, and the speeds to avoid."""

from typing import NamedTuple

import numpy as np
from scipy.optimize import linear_sum_assignment

from nutamill.base.errors import CaseError, Fault
from nutamill.base.units import rpm
from nutamill.case import Case, Machine
from nutamill.design.modes import MachineModes, machine_modes
from nutamill.simulation.setup.altered import turning_drive

ORDERS = (1.0, 2.0)
"""Excitations per turn: unbalance, and the ripple of the universal joint."""


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
