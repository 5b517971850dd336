"""Normal law: Hertz's spring, and the dashpot that gives a restitution independent of speed."""

import math
from typing import NamedTuple

from scipy.integrate import quad

from nutamill.base.kernel import kernel, like
from nutamill.charge.laws.deepest import to_book as to_book
from nutamill.charge.laws.deepest import turned as turned
from nutamill.charge.laws.leapfrog import dashpot_share
from nutamill.charge.laws.oscillator import (
    Impact,
    floor_force,
    restitution_from_damping_ratio,
    scaled_contact_time,
    scaled_overlap,
)
from nutamill.charge.laws.pair import PairLaw, dashpot_faults
from nutamill.charge.laws.terms import Terms, Touch


class HertzSpring(NamedTuple):
    """Normal: Hertz's spring, with the dashpot that gives a restitution independent of speed."""


LAW = HertzSpring()

STIFFENS = True
"""Whether the stiffness grows with the overlap."""


def numbers(pair: PairLaw) -> list[float]:
    """Return what `force` reads: contact modulus E* [Pa], 2 sqrt(5/6) damping ratio [1], the floor [N]."""
    return [pair.contact_modulus, 2.0 * math.sqrt(5.0 / 6.0) * pair.damping_ratio, floor_force(pair)]


def tangential_ratio(pair: PairLaw) -> float:
    """Return the tangential stiffness, `PairLaw.tangential_ratio` x Mindlin's 8 G* sqrt(R* d), over the
    tangent stiffness 2 E* sqrt(R* d) [1].
    """
    return pair.tangential_ratio * 4.0 * pair.contact_shear_modulus / pair.contact_modulus


def faults(pair: PairLaw) -> list[tuple[str, str]]:
    """Return what a pair lacks for this law, and what to write instead."""
    if pair.contact_modulus > 0.0 and pair.contact_shear_modulus > 0.0:
        return dashpot_faults(pair)
    got = f"{pair.contact_modulus:g} and {pair.contact_shear_modulus:g} Pa"
    what = f"Hertz needs contact_modulus and contact_shear_modulus above 0, got {got}"
    return [
        (what, "Work them out from Young's modulus and Poisson's ratio of the two"),
        *dashpot_faults(pair),
    ]


@kernel(inline="always")
def contact_share(overlap, v_n, dt):
    """Return the share [1] of the dashpot and the overlap to take [m]: as `linear.dashpot_speed`, for a
    dashpot that grows with the fourth root of the overlap.

    In the first substep the overlap grows as v_n t from 0 to overlap + v_n dt/2; the integral of ``t^(1/4)``
    over that time is ``4/5 t^(5/4)``.  On release the same holds backwards in time.
    """
    travel = abs(v_n) * dt
    depth = overlap if overlap > like(0.0, dt) else like(0.0, dt)
    ends = depth < travel
    share = like(0.4, dt) + like(0.8, dt) * depth / travel if ends else like(1.0, dt)
    return share, depth + like(0.5, dt) * travel if ends else depth


@kernel(inline="always")
def force(law, p, overlap, v_n, history, m_eff, r_eff, diameters, dt):
    """Return the normal force of two elastic spheres, and of a dashpot with the same share of critical
    damping at any overlap.

    ``F_n = max(4/3 E* sqrt(R*) d^(3/2) + a 2 sqrt(5/6) beta sqrt(m* S) v_n share, floor)`` with the tangent
    stiffness ``S = 2 E* sqrt(R* d)`` of overlap d and a of `dashpot_share`

    Parameters
    ----------
    as `linear.force`, but
    diameters : not used

    Returns
    -------
    F_n [N]; S [N/m]; the history

    Source
    ------
    K. L. Johnson, "Contact Mechanics", 1985, section 4.2; Y. Tsuji, T. Tanaka and T. Ishida, Powder
    Technology 71 (1992); the damping that gives a restitution exactly: D. Antypov and J. A. Elliott, "On an
    analytical solution for the damped Hertzian spring", Europhysics Letters 94 (2011).
    """
    modulus, damping, floor, _, _ = p
    two = like(2.0, dt)
    share, deep = contact_share(overlap, v_n, dt)
    depth = overlap if overlap > like(0.0, dt) else like(0.0, dt)
    stiffness = two * modulus * math.sqrt(r_eff * depth)
    deep_stiffness = two * modulus * math.sqrt(r_eff * deep)
    damping *= dashpot_share(deep_stiffness * dt * dt / m_eff)
    dashpot = damping * math.sqrt(m_eff * deep_stiffness) * share
    push = like(2.0 / 3.0, dt) * stiffness * depth + dashpot * v_n
    return push if push > floor else floor, stiffness, history


@kernel(inline="always")
def energy(law, p, overlap, history, r_eff, diameters):
    """Return the energy in Hertz's spring, ``8/15 E* sqrt(R*) d^(5/2)`` [J], and its tangent stiffness [N/m].
    Parameters are those of `force`.
    """
    modulus, _, _, _, _ = p
    stiffness = 2.0 * modulus * math.sqrt(r_eff * max(overlap, 0.0))
    return 4.0 / 15.0 * stiffness * overlap * overlap, stiffness


