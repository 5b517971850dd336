"""A Gaussian process in place of the runs of one row, with its own error and a check of that error."""

import math
import warnings
from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_triangular
from scipy.special import ndtri, stdtrit

from nutamill.base.errors import CaseError, Fault
from nutamill.studies.identify.inputs import Inputs

SAME = 1e-9
"""Spread of the members over their size below which they are the same number [1]."""
STEEP = 3.0
"""Largest over smallest member above which the logarithm of a positive row is emulated [1]: near a resonance
a row rises so steeply that a smooth process would swing everywhere else.
"""
POOR = 0.5
"""Error of members left out over the spread of all members, above which an emulator is refused [1]."""
LARGEST_LOG = 500.0
"""Largest logarithm of a row, so that extrapolation stays finite [1]."""


class CrossCheck(NamedTuple):
    """How well an emulator predicts members that are left out, one at a time."""

    error: float
    """Root mean square of what it is off, SI."""
    spread: float
    """Standard deviation of the members, SI."""
    ratio: float
    """Root mean square of what it is off over what it states to be off [1]; one if it is honest."""
    members: int
    """Members that it was fitted to [1]."""


class Process(NamedTuple):
    """A fitted Gaussian process of mean zero, with a squared exponential kernel."""

    lengths: np.ndarray
    """Lengths of the kernel, shares of the ranges, (n_inputs,)."""
    members: np.ndarray
    """Points of the members over the lengths, (n, n_inputs)."""
    amplitude: float
    """Variance of the kernel [1]."""
    weights: np.ndarray
    """Inverse of the covariance of the members times their values, (n,)."""
    inverse_root: np.ndarray
    """Inverse of the Cholesky factor of that covariance, (n, n)."""

    def predict(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return mean and variance at points (n, n_inputs), each (n,)."""
        scaled = points / self.lengths
        squares = np.sum(scaled**2, axis=1)[:, None] + np.sum(self.members**2, axis=1)
        across = self.amplitude * np.exp(scaled @ self.members.T - 0.5 * squares)
        explained = across @ self.inverse_root.T
        return across @ self.weights, np.maximum(self.amplitude - np.sum(explained**2, axis=1), 0.0)


class Emulator(NamedTuple):
    """A row over the unknowns: a fitted process of those that change its runs, times its gains."""

    process: Process | None
    """The fitted process; None where no unknown changes the runs."""
    inputs: Inputs
    """Numbers that the process depends on."""
    logarithmic: bool
    """Whether it is the logarithm of the row that is emulated."""
    offset: float
    """Mean of the members, or of their logarithms, SI."""
    scale: float
    """Standard deviation of the members, or of their logarithms, SI."""
    check: CrossCheck
    """Its check."""
    gains: np.ndarray
    """Indices of the unknowns that multiply it."""
    gain_ends: np.ndarray
    """Ends of their ranges, (n_gains, 2)."""
    alone: float = 0.0
    """Standard deviation of the row where no process is fitted, SI."""
    unseen: float = 0.0
    """Variance of what the inputs leave open, over the square of `scale` [1]."""

    def predict(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the row and the standard deviation of the emulator's error at points, each (n,), SI.

        The scatter of single runs is in neither, unless the inputs leave unknowns out.  Where members that
        were left out missed by more than was stated, the error is widened in the same ratio.

        Parameters
        ----------
        points : shares of the ranges of all unknowns, (n, n_unknowns)
        """
        low, high = self.gain_ends.T
        gain = np.prod(low + points[:, self.gains] * (high - low), axis=1)
        if self.process is None:
            return gain * self.offset, np.full(len(points), self.alone)
        mean, variance = self.process.predict(self.inputs.at(points))
        middle = self.offset + self.scale * mean
        error = max(1.0, self.check.ratio) * self.scale * np.sqrt(variance + self.unseen)
        if self.logarithmic:
            middle = np.exp(np.minimum(middle, LARGEST_LOG))
            error = middle * error
        return gain * middle, np.abs(gain) * error

    def score(self, points: np.ndarray) -> np.ndarray:
        """Return the row without its gains as an input of other emulators: in standard deviations of its
        members, or of their logarithms, (n,).
        """
        if self.process is None:
            return np.zeros(len(points))
        return self.process.predict(self.inputs.at(points))[0]


def fit_emulator(
    points: np.ndarray,
    values: np.ndarray,
    inputs: Inputs,
    gains: np.ndarray,
    gain_ends: np.ndarray,
    label: str,
    doubt: float,
    partial: bool = False,
) -> Emulator:
    """Fit a Gaussian process with one length for each unknown, and the scatter of single runs, to members.

    Parameters
    ----------
    points : shares of the ranges of all unknowns, (n, n_unknowns)
    values : what the members gave, (n,), SI; at least two are finite
    inputs, gains, gain_ends : as in `Emulator`
    label : the row, for messages
    doubt : scatter and discrepancy of the row, SI: an error below it does no harm
    partial : whether the inputs leave out numbers that change the runs: the error is then at least that of
        members left out (active variables: P. S. Craig et al., J. Am. Stat. Assoc. 96(454), 717-729, 2001)

    Raises
    ------
    CaseError : the row depends on no unknown, or the emulator fails its check

    Source
    ------
    C. E. Rasmussen, C. K. I. Williams, Gaussian Processes for Machine Learning, MIT Press, 2006, eqs. 2.25,
    2.26 and 5.12 (members left out)
    """
    finite = np.isfinite(values)
    points, values = points[finite], values[finite]
    offset, spread = float(values.mean()), float(values.std())
    if not inputs.number:
        alone = CrossCheck(0.0, spread, 0.0, len(values))
        return Emulator(None, inputs, False, offset, 0.0, alone, gains, gain_ends)
    if spread <= SAME * abs(offset):
        what = f"the row depends on no unknown: all of {len(values)} members give {offset:.6g} (SI)"
        raise CaseError(Fault(label, what, "Leave it out, or name an unknown that acts on it"))
    logarithmic = bool(values.min() > 0.0 and values.max() > STEEP * values.min())
    emulated = np.log(values) if logarithmic else values
    offset, scale = float(emulated.mean()), float(emulated.std())
    process, error, ratio, noise = _fitted(inputs.at(points), (emulated - offset) / scale)
    left_out = emulated - scale * error
    off = values - (np.exp(np.minimum(left_out, LARGEST_LOG)) if logarithmic else left_out)
    check = CrossCheck(float(np.sqrt(np.mean(off**2))), spread, ratio, len(values))
    if check.error > max(POOR * spread, doubt):
        what = (
            f"the emulator does not predict the members that are left out: it is off by {check.error:.3g}, "
            f"the members spread by {spread:.3g} (SI)"
        )
        hint = "Take more members or narrower ranges; with a charge longer runs"
        raise CaseError(Fault(label, what, hint))
    # few members let a process pass through scatter: those left out show it
    unseen = max(noise, float(np.mean(error**2))) if partial else 0.0
    return Emulator(process, inputs, logarithmic, offset, scale, check, gains, gain_ends, unseen=unseen)


def emulator_of_draws(values: np.ndarray, unknowns: int) -> Emulator:
    """Return what draws of a posterior say of a row without a fit: their mean, and a standard deviation with
    which a normal distribution has the 90 % interval that Student's gives for one more draw.

    Parameters
    ----------
    values : what the draws gave, gains included, (n,), SI; at least two are finite
    unknowns : number of all unknowns [1]

    Source
    ------
    G. J. Hahn, W. Q. Meeker, Statistical Intervals, Wiley, 1991, section 4.7 (one more of a normal sample)
    """
    values = values[np.isfinite(values)]
    count, spread = len(values), float(values.std(ddof=1))
    widened = spread * math.sqrt(1.0 + 1.0 / count) * float(stdtrit(count - 1, 0.95) / ndtri(0.95))
    none = np.array([], dtype=int)
    check = CrossCheck(spread, spread, 1.0, count)
    mean = float(values.mean())
    open_ = Inputs(np.zeros((unknowns, 0)))
    return Emulator(None, open_, False, mean, 0.0, check, none, np.zeros((0, 2)), widened)


def _fitted(points: np.ndarray, values: np.ndarray) -> tuple[Process, np.ndarray, float, float]:
    """Return the process of greatest likelihood, by how much it misses each member where it is fitted to all
    others (n,), the root mean square of that over what it states, and the variance that it takes for scatter.
    """
    # these load for a second, and are part of an extra
    from sklearn.exceptions import ConvergenceWarning
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

    smooth = ConstantKernel(4.0, (1e-2, 1e4)) * RBF(np.ones(points.shape[1]), (0.05, 100.0))
    kernel = smooth + WhiteKernel(1e-4, (1e-9, 1.0))
    regressor = GaussianProcessRegressor(kernel, alpha=1e-10, n_restarts_optimizer=1, random_state=0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)  # a length at the end of its range is no fault
        regressor.fit(points, values)
    chosen = regressor.kernel_.k1
    lengths = np.broadcast_to(chosen.k2.length_scale, points.shape[1])
    root = solve_triangular(regressor.L_, np.eye(len(values)), lower=True)
    process = Process(lengths, points / lengths, chosen.k1.constant_value, regressor.alpha_, root)
    precision = np.sum(root**2, axis=0)  # diagonal of the inverse covariance
    error = process.weights / precision
    ratio = float(np.sqrt(np.mean(error**2 * precision)))
    return process, error, ratio, float(regressor.kernel_.k2.noise_level)
