"""What the numbers of a contact mean: restitution, contact time, overlap, and the time a substep has to
resolve.

Plain Python for the doors of the package and for tests; exact for one head-on contact without gravity.

With ``u`` = overlap, a linear contact is ``u'' + 2 zeta w0 u' + w0^2 u = 0``, ``w0 = sqrt(k/m_eff)``.  With
tension kept it ends at zero overlap; with tension cut it ends when the force reaches zero.  A Hertzian
contact is the same oscillator in ``y = u^(5/4)`` and a time that runs with ``u^(1/4)``, so that its
restitution, tension kept or cut, is that of the linear one.

Sources: T. Schwager and T. Poeschel, "Coefficient of restitution and linear-dashpot model revisited",
Granular Matter 9 (2007); D. Antypov and J. A. Elliott, "On an analytical solution for the damped Hertzian
spring", Europhysics Letters 94 (2011).
"""

import math
from dataclasses import dataclass

from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

from nutamill.charge.laws.cohesion import AREA_PER_DEPTH, cohesive_pull
from nutamill.charge.laws.normal import normal_force
from nutamill.charge.laws.numbers import LEAST_FORCE, law_numbers
from nutamill.charge.laws.pair import PairLaw
from nutamill.charge.laws.tags import AreaCohesion, ContactLaw, HertzSpring, HystereticSpring

SUBSTEPS_PER_CONTACT = 20
"""Substeps that the shortest time to resolve of a charge is cut into [1]."""


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
    unloading spring.
    """


def scaled_contact_time(damping_ratio: float, tension_cut: bool) -> float:
    """Contact time [1] in units of ``1/w0`` for a share of critical damping [1] below 1 (any, if tension is
    cut).
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
    """Restitution [1] of a linear or Hertzian contact: ``e = exp(-zeta tau)`` with the scaled contact time
    tau.
    """
    if not tension_cut and damping_ratio >= 1.0:
        return 0.0
    return math.exp(-damping_ratio * scaled_contact_time(damping_ratio, tension_cut))


