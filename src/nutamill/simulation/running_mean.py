"""The mean of a reading while a run goes on, turn by turn, and how uncertain it is."""

import math

import numpy as np

from nutamill.base.steady import batch_half_width


class RunningMean:
    """Mean of readings over the whole turns so far; rows are added as they come."""

    def __init__(self, readings: int):
        self._means: list[np.ndarray] = []
        self._integral = np.zeros(readings)
        self._began: float | None = None
        self._turn = 0
        self._last: tuple[float, float, np.ndarray] | None = None

    def add(self, time: np.ndarray, angle: np.ndarray, values: np.ndarray) -> None:
        """Add rows: times [s] (n,), rising crank angles [rad] (n,), readings (n, readings).

        Trapezoidal rule; a turn ends at the first row at or after its angle, so that its length is right to
        one row.
        """
        for at, turned, value in zip(time, np.abs(angle), values, strict=True):
            if self._last is not None and self._began is not None:
                self._integral += 0.5 * (at - self._last[0]) * (value + self._last[2])
            turn = math.floor(turned / math.tau)
            if self._last is not None and turn > self._turn:
                if self._began is not None:
                    self._means.append(self._integral / (at - self._began))
                self._integral, self._began = np.zeros_like(self._integral), at
            self._turn, self._last = turn, (at, turned, value)

    @property
    def turns(self) -> int:
        """Whole turns so far."""
        return len(self._means)

    def mean(self) -> np.ndarray:
        """Return the mean over the whole turns (readings,), NaN before the first."""
        return np.mean(self._means, axis=0) if self._means else np.full_like(self._integral, math.nan)

    def half_width(self) -> np.ndarray:
        """Return the half width of the 95 % interval of the mean (readings,), as
        `nutamill.base.steady.batch_half_width`, NaN before the second turn.
        """
        return batch_half_width(np.reshape(self._means, (self.turns, len(self._integral))))
