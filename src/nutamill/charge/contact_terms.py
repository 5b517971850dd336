"""What the numbers of a linear contact mean: restitution, contact time, overlap, and the substep they ask for.

Plain Python for the doors of the package and for tests; every function is exact for one contact without gravity.
With ``u`` = overlap, a contact is ``u'' + 2 zeta w0 u' + w0^2 u = 0``, ``w0 = sqrt(k/m_eff)``.  With tension kept it ends at zero
overlap; with tension cut it ends when the force reaches zero.

Source: T. Schwager and T. Poeschel, "Coefficient of restitution and linear-dashpot model revisited", Granular Matter 9 (2007).
"""

import math

from scipy.optimize import brentq

SUBSTEPS_PER_CONTACT = 20
"""Substeps in the contact time of the stiffest, lightest pair that `automatic_substep` asks for [1]."""


def scaled_contact_time(damping_ratio: float, tension_cut: bool) -> float:
    """Contact time [1] in units of ``1/w0`` for a share of critical damping [1] below 1 (any, if tension is cut)."""
    z = damping_ratio
    if not tension_cut:
        return math.pi / math.sqrt(1.0 - z * z)
    if z < 1.0:
        w = math.sqrt(1.0 - z * z)
        return (math.pi - math.atan2(2.0 * z * w, 1.0 - 2.0 * z * z)) / w
    if z == 1.0:
        return 2.0
    w = math.sqrt(z * z - 1.0)
    return 2.0 * math.log(z + w) / w


def restitution_from_damping_ratio(damping_ratio: float, tension_cut: bool) -> float:
    """Restitution [1] of a linear contact: ``e = exp(-zeta tau)`` with the scaled contact time tau."""
    if not tension_cut and damping_ratio >= 1.0:
        return 0.0
    return math.exp(-damping_ratio * scaled_contact_time(damping_ratio, tension_cut))


def damping_ratio_from_restitution(restitution: float, tension_cut: bool) -> float:
    """Share of critical damping [1] that gives `restitution` in (0, 1], exactly.

    Raises
    ------
    ValueError : restitution outside (0, 1]
    """
    if not 0.0 < restitution <= 1.0:
        raise ValueError(f"restitution must be in (0, 1], got {restitution}")
    if restitution == 1.0:
        return 0.0
    if tension_cut:
        # e falls from 1 to about 1/(4 zeta^2): the root lies below 1/e
        return brentq(lambda z: restitution_from_damping_ratio(z, True) - restitution, 0.0, 1.0 + 1.0 / restitution, xtol=1e-15)
    loss = -math.log(restitution)
    return loss / math.hypot(math.pi, loss)


def contact_time(k: float, m_eff: float, damping_ratio: float, tension_cut: bool) -> float:
    """Duration of a contact [s] for stiffness [N/m], reduced mass [kg] and share of critical damping [1]."""
    return scaled_contact_time(damping_ratio, tension_cut) * math.sqrt(m_eff / k)


def largest_overlap(k: float, m_eff: float, damping_ratio: float, v: float) -> float:
    """Largest overlap [m] of a contact that begins with approach speed `v` [m/s]; the share of critical damping is below 1."""
    z = damping_ratio
    w0 = math.sqrt(k / m_eff)
    w = math.sqrt(1.0 - z * z)
    return v / w0 * math.exp(-z / w * math.atan2(w, z))


def series_stiffness(per_diameter_a: float, per_diameter_b: float, diameter_a: float, diameter_b: float) -> float:
    """Stiffness [N/m] of two bodies in series, each `per_diameter` [N/m^2] x `diameter` [m] (a wall takes the particle's)."""
    return 1.0 / (1.0 / (per_diameter_a * diameter_a) + 1.0 / (per_diameter_b * diameter_b))


def automatic_substep(k: float, m_eff: float, damping_ratio: float, tension_cut: bool) -> float:
    """Substep [s]: contact time of the stiffest, lightest pair over `SUBSTEPS_PER_CONTACT`."""
    return contact_time(k, m_eff, damping_ratio, tension_cut) / SUBSTEPS_PER_CONTACT
