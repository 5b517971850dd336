"""Capillary bridge: the pull of a drop of liquid between two bodies, formed at touch and broken at rupture.

``F = 2 pi R gamma cos(theta)/(1 + 1.05 S + 2.5 S^2)`` with ``S = s sqrt(R/V)`` over the gap s, and the full
pull while the solids touch.  R is twice the reduced radius: ``2 R1 R2/(R1 + R2)``, and 2 R at a wall.  The
bridge ruptures at the gap ``s_c = R (1 + theta/2)(V*^(1/3) + V*^(2/3)/10)`` with ``V* = V/R^3``.  Two bodies
that come near without a bridge feel no pull: parting them costs the work of `separation_work`, which their
coming together did not give.

A pair that has a viscosity has a viscous film beside the bridge.

Sources: C. D. Willett, M. J. Adams, S. A. Johnson and J. P. K. Seville, "Capillary bridges between two
spherical bodies", Langmuir 16 (2000) (the force, the rupture distance); B. V. Derjaguin's approximation for
unequal spheres, held there to be accurate for small volumes.
"""

import math
from typing import NamedTuple

from nutamill.base.kernel import kernel, like
from nutamill.base.units import shown
from nutamill.charge.laws import viscous_film
from nutamill.charge.laws.pair import PairLaw
from nutamill.charge.laws.terms import Terms, Touch


class CapillaryBridge(NamedTuple):
    """Film: capillary bridges, with a viscous film where a pair has a viscosity."""


LAW = CapillaryBridge()

MOST_VOLUME = 1e-3
"""Largest volume of a bridge over R^3 [1] for which the closed form holds."""
MOST_ANGLE = math.radians(40.0)
"""Largest contact angle for which it holds [rad]."""
LINEAR, SQUARE = 1.05, 2.5
"""Coefficients of S and S^2 in the closed form [1]."""
NONE = (0.0, 1e-18, 0.0, 0.0)
"""Numbers of a pair without bridge, behind those of its film: no pull, and rupture where the gap begins."""


def numbers(pair: PairLaw) -> list[float]:
    """Return what the film of a pair reads, as `viscous_film.numbers` (3), and of the bridge ``2 pi gamma
    cos(theta)`` [N/m], the volume [m^3], and the rupture distance as ``a + b/R``: a [m] and b [m^2].
    """
    film = viscous_film.numbers(pair)
    if pair.bridge_volume == 0.0:
        return [*film, *NONE]
    pull = 2.0 * math.pi * pair.surface_tension * math.cos(pair.contact_angle)
    wide, root = 1.0 + 0.5 * pair.contact_angle, pair.bridge_volume ** (1.0 / 3.0)
    return [*film, pull, pair.bridge_volume, wide * root, 0.1 * wide * root * root]


def reach(pair: PairLaw, radius: float) -> float:
    """Return the largest gap across which a film or a bridge acts [m] between particles of at least `radius`
    [m]: small particles have the longest bridges.
    """
    return max(viscous_film.reach(pair, radius), rupture_distance(pair, 0.5 * radius))


def faults(pair: PairLaw) -> list[tuple[str, str]]:
    """Return what is wrong with the bridge and the film of a pair, and what to write instead."""
    faulty = viscous_film.faults(pair)
    if pair.bridge_volume == 0.0:
        return faulty
    if not (math.isfinite(pair.bridge_volume) and pair.bridge_volume > 0.0):
        faulty.append((f"bridge_volume must be 0 or more, got {pair.bridge_volume:g} m^3", ""))
    if not (math.isfinite(pair.surface_tension) and pair.surface_tension > 0.0):
        what = f"surface_tension must be positive, got {pair.surface_tension:g} N/m"
        faulty.append((what, "Water has 0.072 N/m; a pair without bridge has bridge_volume = 0"))
    if not 0.0 <= pair.contact_angle <= MOST_ANGLE:
        most, angle = shown(MOST_ANGLE, "deg", "g"), shown(pair.contact_angle, "deg", ".4g")
        what = f"contact_angle must be from 0 to {most}, got {angle}"
        faulty.append((what, "The closed form of the bridge holds for liquids that wet"))
    return faulty


@kernel(inline="always")
def pull(p, gap, r_eff):
    """Return the pull of a bridge [N].

    Parameters
    ----------
    p : `numbers` of the pair behind those of the film (4)
    gap : [m], 0 in contact
    r_eff : reduced radius [m]
    """
    r = r_eff + r_eff
    one = like(1.0, gap)
    ratio = gap * gap * r / p[1]
    return p[0] * r / (one + like(LINEAR, gap) * ratio ** like(0.5, gap) + like(SQUARE, gap) * ratio)


@kernel(inline="always")
def rupture(p, r_eff):
    """Return the gap at which a bridge breaks [m]. Parameters are those of `pull`."""
    return p[2] + p[3] / (r_eff + r_eff)


def rupture_distance(pair: PairLaw, r_eff: float) -> float:
    """Return the gap at which the bridge of a pair breaks [m], 0 without bridge. `r_eff` is the reduced
    radius [m].
    """
    return rupture(tuple(numbers(pair)[3:]), r_eff)


def largest_pull(pair: PairLaw, r_eff: float) -> float:
    """Return the pull of the bridge of two bodies that touch [N], 0 without bridge. `r_eff` is the reduced
    radius [m].
    """
    return pull(tuple(numbers(pair)[3:]), 0.0, r_eff)


def separation_work(pair: PairLaw, r_eff: float) -> float:
    """Return the work that parts two bodies from touch to rupture [J], the integral of `pull` in closed form.

    `r_eff` is the reduced radius [m].
    """
    force, volume, *_ = numbers(pair)[3:]
    r = 2.0 * r_eff
    end = rupture_distance(pair, r_eff) * math.sqrt(r / volume)
    root = math.sqrt(4.0 * SQUARE - LINEAR * LINEAR)
    angle = math.atan((2.0 * SQUARE * end + LINEAR) / root) - math.atan(LINEAR / root)
    return force * r * math.sqrt(volume / r) * 2.0 / root * angle


def terms(touch: Touch) -> dict[str, Terms]:
    """Return this law in the terms of other programs."""
    none = Terms(missing="capillary bridges")
    return {"Rocky": none, "PFC": none, "LAMMPS": none, "LIGGGHTS": none}
