"""Which unknown moves which row, and which measurement would settle which unknown."""

from collections.abc import Sequence

import numpy as np
from scipy.stats import sobol_indices, uniform

from nutamill.studies.identify.emulator import Emulator

POINTS = 1024
"""Points of each matrix of the estimate of indices [1]."""


def total_effects(emulators: Sequence[Emulator], unknowns: int, seed: int) -> np.ndarray:
    """Compute the total-effect index of each unknown for each row over the ranges, (n_rows, n_unknowns).

    It is the share of a row's variance that an unknown has a part in, alone and together with others.

    Source
    ------
    A. Saltelli et al., Comput. Phys. Commun. 181(2), 259-270, 2010
    """

    def rows(points: np.ndarray) -> np.ndarray:
        return np.stack([emulator.predict(points.T)[0] for emulator in emulators])

    estimate = sobol_indices(func=rows, n=POINTS, dists=[uniform()] * unknowns, rng=seed)
    return np.clip(np.nan_to_num(np.atleast_2d(estimate.total_order)), 0.0, None)


def settled(emulators: Sequence[Emulator], doubts: Sequence[float], points: np.ndarray) -> np.ndarray:
    """Compute which share of the posterior variance of each unknown one more measurement of each row would
    take away, (n_rows, n_unknowns).

    For a posterior that is normal it is the squared correlation of unknown and measurement.

    Parameters
    ----------
    doubts : scatter and discrepancy of each row together, SI
    points : the posterior, (n_points, n_unknowns)
    """
    shares = np.zeros((len(emulators), points.shape[1]))
    about = points - points.mean(axis=0)
    for number, (emulator, doubt) in enumerate(zip(emulators, doubts, strict=True)):
        mean, error = emulator.predict(points)
        off = mean - mean.mean()
        noise = float(np.mean(error**2)) + doubt**2
        variance = float(np.mean(off**2)) + noise
        size = np.mean(about**2, axis=0) * variance
        covariance = np.mean(about * off[:, None], axis=0)
        shares[number] = np.divide(covariance**2, size, out=np.zeros_like(size), where=size > 0.0)
    return shares
