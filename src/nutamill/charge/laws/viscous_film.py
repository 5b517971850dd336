"""Viscous film: the lubrication force of a thin layer of liquid between two bodies that are not in contact.

``F = 6 pi mu R*^2 v/s`` against the approach and against the parting, where the separation s is the gap plus
the roughness: the peaks of the roughness touch where the gap is 0, and no film is left between touching
solids.  The film ends at its thickness.

A head-on impact loses ``6 pi mu R*^2 ln(thickness/roughness)`` of momentum on the way in and as much on the
way out, so that ``e = e_dry - (1 + e_dry) ln(thickness/roughness)/St`` with the Stokes number
``St = m* v/(6 pi mu R*^2)``.  Below ``(1 + e_dry)/e_dry ln(thickness/roughness)`` the two stick.

Sources: R. G. Cox and H. Brenner, "The slow motion of a sphere through a viscous fluid towards a plane
surface", Chemical Engineering Science 22 (1967) (the force); G. Barnocky and R. H. Davis,
"Elastohydrodynamic collision and rebound of spheres: experimental verification", Physics of Fluids 31 (1988)
(film down to the roughness, Stokes number).
"""

import math
from typing import NamedTuple

from nutamill.base.kernel import kernel, like
from nutamill.charge.laws.pair import PairLaw
from nutamill.charge.laws.terms import Terms, Touch


class ViscousFilm(NamedTuple):
    """Film: viscous, both ways."""


LAW = ViscousFilm()

MOST_SHARE = 0.1
"""Thickest film over the diameter of a particle [1]: a thicker one is not a thin layer."""
LEAST_ROUGHNESS = 1e-8
"""Smallest roughness [m]: separations are known to about 1e-9 m in single precision."""
DRY = (0.0, 1e-6, 1e-6)
"""Numbers of `push` for a pair without liquid: from its first to its last separation there is no way."""


def numbers(pair: PairLaw) -> list[float]:
    """Return what `push` reads: ``6 pi mu`` [Pa s], thickness and roughness of the film [m]."""
    if pair.liquid_viscosity == 0.0:
        return list(DRY)
    return [6.0 * math.pi * pair.liquid_viscosity, pair.film_thickness, pair.film_roughness]


def reach(pair: PairLaw, radius: float) -> float:
    """Return the largest gap across which the film of a pair acts [m]. It is the same at any `radius` [m]."""
    _, thickness, roughness = numbers(pair)
    return thickness - roughness


def faults(pair: PairLaw) -> list[tuple[str, str]]:
    """Return what is wrong with the film of a pair, and what to write instead."""
    if pair.liquid_viscosity == 0.0:
        return []
    faulty = []
    if not (math.isfinite(pair.liquid_viscosity) and pair.liquid_viscosity > 0.0):
        faulty.append((f"liquid_viscosity must be 0 or more, got {pair.liquid_viscosity:g} Pa s", ""))
    if not pair.film_roughness >= LEAST_ROUGHNESS:
        what = f"film_roughness must be {LEAST_ROUGHNESS:g} m or more, got {pair.film_roughness:g} m"
        faulty.append((what, "Give the height of the surfaces' peaks; polished steel has about 1e-7 m"))
    if not pair.film_thickness > pair.film_roughness:
        what = (
            f"film_thickness must exceed film_roughness {pair.film_roughness:g} m, "
            f"got {pair.film_thickness:g} m"
        )
        faulty.append((what, "A film within the roughness has no effect: leave liquid_viscosity out"))
    return faulty


@kernel(inline="always")
def separation(p, gap):
    """Return the separation of two bodies [m] whose gap is `gap` [m]: with the roughness, from that to the
    thickness of the film. `p` holds the `numbers` of the pair (3).
    """
    _, thickness, roughness = p
    s = gap + roughness
    s = s if s < thickness else thickness
    return s if s > roughness else roughness


@kernel(inline="always")
def separation_before(p, gap, v_n, dt):
    """Return the separation [m] at the beginning of the first substep of a film.

    One substep before, the pair was outside, or another wall surface carried the contact.  A pair that comes
    in begins at the thickness; a particle that slides onto a surface beside its old one, at its present gap,
    else it would be pushed off by a film that it never crossed.

    Parameters
    ----------
    p : `numbers` of the pair (3)
    gap : [m] in the middle of the substep, negative in contact
    v_n : approach speed [m/s]
    dt : substep [s]
    """
    # two substeps back: one might end at the edge of the film but for rounding
    return separation(p, gap + (like(2.0, dt) * v_n * dt if v_n > like(0.0, dt) else like(0.0, dt)))


@kernel(inline="always")
def separation_after(p, gap, v_n, dt):
    """Return the separation [m] at the end of a substep.

    Where the next substep may not meet the pair any more, it is that at the edge of the film.  Parameters are
    those of `separation_before`.
    """
    _, thickness, roughness = p
    half = like(0.5, dt)
    leaves = gap + roughness - like(1.5, dt) * v_n * dt > thickness
    s = separation(p, gap - half * v_n * dt)
    return thickness if leaves else s


@kernel(inline="always")
def push(p, before, after, r_eff, dt):
    """Return the push of a film apart [N]: its impulse over a substep, over the substep.

    ``6 pi mu R*^2 ln(before/after)`` is the exact integral of the force over the way, at any speed: a ball
    may cross ten roughnesses in one substep.  As `after` is the `before` of the next substep, the impulse of
    a whole passage depends on its two ends alone.

    Parameters
    ----------
    p : `numbers` of the pair (3)
    before, after : separation at the beginning and at the end of the substep [m]
    r_eff : reduced radius [m]
    dt : substep [s]
    """
    return p[0] * r_eff * r_eff * math.log(before / after) / dt


def passage(pair: PairLaw) -> float:
    """Return ``ln(thickness/roughness)`` of a pair [1], 0 without liquid."""
    _, thickness, roughness = numbers(pair)
    return math.log(thickness / roughness)


def lost_momentum(pair: PairLaw, r_eff: float) -> float:
    """Return what the film takes of the momentum of approach on the way through [N s], and as much on the way
    out. `r_eff` is the reduced radius [m].
    """
    return numbers(pair)[0] * r_eff * r_eff * passage(pair)


def stokes_number(pair: PairLaw, m_eff: float, r_eff: float, v: float) -> float:
    """Return the Stokes number of an approach at `v` [m/s], ``m* v/(6 pi mu R*^2)`` [1], infinite without
    liquid. `m_eff` [kg] and `r_eff` [m] are the reduced mass and radius.
    """
    drag = numbers(pair)[0] * r_eff * r_eff
    return m_eff * v / drag if drag > 0.0 else math.inf


def braking_time(pair: PairLaw, m_eff: float, r_eff: float) -> float:
    """Return the time in which the film brakes an approach at its smallest separation [s], infinite without
    liquid: a substep has to be small against it. Parameters are those of `stokes_number`.
    """
    per_area, _, roughness = numbers(pair)
    drag = per_area * r_eff * r_eff
    return m_eff * roughness / drag if drag > 0.0 else math.inf


def terms(touch: Touch) -> dict[str, Terms]:
    """Return this law in the terms of other programs."""
    none = Terms(missing="a viscous film")
    return {"Rocky": none, "PFC": none, "LAMMPS": none, "LIGGGHTS": none}
