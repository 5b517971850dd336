"""Resistance to rolling of a contact: none, constant moment, or a spring with a limit."""

import math

from nutamill.base.kernel import by_type, kernel, like
from nutamill.charge.laws.numbers import TINY
from nutamill.charge.laws.tags import NoRolling, RollingTypeA, RollingTypeC


@kernel(inline="always")
def free_rolling(law, t0, t1, t2, w0, w1, w2, n0, n1, n2, kt, m_eff, r_eff, limit, dt):
    """No moment and no memory; parameters as `spring_rolling`."""
    zero = like(0.0, dt)
    return zero, zero, zero, zero, zero, zero


@kernel(inline="always")
def constant_rolling(law, t0, t1, t2, w0, w1, w2, n0, n1, n2, kt, m_eff, r_eff, limit, dt):
    """Type A: the limit moment against the relative spin, ``M = -limit w/|w|``.

    Unless the spin is about to stop: then a drag brakes a share of it in one substep instead of turning it
    round.  Parameters and returned values as `spring_rolling`; the twist about n counts here.

    Source
    ------
    Ansys Rocky, DEM Technical Manual: rolling type A.  It acts here on the relative spin, with the reduced
    radius (as "cdt" in LIGGGHTS), so that a pair keeps its angular momentum; against a resting wall it is
    Rocky's.
    """
    zero = like(0.0, dt)
    # a tenth of the reduced inertia (2/5 m R^2) a substep: several contacts at once brake a spin, and never
    # turn it round
    drag = like(0.04, dt) * m_eff * r_eff * r_eff / dt
    square = w0 * w0 + w1 * w1 + w2 * w2
    brake = limit / math.sqrt(square + like(TINY, dt)) if drag * drag * square > limit * limit else drag
    return -brake * w0, -brake * w1, -brake * w2, zero, zero, zero


@kernel(inline="always")
def spring_rolling(law, t0, t1, t2, w0, w1, w2, n0, n1, n2, kt, m_eff, r_eff, limit, dt):
    """Type C: a spring ``kr = kt R*^2`` on the relative rolling angle t, ``M = -kr t`` with ``|M| <= limit``.

    By the trapezoidal rule, as friction's spring.  The twist about n does not count.

    Parameters
    ----------
    law : tag
    t0, t1, t2 : stored rolling angle [rad], world axes
    w0, w1, w2 : spin of the first relative to the second [rad/s]
    n0, n1, n2 : contact normal [1]
    kt : tangential stiffness [N/m]
    m_eff, r_eff : reduced mass [kg] and radius [m]
    limit : largest moment, rolling friction x reduced radius x normal force that counts for friction [N m]
    dt : substep [s]

    Returns
    -------
    moment [N m] (3 numbers), new stored angle [rad] (3)

    Source
    ------
    Ansys Rocky, DEM Technical Manual: rolling type C.  It equals "rrlinear" in PFC and "epsd2" in LIGGGHTS:
    J. Ai, J.-F. Chen, J. M. Rotter and J. Y. Ooi, Powder Technology 206 (2011).
    """
    half = like(0.5, dt) * dt
    twist = w0 * n0 + w1 * n1 + w2 * n2
    w0 -= twist * n0
    w1 -= twist * n1
    w2 -= twist * n2
    along = t0 * n0 + t1 * n1 + t2 * n2
    t0 += half * w0 - along * n0
    t1 += half * w1 - along * n1
    t2 += half * w2 - along * n2
    kr = kt * r_eff * r_eff
    square = t0 * t0 + t1 * t1 + t2 * t2
    scale = (
        limit / (kr * math.sqrt(square + like(TINY, dt)))
        if kr * kr * square > limit * limit
        else like(1.0, dt)
    )
    t0 *= scale
    t1 *= scale
    t2 *= scale
    return -kr * t0, -kr * t1, -kr * t2, t0 + half * w0, t1 + half * w1, t2 + half * w2


rolling_moment = by_type(
    {NoRolling: free_rolling, RollingTypeA: constant_rolling, RollingTypeC: spring_rolling}
)
"""Moment against rolling of the law whose tag comes first; parameters and returned values as
`spring_rolling`.
"""


@kernel(inline="always")
def no_rolling_energy(law, square, kt, r_eff):
    """Nothing is stored [J]; parameters as `spring_rolling_energy`."""
    return 0.0


@kernel(inline="always")
def spring_rolling_energy(law, square, kt, r_eff):
    """Energy [J] in a rolling spring ``kt r_eff^2`` whose stored angle has this `square` [rad^2]."""
    return 0.5 * kt * r_eff * r_eff * square


rolling_energy = by_type(
    {NoRolling: no_rolling_energy, RollingTypeA: no_rolling_energy, RollingTypeC: spring_rolling_energy}
)
"""Energy in the rolling spring of the law whose tag comes first; as `spring_rolling_energy`."""
