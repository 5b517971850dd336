"""One contact at a time: the composed law under a leapfrog, without the engine around it."""

import math

import numpy as np

from nutamill.base.kernel import kernel
from nutamill.charge.laws.composition import contact
from nutamill.charge.laws.numbers import law_numbers
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
def evaluate(law, n, overlap, u, w, s, t, sliding, history, m_eff, r_eff, diameters, numbers, dt):
    """The composed law; vectors are tuples."""
    return contact(
        law,
        n[0],
        n[1],
        n[2],
        overlap,
        u[0],
        u[1],
        u[2],
        w[0],
        w[1],
        w[2],
        s[0],
        s[1],
        s[2],
        t[0],
        t[1],
        t[2],
        sliding,
        history,
        m_eff,
        r_eff,
        diameters[0],
        diameters[1],
        numbers,
        dt,
    )


def plain(law, n, overlap, u, w, s, t, sliding, history, m_eff, r_eff, diameters, numbers, dt):
    """As `evaluate`, without the compiler: quick to start, for tests of one contact."""
    return getattr(contact, "py_func", contact)(
        law, *n, overlap, *u, *w, *s, *t, sliding, history, m_eff, r_eff, *diameters, numbers, dt
    )  # fmt: skip


ZERO = (0.0, 0.0, 0.0)
UP = (0.0, 0.0, 1.0)


class Probe:
    """One contact with a wall along z, moved by hand; forces act on the particle, whose wall lies in +z."""

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
        self.s, self.t, self.sliding, self.history = out[9:12], out[12:15], out[15], out[16]
        self.powers = out[17:20]
        return np.array(out[:3]), np.array(out[6:9])


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
