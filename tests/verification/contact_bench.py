"""One contact at a time: the composed law under a leapfrog, without the engine around it."""

import math

import numpy as np

from nutamill.base.kernel import kernel
from nutamill.charge.laws.composition import contact, law_numbers
from nutamill.charge.laws.pair import PairLaw

R, M = 0.0025, 5e-4


def pair(**changes):
    """Numbers of a pair with the things a test does not speak of switched off."""
    given = {
        "stiffness_direct": 1e5,
        "stiffness_per_diameter_a": 0.0,
        "stiffness_per_diameter_b": 0.0,
        "tangential_ratio": 1.0,
        "damping_ratio": 0.0,
        "tension_cut": False,
        "static_friction": 0.0,
        "dynamic_friction": 0.0,
        "rolling_friction": 0.0,
        "overlap_warn": 0.3,
        "overlap_stop": 0.4,
        "contact_modulus": 1e8,
        "contact_shear_modulus": 4e7,
    }
    return PairLaw(**(given | changes))


@kernel
def evaluate(law, n, overlap, u, w, spring, rolled, sliding, history, m_eff, r_eff, diameters, numbers, dt):
    """The composed law."""
    return contact(
        law, n, overlap, u, w, spring, rolled, sliding, history, m_eff, r_eff, diameters, numbers, dt
    )


def plain(*arguments):
    """As `evaluate`, without the compiler: quick to start, for tests of one contact."""
    return getattr(contact, "py_func", contact)(*arguments)


ZERO = (0.0, 0.0, 0.0)
UP = (0.0, 0.0, 1.0)


class Probe:
    """One contact with a wall on the side of +z, moved by hand; forces act on the particle."""

    def __init__(self, law, numbers, dt, m=M, r=R):
        self.law, self.numbers, self.dt, self.m, self.r = law, tuple(law_numbers(law, numbers)), dt, m, r
        self.s, self.t, self.sliding, self.history = ZERO, ZERO, 0.0, 0.0

    def step(self, overlap, u, w=ZERO):
        """Force and moment [N, N m] at this overlap [m] with these mid-substep velocities; memory goes on by
        one substep.
        """
        out = plain(
            self.law,
            UP,
            float(overlap),
            tuple(map(float, u)),
            tuple(map(float, w)),
            self.s,
            self.t,
            self.sliding,
            self.history,
            self.m,
            self.r,
            (2 * self.r, 2 * self.r),
            self.numbers,
            self.dt,
        )
        force, _, moment, self.s, self.t, self.sliding, self.history, self.powers = out
        return np.array(force), np.array(moment)


def bounce(law, numbers, v, dt, phase=0.3, m=M, r=R):
    """Head-on impact at `v` by leapfrog: restitution, largest overlap [m] and duration [s]."""
    probe = Probe(law, numbers, dt, m, r)
    depth, speed, kick, deepest, steps = -phase * v * dt, v, 0.0, 0.0, 0
    while True:
        depth += dt * speed
        if depth <= 0.0:
            return -speed / v, deepest, steps * dt
        deepest, steps = max(deepest, depth), steps + 1
        force, _ = probe.step(depth, (0.0, 0.0, speed + 0.5 * dt * kick))
        kick = force[2] / m
        speed += dt * kick
        if steps > 100_000 or not math.isfinite(speed):
            return 0.0, deepest, math.inf
