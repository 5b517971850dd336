"""Life of the rolling bearings at the joints, from the loads a run recorded and the ratings of a
catalogue.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from nutamill.analysis.load_paths import CALLED, axes_of, hodograph
from nutamill.analysis.ratings import Bearing, Ratings
from nutamill.analysis.source import any_case_of
from nutamill.analysis.summary import hours_text
from nutamill.analysis.windows import PAPER_WINDOW, steady_window, turn_series
from nutamill.base.errors import CaseError, Fault, ResultError
from nutamill.case.machine import JointEntry, Machine, drive_series
from nutamill.result import Result

EXPONENT = {"ball": 3.0, "roller": 10.0 / 3.0}
"""Exponent of the load in the life, ISO 281:2007."""

STATIC_FACTORS = {"ball": (0.6, 0.5), "roller": (1.0, 0.0)}
"""Factors X0, Y0 of deep-groove ball bearings and of roller bearings without a contact angle, ISO 76:2006."""

PARALLEL = 1e-9
"""How far the cosine of the angle between parallel axes may be from 1, from numbers that were typed [1]."""
TURN = ("revolute", "cylindrical", "point_on_line")
"""Kinds of joints that a bearing can be."""


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
    """Static safety: C0 over the largest static equivalent load P0 [1]; NaN without a static rating."""


def basic_life(dynamic_rating: float, load: float, kind: str) -> float:
    """Return the basic rating life ``L10 = 10^6 (C/P)^p`` [revolutions], ISO 281:2007."""
    return 1e6 * (dynamic_rating / load) ** EXPONENT[kind] if load > 0.0 else math.inf


def equivalent_load(radial: np.ndarray, axial: np.ndarray, bearing: Bearing) -> np.ndarray:
    """Return the dynamic equivalent load of each sample [N], ISO 281:2007: ``X Fr + Y Fa`` where Fa exceeds e
    Fr, else Fr.
    """
    both = bearing.radial_factor * radial + bearing.axial_factor * axial
    return np.where((axial > bearing.axial_limit * radial) & (bearing.axial_factor > 0.0), both, radial)


def static_load(radial: np.ndarray, axial: np.ndarray, bearing: Bearing) -> np.ndarray:
    """Return the static equivalent load of each sample [N], ISO 76:2006: ``X0 Fr + Y0 Fa``, at least Fr."""
    x, y = STATIC_FACTORS[bearing.kind]
    x = x if bearing.static_radial_factor is None else bearing.static_radial_factor
    y = y if bearing.static_axial_factor is None else bearing.static_axial_factor
    return np.maximum(radial, x * radial + y * axial)


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

    The mean of the load is taken over the whole turns of the steady window, or over its time where the case
    names no drive for its period.  The bearing turns as `turns_per_second` says.

    Raises
    ------
    CaseError : a joint that is no bearing, or has no rating; axes in which its axis stays are not recorded
    ResultError : the run has not made one turn at its last speed; nothing turns
    """
    joints = turning_joints(any_case_of(result).machine)
    if joint not in joints:
        hint = f"Known are {', '.join(joints)}" if joints else "This machine has none"
        raise CaseError(Fault(f"bearing {joint}", "must be a joint that turns", hint))
    if joint not in ratings.bearings:
        hint = f'Add [bearings.{joint}] with kind and dynamic_rating = "30 kN" from its catalogue'
        raise CaseError(Fault(f"bearing {joint}", "must have a rating, the file has none", hint))
    bearing, (axes, axis) = ratings.bearings[joint], resting_axis(result, joints[joint])
    rate = turns_per_second(result, joint, bearing, last)
    force = hodograph(result, joint, axes, last).reaction[:, :3]
    along = force @ axis
    axial = np.abs(along)
    radial = np.linalg.norm(force - along[:, None] * axis, axis=1)
    load = equivalent_load(radial, axial, bearing)
    equivalent = cycle_mean(load, bearing.kind)
    turns = bearing.life_factor * basic_life(bearing.dynamic_rating, equivalent, bearing.kind)
    if bearing.swing is not None:
        turns /= swing_share(bearing.swing)
    largest = float(static_load(radial, axial, bearing).max())
    safety = bearing.static_rating / largest if bearing.static_rating and largest > 0.0 else math.nan
    return BearingLife(
        joint,
        float(radial.mean()),
        float(axial.mean()),
        equivalent,
        turns,
        turns / rate,
        safety,
    )


def turning_joints(machine: Machine) -> dict[str, JointEntry]:
    """Return the joints that a bearing can be, by name: those that turn, and those of unbalance motors."""
    joints = {joint.name: joint for joint in machine.joints if joint.kind in TURN}
    for motor in machine.unbalance_motors:
        between = (motor.body, motor.name)
        joints[motor.name] = JointEntry(
            name=motor.name, kind="revolute", between=between, point=motor.point, axis=motor.axis
        )
    return joints


