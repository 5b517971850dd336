"""Durations in words."""

import math


def duration(seconds: float) -> str:
    """Format a wall time as ``h:mm:ss``, or as a dash if it is not known."""
    if not math.isfinite(seconds):
        return "-"
    whole = round(max(0.0, seconds))
    return f"{whole // 3600}:{whole // 60 % 60:02}:{whole % 60:02}"
