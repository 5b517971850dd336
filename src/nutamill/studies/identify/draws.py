"""Members that are draws of the posterior."""

from collections.abc import Sequence

import numpy as np

from nutamill.base.errors import CaseError, Fault
from nutamill.studies.identify.posterior import Evidence, sample_posterior
from nutamill.studies.identify.problem import Problem, Row

STEPS = 5000
"""Steps of the chain at most [1]: a few draws need no ends of intervals."""


def drawn_points(problem: Problem, evidence: Sequence[Evidence], stage: int) -> np.ndarray:
    """Return points for a stage, drawn from the posterior of the rows before it, (n_members, n_unknowns), of
    which the drawing holds the cases of its rows. Unknowns that those rows do not know are drawn from their
    ranges.

    Raises
    ------
    CaseError : the drawing holds fewer points of the posterior than the stage has members
    """
    asked, seed = problem.stages[stage], problem.seed + stage
    points = sample_posterior(evidence, len(problem.unknowns), seed, STEPS).points
    rng = np.random.default_rng(seed)
    open_ones = sorted(set(range(len(problem.unknowns))) - problem.learned_before(stage))
    points[:, open_ones] = rng.random((len(points), len(open_ones)))
    rows = problem.rows_of(asked.name)
    chosen: list[np.ndarray] = []
    for point in rng.permutation(points):
        if holds(problem, rows, point):
            chosen.append(point)
        if len(chosen) == asked.members:
            return np.array(chosen)
    what = f"the drawing holds only {len(chosen)} of {len(points)} points of the posterior"
    raise CaseError(Fault(f"stage {asked.name}", what, "Narrow the ranges or take fewer members"))


def holds(problem: Problem, rows: Sequence[Row], point: np.ndarray) -> bool:
    """Return whether the drawing holds the cases of rows at a point."""
    try:
        for row in rows:
            problem.case_at(row, point)
    except CaseError:
        return False
    return True
