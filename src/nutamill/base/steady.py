"""Steady or not: where the steady part of a record begins, its mean, and how uncertain that mean is.

Pure functions of numbers.  A mill's readings repeat once or twice per turn, so that everything here is about
one number per whole turn: its mean, its root mean square, or its swing.  A record is **steady** when what is
kept of it has no drift beyond what its scatter explains, or none that matters.
"""

import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.special import stdtrit

FEWEST_TURNS = 5
"""Whole turns below which nothing is said about steadiness [1]."""
BATCHES = 10
"""Largest number of batches of turns from which an interval is estimated, or in which a drift is looked for
[1].
"""
PRECISION = 0.01
"""Share of a reading's size by which its mean may drift over what is kept, and still be called steady [1]."""
ROUND_OFF = 1e-9
"""Share of its size by which a reading may vary and still be called constant [1]."""
TWO_SIDED_95 = 0.975
"""Student's quantile is taken here for an interval that holds 95 %."""


class SteadyMean(NamedTuple):
    """The mean of the steady part of a record of one number per turn."""

    mean: float
    """Mean of the turns kept, unit of the record."""
    half_width: float
    """Half width of its 95 % confidence interval, correlation of the turns included, unit of the record."""
    first: int
    """First turn kept, counted from 0 [1]."""
    turns: int
    """Turns kept [1]."""
    correlation: float
    """Turns that count as one independent value [1]."""
    drift: float
    """Change of the mean from the first to the last turn kept, as a straight line has it, unit of the
    record.
    """
    steady: bool
    """Whether that drift is explained by the scatter, or smaller than it matters."""


def whole_turns(time: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Times [s] (n + 1,) at which the whole turns begin and end that fit into the record, counted back from
    its end.

    Parameters
    ----------
    time : sample times [s], (n_samples,)
    angle : crank angle at them [rad], rising, (n_samples,)
    """
    if not len(time):
        return np.empty(0)
    count = math.floor((angle[-1] - angle[0]) / math.tau + 1e-9)
    return np.interp(angle[-1] - math.tau * np.arange(count, -1, -1), angle, time)


def turn_means(time: np.ndarray, value: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """Mean of `value` over each turn, (n,), by the trapezoidal rule: `value` sampled at `time` [s], turns
    between `turns` [s] (n + 1,).
    """
    integral = np.concatenate(([0.0], np.cumsum(0.5 * np.diff(time) * (value[1:] + value[:-1]))))
    return np.diff(np.interp(turns, time, integral)) / np.diff(turns)


def turn_swings(time: np.ndarray, value: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """Half of the largest less the smallest sample of each turn, (n,); arguments as of `turn_means`."""
    edges = np.searchsorted(time, turns)
    slices = [value[begin : max(end, begin + 1)] for begin, end in itertools.pairwise(edges)]
    return np.array([0.5 * np.ptp(inside) for inside in slices])


def steady_mean(
    values: Sequence[float] | np.ndarray, size: float | None = None, precision: float = PRECISION
) -> SteadyMean:
    """Cut off what comes before the steady part of a record, and take the mean of the rest with its 95 %
    interval.

    The cut is the marginal standard error rule; half of the record at most is cut off.  The rest is called
    steady if a straight line through it has no slope beyond its uncertainty, or changes by less than
    `precision` times `size` from end to end.

    Parameters
    ----------
    values : one number per turn, (n,)
    size : what the drift is compared with, unit of `values`; the root mean square of the turns kept if None
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
        raise ValueError("must be finite numbers, they are not")
    first = truncation(values)
    kept = values[first:]
    change, doubt = drift(kept)
    size = float(np.sqrt(np.mean(kept**2))) if size is None else size
    correlation = correlation_length(kept)
    return SteadyMean(
        mean=float(kept.mean()),
        half_width=interval(kept, correlation),
        first=first,
        turns=len(kept),
        correlation=correlation,
        drift=change,
        steady=abs(change) <= max(doubt, precision * size),
    )


def truncation(values: np.ndarray) -> int:
    """How many values to cut off at the beginning: the least `sum((y - mean)^2) / n^2` of what is left, half
    at most, and never so many that fewer than `FEWEST_TURNS` are left.

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
    """How many successive values count as one: `1 + 2 sum(autocorrelation)`, at least 1, by the initial
    monotone sequence.

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
    """Half width of the 95 % interval of the mean of `values`, `correlation` of which count as one.

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
    """Half width of the 95 % interval of the mean of turns, (m,), from the scatter of up to `BATCHES` batches
    of them.

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
    """Change from the first to the last value along the line of least squares through batch means, and its 95
    % half width.

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
