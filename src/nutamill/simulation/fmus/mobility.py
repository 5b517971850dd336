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
    if not matrix.any():
        hint = "Look at the names of the inputs"
        yield Fault(f"{where}.force", "no unit force or moment moves the body", hint)
        return
    kinds = np.array([name.split()[0] for name in names])
    sizes = np.array([np.abs(matrix[np.ix_(kinds == kind, kinds == kind)]).max() for kind in kinds])
    scale = np.sqrt(np.where(sizes > 0.0, sizes, 1.0))
    scaled = matrix / np.outer(scale, scale)
    for k, name in enumerate(names):
        if scaled[k, k] < -TOLERANCE:
            what = f"a unit {name} moves the body the other way"
            yield Fault(f"{where}.{kinds[k]}", what, "Give one of the two names a minus sign")
            return
    wrong = np.abs(scaled - scaled.T)
    lowest = np.linalg.eigvalsh(0.5 * (scaled + scaled.T)).min()
    if wrong.max() > TOLERANCE or lowest < -TOLERANCE:
        i, j = np.unravel_index(int(np.abs(scaled - np.diag(np.diag(scaled))).argmax()), wrong.shape)
        what = (
            f"its answers to unit loads are those of no machine, look at {names[int(j)]} and {names[int(i)]}"
        )
        yield Fault(where, what, "Correct the order of the names, turn or point")
