"""Normal law: linear spring and dashpot."""

import math
from typing import NamedTuple

from nutamill.base.kernel import kernel, like
from nutamill.charge.laws.deepest import to_book as to_book
from nutamill.charge.laws.deepest import turned as turned
from nutamill.charge.laws.leapfrog import dashpot_share
from nutamill.charge.laws.oscillator import (
    Impact,
    contact_time,
    floor_force,
    largest_overlap,
    restitution_from_damping_ratio,
)
from nutamill.charge.laws.pair import (
    PairLaw,
    compliances,
    dashpot_faults,
    pair_stiffness,
    spring_faults,
    spring_stiffness,
)
from nutamill.charge.laws.terms import Terms, Touch


class LinearSpring(NamedTuple):
    """Normal: linear spring and dashpot."""


LAW = LinearSpring()

STIFFENS = False
"""Whether the stiffness grows with the overlap."""


def numbers(pair: PairLaw) -> list[float]:
    """Return what `force` reads: three compliances as `pair_stiffness` (direct [m/N], of both bodies
    [m^2/N]), twice the damping ratio [1], the floor [N].
    """
    return [*compliances(pair), 2.0 * pair.damping_ratio, floor_force(pair)]


def tangential_ratio(pair: PairLaw) -> float:
    """Return the tangential stiffness over the normal one [1]."""
    return pair.tangential_ratio


def faults(pair: PairLaw) -> list[tuple[str, str]]:
    """Return what a pair lacks for this law, and what to write instead."""
    return spring_faults(pair) + dashpot_faults(pair)


@kernel(inline="always")
def dashpot_speed(overlap, v_n, dt):
    """Return the approach speed with the share of the substep's dashpot impulse that belongs to the contact,
    in its first and last substep.

    Forces are sampled at mid-substep, but the dashpot's force jumps when contact begins: seen first at
    overlap d < v_n dt, the contact has lasted d/v_n + dt/2 by the end of the substep, half a substep at least
    and one and a half at most.  The same holds, backwards in time, on release.  Without this share the
    restitution scatters with the phase of the first substep, by first order in dt; with it the error is of
    second order (but where tension slows a release so that it is met twice).

    Parameters
    ----------
    overlap : [m], positive in contact
    v_n : approach speed [m/s], positive when closing
    dt : substep [s]

    Returns
    -------
    speed [m/s]: v_n/2 + overlap/dt with the sign of v_n when overlap < abs(v_n) dt, else v_n
    """
    # round-off can make a touching pair's overlap negative
    covered = overlap / dt if overlap > like(0.0, dt) else like(0.0, dt)
    return like(0.5, dt) * v_n + math.copysign(covered, v_n) if covered < abs(v_n) else v_n


@kernel(inline="always")
def force(law, p, overlap, v_n, history, m_eff, r_eff, diameters, dt):
    """Return the normal force of a linear spring and dashpot.

    ``F_n = max(k overlap + a c v, floor)`` with ``c = 2 zeta sqrt(m_eff k)``, v of `dashpot_speed` and a of
    `dashpot_share`

    Parameters
    ----------
    law : tag
    p : `numbers` of the pair (5)
    overlap : [m], positive in contact
    v_n : approach speed [m/s], positive when closing
    history : deepest overlap that has been booked [m], see `deepest.to_book`; not used
    m_eff, r_eff : reduced mass [kg], reduced radius [m]
    diameters : of the two particles [m] (2); a wall takes the particle's
    dt : substep [s], for `dashpot_speed`

    Returns
    -------
    F_n [N], positive pushing apart; k, the stiffness that the tangential one is a multiple of [N/m]; the
    history

    Source
    ------
    P. A. Cundall and O. D. L. Strack, "A discrete numerical model for granular assemblies", Geotechnique 29
    (1979).
    """
    compliance, compliance_a, compliance_b, twice_zeta, floor = p
    k = pair_stiffness(compliance, compliance_a, compliance_b, diameters)
    # w = k/sqrt(m k) and sqrt(m k) = m k/sqrt(m k): one inverse root, and no quotient
    inverse = like(1.0, dt) / math.sqrt(m_eff * k)
    turned = k * dt * inverse
    damping = dashpot_share(turned * turned) * twice_zeta * m_eff * k * inverse
    push = k * overlap + damping * dashpot_speed(overlap, v_n, dt)
    return push if push > floor else floor, k, history


@kernel(inline="always")
def energy(law, p, overlap, history, r_eff, diameters):
    """Return the energy in a linear spring, ``k d^2/2`` [J], and its stiffness k [N/m]. Parameters are those
    of `force`.
    """
    compliance, compliance_a, compliance_b, _, _ = p
    k = pair_stiffness(compliance, compliance_a, compliance_b, diameters)
    return 0.5 * k * overlap * overlap, k


@kernel(inline="always")
def loading(law, p, overlap, r_eff, diameters):
    """Return the work of loading a linear spring up to an overlap [J], and its force there [N]. Parameters
    are those of `energy`.
    """
    compliance, compliance_a, compliance_b, _, _ = p
    force = pair_stiffness(compliance, compliance_a, compliance_b, diameters) * overlap
    return 0.5 * force * overlap, force


def impact(pair: PairLaw, m_eff: float, r_eff: float, diameters: tuple[float, float], v: float) -> Impact:
    """Return the head-on contact of two bodies that meet at `v` [m/s], without cohesion: a damped oscillator.

    Parameters
    ----------
    m_eff, r_eff : reduced mass [kg] and radius [m]
    diameters : [m]; a wall takes the particle's
    """
    k, z, cut = spring_stiffness(pair, *diameters), pair.damping_ratio, pair.tension_cut
    time = contact_time(k, m_eff, z, cut)
    return Impact(k, time, largest_overlap(k, m_eff, z, v), restitution_from_damping_ratio(z, cut), time)


def resolve_time(pair: PairLaw, k: float, m_eff: float, loading: float) -> float:
    """Return the time that a substep has to be small against [s] in a contact of reduced mass `m_eff` [kg]
    that takes `loading` [s] to its largest overlap and has stiffness `k` [N/m] there.
    """
    return 2.0 * loading


def restitution(pair: PairLaw) -> float:
    """Return the restitution [1] without cohesion."""
    return restitution_from_damping_ratio(pair.damping_ratio, pair.tension_cut)


def terms(touch: Touch) -> dict[str, Terms]:
    """Return this law in the terms of other programs."""
    pair = touch.pair
    gamma = 2.0 * pair.damping_ratio * math.sqrt(touch.k / touch.mass)
    gamma_t = 2.0 * pair.tangential_damping * math.sqrt(touch.kt / touch.mass)
    return {
        "Rocky": Terms(
            "Linear Spring Dashpot; tangential force Linear Spring Coulomb Limit",
            lines=(f"restitution {touch.restitution:.6g}",),
        ),
        "PFC": Terms(
            f"linear property kn {touch.k:.6g} ks {touch.kt:.6g} dp_nratio {pair.damping_ratio:.6g}",
            notes=("# its friction is limited by the spring's part of the normal force alone",),
        ),
        "LAMMPS": Terms(
            f"hooke {touch.k:.6g} {touch.plain_restitution:.6g} damping coeff_restitution",
            notes=touch.restitution_notes,
            missing="a dashpot above its critical value" if pair.damping_ratio >= 1.0 else "",
        ),
        "LIGGGHTS": Terms(
            "hooke/stiffness",
            lines=(f"kn {touch.k:.6g}; kt {touch.kt:.6g}; gamman {gamma:.6g}; gammat {gamma_t:.6g}",),
        ),
    }
