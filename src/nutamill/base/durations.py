"""Durations in words."""

import math


def duration(seconds: float) -> str:
    """Wall time as ``h:mm:ss``; a dash if it is not known."""
    if not math.isfinite(seconds):
        return "-"
    whole = round(max(0.0, seconds))
    return f"{whole // 3600}:{whole // 60 % 60:02}:{whole % 60:02}"
