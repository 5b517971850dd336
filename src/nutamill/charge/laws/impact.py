"""What the numbers of a contact mean: restitution, contact time, overlap, and the time a substep has to
resolve.

Plain Python for the doors of the package and for tests; exact for one head-on contact without gravity.
"""

import math
from dataclasses import replace

from scipy.integrate import solve_ivp

from nutamill.charge.laws import capillary, no_film, viscous_film
from nutamill.charge.laws.area import cohesive_softening
from nutamill.charge.laws.composition import (
    ContactLaw,
    cohesive_pull,
    law_files,
    law_numbers,
    normal_force,
    rolling_energy,
)
from nutamill.charge.laws.oscillator import Impact
from nutamill.charge.laws.pair import NORMAL_NUMBERS, PairLaw, spring_stiffness

SUBSTEPS_PER_CONTACT = 20
"""Substeps that the shortest time to resolve of a charge is cut into [1]."""


def impact(
    law: ContactLaw, pair: PairLaw, m_eff: float, r_eff: float, diameter_a: float, diameter_b: float, v: float
) -> Impact:
    """Return the head-on contact of two bodies that meet at `v` [m/s].

    In closed form (Hertz: an integral) without cohesion; with cohesion by integration of the law.  A linear
    spring weaker than its cohesion never comes to rest: its overlap is infinite.  A film takes its momentum
    on the way in and on the way out; where it stops the two, they do not touch.  A bridge takes the work of
    its separation, after the film.  A rolling spring whose stiffness is given, and the time in which the film
    brakes near the roughness, have to be resolved, too.

    Parameters
    ----------
    law, pair : the law and its numbers
    m_eff, r_eff : reduced mass [kg] and radius [m]
    diameter_a, diameter_b : [m]; a wall takes the particle's
    """
    if law_files(law)[4] is no_film:
        met = _head_on(law, pair, m_eff, r_eff, diameter_a, diameter_b, v)
    else:
        met = _through_film(law, pair, m_eff, r_eff, diameter_a, diameter_b, v)
    if law_files(law)[4] is capillary and v > 0.0:
        met = _from_bridge(met, 2.0 * capillary.separation_work(pair, r_eff) / (m_eff * v * v))
    # without a tangential spring, only a rolling stiffness that is given is left
    stiffness = 2.0 * rolling_energy(law.rolling, 1.0, 0.0, r_eff, pair.rolling_stiffness)
    if stiffness == 0.0:
        return met
    # the least inertia against rolling that two spheres of these reduced numbers have
    inertia = 0.4 * m_eff * r_eff * r_eff
    return replace(met, resolve=min(met.resolve, math.pi * math.sqrt(inertia / stiffness)))


def _through_film(law, pair, m_eff, r_eff, diameter_a, diameter_b, v) -> Impact:
    """Return the contact of the solids behind a film, its restitution that of the whole impact."""
    lost = viscous_film.lost_momentum(pair, r_eff) / m_eff
    resolve = viscous_film.braking_time(pair, m_eff, r_eff)
    if lost >= v > 0.0:
        met = _head_on(law, pair, m_eff, r_eff, diameter_a, diameter_b, v)
        return replace(met, time=math.inf, overlap=0.0, restitution=0.0, resolve=min(met.resolve, resolve))
    met = _head_on(law, pair, m_eff, r_eff, diameter_a, diameter_b, v - lost)
    left = met.restitution * (v - lost) - lost
    restitution = max(left / v, 0.0) if v > 0.0 else met.restitution
    return replace(met, restitution=restitution, resolve=min(met.resolve, resolve))


def _from_bridge(met: Impact, share: float) -> Impact:
    """Return a contact whose bridge takes `share` of the energy of approach on parting [1]."""
    return replace(met, restitution=math.sqrt(max(met.restitution**2 - share, 0.0)))


def _head_on(law, pair, m_eff, r_eff, diameter_a, diameter_b, v) -> Impact:
    """Return `impact` as far as the normal law and cohesion go."""
    normal, diameters = law_files(law)[0], (diameter_a, diameter_b)
    if not cohesive_pull(law.cohesion, 1.0, r_eff, pair.cohesive_pressure) > 0.0:
        return normal.impact(pair, m_eff, r_eff, diameters, v)
    if not normal.STIFFENS and (k := spring_stiffness(pair, *diameters)) <= cohesive_softening(pair, r_eff):
        return Impact(k, math.inf, math.inf, 0.0, math.pi * math.sqrt(m_eff / k))
    return _integrated(law, pair, m_eff, r_eff, diameters, v)


def _integrated(law, pair, m_eff, r_eff, diameters, v) -> Impact:
    """Return `impact` by integration of the law itself: loading up to rest, then unloading with the memory of
    the largest overlap.
    """
    numbers = law_numbers(law, pair)
    p, fixed = tuple(numbers[:NORMAL_NUMBERS]), (m_eff, r_eff, diameters, 0.0)

    def push_of(overlap, speed, memory):
        return normal_force(law.normal, p, overlap, speed, memory, *fixed)

    def pull_of(overlap):
        return cohesive_pull(law.cohesion, overlap, r_eff, pair.cohesive_pressure)

    # in units of the time and depth of a linear contact of like energy
    per = math.sqrt(m_eff / push_of(0.01 * r_eff, 0.0, 0.0)[1])

    def rates(t, y, memory):
        depth = y[0] * v * per
        return y[1], (pull_of(depth) - push_of(depth, y[1] * v, memory)[0]) * per / (m_eff * v)

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

    rest.direction = apart.direction = -1.0  # type: ignore[attr-defined]  # as SciPy asks
    loading = march((0.0, 1.0), 0.0, rest)
    deep, loaded = float(loading.y[0, -1]), float(loading.t[-1])
    overlap = deep * v * per
    push, tangent, memory = push_of(overlap, 0.0, 0.0)
    resolve = law_files(law)[0].resolve_time(pair, tangent, m_eff, loaded * per)
    sticks = push <= pull_of(overlap)
    rest.direction = 1.0  # type: ignore[attr-defined]
    parting = None if sticks else march((deep, -1e-12), memory, apart, rest)
    if parting is None or not parting.t_events[0].size:
        return Impact(tangent, math.inf, overlap, 0.0, resolve)
    return Impact(tangent, (loaded + float(parting.t[-1])) * per, overlap, -float(parting.y[1, -1]), resolve)
