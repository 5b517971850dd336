"""Sums of the statistics over all threads: as a checkpoint holds them, put back, and over processes."""

from collections.abc import Callable

import numpy as np

from nutamill.charge.measures.statistics import ChargeStatistics
from nutamill.charge.model import ImpactBook


def _by_thread(sums: ChargeStatistics, impacts: ImpactBook) -> dict[str, np.ndarray]:
    """Return all arrays with a first axis of threads, by their names in a checkpoint."""
    return {
        "walls": sums.walls,
        "fields": sums.fields,
        "neighbours": sums.neighbours,
        "spectra": impacts.spectra,
        "cut": impacts.cut,
    }


def gathered(sums: ChargeStatistics, impacts: ImpactBook) -> dict[str, np.ndarray]:
    """Return the sums over all threads by name, as a checkpoint holds them: the same for any number of
    threads.
    """
    return {
        "samples": sums.samples.copy(),
        **{name: array.sum(axis=0) for name, array in _by_thread(sums, impacts).items()},
    }


def put_back(sums: ChargeStatistics, impacts: ImpactBook, saved: dict[str, np.ndarray]) -> None:
    """Set the sums to those that `gathered` returned."""
    clear(sums, impacts)
    for name, array in _by_thread(sums, impacts).items():
        array[0] = saved[name]
    sums.samples[...] = saved["samples"]


def clear(sums: ChargeStatistics, impacts: ImpactBook) -> None:
    """Set the sums to zero, of the charge on all threads."""
    for array in _by_thread(sums, impacts).values():
        array[...] = 0


def add_to_first(
    sums: ChargeStatistics,
    impacts: ImpactBook,
    total: Callable[[np.ndarray], np.ndarray],
    first: bool,
) -> None:
    """Add the sums of all processes up on the first, and set those of the others to zero.

    Parameters
    ----------
    total : sums an array over all processes, which all call it
    first : whether this process is the first; it counts the samples
    """
    wholes = {name: total(array.sum(axis=0)) for name, array in _by_thread(sums, impacts).items()}
    clear(sums, impacts)
    if first:
        for name, array in _by_thread(sums, impacts).items():
            array[0] = wholes[name]
