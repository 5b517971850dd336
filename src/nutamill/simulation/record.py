"""When a run keeps what, and when it ends: counted in rows of the record, never in floating-point time."""

import math
from dataclasses import dataclass
from typing import Self

import numpy as np

from nutamill.base.steady import FEWEST_TURNS, Estimate, estimate_of_turns, turn_means, whole_turns
from nutamill.case.machine import Machine
from nutamill.case.machine_checks import series_count
from nutamill.result.fields import series_field
from nutamill.result.recorder import SERIES_ROOM
from nutamill.simulation.setup.particles import charge_parts

LEVER_SHARE = 1e-3
"""Share of a force times its lever below which a torque is as good as none [1]."""
CHECKPOINT_SIZE = 400
"""Size of a checkpoint for each sphere, contacts included [bytes]: 120, and 40 for each of some seven."""


def room_at_start(machine: Machine) -> int:
    """Return the room that the result file of a machine needs to begin with: empty series and the first
    checkpoint [bytes].
    """
    names = series_count(machine) if machine.run.series is None else len(machine.run.series)
    return SERIES_ROOM * (names + 2) + CHECKPOINT_SIZE * sum(
        particles.pebbles for particles in charge_parts(machine)
    )


@dataclass(frozen=True, slots=True)
class RecordPlan:
    """When checkpoints and snapshots are recorded, counted in rows of the record."""

    rows: int
    """Rows to the end of the run [1]."""
    rows_per_checkpoint: int
    """Rows between two checkpoints [1]."""
    snapshots: range
    """Rows with a snapshot."""

    @classmethod
    def of(cls, case: Machine, rows: int) -> Self:
        """Plan of a case that ends with row `rows`."""
        rate, snapshots = case.run.series_rate, case.run.snapshots
        stride = max(1, round(rate / snapshots.rate))
        first = -(-max(0, rows - round(snapshots.last * rate)) // stride) * stride
        return cls(rows, max(1, round(case.run.checkpoint * rate)), range(first, rows + 1, stride))

    def next_stop(self, row: int) -> int:
        """Return the next row after `row` at which something beside the series is recorded."""
        stops = [self.rows, (row // self.rows_per_checkpoint + 1) * self.rows_per_checkpoint]
        stops += [stop for stop in self.snapshots if stop > row][:1]
        return min(stops)


class Ending:
    """Decides with which row a run ends: a fixed one, or some time after it has become steady.

    Steadiness is looked for at checkpoints, in the means over whole turns of the watched series since the
    end of the ramp.  Once the run is steady, it goes on for as long as snapshots are recorded, and ends.
    The decision depends on the record alone, so that a run that stops and goes on ends where the run that
    never stopped does.

    Parameters
    ----------
    case : the machine
    until : simulated time at which the run ends at the latest [s]
    """

    def __init__(self, case: Machine, until: float):
        self._case = case
        self._columns: list[np.ndarray] = []
        self._wanted = case.run.until == "steady"
        self._precision = case.run.precision or math.inf  # a run until steady has one
        self._means: dict[str, Estimate] = {}
        self._known: dict[str, float] = {}
        self.steady = False
        self.columns = ("time", case.turn_series or "", *(watched.series for watched in case.run.watch))
        self.plan = RecordPlan.of(case, round(until * case.run.series_rate))

    def fixed(self) -> Self:
        """Return this ending without a look at steadiness."""
        self._wanted = False
        return self

    def replay(self, columns: np.ndarray) -> None:
        """Take the record of a run that is to go on, (n_rows, n_columns) with the series of `columns`, as if
        it had just been made.
        """
        last = len(columns) - 1
        tested = [
            *range(self.plan.rows_per_checkpoint, last + 1, self.plan.rows_per_checkpoint),
            *([last] if last == self.plan.rows else []),
        ]
        begin = 0
        for row in tested:
            self._columns.append(columns[begin : row + 1])
            begin = row + 1
            self.look(row)
        self._columns.append(columns[begin:])

    def recorded(self, names: tuple[str, ...], series: np.ndarray) -> None:
        """Take `series` (n, n_names), which has just been recorded."""
        if self._wanted:
            self._columns.append(series[:, [names.index(name) for name in self.columns]])

    def look(self, row: int) -> None:
        """Test at a checkpoint or at the last row, `row`, whether the run is steady, and if so let it end."""
        if not self._wanted or self.steady or (row % self.plan.rows_per_checkpoint and row != self.plan.rows):
            return
        columns = np.concatenate(self._columns)
        self._columns = [columns]
        at_speed = columns[columns[:, 0] >= self._case.drive.ramp_end]
        time, angle, *watched = at_speed.T
        turns = whole_turns(time, angle)
        if len(turns) <= FEWEST_TURNS:
            return
        sizes = [math.sqrt(np.mean(value**2)) for value in watched]
        names = self.columns[2:]
        for k, watch in enumerate(self._case.run.watch):
            if watch.force is not None and watch.lever is not None:
                sizes[k] = max(sizes[k], LEVER_SHARE * watch.lever * sizes[names.index(watch.force)])
        precision = self._precision
        self._means = {
            name: estimate_of_turns(turn_means(time, value, turns), size, precision)
            for name, value, size in zip(names, watched, sizes, strict=True)
        }
        self._known = {
            name: mean.half_width / size
            for (name, mean), size in zip(self._means.items(), sizes, strict=True)
        }
        self.steady = all(
            mean.steady and self._known[name] <= precision for name, mean in self._means.items()
        )
        if self.steady:
            tail = round(self._case.run.snapshots.last * self._case.run.series_rate)
            self.plan = RecordPlan.of(self._case, min(row + tail, self.plan.rows))

    @property
    def missed(self) -> str:
        """Why a run that should become steady is not, empty where there is nothing to say."""
        if not self._wanted or self.steady:
            return ""
        if not self._means:
            return f"fewer than {FEWEST_TURNS} whole turns at full speed"
        reasons = []
        for name, mean in self._means.items():
            label, share = series_field(name).label, mean.drift / (mean.turns * mean.mean or 1.0)
            if not mean.steady:
                reasons.append(f"{label} still drifts {100 * share:+.2g} % per turn")
            elif self._known[name] > self._precision:
                reasons.append(
                    f"{label} is known to ± {100 * self._known[name]:.2g} %, run.precision asks for "
                    f"{self._precision:.2g}"
                )
        return ", ".join(reasons)
