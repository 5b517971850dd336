"""Life of the rolling bearings at the joints, from the loads a run recorded and the ratings of a
catalogue.
"""

import math
from typing import NamedTuple

import numpy as np

from nutamill.analysis.load_paths import hodograph
from nutamill.analysis.ratings import Bearing, Ratings
from nutamill.analysis.summary import hours_text
from nutamill.analysis.windows import PAPER_WINDOW
from nutamill.base.errors import CaseError, Fault
from nutamill.result import Result

EXPONENT = {"ball": 3.0, "roller": 10.0 / 3.0}
"""Exponent of the load in the life, ISO 281:2007."""

AXIS = {
    "intermediate_shaft_bearing": ("ground", 2),
    "driveshaft_bearing": ("frame", 2),
    "pin_joint": ("crank", 2),
    "chamber_pivot": ("chamber", 0),
    "yoke_pivot": ("frame", 1),
}
"""Axes and axis of each joint that a bearing can be."""


class BearingLife(NamedTuple):
    """What a bearing has to carry, and for how long it does."""

    joint: str
    """The joint it is at."""
    radial: float
    """Mean radial load [N]."""
    axial: float
    """Mean magnitude of the axial load [N]."""
    equivalent: float
    """Equivalent dynamic load over the cycle P [N]."""
    turns: float
    """Life that 90 % reach [revolutions], or [to-and-fro swings]."""
    time: float
    """The same at the speed of the run [s]."""
    static_safety: float
    """C0 over the largest load [1]; NaN without a static rating."""


def basic_life(dynamic_rating: float, load: float, kind: str) -> float:
    """Return the basic rating life ``L10 = 10^6 (C/P)^p`` [revolutions], ISO 281:2007."""
    return 1e6 * (dynamic_rating / load) ** EXPONENT[kind] if load > 0.0 else math.inf


def equivalent_load(radial: np.ndarray, axial: np.ndarray, bearing: Bearing) -> np.ndarray:
    """Return the dynamic equivalent load of each sample [N], ISO 281:2007: ``X Fr + Y Fa`` where Fa exceeds e
    Fr, else Fr.
    """
    both = bearing.radial_factor * radial + bearing.axial_factor * axial
    return np.where((axial > bearing.axial_limit * radial) & (bearing.axial_factor > 0.0), both, radial)


def cycle_mean(load: np.ndarray, kind: str) -> float:
    """Return the steady load [N] with the life of a load that varies over the turn: ``(mean P^p)^(1/p)`` over
    equal angles.

    Source: Harris, Rolling Bearing Analysis, 4th ed., 2001, chapter 18 (variable loads, by Palmgren's linear
    damage).
    """
    p = EXPONENT[kind]
    return float(np.mean(load**p) ** (1.0 / p))


def swing_share(swing: float) -> float:
    """Return the revolutions [1] that one oscillation counts as: ``4 swing / 2 pi`` for the half angle
    `swing` [rad]. Harris, Rolling Bearing Analysis, 4th ed., 2001, chapter 18 (oscillating bearings).
    """
    return 4.0 * swing / (2.0 * math.pi)


def bearing_life(
    result: Result, joint: str, ratings: Ratings, last: float | str = PAPER_WINDOW
) -> BearingLife:
    """Compute the L10 life of the bearing at a joint under the loads of the steady window.

    The load repeats with the turn, so that its mean is taken over the turn and the speed is that of the
    driveshaft.

    Raises
    ------
    CaseError : a joint that is no bearing, or has no rating
    ResultError : the run has not made one turn at its last speed
    """
    if joint not in AXIS:
        raise CaseError(
            Fault(f"bearing {joint}", "must be a joint that turns", f"Known are {', '.join(AXIS)}")
        )
    if joint not in ratings.bearings:
        hint = f'Add [bearings.{joint}] with kind and dynamic_rating = "30 kN" from its catalogue'
        raise CaseError(Fault(f"bearing {joint}", "must have a rating, the file has none", hint))
    bearing, (axes, axis) = ratings.bearings[joint], AXIS[joint]
    force = hodograph(result, joint, axes, last).reaction[:, :3]
    axial = np.abs(force[:, axis])
    radial = np.linalg.norm(np.delete(force, axis, axis=1), axis=1)
    load = equivalent_load(radial, axial, bearing)
    equivalent = cycle_mean(load, bearing.kind)
    turns = bearing.life_factor * basic_life(bearing.dynamic_rating, equivalent, bearing.kind)
    if bearing.swing is not None:
        turns /= swing_share(bearing.swing)
    speed = float(result.series["driveshaft_speed"].values[-1])
    safety = bearing.static_rating / load.max() if bearing.static_rating else math.nan
    return BearingLife(
        joint,
        float(radial.mean()),
        float(axial.mean()),
        equivalent,
        turns,
        turns * 2.0 * math.pi / speed,
        safety,
    )


def bearings_lines(lives: list[BearingLife]) -> list[str]:
    """Format the lives of bearings as a table."""
    rows = [
        f"{'bearing':27} {'Fr (N)':>9} {'Fa (N)':>9} {'P (N)':>9} {'L10 (turns)':>12} "
        f"{'L10 (h)':>11} {'C0/P max':>9}"
    ]
    for one in lives:
        numbers = (
            f"{one.radial:9.4g} {one.axial:9.4g} {one.equivalent:9.4g} {one.turns:12.4g} "
            f"{hours_text(one.time)}"
        )
        safety = "-" if math.isnan(one.static_safety) else f"{one.static_safety:.3g}"
        rows.append(f"{one.joint:27} {numbers} {safety:>9}")
    return rows
