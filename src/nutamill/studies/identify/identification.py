"""The result of an identification: posterior, predictions of all rows, indices."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from nutamill.base.errors import CaseError, Fault
from nutamill.base.notebook_hook import notebook_html
from nutamill.studies.identify.draws import holds
from nutamill.studies.identify.emulator import Emulator
from nutamill.studies.identify.indices import settled, total_effects
from nutamill.studies.identify.posterior import (
    MOST_STEPS,
    Evidence,
    Posterior,
    implausibility,
    log_posterior,
    sample_posterior,
)
from nutamill.studies.identify.problem import Problem
from nutamill.studies.identify.sample import cube
from nutamill.studies.identify.table import lines

LEVELS = (0.05, 0.5, 0.95)
"""Quantiles of intervals and their middle [1]."""
PRIOR = 11
"""Binary logarithm of the number of points that stand for the ranges [1]."""
CHECKED = 300
"""Points of the posterior of which the case is made where members were refused, at most [1]."""


class Identification(NamedTuple):
    """What is known of the unknowns after the rows, and what follows for each row."""

    problem: Problem
    """What was asked."""
    emulators: list[Emulator]
    """The emulator of each row."""
    posterior: Posterior
    """Points that agree with the rows."""
    prior_rows: np.ndarray
    """Quantiles `LEVELS` of each row over the ranges, (n_rows, 3), SI."""
    posterior_rows: np.ndarray
    """Quantiles `LEVELS` of each row over the posterior, with all errors, (n_rows, 3), SI."""
    effects: np.ndarray
    """Total-effect index of each unknown for each row, (n_rows, n_unknowns)."""
    settles: np.ndarray
    """Share of the variance of each unknown that one more measurement of each row would take away,
    (n_rows, n_unknowns).
    """
    least: np.ndarray
    """Least implausibility of each row by itself over the ranges, (n_rows,); NaN without a measurement, and
    for rows predicted from draws.
    """
    refused: int
    """Members that the drawing could not hold [1]."""
    files: list[Path]
    """Tables, figures and machine files that were written."""

    @property
    def unknowns(self) -> np.ndarray:
        """Quantiles `LEVELS` of each unknown, (n_unknowns, 3), SI."""
        return np.quantile(self.problem.values(self.posterior.points), LEVELS, axis=0).T

    @property
    def inside(self) -> list[bool | None]:
        """Whether the measurement of each row is within its 90 % interval, None without a measurement."""
        return [
            bool(low <= row.value <= high) if np.isfinite(row.value) else None
            for row, (low, _, high) in zip(self.problem.rows, self.posterior_rows, strict=True)
        ]

    def lines(self) -> list[str]:
        """Format the identification as text: unknowns, rows, indices."""
        return lines(self)

    def _repr_html_(self) -> str:
        return notebook_html("campaigns.identification_html", self)


def identification_of(
    problem: Problem, emulators: Sequence[Emulator], refused: int = 0, steps: int = MOST_STEPS
) -> Identification:
    """Sample the posterior, predict all rows and compute the indices.

    Parameters
    ----------
    emulators : the emulator of each row
    refused : members that the drawing could not hold [1]: where there are any, points of the posterior that
        it cannot hold are left out
    steps : steps of the chain at most [1]

    Raises
    ------
    CaseError : the drawing can hold no point of the posterior
    """
    evidence = [
        Evidence(emulator, row.value, row.doubt)
        for emulator, row in zip(emulators, problem.rows, strict=True)
        if row.learned
    ]
    unknowns = len(problem.unknowns)
    posterior = sample_posterior(evidence, unknowns, problem.seed, steps)
    if refused:
        posterior = _held(problem, posterior, evidence)
    prior = cube(unknowns, PRIOR, problem.seed)
    doubts = [row.doubt for row in problem.rows]
    rng = np.random.default_rng(problem.seed)
    least = [
        float(implausibility([Evidence(emulator, row.value, row.doubt or 1e-300)], prior).min())
        if np.isfinite(row.value) and not problem.drawn(row)
        else np.nan
        for emulator, row in zip(emulators, problem.rows, strict=True)
    ]
    return Identification(
        problem=problem,
        emulators=list(emulators),
        posterior=posterior,
        prior_rows=predictive(emulators, doubts, prior, rng),
        posterior_rows=predictive(emulators, doubts, posterior.points, rng),
        effects=total_effects(emulators, unknowns, problem.seed),
        settles=settled(emulators, doubts, posterior.points),
        least=np.array(least),
        refused=refused,
        files=[],
    )


def predictive(
    emulators: Sequence[Emulator], doubts: Sequence[float], points: np.ndarray, rng: np.random.Generator
) -> np.ndarray:
    """Compute the quantiles `LEVELS` of measurements of rows over points, (n_rows, 3), SI: unknowns, error of
    the emulator, discrepancy and scatter vary.
    """
    rows = []
    for emulator, doubt in zip(emulators, doubts, strict=True):
        mean, error = emulator.predict(points)
        rows.append(np.quantile(mean + np.hypot(error, doubt) * rng.standard_normal(len(mean)), LEVELS))
    return np.array(rows)


def _held(problem: Problem, posterior: Posterior, evidence: Sequence[Evidence]) -> Posterior:
    """Return the points of a posterior that the drawing can hold, with the most probable of them."""
    points = posterior.points[:: max(1, len(posterior.points) // CHECKED)]
    rows = list({tuple(problem.columns(row)): row for row in problem.rows}.values())

    def held(point: np.ndarray) -> bool:
        return holds(problem, rows, point)

    sound = points[[held(point) for point in points]]
    if not len(sound):
        hint = "Check the measured values, or state a larger discrepancy"
        raise CaseError(Fault("learn", "the drawing can hold no point that agrees with the rows", hint))
    mode = posterior.mode if held(posterior.mode) else sound[np.argmax(log_posterior(evidence, sound))]
    return posterior._replace(points=sound, mode=mode)
