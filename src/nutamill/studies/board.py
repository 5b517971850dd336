"""What a campaign shows while it runs: a live table on a terminal, a line for each run that ends in a log."""

import sys
from collections.abc import Sequence
from types import TracebackType
from typing import TYPE_CHECKING, Self

from nutamill.analysis.summary import with_interval
from nutamill.analysis.values import Reading
from nutamill.base.steady import Estimate
from nutamill.result import is_finished
from nutamill.studies.table import Outcome

if TYPE_CHECKING:
    from rich.live import Live
    from rich.table import Table

SHOWN = 40
"""Rows of the live table at most [1]; those that are finished give way first."""


class Board:
    """Shows how the runs stand; a context manager, called with all outcomes:
    ``with Board(readings) as show: show(outcomes)``.
    """

    def __init__(self, readings: Sequence[Reading]):
        self._readings = readings[:2]
        self._live: Live | None = None
        self._printed: set[str] = set()

    def __enter__(self) -> Self:
        if sys.stdout.isatty():
            from rich.live import Live  # rich is needed on a terminal only

            self._live = Live(refresh_per_second=2)
            self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._live is not None:
            self._live.stop()

    def message(self, text: str) -> None:
        """Show one line."""
        if self._live is not None:
            self._live.console.print(text, highlight=False)
        else:
            print(text, flush=True)

    def __call__(self, outcomes: Sequence[Outcome]) -> None:
        """Show how all runs stand."""
        if self._live is not None:
            self._live.update(table(outcomes, self._readings))
            return
        over = [outcome for outcome in outcomes if ended(outcome)]
        new = [outcome for outcome in over if outcome.file.name not in self._printed]
        for number, outcome in enumerate(new, start=len(over) - len(new) + 1):
            self._printed.add(outcome.file.name)
            print(f"{number} of {len(outcomes)}  {line(outcome, self._readings)}", flush=True)


def ended(outcome: Outcome) -> bool:
    """Return whether nothing more happens to a run in this call."""
    return outcome.state != "waiting" and not outcome.state.startswith("running")


def line(outcome: Outcome, readings: Sequence[Reading]) -> str:
    """Format a run as one line."""
    means = [
        f"{reading.field.label} {with_interval(value)} {reading.field.unit}"
        for reading, value in _read(outcome, readings)
    ]
    return "  ".join([outcome.member.label or outcome.member.case.name, *means, outcome.state])


def _read(outcome: Outcome, readings: Sequence[Reading]) -> list[tuple[Reading, Estimate]]:
    """Format the readings of a run, as far as it has them."""
    return [(reading, outcome.values[reading]) for reading in readings if reading in outcome.values]


def total(outcomes: Sequence[Outcome]) -> str:
    """Format how many runs have ended, and how many of them badly."""
    bad = sum(ended(outcome) and not is_finished(outcome.state) for outcome in outcomes)
    done = sum(is_finished(outcome.state) for outcome in outcomes)
    return f"{done} of {len(outcomes)} done" + (f", {bad} not finished" if bad else "")


def table(outcomes: Sequence[Outcome], readings: Sequence[Reading]) -> "Table":
    """Build the live table: one row a run, and the total."""
    from rich.table import Table

    shown = Table(title=total(outcomes), title_justify="left")
    for key in outcomes[0].member.values:
        shown.add_column(key)
    for reading in readings:
        shown.add_column(f"{reading.field.label} ({reading.field.unit})", justify="right")
    shown.add_column("state")
    rows = sorted(outcomes, key=ended)[:SHOWN] if len(outcomes) > SHOWN else outcomes
    for outcome in rows:
        read = dict(_read(outcome, readings))
        means = [with_interval(read[reading]) if reading in read else "" for reading in readings]
        shown.add_row(*map(str, outcome.member.values.values()), *means, outcome.state)
    return shown
