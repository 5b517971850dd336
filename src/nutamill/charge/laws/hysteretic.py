"""Normal law: linear spring that is stiffer on unloading, and on reloading below the largest load."""

import math
from typing import NamedTuple

from nutamill.base.kernel import kernel, like
from nutamill.charge.laws.oscillator import Impact
from nutamill.charge.laws.pair import PairLaw, compliances, pair_stiffness, spring_faults, spring_stiffness
from nutamill.charge.laws.terms import Terms, Touch

LEAST_FORCE = 0.001
"""Least force of a hysteretic contact over that of loading [1]. Source: Ansys Rocky, DEM Technical Manual."""

BOOKED = 2.0**100
"""Factor on the remembered overlap [1] while the contact unloads and its work of loading is booked: a power
of two, so that nothing is rounded.
"""
FLAG = 0.5
"""Least size of a number that has that factor [m]; no overlap is as large."""
NEAR = 1e-4
"""Share of an overlap within which a contact is looked at more closely [1]: rounding is less."""


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
def remembered(history):
    """Return the remembered overlap [m]: without the factor `BOOKED`, if it has it."""
    return history * like(1.0 / BOOKED, history) if abs(history) >= like(FLAG, history) else history


@kernel(inline="always")
def marked(rest):
    """Return a remembered overlap [m] with the factor `BOOKED`, one of 0 as the smallest that can have it."""
    least = like(1.0 / BOOKED, rest)
    return (rest if abs(rest) > least else least) * like(BOOKED, rest)


@kernel(inline="always")
def turned(law, p, parting, history):
    """Return whether the work of loading has to be booked, as the contact leaves the line of loading, or may
    have to be taken back, as it comes back to it. Parameters are those of `deepest.turned`.

    A contact on the least force is as good as parted: what comes after it is booked on top.
    """
    _, _, _, loading_over_unloading, least_share = p
    zero, one, two = like(0.0, parting), like(1.0, parting), like(2.0, parting)
    rest = remembered(history)
    booked = abs(history) >= like(FLAG, history)
    above = parting - rest > two * least_share * loading_over_unloading * parting
    leaves = parting > zero and above and not booked
    from_line = (rest if rest > zero else zero) * like(1.0 - NEAR, parting)
    return leaves or (booked and -parting * (one - loading_over_unloading) > from_line)


@kernel(inline="always")
def to_book(law, p, parting, beyond, history, before):
    """Return what to book and to take back, and the history, as `deepest.to_book`.

    The deepest overlap is that which the law has seen: the plastic work is that of this overlap.  `beyond` is
    not used.
    """
    plastic = 1.0 - p[3]
    rest = remembered(history)
    if parting > 0.0:
        return rest / plastic if plastic > 0.0 else parting, 0.0, marked(rest)
    if rest > remembered(before):
        return 0.0, remembered(before) / plastic, rest
    return 0.0, 0.0, history


@kernel(inline="always")
def loading(law, p, overlap, r_eff, diameters):
    """Return the work of loading up to an overlap, ``K_l d^2/2`` [J], and the force there [N]. Parameters are
    those of `linear.loading`.
    """
    compliance, compliance_a, compliance_b, _, _ = p
    force = pair_stiffness(compliance, compliance_a, compliance_b, diameters) * overlap
    return 0.5 * force * overlap, force


@kernel(inline="always")
def force(law, p, overlap, v_n, history, m_eff, r_eff, diameters, dt):
    """Return the normal force of a linear spring that is stiffer on unloading.

    ``F_n = max(min(F_n' + K_u (overlap - overlap'), K_l overlap), lambda K_l overlap)``, the prime marking
    the substep before. What is remembered is not the force but the overlap at which it would vanish,
    ``overlap - F_n/K_u``: the law is then a function of overlap and memory, and rounding does not add up.
    It has the factor `BOOKED` from the booking of the work of loading (`to_book`) down to the least force.

    Parameters
    ----------
    as `linear.force`, but
    history : remembered overlap [m], as `remembered` reads it; 0 for a new contact
    v_n, m_eff, r_eff, dt : not used

    Returns
    -------
    F_n [N]; K_l [N/m]; the history

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
    push = unloading * (overlap - remembered(history))
    push = push if push < loading else loading
    least = least_share * loading
    unloads = abs(history) >= like(FLAG, history) and push > least
    push = push if push > least else least
    rest = overlap - push / unloading
    return push, k, marked(rest) if unloads else rest


@kernel(inline="always")
def energy(law, p, overlap, history, r_eff, diameters):
    """Return the energy a hysteretic spring would give back [J], and its stiffness K_l [N/m]. Parameters are
    those of `force`.

    Below the unloading line down to where it meets the least force, and below that from there on.
    """
    _, _, _, loading_over_unloading, least_share = p
    push, k, history = force(law, p, overlap, 0.0, history, 0.0, r_eff, diameters, 0.0)
    meets = remembered(history)
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
