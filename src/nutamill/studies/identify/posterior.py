"""Which points of the ranges agree with what was measured: history matching, and the posterior."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize

from nutamill.studies.identify.emulator import Emulator
from nutamill.studies.identify.sample import cube

BLOCK, SHARE = 500, 0.1
"""Steps of the chain between two looks at its memory, at least, and as a share of its length, with which the
work of a look grows [1].
"""
MOST_STEPS = 20_000
"""Steps at which the chain is ended [1]."""
SNOOKER = 0.2
"""Share of steps along the line through another walker; the others are along differences of two [1]."""
MEMORIES = 50
"""Autocorrelation times that a chain has to hold [1]."""
MOST_POINTS = 4000
"""Points of the posterior that are used, at most [1]."""
STARTS = 12
"""Binary logarithm of the number of points among which the chain chooses its starts [1]."""


class Evidence(NamedTuple):
    """A row that is learned from: its emulator and what was measured."""

    emulator: Emulator
    """The row over the unknowns."""
    value: float
    """What was measured, SI."""
    doubt: float
    """Measurement scatter and model discrepancy together, standard deviation, SI."""


class Posterior(NamedTuple):
    """Points that agree with the rows, each as probable as the next."""

    points: np.ndarray
    """Shares of the ranges, (n_points, n_unknowns)."""
    mode: np.ndarray
    """The most probable point, (n_unknowns,)."""
    memory: float
    """Autocorrelation time of the chain, steps [1]."""
    steps: int
    """Steps of each of its walkers [1]."""

    @property
    def converged(self) -> bool:
        """Return whether the chain is long for its memory."""
        return self.steps >= MEMORIES * self.memory


def implausibility(rows: Sequence[Evidence], points: np.ndarray) -> np.ndarray:
    """Compute by how many standard deviations each row misses its measurement at points, (n, n_rows).

    Source
    ------
    I. Vernon, M. Goldstein, R. G. Bower, Bayesian Analysis 5(4), 619-669, 2010, eq. 14; three rules a point
    out (F. Pukelsheim, Am. Stat. 48(2), 88-91, 1994)
    """
    columns = []
    for row in rows:
        mean, error = row.emulator.predict(points)
        columns.append(np.abs(mean - row.value) / np.hypot(error, row.doubt))
    return np.stack(columns, axis=1)


def log_posterior(rows: Sequence[Evidence], points: np.ndarray) -> np.ndarray:
    """Compute the logarithm of the posterior density at points (n, n_unknowns) up to a constant, (n,).

    The prior is even over the unit cube.  Errors of rows are independent and normal: scatter of the
    measurement, discrepancy of the model, error of the emulator.

    Source
    ------
    M. C. Kennedy, A. O'Hagan, J. R. Stat. Soc. B 63(3), 425-464, 2001
    """
    inside = np.all((points >= 0.0) & (points <= 1.0), axis=1)
    density = np.full(len(points), -np.inf)
    held = points[inside]
    total = np.zeros(len(held))
    for row in rows:
        mean, error = row.emulator.predict(held)
        variance = error**2 + row.doubt**2
        total -= 0.5 * ((mean - row.value) ** 2 / variance + np.log(variance))
    density[inside] = total
    return density


def sample_posterior(
    rows: Sequence[Evidence], unknowns: int, seed: int, most_steps: int = MOST_STEPS
) -> Posterior:
    """Sample the posterior by an ensemble of walkers until their chain is long for its memory.

    Source
    ------
    D. Foreman-Mackey, D. W. Hogg, D. Lang, J. Goodman, Publ. Astron. Soc. Pac. 125, 306-312, 2013
    (ensemble); C. J. F. ter Braak, J. A. Vrugt, Stat. Comput. 18(4), 435-446, 2008 (steps along
    differences of walkers, which go along narrow ridges of many unknowns)
    """
    import emcee  # part of an extra

    walkers = max(32, 4 * unknowns)
    examined = cube(unknowns, STARTS, seed)
    density = log_posterior(rows, examined)
    rng = np.random.default_rng(seed)
    best = np.argsort(-(density + rng.gumbel(size=len(density))))[:walkers]  # drawn by their probability
    moves = [(emcee.moves.DEMove(), 1.0 - SNOOKER), (emcee.moves.DESnookerMove(), SNOOKER)]
    sampler = emcee.EnsembleSampler(
        walkers, unknowns, lambda x: log_posterior(rows, x), moves=moves, vectorize=True
    )
    sampler.random_state = np.random.RandomState(seed).get_state()
    state, memory = examined[best], np.inf
    while sampler.iteration < most_steps and sampler.iteration < MEMORIES * memory:
        block = max(BLOCK, int(SHARE * sampler.iteration))
        state = sampler.run_mcmc(state, min(block, most_steps - sampler.iteration))
        memory = float(np.max(sampler.get_autocorr_time(tol=0)))
        memory = memory if np.isfinite(memory) else np.inf
    steps = sampler.iteration
    discard = min(steps // 2, int(5 * memory)) if np.isfinite(memory) else steps // 2
    chain = sampler.get_chain(discard=discard, flat=True)
    points = chain[:: max(1, len(chain) // MOST_POINTS)][:MOST_POINTS]
    mode = _mode(rows, points[np.argmax(log_posterior(rows, points))])
    return Posterior(points, mode, memory, steps)


def _mode(rows: Sequence[Evidence], start: np.ndarray) -> np.ndarray:
    """Return the most probable point near a start."""
    solution = minimize(
        lambda x: -float(log_posterior(rows, x[None, :])[0]),
        start,
        method="Nelder-Mead",
        bounds=[(0.0, 1.0)] * len(start),
        options={"maxiter": 400 * len(start), "xatol": 1e-5, "fatol": 1e-6},
    )
    return np.clip(solution.x, 0.0, 1.0)
