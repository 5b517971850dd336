"""Closed forms of impacts, and one small integration of an oblique impact for what has none.

Sources: W. Goldsmith, Impact (1960), for Hertz; Y. Tsuji, T. Tanaka and T. Ishida, Powder Technology 71
(1992), for its dashpot; O. R. Walton, in Particulate Two-Phase Flow (1993), and S. F. Foerster et al.,
Physics of Fluids 6 (1994), for hard spheres with friction.
"""

import math
from typing import NamedTuple

HERTZ_TIME = 4.0 * math.sqrt(math.pi) / 5.0 * math.gamma(0.4) / math.gamma(0.9)
"""Contact time of an elastic Hertz impact over (largest overlap/speed) [1]: 2.943."""


def modulus(*solids: tuple[float, float]) -> float:
    """Contact modulus E* [Pa] of one (the other rigid) or two solids (E [Pa], nu [1])."""
    return 1.0 / sum((1.0 - nu * nu) / e for e, nu in solids)


def shear_modulus(*solids: tuple[float, float]) -> float:
    """Contact shear modulus G* [Pa] of one (the other rigid) or two solids (E [Pa], nu [1]); 1/G* = sum (2 -
    nu)/G.
    """
    return 1.0 / sum(2.0 * (2.0 - nu) * (1.0 + nu) / e for e, nu in solids)


class Elastic(NamedTuple):
    """Elastic Hertz impact."""

    force: float
    """Largest force [N]."""
    overlap: float
    """Largest overlap [m]."""
    time: float
    """Contact time [s]."""


def hertz(mass: float, radius: float, e_star: float, v: float) -> Elastic:
    """Elastic impact of reduced mass [kg] and radius [m] at `v` [m/s]."""
    k = 4.0 / 3.0 * e_star * math.sqrt(radius)
    overlap = (1.25 * mass * v * v / k) ** 0.4
    return Elastic(k * overlap**1.5, overlap, HERTZ_TIME * overlap / v)


def damped_hertz_time(mass: float, radius: float, e_star: float, v: float, zeta: float) -> float:
    """Upper bound of the contact time [s] with dashpot: that of the elastic impact, stretched as a damped
    oscillator is.
    """
    return hertz(mass, radius, e_star, v).time * (1.0 + 2.0 * zeta)


def sliding_rebound(v_n, v_t, e, mu, radius, spin=0.0):
    """Tangential velocity [m/s] and spin [rad/s] after an impact that slides throughout, in the direction of
    `v_t`.
    """
    return v_t - mu * (1.0 + e) * v_n, spin + 2.5 * mu * (1.0 + e) * v_n / radius


class Spring(NamedTuple):
    """Contact of a sphere with a flat, for `oblique`."""

    normal: object
    """Function of overlap [m] and its rate [m/s]: normal force [N], not below zero where tension is cut."""
    tangential: object
    """Function of overlap [m]: tangential stiffness [N/m]."""


def oblique(mass, radius, v_n, v_t, spin, mu, spring: Spring, stored: str, dt: float, tangential_damping=0.0):
    """Velocities v_n', v_t' [m/s] and spin [rad/s] of a sphere after an oblique impact on a fixed flat, by
    small steps `dt` [s].

    `stored` is what the tangential spring remembers: "displacement" or "incremental" (its force).  A dashpot
    of `tangential_damping` times ``2 sqrt(m k_t)`` acts beside it, both within Coulomb's limit.
    Trapezoidal in the spring, midpoint in the motion; the arm of friction is the radius less half the
    overlap.
    """
    d, rate, memory = 0.0, v_n, 0.0
    inertia = 0.4 * mass * radius * radius
    while True:
        # to the middle of the step
        middle = d + 0.5 * dt * rate
        if middle <= 0.0 and rate < 0.0:
            return -rate, v_t, spin
        arm = radius - 0.5 * middle
        force = spring.normal(middle, rate)
        force = spring.normal(middle, rate - 0.5 * dt * force / mass)
        k_t = spring.tangential(middle)
        slip = v_t - arm * spin
        memory += 0.5 * dt * slip * (k_t if stored == "incremental" else 1.0)
        pull = memory if stored == "incremental" else k_t * memory
        limit = mu * max(force, 0.0)
        if abs(pull) > limit:
            memory *= limit / abs(pull)
            pull = math.copysign(limit, pull)
        pull += 2.0 * tangential_damping * math.sqrt(mass * k_t) * slip
        pull = math.copysign(min(abs(pull), limit), pull)
        v_t -= dt * pull / mass
        spin += dt * arm * pull / inertia
        slip = v_t - arm * spin
        memory += 0.5 * dt * slip * (k_t if stored == "incremental" else 1.0)
        rate -= dt * force / mass
        d = middle + 0.5 * dt * rate


def hertz_mindlin(mass, radius, e_star, g_star, zeta, cut) -> Spring:
    """Hertz's and Mindlin's springs with the dashpot 2 zeta sqrt(5/6) sqrt(S m), S = 2 E* sqrt(R d)."""

    def normal(d, rate):
        d = max(d, 0.0)
        stiffness = 2.0 * e_star * math.sqrt(radius * d)
        force = (
            2.0 / 3.0 * stiffness * d + 2.0 * math.sqrt(5.0 / 6.0) * zeta * math.sqrt(stiffness * mass) * rate
        )
        return max(force, 0.0) if cut else force

    return Spring(normal, lambda d: 8.0 * g_star * math.sqrt(radius * max(d, 0.0)))


def linear(mass, k, zeta, ratio, cut) -> Spring:
    """Linear springs, tangential = `ratio` x normal, with the dashpot 2 zeta sqrt(k m)."""

    def normal(d, rate):
        force = k * d + 2.0 * zeta * math.sqrt(k * mass) * rate
        return max(force, 0.0) if cut else force

    return Spring(normal, lambda d: ratio * k)