def resting_axis(result: Result, joint: JointEntry) -> tuple[str, np.ndarray]:
    """Return axes in which the axis of a joint stays where it is, and its direction in them (3,).

    The axis is fixed in body a, of a joint that turns in body b as well; and in every body that is joined to
    such a body without turning, or turns about this very direction.  The first one with a recorded attitude
    counts, or the ground.

    Raises CaseError where none of them has one.
    """
    machine, recorded = any_case_of(result).machine, axes_of(result)
    world = _unit(joint.axis or (0.0, 0.0, 1.0))  # joints that turn have an axis
    ways = [tuple(entry.between) for entry in machine.joints if _keeps(entry, world)]
    waiting = list(joint.between[:1] if joint.kind == "point_on_line" else joint.between)
    seen: list[str] = []
    while waiting:
        body = waiting.pop(0)
        if (axes := CALLED.get(body, body)) in recorded:
            entry = next((entry for entry in machine.bodies if entry.name == body), None)
            if entry is None or entry.turn is None:
                return axes, world
            turn = Rotation.from_rotvec(entry.turn.angle * _unit(entry.turn.axis))
            return axes, turn.inv().apply(world)
        seen.append(body)
        waiting += [other for way in ways if body in way for other in way if other not in (*seen, *waiting)]
    hint = 'Add [[sensors]] with kind = "attitude" of one of them, and run the case again'
    what = f"its axis turns with {' and '.join(seen)}, whose attitudes are not recorded"
    raise CaseError(Fault(f"bearing {joint.name}", what, hint))


def _keeps(joint: JointEntry, direction: np.ndarray) -> bool:
    """Return whether both bodies of a joint keep a direction (3,) that one of them keeps."""
    if joint.kind in ("fixed", "prismatic"):
        return True
    parallel = joint.axis is not None and abs(float(_unit(joint.axis) @ direction)) > 1.0 - PARALLEL
    return joint.kind in ("revolute", "cylindrical") and parallel


def _unit(vector: Sequence[float]) -> np.ndarray:
    """Return a vector of length 1 (3,)."""
    return np.asarray(vector, float) / np.linalg.norm(vector)


def turns_per_second(result: Result, joint: str, bearing: Bearing, last: float | str = PAPER_WINDOW) -> float:
    """Return how often a bearing turns, or swings to and fro, per second of the steady window [Hz].

    A drive of its joint turns it, or gears between it and a joint with a drive.  Any other bearing turns, and
    every bearing with a ``swing`` swings, once per turn of the drive over whose turns means are taken.

    Raises
    ------
    ResultError : the run has not made one turn at its last speed; no drive turns the bearing
    """
    window = steady_window(result, last)
    machine = any_case_of(result).machine
    if bearing.swing is None:
        for name, ratio in _geared(machine, joint).items():
            driven = [drive.name for drive in machine.drives if drive.joint == name]
            driven += [motor.name for motor in machine.unbalance_motors if motor.name == name]
            for angle in (drive_series(machine, drive, "angle") for drive in driven):
                if angle in result.series:
                    ends = np.interp(window.turns[[0, -1]], result.series["time"], result.series[angle])
                    turned = abs(ratio) * float(np.ptp(ends)) / (2.0 * math.pi)
                    if turned > 0.0:
                        return turned / float(window.turns[-1] - window.turns[0])
    if turn_series(result) is None:
        raise ResultError(
            f"{result.path}: bearing {joint}: a life counts turns, and no drive turns this joint. Give the "
            "case a drive, and name it as run.period."
        )
    return window.turn_rate


def _geared(machine: Machine, joint: str) -> dict[str, float]:
    """Return the joints that a joint is geared to, itself among them: by name how often it turns in a turn of
    that one [1].
    """
    turns = {joint: 1.0}
    for _ in machine.gears:
        for gear in machine.gears:
            if gear.output in turns:
                turns.setdefault(gear.input, turns[gear.output] * gear.ratio)
            if gear.input in turns:
                turns.setdefault(gear.output, turns[gear.input] / gear.ratio)
    return turns


def bearings_lines(lives: list[BearingLife]) -> list[str]:
    """Format the lives of bearings as a table."""
    width = max([len("bearing"), *(len(one.joint) for one in lives)])
    rows = [
        f"{'bearing':{width}} {'Fr (N)':>7} {'Fa (N)':>7} {'P (N)':>7} {'L10 turns':>9} "
        f"{'L10 (h)':>11} {'C0/P0':>5}"
    ]
    for one in lives:
        numbers = (
            f"{one.radial:7.1f} {one.axial:7.1f} {one.equivalent:7.1f} {one.turns:9.3g} "
            f"{hours_text(one.time)}"
        )
        safety = "-" if math.isnan(one.static_safety) else f"{one.static_safety:.3g}"
        rows.append(f"{one.joint:{width}} {numbers} {safety:>5}")
    return rows
