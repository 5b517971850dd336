"""The steady end of a run: where it begins, its whole turns, and steady means of series over them."""

import math
from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np

from nutamill.analysis.source import any_case_of
from nutamill.base.errors import CaseError, Fault, ResultError
from nutamill.base.schema import spelled
from nutamill.base.steady import (
    FEWEST_TURNS,
    Estimate,
    estimate_of_turns,
    turn_means,
    turn_swings,
    whole_turns,
)
from nutamill.base.units import Kind, UnitError, parse
from nutamill.case.machine import DriveEntry
from nutamill.result import Result

PAPER_WINDOW = 3.0
"""Length of the averaging window at the end of a run in both NuMill papers [s]."""
STEADY_SPEED = 1e-6
"""Share by which the speed of a run may differ from the last one in steady running [1]."""
MEASURED_SPEED = 0.02
"""Share by which a measured speed may scatter in steady running: no real drive keeps it exactly [1]."""

BLOCKS = 20
"""Lengths of time that stand for turns where nothing turns [1]."""

TURNING = ("series_of_angle", "series_of_speed")
"""Entries of the provenance of measured data that name angle and speed of the drive over whose turns means
are taken; without them those of a crank.
"""

How = Literal["mean", "rms", "swing"]
"""Mean, root mean square, or half the range, of each turn."""

PHASE_LAG = "charge_phase_lag"
"""Series of the angle of the crank ahead of the charge's mass centre, about the driveshaft."""


class SteadyWindow(NamedTuple):
    """The last seconds of a run, cut where the speed was still changing."""

    start: float
    """Start of the window [s]."""
    end: float
    """End of the window and of the run [s]."""
    turns: np.ndarray
    """Times at which the whole turns in the window begin and end [s], (n_turns + 1,)."""

    @property
    def turn_rate(self) -> float:
        """Mean number of turns per second [Hz]."""
        return (len(self.turns) - 1) / float(self.turns[-1] - self.turns[0])


class SteadyPart(NamedTuple):
    """Steady means of several series, and the turns they were taken from."""

    turns: np.ndarray
    """Times at which all whole turns at the last speed begin and end [s], (n_turns + 1,)."""
    means: dict[str, Estimate]
    """Steady mean of each series."""

    @property
    def start(self) -> float:
        """Time from which all of the series are steady [s]."""
        return float(self.turns[max(estimate.first for estimate in self.means.values())])

    @property
    def drifting(self) -> list[str]:
        """Series that are not steady."""
        return [name for name, estimate in self.means.items() if not estimate.steady]


def ramp_end(result: Result, scatter: float = STEADY_SPEED) -> float:
    """Return the time from which the driveshaft keeps its last speed [s].

    It is the time of the first sample if the speed never changes.  The speed of a motor is never quite
    steady: there it is the time from which the last speed is commanded, or the supply is back.

    Parameters
    ----------
    scatter : share by which the speed may differ from the last one [1]; beyond `STEADY_SPEED` the last speed
        is the median of the last fifth of the record
    """
    case = any_case_of(result) if result.case_text else None
    driven = case.machine if case is not None else None
    if driven is not None and (ends := [_supplied(drive) for drive in driven.drives if drive.motor]):
        return max(driven.drive.ramp_end, *ends)
    speeds = "driveshaft_speed"
    if driven is None:
        speeds = result.provenance.get(TURNING[1], speeds)
    if speeds not in result.series:
        return 0.0 if driven is None else driven.drive.ramp_end
    time, speed = (result.series[name].values for name in ("time", speeds))
    if not len(time):
        return math.nan
    final = float(speed[-1])
    if scatter > STEADY_SPEED:
        final = float(np.median(speed[time >= time[-1] - 0.2 * (time[-1] - time[0])]))
    changing = np.flatnonzero(np.abs(speed - final) > scatter * abs(final))
    if not len(changing) or changing[-1] + 1 == len(time):  # the last sample differs in measured data only
        return float(time[0])
    return float(time[changing[-1] + 1])


def _supplied(drive: DriveEntry) -> float:
    """Return the time from which the supply of a motor is back, or is cut for good [s]."""
    return drive.motor.restored or drive.motor.cut or 0.0 if drive.motor else 0.0


def turns_at_speed(
    result: Result, since: float = -math.inf, scatter: float = STEADY_SPEED
) -> tuple[np.ndarray, np.ndarray]:
    """Return the samples at the last speed, (n_samples,) of bool, and the times between their whole turns
    [s], (n_turns + 1,).

    Without a whole turn there are fewer than two times.  The turns are those of the drive that the case names
    for its period, of a mill of its crank.  Where nothing turns, they are `BLOCKS` equal lengths of time.

    Parameters
    ----------
    since : earliest time [s]
    scatter : as for `ramp_end`
    """
    time, turning = result.series["time"].values, turn_series(result)
    inside = time >= max(ramp_end(result, scatter), since)
    if turning is None:
        within = time[inside]
        return inside, np.linspace(within[0], within[-1], BLOCKS + 1) if len(within) > BLOCKS else within[:0]
    return inside, whole_turns(time[inside], result.series[turning].values[inside])


def turn_series(result: Result) -> str | None:
    """Return the series with the angle over whose turns means are taken, or None where nothing turns."""
    if result.case_text:
        name = any_case_of(result).machine.turn_series
    else:
        name = result.provenance.get(TURNING[0], "crank_angle")
    return name if name in result.series else None


