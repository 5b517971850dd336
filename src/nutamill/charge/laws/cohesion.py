"""Cohesion of a contact: none, or a pull in proportion to the contact area."""

import math

from nutamill.base.kernel import by_type, kernel, like
from nutamill.charge.laws.tags import AreaCohesion, NoCohesion

AREA_PER_DEPTH = 4.0 * math.pi
"""Contact area over overlap and reduced radius [1]: ``A = 2 pi d (2 R*)``."""


@kernel(inline="always")
def no_pull(law, overlap, r_eff, pressure):
    """No pull; parameters as `area_pull`."""
    return like(0.0, overlap)


@kernel(inline="always")
def area_pull(law, overlap, r_eff, pressure):
    """Pull of a cohesive contact area: ``F = pressure A``, ``A = 2 pi d (2 R*)``.

    It acts beside the normal law while the particles overlap; friction and rolling do not see it, for it
    presses the two together as much as it holds them: their load is the push of the normal law alone.

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


cohesive_pull = by_type({NoCohesion: no_pull, AreaCohesion: area_pull})
"""Pull of the law whose tag comes first; as `area_pull`."""
