"""A head-on contact as a damped oscillator: restitution, duration and overlap of the dashpot's damping ratio.

Plain Python, exact for one contact without gravity.  With ``u`` = overlap, a linear contact is
``u'' + 2 zeta w0 u' + w0^2 u = 0``, ``w0 = sqrt(k/m_eff)``.  With tension kept it ends at zero overlap; with
tension cut it ends when the force reaches zero.

Sources: T. Schwager and T. Poeschel, "Coefficient of restitution and linear-dashpot model revisited",
Granular Matter 9 (2007); D. Antypov and J. A. Elliott, "On an analytical solution for the damped Hertzian
spring", Europhysics Letters 94 (2011).
"""

import math
from dataclasses import dataclass

from scipy.optimize import brentq

from nutamill.charge.laws.pair import PairLaw


@dataclass(frozen=True, slots=True)
class Impact:
    """A head-on contact that begins at a given speed."""

    stiffness: float
    """Normal stiffness [N/m]; hysteretic: loading; Hertz: tangent at the largest overlap."""
    time: float
    """Duration [s]; infinite where the two stick."""
    overlap: float
    """Largest overlap [m]."""
    restitution: float
    """Speed of parting over speed of meeting [1]; 0 where they stick."""
    resolve: float
    """Time that a substep has to be small against [s]: the duration; hysteretic: half a period of the
    unloading spring; where a rolling stiffness is given, half a period of rolling if that is shorter.
    """


def floor_force(pair: PairLaw) -> float:
    """Return the least normal force of a spring with a dashpot [N]: 0 where tension is cut, else minus
    infinity.
    """
    return 0.0 if pair.tension_cut else -math.inf


def scaled_contact_time(damping_ratio: float, tension_cut: bool) -> float:
    """Return the contact time [1] in units of ``1/w0`` for a share of critical damping [1] below 1 (any, if
    tension is cut).
    """
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
    """Return the restitution [1] of a linear or Hertzian contact: ``e = exp(-zeta tau)`` with the scaled
    contact time tau.
    """
    if not tension_cut and damping_ratio >= 1.0:
        return 0.0
    return math.exp(-damping_ratio * scaled_contact_time(damping_ratio, tension_cut))


def damping_ratio_from_restitution(restitution: float, tension_cut: bool) -> float:
    """Return the share of critical damping [1] that gives `restitution` in (0, 1], exactly, for linear and
    Hertz.

    Raises
    ------
    ValueError : restitution outside (0, 1]
    """
    if not 0.0 < restitution <= 1.0:
        raise ValueError(f"restitution must be in (0, 1], got {restitution}")
    if restitution == 1.0:
        return 0.0
    if tension_cut:
        # e falls from 1 to about 1/(4 zeta^2): the root is below 1/e
        return brentq(
            lambda z: restitution_from_damping_ratio(z, True) - restitution,
            0.0,
            1.0 + 1.0 / restitution,
            xtol=1e-15,
        )
    loss = -math.log(restitution)
    return loss / math.hypot(math.pi, loss)


def contact_time(k: float, m_eff: float, damping_ratio: float, tension_cut: bool) -> float:
    """Return the duration of a linear contact [s] for stiffness [N/m], reduced mass [kg] and share of
    critical damping [1].
    """
    return scaled_contact_time(damping_ratio, tension_cut) * math.sqrt(m_eff / k)


def scaled_overlap(damping_ratio: float) -> float:
    """Return the largest overlap [1] in units of ``v/w0``: ``exp(-zeta t)`` at the time t of rest."""
    z = damping_ratio
    w = math.sqrt(abs(1.0 - z * z))
    if z < 1.0:
        return math.exp(-z / w * math.atan2(w, z))
    return math.exp(-z / w * math.atanh(w / z)) if w > 0.0 else math.exp(-1.0)


def largest_overlap(k: float, m_eff: float, damping_ratio: float, v: float) -> float:
    """Return the largest overlap [m] of a linear contact that begins with approach speed `v` [m/s]."""
    return v * math.sqrt(m_eff / k) * scaled_overlap(damping_ratio)
