"""Fatigue of shafts and pins from the joint reactions of a run: rainflow cycles, Goodman's mean stress,
Miner's sum.
"""

import math
from typing import NamedTuple

import numpy as np

from nutamill.analysis.load_paths import hodograph
from nutamill.analysis.ratings import Ratings, Section
from nutamill.analysis.summary import hours_text
from nutamill.analysis.windows import PAPER_WINDOW, steady_window
from nutamill.base.errors import CaseError, Fault, missing_extra
from nutamill.base.units import in_unit
from nutamill.result import Result

POINTS = 12
"""Points around a section at which the stress is followed, of which the worst counts [1]."""
AXES = {"x": (1, 2, 0), "y": (2, 0, 1), "z": (0, 1, 2)}
"""Two cross axes and the axis of a section."""


class SectionLife(NamedTuple):
    """What a section has to bear, and for how long it does."""

    name: str
    """Name of the section."""
    peak: float
    """Largest equivalent stress [Pa]."""
    amplitude: float
    """Amplitude of the largest cycle [Pa], notch factor included."""
    mean: float
    """Mean stress of that cycle [Pa]."""
    damage: float
    """Miner's sum per turn of the drive [1], or per length of time that stands for one where nothing turns;
    infinite where the ultimate strength is reached.
    """
    time: float
    """Time until Miner's sum is one at the speed of the run [s]."""


def cycles(stress: np.ndarray) -> np.ndarray:
    """Count the rainflow cycles of a history: range, mean and count (0.5 or 1) of each, (n, 3).

    Source: ASTM E1049-85(2017), section 5.4.4, as the package ``rainflow`` counts.
    """
    try:
        import rainflow
    except ImportError:
        raise missing_extra("fatigue: counting cycles", "the package rainflow", "life") from None
    return np.array(
        [(size, mean, count) for size, mean, count, _, _ in rainflow.extract_cycles(stress)]
    ).reshape(-1, 3)


def goodman(amplitude: np.ndarray, mean: np.ndarray, ultimate: float) -> np.ndarray:
    """Return the fully reversed amplitude [Pa] that does the damage of an amplitude about a mean stress: ``Sa
    / (1 - Sm/Su)``. A compressive mean does not count as relief.

    Source: Goodman, Mechanics Applied to Engineering, 1899; Budynas and Nisbett, Shigley's Mechanical
    Engineering Design, section 6-12.
    """
    left = 1.0 - np.maximum(mean, 0.0) / ultimate
    return np.where(left > 0.0, amplitude / np.where(left > 0.0, left, 1.0), np.inf)


def miner(counted: np.ndarray, section: Section) -> float:
    """Compute Miner's sum of rainflow cycles, with Basquin's line ``N = Nf (Sf/S)^k`` and no endurance limit.

    Source: Miner, J. Appl. Mech. 12, A159-A164, 1945; elementary form without a limit: Haibach,
    Betriebsfestigkeit, 3rd ed., 2006.
    """
    harmful = goodman(
        section.stress_concentration * counted[:, 0] / 2.0, counted[:, 1], section.ultimate_strength
    )
    return float(
        (counted[:, 2] * (harmful / section.fatigue_strength) ** section.exponent).sum()
        / section.fatigue_cycles
    )


def equivalent_stress(section: Section, force: np.ndarray, moment: np.ndarray, azimuth: float) -> np.ndarray:
    """Compute the stress at a point of the rim of a section [Pa], (n,): von Mises of axial, bending and
    torsion, with the sign of the first two.

    Parameters
    ----------
    force, moment : load on the section [N], and about its middle [N m], (n, 3) each, in the section's axes
    azimuth : of the point about the section's axis [rad]

    Source
    ------
    Budynas and Nisbett, Shigley's Mechanical Engineering Design, chapters 3 and 5 (bending, torsion, von
    Mises stress of round shafts); the sign makes reversals of bending reversals of the history.
    """
    u, v, axis = AXES[section.axis]
    d, b = section.diameter, section.bore
    area = math.pi / 4.0 * (d**2 - b**2)
    resistance = math.pi / 32.0 * (d**4 - b**4) / d
    # a moment about u bends the rim at v: sigma = (M_u sin - M_v cos) / W
    bending = (moment[:, u] * math.sin(azimuth) - moment[:, v] * math.cos(azimuth)) / resistance
    direct = force[:, axis] / area + bending
    shear = moment[:, axis] / (2.0 * resistance)
    return np.where(direct < 0.0, -1.0, 1.0) * np.sqrt(direct**2 + 3.0 * shear**2)


def section_life(
    result: Result, name: str, ratings: Ratings, last: float | str = PAPER_WINDOW
) -> SectionLife:
    """Compute the fatigue of a section under the reactions of the steady window, at its worst point.

    Raises
    ------
    CaseError : a section that the ratings do not have
    NotInstalledError : the package rainflow is missing
    ResultError : the run has not made one turn at its last speed
    """
    if name not in ratings.sections:
        known = ", ".join(ratings.sections) or "none"
        raise CaseError(Fault(f"section {name}", "must be one of the ratings", f"The file has {known}"))
    section = ratings.sections[name]
    turns = hodograph(result, section.joint, section.axes, last)
    force = turns.reaction[:, :3]
    moment = turns.reaction[:, 3:] - np.cross(np.array(section.arm), force)
    lives = []
    for azimuth in 2.0 * np.pi * np.arange(POINTS) / POINTS:
        stress = equivalent_stress(section, force, moment, azimuth)
        # the history repeats: from one largest value to the next it has no open ends
        begin = int(np.abs(stress).argmax())
        counted = cycles(np.append(np.roll(stress, -begin), stress[begin]))
        largest = counted[counted[:, 0].argmax()] if len(counted) else np.array([0.0, stress.mean(), 0.0])
        lives.append((miner(counted, section), float(np.abs(stress).max()), largest))
    damage, peak, largest = max(lives, key=lambda life: (life[0], life[1]))
    if section.stress_concentration * peak >= section.ultimate_strength:
        damage = math.inf
    window = steady_window(result, last)
    per_turn = damage / (len(window.turns) - 1)
    lasts = 1.0 / (window.turn_rate * per_turn) if per_turn > 0.0 else math.inf
    return SectionLife(
        name, peak, section.stress_concentration * float(largest[0]) / 2.0, float(largest[1]), per_turn, lasts
    )


def sections_lines(lives: list[SectionLife]) -> list[str]:
    """Format the lives of sections as a table."""
    width = max([len("section"), *(len(one.name) for one in lives)])
    rows = [
        f"{'section':{width}} {'peak (MPa)':>10} {'amplitude':>9} {'mean':>9} {'damage/turn':>11} "
        f"{'life (h)':>11}"
    ]
    for one in lives:
        peak, amplitude, mean = (in_unit(value, "MPa") for value in (one.peak, one.amplitude, one.mean))
        stresses = f"{peak:10.4g} {amplitude:9.4g} {mean:9.4g}"
        rows.append(f"{one.name:{width}} {stresses} {one.damage:11.3g} {hours_text(one.time)}")
    return rows