def damping_ratio_from_restitution(restitution: float, tension_cut: bool) -> float:
    """Share of critical damping [1] that gives `restitution` in (0, 1], exactly; linear and Hertz.

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
        return brentq(
            lambda z: restitution_from_damping_ratio(z, True) - restitution,
            0.0,
            1.0 + 1.0 / restitution,
            xtol=1e-15,
        )
    loss = -math.log(restitution)
    return loss / math.hypot(math.pi, loss)


def contact_time(k: float, m_eff: float, damping_ratio: float, tension_cut: bool) -> float:
    """Duration of a linear contact [s] for stiffness [N/m], reduced mass [kg] and share of critical damping
    [1].
    """
    return scaled_contact_time(damping_ratio, tension_cut) * math.sqrt(m_eff / k)


def _scaled_overlap(damping_ratio: float) -> float:
    """Largest overlap [1] of the oscillator in units of ``v/w0``: ``exp(-zeta t)`` at the time t when it
    turns.
    """
    z = damping_ratio
    w = math.sqrt(abs(1.0 - z * z))
    if z < 1.0:
        return math.exp(-z / w * math.atan2(w, z))
    return math.exp(-z / w * math.atanh(w / z)) if w > 0.0 else math.exp(-1.0)


def largest_overlap(k: float, m_eff: float, damping_ratio: float, v: float) -> float:
    """Largest overlap [m] of a linear contact that begins with approach speed `v` [m/s]."""
    return v * math.sqrt(m_eff / k) * _scaled_overlap(damping_ratio)


def hertz_time(
    modulus: float, r_eff: float, m_eff: float, damping_ratio: float, tension_cut: bool, v: float
) -> float:
    """Duration of a Hertzian contact [s] that begins at `v` [m/s]; contact modulus E* [Pa], reduced radius
    [m] and mass [kg].
    """
    w0, z = _hertz_frequency(modulus, r_eff, m_eff), damping_ratio
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


def hertz_overlap(modulus: float, r_eff: float, m_eff: float, damping_ratio: float, v: float) -> float:
    """Largest overlap [m] of a Hertzian contact; parameters as `hertz_time`."""
    return (1.25 * v / _hertz_frequency(modulus, r_eff, m_eff) * _scaled_overlap(damping_ratio)) ** 0.8


def _hertz_frequency(modulus: float, r_eff: float, m_eff: float) -> float:
    """``w0`` of the oscillator in ``y = u^(5/4)`` [m^-1/4 s^-1]: ``w0^2 = 5/4 (4/3 E* sqrt(R*))/m*``."""
    return math.sqrt(5.0 / 3.0 * modulus * math.sqrt(r_eff) / m_eff)


def hysteretic_restitution(unloading_ratio: float) -> float:
    """Restitution [1] of a hysteretic contact without cohesion; a little above ``1/sqrt(unloading_ratio)``
    for its least force.

    The share of the work of loading that is left under the unloading line and under the least force.
    """
    r, least = unloading_ratio, LEAST_FORCE
    return math.sqrt((1.0 - 2.0 * least + r * least) / (r - least))


def _hysteretic(k: float, r: float, m_eff: float, v: float) -> Impact:
    """Impact on a hysteretic spring of loading stiffness `k` [N/m] and `r` times that on unloading."""
    load, unload, last = math.sqrt(k / m_eff), math.sqrt(r * k / m_eff), math.sqrt(LEAST_FORCE * k / m_eff)
    deep = v / load
    spring, corner = deep / r, deep * (1.0 - 1.0 / r) / (1.0 - LEAST_FORCE / r)
    share = (corner - deep + spring) / spring
    speed = spring * unload * math.sqrt(1.0 - share * share)
    time = 0.5 * math.pi / load + math.acos(share) / unload + math.atan2(corner * last, speed) / last
    return Impact(k, time, deep, hysteretic_restitution(r), math.pi / unload)


def impact(
    law: ContactLaw, pair: PairLaw, m_eff: float, r_eff: float, diameter_a: float, diameter_b: float, v: float
) -> Impact:  # fmt: skip
    """A head-on contact of two bodies that meet at `v` [m/s].

    In closed form (Hertz: an integral) without cohesion; with cohesion by integration of the law.  A linear
    spring weaker than its cohesion never turns: its overlap is infinite.

    Parameters
    ----------
    law, pair : the law and its numbers
    m_eff, r_eff : reduced mass [kg] and radius [m]
    diameter_a, diameter_b : [m]; a wall takes the particle's
    """
    hertz, hysteretic = isinstance(law.normal, HertzSpring), isinstance(law.normal, HystereticSpring)
    z, cut = pair.damping_ratio, pair.tension_cut
    k = 0.0 if hertz else spring_stiffness(pair, diameter_a, diameter_b)
    if isinstance(law.cohesion, AreaCohesion) and pair.cohesive_pressure > 0.0:
        if not hertz and k <= cohesive_softening(pair, r_eff):
            return Impact(k, math.inf, math.inf, 0.0, math.pi * math.sqrt(m_eff / k))
        return _integrated(law, pair, m_eff, r_eff, diameter_a, diameter_b, v)
    if hysteretic:
        return _hysteretic(k, pair.unloading_ratio, m_eff, v)
    if not hertz:
        time = contact_time(k, m_eff, z, cut)
        return Impact(k, time, largest_overlap(k, m_eff, z, v), restitution_from_damping_ratio(z, cut), time)
    time, deep = (
        hertz_time(pair.contact_modulus, r_eff, m_eff, z, cut, v),
        hertz_overlap(pair.contact_modulus, r_eff, m_eff, z, v),
    )
    tangent = 2.0 * pair.contact_modulus * math.sqrt(r_eff * deep)
    return Impact(tangent, time, deep, restitution_from_damping_ratio(z, cut), time)


def _integrated(law, pair, m_eff, r_eff, diameter_a, diameter_b, v) -> Impact:
    """`impact` by integration of the law itself: loading up to rest, then unloading with the memory of the
    turning point.
    """
    numbers = law_numbers(law, pair)
    fixed = (m_eff, r_eff, diameter_a, diameter_b, *numbers[:3], *numbers[4:6], 0.0)
    # in units of the time and depth of a linear contact of like energy
    stiffness = normal_force(law.normal, 0.01 * r_eff, 0.0, 0.0, *fixed)[1]
    per = math.sqrt(m_eff / stiffness)

    def rates(t, y, memory):
        push = normal_force(law.normal, y[0] * v * per, y[1] * v, memory, *fixed)[0]
        pull = cohesive_pull(law.cohesion, y[0] * v * per, r_eff, numbers[10])
        return y[1], (pull - push) * per / (m_eff * v)

    def march(start, memory, *events):
        for event in events:
            event.terminal = True
        return solve_ivp(
            rates, (0.0, 1e4), start, "DOP853", args=(memory,), events=events, rtol=1e-9, atol=1e-12
        )

    def rest(t, y, memory):
        return y[1]

    def apart(t, y, memory):
        return y[0]

    rest.direction, apart.direction = -1.0, -1.0
    loading = march((0.0, 1.0), 0.0, rest)
    deep, turned = float(loading.y[0, -1]), float(loading.t[-1])
    push, tangent, memory = normal_force(law.normal, deep * v * per, 0.0, 0.0, *fixed)
    resolve = 2.0 * turned * per
    if isinstance(law.normal, HystereticSpring):
        resolve = math.pi * math.sqrt(m_eff / (tangent * pair.unloading_ratio))
    held = push <= cohesive_pull(law.cohesion, deep * v * per, r_eff, numbers[10])
    rest.direction = 1.0
    parting = None if held else march((deep, -1e-12), memory, apart, rest)
    if held or not parting.t_events[0].size:
        return Impact(tangent, math.inf, deep * v * per, 0.0, resolve)
    return Impact(
        tangent, (turned + float(parting.t[-1])) * per, deep * v * per, -float(parting.y[1, -1]), resolve
    )


def cohesive_softening(pair: PairLaw, r_eff: float) -> float:
    """Stiffness that area cohesion takes from the normal spring [N/m]: ``4 pi R* x pressure``; a linear
    spring must have more.
    """
    return AREA_PER_DEPTH * r_eff * pair.cohesive_pressure


def spring_stiffness(pair: PairLaw, diameter_a: float, diameter_b: float) -> float:
    """Normal stiffness [N/m] of a linear or hysteretic pair: as given, or of two bodies in series; a wall has
    the particle's diameter.
    """
    if pair.stiffness_direct > 0.0:
        return pair.stiffness_direct
    return 1.0 / (
        1.0 / (pair.stiffness_per_diameter_a * diameter_a)
        + 1.0 / (pair.stiffness_per_diameter_b * diameter_b)
    )
