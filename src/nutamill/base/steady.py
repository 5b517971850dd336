"""Steady or not: where the steady part of a record begins, its mean, and how uncertain that mean is.

Pure functions of numbers.  A mill's readings repeat once or twice per turn, so that everything here is about
one number per whole turn: its mean, its root mean square, or its swing.  A record is **steady** when the
turns used of it have no drift beyond what their scatter explains, or none that matters.
"""

import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.special import stdtrit

FEWEST_TURNS = 5
"""Fewest whole turns for a test of steadiness [1]."""
BATCHES = 10
"""Largest number of batches of turns from which an interval is estimated, or in which a drift is looked for
[1].
"""
PRECISION = 0.01
"""Share of its size by which a steady reading may drift over the turns used [1]."""
ROUND_OFF = 1e-9
"""Share of its size by which a reading may vary and still be called constant [1]."""
TWO_SIDED_95 = 0.975
"""Student's quantile is taken here for an interval that holds 95 %."""


class Estimate(NamedTuple):
    """Steady mean of a quantity with its 95 % confidence interval."""

    mean: float
    """Mean over the turns used, unit of the quantity; NaN where there is none."""
    half_width: float
    """Half width of its 95 % confidence interval, correlation of the turns included, unit of the quantity;
    NaN with too few turns for a test of steadiness.
    """
    plain_mean: float
    """Mean without that test, over the last seconds or over the whole record, unit of the quantity."""
    turns: int
    """Turns used [1]."""
    steady: bool
    """Whether the drift over the turns used is explained by their scatter, or too small to matter."""
    first: int = 0
    """First turn used, counted from 0 [1]."""
    drift: float = math.nan
    """Change of the mean from the first to the last turn used, by a straight line, unit of the quantity."""

    @classmethod
    def exact(cls, value: float) -> "Estimate":
        """Return the estimate of a number that has no interval."""
        return cls(value, math.nan, value, 1, True)


NO_ESTIMATE = Estimate(math.nan, math.nan, math.nan, 0, False)
"""Estimate of a quantity that a result does not hold."""


