"""Frame test of a foreign machine: how its bodies answer unit forces and moments over one window.

The velocities that unit impulses give are a symmetric matrix without a negative eigenvalue for every machine
(Maxwell-Betti; its inverse is a mass).  A wrong sign, a wrong axis or a wrong reference point breaks that.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from nutamill.base.errors import Fault
from nutamill.simulation.fmus.mapping import BodyPlan
from nutamill.simulation.fmus.session import FmuSession

TOLERANCE = 0.05
"""Share of the largest response that asymmetry and negative eigenvalues may have [1]: what the solver of an
FMU may be wrong by.
"""
PAIRS = (("force", "velocity", "xyz"), ("moment", "angular_velocity", "xyz"))
"""Inputs and the outputs that belong to them."""


def wrong_mobility(
    session: FmuSession, bodies: Sequence[BodyPlan], inputs: np.ndarray, step: float
) -> Iterator[Fault]:
    """Yield a fault where the bodies of an FMU answer unit forces and moments like no machine.

    Parameters
    ----------
    session : an FMU that can go back to a stored state; it is left at its start
    bodies : its bodies
    inputs : its inputs at the start
    step : window [s]
    """
    for plan in bodies:
        names, places, answers = [], [], []
        for load, rate, axes in PAIRS:
            for k, axis in enumerate(axes):
                given, read = getattr(plan, load), plan.rates.get(rate, [])
                if given and read and given[k] >= 0 and read[k] >= 0:
                    names.append(f"{load} {axis}")
                    places.append(given[k])
                    answers.append(read[k])
        if not places:
            continue
        matrix = _responses(session, inputs, places, answers, step)
        where = f"{session.plan.where}.bodies.{plan.carrier}"
        yield from _faults(matrix, names, where)


def _responses(
    session: FmuSession, inputs: np.ndarray, places: list[int], answers: list[int], step: float
) -> np.ndarray:
    """Return the change of each answer (rows) by a unit load (columns) over a window."""

    def velocities(place: int | None) -> np.ndarray:
        session.back(0.0)
        loaded = inputs.copy()
        if place is not None:
            loaded[place] += 1.0
        return session.step(0.0, step, loaded[:-1])[answers]

    session.mark(0.0)
    plain = velocities(None)
    matrix = np.column_stack([velocities(place) - plain for place in places])
    session.back(0.0)
    session.read(inputs[:-1])
    return matrix


def _faults(matrix: np.ndarray, names: list[str], where: str) -> Iterator[Fault]:
    """Yield what is wrong with a matrix of responses."""
    size = np.sqrt(np.abs(np.diag(matrix)).max())
    largest = float(np.abs(matrix).max())
    if largest == 0.0:
        yield Fault(
            f"{where}.force", "no unit force or moment moves the body", "Look at the names of the inputs"
        )
        return
    for k, name in enumerate(names):
        if matrix[k, k] < -TOLERANCE * largest:
            what = f"a unit {name} moves the body the other way"
            yield Fault(f"{where}.{name.split()[0]}", what, "Give one of the two names a minus sign")
            return
    scale = np.sqrt(np.maximum(np.abs(np.diag(matrix)), 1e-12 * size * size))
    scaled = matrix / np.outer(scale, scale)
    wrong = np.abs(scaled - scaled.T)
    if wrong.max() > TOLERANCE * max(1.0, float(np.abs(scaled).max())):
        i, j = np.unravel_index(int(wrong.argmax()), wrong.shape)
        what = (
            f"its answers to unit loads are not symmetric: {names[int(i)]} and {names[int(j)]} do not agree"
        )
        yield Fault(where, what, "Correct the order of the names, turn or point")