@kernel(inline="always")
def loading(law, p, overlap, r_eff, diameters):
    """Return the work of loading Hertz's spring up to an overlap, ``8/15 E* sqrt(R*) d^(5/2)`` [J], and its
    force there [N]. Parameters are those of `linear.loading`.
    """
    modulus, _, _, _, _ = p
    force = 4.0 / 3.0 * modulus * math.sqrt(r_eff * overlap) * overlap
    return 0.4 * force * overlap, force


def contact_duration(
    modulus: float, r_eff: float, m_eff: float, damping_ratio: float, tension_cut: bool, v: float
) -> float:
    """Return the duration of a Hertzian contact [s] that begins at `v` [m/s] for contact modulus E* [Pa],
    reduced radius [m] and mass [kg].
    """
    w0, z = _frequency(modulus, r_eff, m_eff), damping_ratio
    w = math.sqrt(abs(1.0 - z * z))

    def slowness(s):
        swing = math.sin(w * s) if z < 1.0 else math.sinh(w * s)
        return (math.exp(-z * s) * (swing / w if w > 0.0 else s)) ** -0.2

    end = scaled_contact_time(z, tension_cut)
    scaled = (
        quad(slowness, 0.0, 0.5 * end, epsabs=0.0, epsrel=1e-9)[0]
        + quad(slowness, 0.5 * end, end, epsabs=0.0, epsrel=1e-9)[0]
    )
    return scaled / w0 * (1.25 * v / w0) ** -0.2


def deepest(modulus: float, r_eff: float, m_eff: float, damping_ratio: float, v: float) -> float:
    """Return the largest overlap [m] of a Hertzian contact. Parameters are those of `contact_duration`."""
    return (1.25 * v / _frequency(modulus, r_eff, m_eff) * scaled_overlap(damping_ratio)) ** 0.8


def _frequency(modulus: float, r_eff: float, m_eff: float) -> float:
    """Return ``w0`` of the motion of ``y = u^(5/4)`` [m^-1/4 s^-1], ``w0^2 = 5/4 (4/3 E* sqrt(R*))/m*``."""
    return math.sqrt(5.0 / 3.0 * modulus * math.sqrt(r_eff) / m_eff)


def impact(pair: PairLaw, m_eff: float, r_eff: float, diameters: tuple[float, float], v: float) -> Impact:
    """Return the head-on contact of two bodies that meet at `v` [m/s], without cohesion.

    The contact is a damped oscillator in ``y = u^(5/4)`` and a time that runs with ``u^(1/4)``, so that its
    restitution, tension kept or cut, is that of the linear one.  Parameters as `linear.impact`; `diameters`
    are not used.
    """
    z, cut = pair.damping_ratio, pair.tension_cut
    time = contact_duration(pair.contact_modulus, r_eff, m_eff, z, cut, v)
    deep = deepest(pair.contact_modulus, r_eff, m_eff, z, v)
    tangent = 2.0 * pair.contact_modulus * math.sqrt(r_eff * deep)
    return Impact(tangent, time, deep, restitution_from_damping_ratio(z, cut), time)


def resolve_time(pair: PairLaw, k: float, m_eff: float, loading: float) -> float:
    """Return twice the time of loading [s]. Parameters are those of `linear.resolve_time`."""
    return 2.0 * loading


def restitution(pair: PairLaw) -> float:
    """Return the restitution [1] without cohesion."""
    return restitution_from_damping_ratio(pair.damping_ratio, pair.tension_cut)


def terms(touch: Touch) -> dict[str, Terms]:
    """Return this law in the terms of other programs."""
    pair = touch.pair
    # PFC takes two equal solids: E* = G/(1 - nu), G* = G/(2 (2 - nu)), so that E*/G* = 2 (2 - nu)/(1 - nu)
    quotient = pair.contact_modulus / (pair.tangential_ratio * pair.contact_shear_modulus)
    nu = (quotient - 4.0) / (quotient - 2.0)
    shear = pair.contact_modulus * (1.0 - nu)
    moduli = " ".join(f"{e:.6g}" for e in touch.young)
    ratios = " ".join(f"{ratio:g}" for ratio in touch.poisson)
    other_ratio = pair.tangential_ratio != 1.0
    return {
        "Rocky": Terms(
            "Hertzian Spring Dashpot; tangential force Mindlin-Deresiewicz, or nearest",
            lines=(f"restitution {touch.restitution:.6g}",),
        ),
        "PFC": Terms(
            f"hertz property hz_shear {shear:.6g} hz_poiss {nu:.6g} "
            f"dp_nratio {math.sqrt(5.0 / 6.0) * pair.damping_ratio:.6g}",
            notes=(
                "# dp_nratio counts with the tangent stiffness; hz_* are those of two equal solids with "
                "the same E* and G*",
            ),
        ),
        "LAMMPS": Terms(
            f"hertz {4 / 3 * pair.contact_modulus:.6g} {touch.plain_restitution:.6g} "
            "damping coeff_restitution",
            notes=touch.restitution_notes,
            missing="a dashpot above its critical value" if pair.damping_ratio >= 1.0 else "",
        ),
        "LIGGGHTS": Terms(
            "hertz",
            lines=(
                f"youngsModulus peratomtype {moduli}; poissonsRatio peratomtype {ratios}",
                f"coefficientRestitution {touch.plain_restitution:.6g}",
            ),
            notes=(
                *touch.restitution_notes,
                *(
                    [f"# its tangential stiffness is Mindlin's, here {pair.tangential_ratio:g} times that"]
                    if other_ratio
                    else []
                ),
            ),
        ),
    }