def whole_turns(time: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Return the times [s] (n + 1,) between the whole turns of a record, counted back from its end.

    Parameters
    ----------
    time : sample times [s], (n_samples,)
    angle : crank angle at them [rad], monotone, (n_samples,)
    """
    if not len(time):
        return np.empty(0)
    if angle[-1] < angle[0]:
        angle = -angle
    count = math.floor((angle[-1] - angle[0]) / math.tau + 1e-9)
    return np.interp(angle[-1] - math.tau * np.arange(count, -1, -1), angle, time)


def turn_means(time: np.ndarray, value: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """Compute the mean of `value` over each turn, (n,), by the trapezoidal rule.

    Parameters
    ----------
    time : sample times [s], (n_samples,)
    value : samples, (n_samples,)
    turns : times between the turns [s], (n + 1,)
    """
    integral = np.concatenate(([0.0], np.cumsum(0.5 * np.diff(time) * (value[1:] + value[:-1]))))
    return np.diff(np.interp(turns, time, integral)) / np.diff(turns)


def turn_swings(time: np.ndarray, value: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """Compute half the range of the samples of each turn, (n,). Arguments are those of `turn_means`."""
    edges = np.searchsorted(time, turns)
    slices = [value[begin : max(end, begin + 1)] for begin, end in itertools.pairwise(edges)]
    return np.array([0.5 * np.ptp(inside) for inside in slices])


def estimate_of_turns(
    values: Sequence[float] | np.ndarray, size: float | None = None, precision: float = PRECISION
) -> Estimate:
    """Estimate the mean of the steady part of a record, with its 95 % interval.

    The cut is the marginal standard error rule; half of the record at most is cut off.  The rest is called
    steady if a straight line through it has no slope beyond its uncertainty, or changes by less than
    `precision` times `size` from end to end.

    Parameters
    ----------
    values : one number per turn, (n,)
    size : what the drift is compared with, unit of `values`; the root mean square of the turns used if None
    precision : share of `size` that a drift may have [1]

    Raises
    ------
    ValueError : fewer than `FEWEST_TURNS` turns, or numbers that are not finite

    Source
    ------
    K. P. White, Simulation 69(6), 323-334, 1997 (marginal standard error rule); C. J. Geyer, Statist. Sci.
    7(4), 473-483, 1992 (correlation); A. M. Law, Simulation Modeling and Analysis, 5th ed., 2015, section 9.5
    (batch means)
    """
    values = np.asarray(values, dtype=float)
    if len(values) < FEWEST_TURNS:
        raise ValueError(f"needs at least {FEWEST_TURNS} whole turns, got {len(values)}")
    if not np.isfinite(values).all():
        raise ValueError("values of the turns must be finite numbers")
    first = truncation(values)
    used = values[first:]
    change, doubt = drift(used)
    size = float(np.sqrt(np.mean(used**2))) if size is None else size
    return Estimate(
        mean=float(used.mean()),
        half_width=interval(used, correlation_length(used)),
        plain_mean=float(values.mean()),
        turns=len(used),
        steady=abs(change) <= max(doubt, precision * size),
        first=first,
        drift=change,
    )


def truncation(values: np.ndarray) -> int:
    """Return how many values to cut off at the beginning.

    The rest has the least `sum((y - mean)^2) / n^2`.  At most half is cut off, and at least `FEWEST_TURNS`
    remain.

    Source
    ------
    K. P. White, Simulation 69(6), 323-334, 1997, equation 1
    """
    n = len(values)
    if np.ptp(values) <= ROUND_OFF * np.abs(values).max():
        return 0
    cuts = np.arange(max(0, min(n // 2, n - FEWEST_TURNS)) + 1)
    centred = (
        values - values[n // 2 :].mean()
    )  # sums of squares of numbers far from zero would lose the scatter
    sums, squares = (np.cumsum(powers[::-1])[::-1][cuts] for powers in (centred, centred**2))
    left = n - cuts
    return int(np.argmin((squares - sums**2 / left) / left**2))


def correlation_length(values: np.ndarray) -> float:
    """Compute how many successive values count as one: `1 + 2 sum(autocorrelation)`, at least 1.

    The sum is that of the initial monotone sequence.

    Autocorrelations of a record are noise beyond some lag.  Those of lag 2k and 2k + 1 together must be
    positive and fall with k; the sum stops where they are not, and takes none for more than those before it.

    Source
    ------
    C. J. Geyer, Statist. Sci. 7(4), 473-483, 1992, section 3.3
    """
    n = len(values)
    centred = values - values.mean()
    spectrum = np.abs(np.fft.rfft(centred, 2 * n)) ** 2
    covariance = np.fft.irfft(spectrum)[: n // 2 * 2] / n
    if not covariance[0] > 0.0:
        return 1.0
    pairs = (covariance[0::2] + covariance[1::2]) / covariance[0]
    falls = np.flatnonzero(pairs <= 0.0)
    pairs = np.minimum.accumulate(pairs[: falls[0]] if len(falls) else pairs)
    return max(1.0, float(2.0 * pairs.sum() - 1.0))


def interval(values: np.ndarray, correlation: float) -> float:
    """Compute the half width of the 95 % interval of a mean, `correlation` values of which count as one.

    The variance of the sample is made unbiased for correlated values; Student's law has one degree of freedom
    less than independent values, and one at least.

    Source
    ------
    A. M. Law, Simulation Modeling and Analysis, 5th ed., 2015, section 4.4 (equations 4.7 and 4.8)
    """
    independent = max(len(values) / correlation, 2.0)
    variance = values.var() / (1.0 - 1.0 / independent)
    return float(stdtrit(max(independent - 1.0, 1.0), TWO_SIDED_95) * math.sqrt(variance / independent))


def batch_half_width(means: np.ndarray) -> np.ndarray:
    """Compute the half width of the 95 % interval of the mean of turns, (m,), by up to `BATCHES` batches.

    Parameters
    ----------
    means : one number per turn and reading, (n_turns, m); NaN is returned for fewer than two turns

    Source
    ------
    A. M. Law, Simulation Modeling and Analysis, 5th ed., 2015, section 9.5.3 (batch means, Student's t)
    """
    if len(means) < 2:
        return np.full(means.shape[1], math.nan)
    batches = [batch.mean(axis=0) for batch in np.array_split(means, min(len(means), BATCHES))]
    return stdtrit(len(batches) - 1, TWO_SIDED_95) * np.std(batches, axis=0, ddof=1) / math.sqrt(len(batches))


def drift(values: np.ndarray) -> tuple[float, float]:
    """Compute the change from first to last value by a straight line through batch means, and its half width.

    Batches are so long that their means are nearly independent; the half width is that of a slope with
    independent scatter.
    """
    batches = np.array_split(values, min(BATCHES, len(values)))
    middle = np.cumsum([len(batch) for batch in batches]) - 0.5 * np.array([len(batch) for batch in batches])
    means = np.array([batch.mean() for batch in batches])
    x = middle - middle.mean()
    slope = float(x @ means / (x @ x))
    scatter = means - means.mean() - slope * x
    freedom = len(means) - 2
    doubt = stdtrit(freedom, TWO_SIDED_95) * math.sqrt(scatter @ scatter / freedom / (x @ x))
    return slope * (len(values) - 1), float(doubt) * (len(values) - 1)
