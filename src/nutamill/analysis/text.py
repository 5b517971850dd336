"""How readings are worded."""

LONGEST = 1e7
"""Life [h] beyond which none is told: more than a thousand years."""


def hours_text(time: float) -> str:
    """A life [s] in hours, 11 wide; beyond what a machine is ever run for no more than that is said."""
    hours = time / 3600
    return f"{hours:11.4g}" if hours <= LONGEST else f"{f'> {LONGEST:.0e}':>11}"
