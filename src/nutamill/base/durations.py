"""Durations in words."""

import math

from nutamill.base.units import shown, si_value

DAY = si_value(24.0, "h")
"""A day [s]."""

IN_SECONDS, IN_MINUTES = si_value(1.5, "min"), si_value(1.5, "h")
"""Durations [s] up to which an estimate is given in seconds, and in minutes."""


def duration(seconds: float) -> str:
    """Format a wall time as ``h:mm:ss``, or as a dash if it is not known."""
    if not math.isfinite(seconds):
        return "-"
    whole = round(max(0.0, seconds))
    return f"{whole // 3600}:{whole // 60 % 60:02}:{whole % 60:02}"


def rough_duration(seconds: float) -> str:
    """Format an estimated wall time with the unit that suits it: ``12 min``, ``3.5 h``, ``9 days``."""
    if seconds < IN_MINUTES:
        return f"{seconds:.0f} s" if seconds < IN_SECONDS else shown(seconds, "min", ".0f")
    return shown(seconds, "h", ".1f") if seconds < 2.0 * DAY else f"{seconds / DAY:.0f} days"
