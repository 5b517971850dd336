"""Quantities of a machine given part by part: how its first sensed body moves, and what its drive takes."""

import itertools
import math

import numpy as np

from nutamill.analysis.windows import steady_mean
from nutamill.base.errors import ResultError
from nutamill.base.steady import Estimate
from nutamill.result import Result

PARTS = 10
"""Parts of the last seconds in each of which an amplitude is taken [1]."""
STUDENT = 2.262
"""Half width of a 95 % interval of the mean of ten over its standard error [1]."""
DRIFT = 0.01
"""Share by which an amplitude may change and still be steady [1]."""
ABOUT = 1e-3
"""Time before and after, over which a speed is taken [s]: published records have a sample each
millisecond.
"""


def _height(result: Result) -> tuple[np.ndarray, np.ndarray]:
    """Return time [s] and height [m] of the first sensor of a position, (n,) each."""
    name = next((name for name in map(str, result.series.data_vars) if name.endswith("_position_z")), None)
    if name is None:
        raise ResultError(f'{result.path}: has no height. Add to the case a sensor of kind "position".')
    return result.series["time"].values, result.series[name].values


def amplitude(result: Result, last: float) -> Estimate:
    """Compute half of the largest less the smallest height, mean over ten parts of the last seconds [m].

    It is steady if the means of the first and the last five differ by less than the parts scatter, or by one
    per cent.
    """
    time, heights = _height(result)
    ends = np.linspace(time[-1] - last, time[-1], PARTS + 1)
    parts = [heights[(time >= begin) & (time <= end)] for begin, end in itertools.pairwise(ends)]
    swings = np.array([0.5 * np.ptp(part) for part in parts])
    mean, scatter = float(swings.mean()), float(swings.std(ddof=1))
    drift = abs(float(swings[PARTS // 2 :].mean() - swings[: PARTS // 2].mean()))
    half_width = STUDENT * scatter / math.sqrt(PARTS)
    return Estimate(mean, half_width, mean, PARTS, drift <= max(scatter, DRIFT * mean))


def height(result: Result, last: float, at: float) -> Estimate:
    """Return the height at a time [m]."""
    return Estimate.exact(float(np.interp(at, *_height(result))))


def upward_speed(result: Result, last: float, at: float) -> Estimate:
    """Compute the mean upward speed from one millisecond before a time to one after it [m/s]."""
    before, after = np.interp([at - ABOUT, at + ABOUT], *_height(result))
    return Estimate.exact(float((after - before) / (2.0 * ABOUT)))


def lowest_height(result: Result, last: float) -> Estimate:
    """Return the lowest height [m]."""
    return Estimate.exact(float(_height(result)[1].min()))


def time_of_lowest(result: Result, last: float) -> Estimate:
    """Return the time of the lowest height [s]."""
    time, heights = _height(result)
    return Estimate.exact(float(time[np.argmin(heights)]))


def rebound_speed(result: Result, last: float) -> Estimate:
    """Compute the largest mean upward speed over a millisecond after the lowest height [m/s].

    Raises
    ------
    ResultError : the run ends at the lowest height
    """
    time, heights = _height(result)
    after = np.arange(time[np.argmin(heights)], time[-1], ABOUT)
    if len(after) < 2:
        raise ResultError(f"{result.path}: ends at its lowest height. Run it longer.")
    return Estimate.exact(float(np.max(np.diff(np.interp(after, time, heights))) / ABOUT))


def drive_power(result: Result, last: float) -> Estimate:
    """Compute the mean power of the first drive [W].

    Raises
    ------
    ResultError : nothing is driven
    """
    names = map(str, result.series.data_vars)
    torque = next((name for name in names if name.startswith("drive_") and name.endswith("_torque")), None)
    if torque is None:
        raise ResultError(f"{result.path}: has no drive. Run a machine with one.")
    speed = result.series[torque.removesuffix("torque") + "speed"].values
    return steady_mean(result, result.series[torque].values * speed, last=last)
