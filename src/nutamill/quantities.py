"""One number with its uncertainty from a result: a steady mean, a root mean square, or a swing of a series."""

import math
from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np

from nutamill.analysis import PAPER_WINDOW, ramp_end
from nutamill.errors import CaseError, Fault
from nutamill.fields import Field, series_field
from nutamill.result import Result
from nutamill.steady import FEWEST_TURNS, steady_mean, turn_means, turn_swings, whole_turns

HOW = ("mean", "rms", "swing")


class Reading(NamedTuple):
    """What is read from a result: for each turn one number of a series, and of these the steady mean."""

    series: str
    """Name of the series."""
    by: Literal["mean", "rms", "swing"] = "mean"
    """Mean, root mean square, or half of largest less smallest, of each turn."""

    @property
    def name(self) -> str:
        """``driveshaft_torque``, ``mount_1_travel_x_swing``."""
        return self.series if self.by == "mean" else f"{self.series}_{self.by}"

    @property
    def field(self) -> Field:
        """The series, as declared."""
        return series_field(self.series)


class Value(NamedTuple):
    """What was read; NaN where the result does not hold the series or a whole turn at its last speed."""

    mean: float
    """Steady mean, unit of the series."""
    half_width: float
    """Half width of its 95 % interval; NaN with too few turns for a test of steadiness."""
    window: float
    """The same over the last `PAPER_WINDOW` seconds or what there is of them: for means the plain mean of all samples."""
    turns: int
    """Turns in the steady mean [1]."""
    steady: bool
    """Whether the test calls it steady."""


DEFAULT = (
    Reading("crank_pin_force_resultant"),
    Reading("driveshaft_torque"),
    Reading("driveshaft_power"),
    Reading("mount_1_travel_x", "swing"),
    Reading("mount_1_travel_z", "swing"),
)
"""What a campaign reads unless told."""

NOTHING = Value(math.nan, math.nan, math.nan, 0, False)


def reading_of(text: str, where: str = "reading") -> Reading:
    """The reading a text names: a series, or ``rms`` or ``swing`` and a series.

    Raises
    ------
    CaseError : no such series, or no such way to read it
    """
    *ways, series = text.split()
    if len(ways) > 1 or any(way not in HOW for way in ways):
        raise CaseError(
            Fault(where, f'must be a series, or "rms" or "swing" and a series, got "{text}"', 'Write e.g. "rms driveshaft_torque"')
        )
    try:
        series_field(series)
    except CaseError as error:
        raise CaseError(*(Fault(where, f"{fault.where}: {fault.what}", fault.hint) for fault in error.faults)) from None
    return Reading(series, *ways)


def read(result: Result, readings: Sequence[Reading]) -> dict[Reading, Value]:
    """What a result says, reading by reading.

    Means and their intervals are those of `nutamill.steady.steady_mean` over the whole turns at the last speed.
    """
    series = result.series
    time, angle = series["time"].values, series["crank_angle"].values
    inside = time >= ramp_end(result)
    time, turns = time[inside], whole_turns(time[inside], angle[inside])
    if len(turns) < 2:
        return dict.fromkeys(readings, NOTHING)
    return {
        reading: _value(reading, time, series[reading.series].values[inside], turns) if reading.series in series else NOTHING
        for reading in readings
    }


def _value(reading: Reading, time: np.ndarray, value: np.ndarray, turns: np.ndarray) -> Value:
    """Steady mean over turns of a series at constant speed, and the same over the window of the papers."""
    if reading.by == "swing":
        each = turn_swings(time, value, turns)
    elif reading.by == "rms":
        each = np.sqrt(turn_means(time, value**2, turns))
    else:
        each = turn_means(time, value, turns)
    last = turns[:-1] >= turns[-1] - PAPER_WINDOW - 1e-9
    window = float(value[time >= time[-1] - PAPER_WINDOW].mean() if reading.by == "mean" else each[last].mean()) if last.any() else math.nan
    if len(each) < FEWEST_TURNS:
        return Value(float(each.mean()), math.nan, window, len(each), False)
    found = steady_mean(each)
    return Value(found.mean, found.half_width, window, found.turns, found.steady)
