"""Cohesion: a pull in proportion to the contact area."""

import math
from typing import NamedTuple

from nutamill.base.kernel import kernel, like
from nutamill.charge.laws.pair import PairLaw
from nutamill.charge.laws.terms import Terms, Touch

AREA_PER_DEPTH = 4.0 * math.pi
"""Contact area over overlap and reduced radius [1]: ``A = 2 pi d (2 R*)``."""


class AreaCohesion(NamedTuple):
    """Cohesion: a pull in proportion to the contact area."""


LAW = AreaCohesion()


@kernel(inline="always")
def pull(law, overlap, r_eff, pressure):
    """Return the pull of a cohesive contact area: ``F = pressure A``, ``A = 2 pi d (2 R*)``.

    It acts beside the normal law while the particles overlap.  Friction and rolling do not see it, because it
    presses the two together as much as it pulls: their load is the push of the normal law alone.

    Parameters
    ----------
    law : tag
    overlap : d [m]
    r_eff : reduced radius R* [m]
    pressure : cohesive pressure, or energy density [Pa = J/m^3]

    Returns
    -------
    pull [N], positive pulling together

    Source
    ------
    LIGGGHTS manual, "gran cohesion sjkr2", with its default ``tangential_reduce off``.
    """
    return like(AREA_PER_DEPTH, overlap) * pressure * r_eff * overlap


def cohesive_softening(pair: PairLaw, r_eff: float) -> float:
    """Return the stiffness that area cohesion takes from the normal spring [N/m], ``4 pi R* x pressure``. A
    linear spring must have more.
    """
    return AREA_PER_DEPTH * r_eff * pair.cohesive_pressure


def faults(pair: PairLaw) -> list[tuple[str, str]]:
    """Return no faults: any pressure will do."""
    return []


def terms(touch: Touch) -> dict[str, Terms]:
    """Return this law in the terms of other programs."""
    # the wall of LIGGGHTS has half the area: 2 pi d R
    pressure = (2.0 if touch.wall else 1.0) * touch.pair.cohesive_pressure
    none = Terms(missing="area cohesion")
    return {
        "Rocky": none,
        "PFC": none,
        "LAMMPS": none,
        "LIGGGHTS": Terms(" cohesion sjkr2", lines=(f"cohesionEnergyDensity {pressure:.6g}",)),
    }
