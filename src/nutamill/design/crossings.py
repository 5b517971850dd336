"""Natural frequencies that the ramp of a drive passes on its way to full speed."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from nutamill.base.units import rpm
from nutamill.case.drive import DriveProgramme


class Crossing(NamedTuple):
    """A natural frequency that the ramp passes."""

    frequency: float
    """Undamped natural frequency [Hz]."""
    damping_ratio: float
    """Share of critical damping [1]."""
    speed: float
    """Speed of the drive at which an unbalance excites it [rad/s]."""
    time: float
    """When the ramp passes that speed [s]."""


def crossings(modes: Sequence[tuple[float, float]], drive: DriveProgramme) -> list[Crossing]:
    """Return the modes between rest and full speed of a drive, and when it passes them.

    `modes` are natural frequencies [Hz] and damping ratios [1].
    """
    times, speeds = drive.breakpoints()
    passed = []
    for frequency, damping in modes:
        speed = 2 * np.pi * frequency
        above = np.flatnonzero(speeds >= speed)
        if above.size and above[0] > 0:
            k = above[0]
            share = (speed - speeds[k - 1]) / (speeds[k] - speeds[k - 1])
            time = times[k - 1] + share * (times[k] - times[k - 1])
            passed.append(Crossing(frequency, damping, speed, float(time)))
    return passed


def crossing_lines(passed: Sequence[Crossing], loaded: str) -> list[str]:
    """Format the crossings, one line each.

    The two sways of a machine that is alike in x and y are one. `loaded` names what the modes are with.
    """
    lines, last = [], ""
    for crossing in passed:
        place = f"{crossing.frequency:.2f} Hz = {rpm(crossing.speed):.0f} rpm"
        if place == last:
            continue
        last = place
        lines.append(
            f"          {loaded}: {place} (damping {100 * crossing.damping_ratio:.1f} %)"
            f" is passed at t = {crossing.time:.1f} s; the largest motion comes later"
        )
    return lines
