"""What an emulator depends on: unknowns, sums of two, and rows of earlier stages."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

SCORES = 4.0
"""Standard deviations of a row over its members that count as much as the whole range of an unknown [1]."""


class Inputs(NamedTuple):
    """Numbers that runs depend on, over the shares of the unknowns."""

    mixed: np.ndarray
    """How those that are unknowns, or sums of two, follow from the shares, (n_unknowns, n_mixed)."""
    scores: tuple[Callable[[np.ndarray], np.ndarray], ...] = ()
    """`Emulator.score` of the rows of earlier stages among them."""

    @property
    def number(self) -> int:
        """How many they are [1]."""
        return self.mixed.shape[1] + len(self.scores)

    def at(self, points: np.ndarray) -> np.ndarray:
        """Return the numbers at points (n, n_unknowns), (n, number)."""
        return np.column_stack([points @ self.mixed, *(score(points) / SCORES for score in self.scores)])