def steady_window(result: Result, last: float | str = PAPER_WINDOW) -> SteadyWindow:
    """Return the last seconds of a run at its last speed, and the whole turns in them.

    Readings of a mill repeat once or twice per turn, so that a mean over a broken number of turns depends on
    where it is cut.  The whole turns are counted back from the end of the run.

    Parameters
    ----------
    last : length of the window [s], or a text with a unit as ``"3 s"``

    Raises
    ------
    CaseError : as `window_length`
    ResultError : the run has not made one turn at its last speed
    """
    time = result.series["time"].values
    since = float(time[-1]) - window_length(last) if len(time) else math.nan
    inside, turns = turns_at_speed(result, since)
    if len(turns) < 2:
        raise _no_turn(result)
    return SteadyWindow(float(time[inside][0]), float(time[-1]), turns)


def steady_mean(
    result: Result,
    series: str | np.ndarray,
    by: How = "mean",
    last: float | str = PAPER_WINDOW,
    scatter: float = STEADY_SPEED,
) -> Estimate:
    """Estimate the steady mean of a series of a result, with its 95 % confidence interval.

    Of each whole turn at the last speed one number is taken; `nutamill.base.steady.estimate_of_turns` cuts
    off those before the steady part.  With fewer than `FEWEST_TURNS` turns it is the mean of all of them,
    without an interval.

    Parameters
    ----------
    series : name of a series, or numbers at the times of the series, (n_samples,)
    by : number taken of each turn: its mean, root mean square, or half its range
    last : length of the window of the plain mean at the end of the run [s], or a text with a unit.  For means
        it is the mean of all samples in it, as in the NuMill papers, otherwise of the turns that begin in it.
    scatter : as for `ramp_end`; `MEASURED_SPEED` for a test

    Returns
    -------
    the estimate, unit of the series

    Raises
    ------
    CaseError : as `window_length`
    ResultError : no such series in the result, or no whole turn at the last speed
    """
    if isinstance(series, str) and series not in result.series:
        raise ResultError(f"{result.path}: has no series {series}. `nutamill info fields` lists all series.")
    if isinstance(series, str):
        values = phase_lag(result, series) if _is_lag(result, series) else result.series[series].values
    else:
        values = series
    inside, turns = turns_at_speed(result, scatter=scatter)
    if len(turns) < 2:
        raise _no_turn(result)
    time, values = result.series["time"].values[inside], values[inside]
    if by == "swing":
        each = turn_swings(time, values, turns)
    elif by == "rms":
        each = np.sqrt(turn_means(time, values**2, turns))
    else:
        each = turn_means(time, values, turns)
    begin = time[-1] - window_length(last)
    recent = values[time >= begin] if by == "mean" else each[turns[:-1] >= begin - 1e-9]
    plain_mean = float(recent.mean()) if len(recent) else math.nan
    if len(each) < FEWEST_TURNS:
        return Estimate(float(each.mean()), math.nan, plain_mean, len(each), False)
    return estimate_of_turns(each)._replace(plain_mean=plain_mean)


def phase_lag(result: Result, name: str = PHASE_LAG) -> np.ndarray:
    """Return a phase lag at every sample without its steps from pi to -pi [rad], (n,): within half a turn of
    its mean direction.

    A machine that does not record the lag of its charge has that of the mass centre about the vertical
    through the origin.
    """
    series = result.series
    if name in series:
        values = series[name].values
    else:
        place = series["charge_mass_centre_x"].values + 1j * series["charge_mass_centre_y"].values
        values = np.angle(np.exp(1j * series["crank_angle"].values) * place.conj())
    if not len(values) or np.ptp(values) <= math.pi:
        return values
    middle = float(np.angle(np.exp(1j * values).mean()))
    return middle + np.angle(np.exp(1j * (values - middle)))


def _is_lag(result: Result, name: str) -> bool:
    """Return whether a series is the lag of one angle behind another."""
    quantities = any_case_of(result).machine.quantities if result.case_text else ()
    return name == PHASE_LAG or any(entry.name == name and entry.take == "lag" for entry in quantities)


def steady_part(result: Result, names: Sequence[str]) -> SteadyPart:
    """Estimate the steady means of several series of a run.

    Raises
    ------
    ResultError : no such series, or fewer whole turns at the last speed than the test of steadiness needs
    """
    turns = turns_at_speed(result)[1]
    if len(turns) <= FEWEST_TURNS:
        raise ResultError(
            f"{result.path}: a test of steadiness needs {FEWEST_TURNS} whole turns at the last speed, got "
            f"{max(0, len(turns) - 1)}. Continue the run with `nutamill resume`."
        )
    return SteadyPart(turns, {name: steady_mean(result, name) for name in names})


def _no_turn(result: Result) -> ResultError:
    """Return the error of a run without a whole turn at its last speed."""
    time = result.series["time"].values
    reached = f"the run ends at t = {time[-1]:g} s" if len(time) else "the run is empty"
    if turn_series(result) is None:
        return ResultError(
            f"{result.path}: fewer than {BLOCKS + 1} samples at constant speed, {reached}. "
            "Continue it with `nutamill resume`, or take a longer window."
        )
    return ResultError(
        f"{result.path}: fewer than one whole turn at constant speed, {reached}. Continue it with "
        "`nutamill resume`."
    )


def window_length(last: float | str) -> float:
    """Return the length of a window at the end of a run [s], given so or as a text with a unit.

    Raises
    ------
    CaseError : a text that is no time, or a length that is not positive
    """
    try:
        length = parse(last, Kind.TIME) if isinstance(last, str) else last
    except UnitError as error:
        raise CaseError(Fault("last", error.what, error.hint)) from None
    if not length > 0.0:
        given = spelled(last) if isinstance(last, str) else f"{last:g} s"
        raise CaseError(Fault("last", f"must be positive, got {given}", 'Write e.g. "3 s"'))
    return length
