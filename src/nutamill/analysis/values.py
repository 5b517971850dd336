"""One number with its uncertainty from a result: a steady mean, a root mean square, or a swing of a
series.
"""

import contextlib
import math
from collections.abc import Sequence
from typing import Literal, NamedTuple, get_args

import numpy as np

from nutamill.analysis.windows import PAPER_WINDOW, turns_at_speed
from nutamill.base.errors import CaseError, Fault, ResultError
from nutamill.base.steady import FEWEST_TURNS, steady_mean, turn_means, turn_swings
from nutamill.result import Result
from nutamill.result.fields import Field, series_field

How = Literal["mean", "rms", "swing"]
"""Mean, root mean square, or half of largest less smallest, of each turn."""


class Reading(NamedTuple):
    """What is read from a result: for each turn one number of a series, and of these the steady mean."""

    series: str
    """Name of the series."""
    by: How = "mean"
    """What of it is taken of each turn."""

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
    """The same over the last seconds or what there is of them: for means the plain mean of all samples; NaN
    without a turn in them.
    """
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
    if len(ways) > 1 or any(way not in get_args(How) for way in ways):
        raise CaseError(
            Fault(
                where,
                f'must be a series, or "rms" or "swing" and a series, got "{text}"',
                'Write e.g. "rms driveshaft_torque"',
            )
        )
    try:
        series_field(series)
    except CaseError as error:
        raise CaseError(
            *(Fault(where, f"{fault.where}: {fault.what}", fault.hint) for fault in error.faults)
        ) from None
    return Reading(series, *ways)


def read(result: Result, readings: Sequence[Reading]) -> dict[Reading, Value]:
    """What a result says, reading by reading: `steady_value` of each, `NOTHING` where it does not hold the
    series or a whole turn.
    """
    series, found = result.series, dict.fromkeys(readings, NOTHING)
    held = [reading for reading in readings if reading.series in series]
    with contextlib.suppress(ResultError):
        found |= {
            reading: steady_value(result, series[reading.series].values, reading.by) for reading in held
        }
    return found


def steady_value(result: Result, value: np.ndarray, by: How = "mean", last: float = PAPER_WINDOW) -> Value:
    """Steady mean, with its 95 % interval, of a series or of something made from series, (n,) at their times.

    The mean is that of `nutamill.base.steady.steady_mean` over the whole turns at the last speed.

    Parameters
    ----------
    by : what is taken of each turn
    last : length of the window of `Value.window` at the end [s]

    Raises
    ------
    ResultError : the run has not made one turn at its last speed
    """
    inside, turns = turns_at_speed(result)
    if len(turns) < 2:
        raise ResultError(
            f"{result.path}: must hold a whole turn at its last speed, it holds none. Continue it "
            "with `nutamill resume`."
        )
    time, value = result.series["time"].values[inside], value[inside]
    if by == "swing":
        each = turn_swings(time, value, turns)
    elif by == "rms":
        each = np.sqrt(turn_means(time, value**2, turns))
    else:
        each = turn_means(time, value, turns)
    recent = value[time >= time[-1] - last] if by == "mean" else each[turns[:-1] >= turns[-1] - last - 1e-9]
    window = float(recent.mean()) if len(recent) else math.nan
    if len(each) < FEWEST_TURNS:
        return Value(float(each.mean()), math.nan, window, len(each), False)
    found = steady_mean(each)
    return Value(found.mean, found.half_width, window, found.turns, found.steady)
