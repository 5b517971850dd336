"""Series as a screen draws them: which ones, and thinned so that no peak is lost."""

import itertools

import numpy as np

from nutamill.result import Result

MOST_SAMPLES = 2000
"""Samples of a trace; a screen is not wider."""


def traced(result: Result) -> list[str]:
    """Return the two series that are drawn first: the force and the torque of a mill, else of drives the
    torque, and forces.
    """
    names = [str(name) for name in result.series.data_vars]
    first: list[str] = [name for name in ("crank_pin_force_resultant", "driveshaft_torque") if name in names]
    others = [name for name in names if name.endswith("_torque")]
    others += [name for name in names if name.endswith(("_force_z", "_energy"))]
    return (first if len(first) == 2 else others)[:2]


def thinned(count: int, series: list[np.ndarray], most: int = MOST_SAMPLES) -> np.ndarray:
    """Return the indices of samples to draw: of each piece of time the least and the largest of every series.

    Parameters
    ----------
    count : samples of each series [1]
    series : arrays (count,)
    most : samples to draw of one series [1]

    Returns
    -------
    indices, rising; all of them where there are no more than `most`
    """
    if count <= most or not series:
        return np.arange(count)
    edges = np.linspace(0, count, max(1, most // 2) + 1).astype(int)
    chosen = {0, count - 1}
    for values in series:
        for first, end in itertools.pairwise(edges):
            piece = values[first:end]
            chosen |= {int(first + piece.argmin()), int(first + piece.argmax())}
    return np.array(sorted(chosen))
