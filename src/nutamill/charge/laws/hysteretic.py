"""Normal law: linear spring that is stiffer on unloading, and on reloading below the largest load."""

import math
from typing import NamedTuple

from nutamill.base.kernel import kernel
from nutamill.charge.laws.oscillator import Impact
from nutamill.charge.laws.pair import PairLaw, compliances, pair_stiffness, spring_faults, spring_stiffness
from nutamill.charge.laws.terms import Terms, Touch

LEAST_FORCE = 0.001
"""Least force of a hysteretic contact over that of loading [1]. Source: Ansys Rocky, DEM Technical Manual."""


class HystereticSpring(NamedTuple):
    """Normal: linear spring, stiffer on unloading; no dashpot."""


LAW = HystereticSpring()

STIFFENS = False
"""Whether the stiffness of loading grows with the overlap."""


def numbers(pair: PairLaw) -> list[float]:
    """Return what `force` reads: three compliances of loading as `pair_stiffness` (direct [m/N], of both
    bodies [m^2/N]), loading over unloading stiffness [1], least force over that of loading [1].
    """
    return [*compliances(pair), 1.0 / pair.unloading_ratio, LEAST_FORCE]


def tangential_ratio(pair: PairLaw) -> float:
    """Return the tangential stiffness over that of loading [1]."""
    return pair.tangential_ratio


def faults(pair: PairLaw) -> list[tuple[str, str]]:
    """Return what a pair lacks for this law, and what to write instead."""
    if pair.unloading_ratio >= 1.0:
        return spring_faults(pair)
    what = f"unloading_ratio must be 1 or more, got {pair.unloading_ratio:g}"
    return [*spring_faults(pair), (what, "For a restitution e write 1/e^2")]


@kernel(inline="always")
def force(law, p, overlap, v_n, history, m_eff, r_eff, diameters, dt):
    """Return the normal force of a linear spring that is stiffer on unloading.

    ``F_n = max(min(F_n' + K_u (overlap - overlap'), K_l overlap), lambda K_l overlap)``, the prime marking
    the substep before. What is remembered is not the force but the overlap at which it would vanish,
    ``overlap - F_n/K_u``: the law is then a function of overlap and memory, and rounding does not add up.

    Parameters
    ----------
    as `linear.force`, but
    history : remembered overlap [m]; 0 for a new contact
    v_n, m_eff, r_eff, dt : not used

    Returns
    -------
    F_n [N]; K_l [N/m]; remembered overlap [m]

    Source
    ------
    O. R. Walton and R. L. Braun, "Viscosity, granular-temperature, and stress calculations for shearing
    assemblies of inelastic, frictional disks", Journal of Rheology 30 (1986); the form with lambda: Ansys
    Rocky, DEM Technical Manual.
    """
    compliance, compliance_a, compliance_b, loading_over_unloading, least_share = p
    k = pair_stiffness(compliance, compliance_a, compliance_b, diameters)
    unloading = k / loading_over_unloading
    loading = k * overlap
    push = unloading * (overlap - history)
    push = push if push < loading else loading
    least = least_share * loading
    push = push if push > least else least
    return push, k, overlap - push / unloading


@kernel(inline="always")
def energy(law, p, overlap, history, r_eff, diameters):
    """Return the energy a hysteretic spring would give back [J], and its stiffness K_l [N/m]. Parameters are
    those of `force`.

    Below the unloading line down to where it meets the least force, and below that from there on.
    """
    _, _, _, loading_over_unloading, least_share = p
    push, k, meets = force(law, p, overlap, 0.0, history, 0.0, r_eff, diameters, 0.0)
    # where K_u (d - meets) = lambda K_l d
    corner = min(overlap, meets / (1.0 - least_share * loading_over_unloading))
    least = least_share * k * corner
    return 0.5 * (push + least) * (overlap - corner) + 0.5 * least * corner, k


def restitution(pair: PairLaw) -> float:
    """Return the restitution [1] without cohesion, a little above ``1/sqrt(unloading_ratio)`` because of the
    least force.

    The share of the work of loading that remains under the unloading line and under the least force.
    """
    r, least = pair.unloading_ratio, LEAST_FORCE
    return math.sqrt((1.0 - 2.0 * least + r * least) / (r - least))


def impact(pair: PairLaw, m_eff: float, r_eff: float, diameters: tuple[float, float], v: float) -> Impact:
    """Return the head-on contact of two bodies that meet at `v` [m/s], without cohesion: three quarters of
    oscillations, on the loading line, the unloading line and the least force. Parameters are those of
    `linear.impact`.
    """
    k, r = spring_stiffness(pair, *diameters), pair.unloading_ratio
    load, unload, last = math.sqrt(k / m_eff), math.sqrt(r * k / m_eff), math.sqrt(LEAST_FORCE * k / m_eff)
    deep = v / load
    spring, corner = deep / r, deep * (1.0 - 1.0 / r) / (1.0 - LEAST_FORCE / r)
    share = (corner - deep + spring) / spring
    speed = spring * unload * math.sqrt(1.0 - share * share)
    time = 0.5 * math.pi / load + math.acos(share) / unload + math.atan2(corner * last, speed) / last
    return Impact(k, time, deep, restitution(pair), math.pi / unload)


def resolve_time(pair: PairLaw, k: float, m_eff: float, loading: float) -> float:
    """Return half a period of the unloading spring [s]. Parameters are those of `linear.resolve_time`."""
    return math.pi * math.sqrt(m_eff / (k * pair.unloading_ratio))


def terms(touch: Touch) -> dict[str, Terms]:
    """Return this law in the terms of other programs."""
    return {
        "Rocky": Terms(
            "Hysteretic Linear Spring; tangential force Linear Spring Coulomb Limit",
            lines=(f"restitution {math.sqrt(1 / touch.pair.unloading_ratio):.6g}",),
        ),
        "PFC": Terms(missing="hysteretic linear spring"),
        "LAMMPS": Terms(missing="hysteretic linear spring"),
        "LIGGGHTS": Terms(missing="hysteretic linear spring (hooke/hysteresis is another)"),
    }
