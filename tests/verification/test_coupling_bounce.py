"""A sphere that bounces on a sprung, damped body, against the exact piecewise linear motion of both."""

import math

import numpy as np
import pytest
from coupled_bench import FLOOR, CoupledBench, G, Scheme, law
from scipy.linalg import expm
from scipy.optimize import brentq

SPHERE, BODY = 0.02, 0.5
"""Masses [kg]."""
SPRING, DAMPER = 2000.0, 0.4
CONTACT, DASHPOT = 2e4, 2.0
"""Stiffness [N/m] and damping [N s/m] of body and contact."""
HEIGHT, SPEED = 0.01, 1.0
R = 0.01


def exact_motion(end):
    """States (z, v, Z, V) of sphere and body as a function of time up to `end`, and the instants of touch and
    release.

    Between two events the motion is linear, y' = A y with y = (z, v, Z, V, 1), and is carried on by the
    matrix exponential.
    """
    free = np.zeros((5, 5))
    free[0, 1] = free[2, 3] = 1.0
    free[1, 4] = -G
    free[3, 2:] = -SPRING / BODY, -DAMPER / BODY, -G
    touching = free.copy()
    touching[1, :4] += np.array([-CONTACT, -DASHPOT, CONTACT, DASHPOT]) / SPHERE
    touching[3, :4] += np.array([CONTACT, DASHPOT, -CONTACT, -DASHPOT]) / BODY
    y, t, pieces, events = np.array([HEIGHT, -SPEED, 0.0, 0.0, 1.0]), 0.0, [], []
    system, look = free, 2e-5
    while t < end:
        pieces.append((t, system, y))
        sign = 1.0 if system is free else -1.0
        carry, z, s = expm(system * look), y, 0.0
        while t + s < end:
            ahead = carry @ z
            # the first look after an event may still see the event itself
            if s > 0.0 and sign * (ahead[0] - ahead[2]) < 0.0:
                s += brentq(
                    lambda q, z=z, m=system, sign=sign: sign * ((expm(m * q) @ z)[0] - (expm(m * q) @ z)[2]),
                    0.0,
                    look,
                    xtol=1e-15,
                )
                break
            z, s = ahead, s + look
        y, t = expm(system * s) @ y, t + s
        if t < end:
            events.append(t)
            system = touching if system is free else free

    def motion(time):
        begun, matrix, at = [piece for piece in pieces if piece[0] <= time][-1]
        return (expm(matrix * (time - begun)) @ at)[:4]

    return motion, events


def bounce(window, end, scheme=Scheme.STAGGERED):
    """The same case marched; dashpot 2 zeta sqrt(m k) of the sphere against a wall, with tension as in the
    exact motion.
    """
    zeta = DASHPOT / (2.0 * math.sqrt(SPHERE * CONTACT))
    return CoupledBench(
        [0.0, 0.0, HEIGHT + R],
        [FLOOR],
        law(CONTACT, zeta),
        window,
        BODY,
        stiffness=SPRING,
        damping=DAMPER,
        gravity=(0.0, 0.0, -G),
        scheme=scheme,
        radius=R,
        density=SPHERE / (4.0 / 3.0 * math.pi * R**3),
        velocities=[0.0, 0.0, -SPEED],
    ).until(end)


def errors(bench, exact):
    """Error of (z, v, Z, V) in parts of the contact's own length and of the speed of impact."""
    state = np.array([bench.x[0, 2] - R, bench.v[0, 2], bench.z, bench.speed])
    length = SPEED * math.sqrt(SPHERE / CONTACT)
    return (state - exact) / np.array([length, SPEED, length, SPEED])


@pytest.mark.parametrize("scheme", [Scheme.STAGGERED, Scheme.ITERATED])
def test_sphere_and_sprung_body_follow_the_exact_two_way_motion(scheme):
    # Both schemes are of second order in a = w0 dt, dt the window: a contact's impulse is wrong by a^2/4 at
    # most (half of it at each
    # end), and a wrong speed moves the sphere until the end; the body swings about its spring and so never
    # strays beyond V error/w.
    window, end = 4e-5, 0.192
    motion, _ = exact_motion(end)
    wrong = np.abs(errors(bounce(window, end, scheme), motion(end)))
    w0 = math.sqrt(CONTACT * (1.0 / SPHERE + 1.0 / BODY))
    speed = 2 * (w0 * window) ** 2 / 4
    assert wrong[1] < speed
    assert wrong[3] < speed * SPHERE / BODY
    assert wrong[0] < speed * end * w0
    assert wrong[2] < speed * SPHERE / BODY * w0 / math.sqrt(SPRING / BODY)


def test_bounces_happen_when_the_exact_motion_says():
    # the record says at the end of each window whether sphere and body touch: an event is seen one window
    # late at most, and the
    # second bounce is late by the position error over the speed, far less than a window
    window, end = 2e-5, 0.192
    _, events = exact_motion(end)
    bench = bounce(window, end)
    touching = bench.read("contacts", "wall") > 0
    seen = (np.flatnonzero(np.diff(touching)) + 2) * window
    assert len(seen) == len(events) == 4
    assert seen == pytest.approx(np.array(events), abs=1.5 * window)


def test_error_of_the_bounce_falls_with_the_square_of_the_window():
    # in the middle of the first contact, three halvings: second order leaves 1/64, first order 1/8
    end = 0.0128
    motion, (touch, release, *_) = exact_motion(0.02)
    assert touch < end < release
    coarse, fine = (np.abs(errors(bounce(window, end), motion(end))) for window in (8e-5, 1e-5))
    assert np.all(np.log2(coarse / fine) / 3 > 1.8)


def test_prescribed_motion_feels_nothing_of_the_sphere():
    # Without reaction the body swings about its static sag as if alone: Z = Z0 (e^-dt (cos wt + d/w sin wt) -
    # 1), Z0 = M g/K.
    # Verlet's own error: phase w t (w dt)^2/24 of Z0.
    window, end = 4e-5, 0.192
    bench = bounce(window, end, Scheme.PRESCRIBED)
    sag, decay = BODY * G / SPRING, DAMPER / (2 * BODY)
    w = math.sqrt(SPRING / BODY - decay**2)
    exact = sag * (math.exp(-decay * end) * (math.cos(w * end) + decay / w * math.sin(w * end)) - 1.0)
    assert bench.z == pytest.approx(exact, abs=sag * (w * window) ** 2 * (w * end + 1))
    assert np.abs(bench.coupling.charge_impulse[2]) > SPHERE * SPEED
    assert np.all(bench.coupling.mechanism_impulse == 0.0)
    assert np.ptp(bench.read("sensors", "box_z")) > sag and np.ptp(bench.read("sensors", "box_vz")) > sag * w
