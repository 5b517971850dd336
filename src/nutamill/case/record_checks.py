"""Checks of what a run records: series, checkpoints and snapshots that hold nothing, or more than is meant.

A finding is (key, what, hint); the key is a tuple of its parts, which gives its line in the file.
"""

from typing import TYPE_CHECKING

from nutamill.base import units
from nutamill.base.units import Kind
from nutamill.case.charge_checks import Finding

if TYPE_CHECKING:
    from nutamill.case.charge_checks import AnyCase

MOST_NUMBERS = 1e10
"""Numbers of all series, and of all snapshots, above which a case is refused as a slip of the pen [1]."""
MOST_CHECKPOINTS = 1e5
"""Checkpoints above which a case is refused as a slip of the pen [1]."""
PARTICLE_NUMBERS = 9
"""Numbers that a snapshot holds of a particle [1]."""


def record_findings(case: "AnyCase", series: int) -> list[Finding]:
    """Return what is wrong with the series, the checkpoints and the snapshots of a run with this number of
    series.
    """
    run = case.run
    rows = run.end * run.series_rate
    findings: list[Finding] = []
    if rows < 1.0:
        what = f"must give at least one row in {run.end:g} s, got {rows:.2g}"
        findings.append((("run", "series_rate"), what, f'Write e.g. "{units.example(Kind.FREQUENCY)}"'))
    if rows * series > MOST_NUMBERS:
        findings.append((("run", "series_rate"), _too_many(rows * series), "Lower it, or end the run sooner"))
    if (checkpoints := run.end / run.checkpoint) > MOST_CHECKPOINTS:
        what = f"makes {checkpoints:.2g} checkpoints, more than the limit of {MOST_CHECKPOINTS:.0e}"
        findings.append((("run", "checkpoint"), what, "Take a longer time"))
    particles = max((part.count or 0 for part in case.charge.parts), default=0)
    snapshots = min(run.snapshots.last, run.end) * run.snapshots.rate
    if (numbers := snapshots * PARTICLE_NUMBERS * max(1, particles)) > MOST_NUMBERS:
        findings.append(
            (("run", "snapshots", "rate"), _too_many(numbers), "Lower it, or shorten run.snapshots.last")
        )
    return findings


def _too_many(numbers: float) -> str:
    return f"makes {numbers:.2g} numbers to record, more than the limit of {MOST_NUMBERS:.0e}"
