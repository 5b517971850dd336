"""Points that fill the ranges of the unknowns, or what earlier stages have not ruled out of them."""

from collections.abc import Callable

import numpy as np
from scipy.spatial.distance import cdist
from scipy.stats import qmc

from nutamill.base.errors import CaseError, Fault
from nutamill.studies.identify.inputs import Inputs

CANDIDATES = 15
"""Binary logarithm of the number of points that are examined at once for what is not ruled out [1]."""
MOST_BLOCKS = 16
"""Such blocks of points that are examined where too few are left, at most [1]."""
SPARE = 4
"""Points that are then looked for, for each that is asked for, so that they can be chosen far apart [1]."""


def filling_points(unknowns: int, count: int, seed: int) -> np.ndarray:
    """Return points that fill the unit cube evenly, (count, unknowns).

    Source
    ------
    R. Jin, W. Chen, A. Sudjianto, J. Stat. Plan. Inference 134(1), 268-287, 2005 (the latin hypercube of low
    discrepancy, as in SciPy)
    """
    return qmc.LatinHypercube(unknowns, optimization="random-cd", rng=seed).random(count)


def cube(unknowns: int, exponent: int, seed: int) -> np.ndarray:
    """Return 2^exponent points of a scrambled Sobol sequence, (2^exponent, unknowns)."""
    return qmc.Sobol(unknowns, rng=seed).random_base2(exponent)


def points_left(
    unknowns: int,
    deciding: np.ndarray,
    count: int,
    seed: int,
    plausible: Callable[[np.ndarray], np.ndarray],
    stage: str,
    inputs: Inputs,
) -> np.ndarray:
    """Return points that fill what is not ruled out of the unit cube, (count, unknowns).

    Of the points of a Sobol sequence that are not ruled out, each next one is the farthest from those chosen
    before, in the numbers that its runs depend on.

    Parameters
    ----------
    deciding : which unknowns the points differ in, as indices; the others are in the middle
    plausible : whether points (n, unknowns) are not ruled out, (n,)
    stage : name of the stage, for messages
    inputs : these numbers

    Raises
    ------
    CaseError : fewer points are left than are asked for
    """
    sequence = qmc.Sobol(len(deciding), rng=seed)
    left, enough, blocks = np.zeros((0, unknowns)), count, 0
    while len(left) < enough and blocks < MOST_BLOCKS:
        block = np.full((2**CANDIDATES, unknowns), 0.5)
        block[:, deciding] = sequence.random(len(block))
        left, blocks = np.vstack([left, block[plausible(block)]]), blocks + 1
        enough = count if len(left) >= count and blocks == 1 else SPARE * count
    if len(left) < count:
        examined = blocks * 2**CANDIDATES
        what = f"the rows before it rule out all but {len(left)} of {examined} points of the ranges"
        hint = "Widen the ranges, state a larger discrepancy, or take fewer members"
        raise CaseError(Fault(f"stage {stage}", what, hint))
    seen = inputs.at(left)
    chosen = [0]
    distance = cdist(seen[:1], seen)[0]
    while len(chosen) < count:
        chosen.append(int(np.argmax(distance)))
        distance = np.minimum(distance, cdist(seen[chosen[-1] :][:1], seen)[0])
    return left[chosen]
