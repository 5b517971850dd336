"""Rigid bodies that turn: pendulum, tops, free rotation, against closed forms and one high-accuracy
integration.
"""

import math

import numpy as np
from scipy.integrate import solve_ivp
from scipy.special import ellipj, ellipk

from nutamill import System
from nutamill.base.frames import turn_quaternion
from nutamill.mechanism.parts import GROUND, Body, Joint, JointKind
from nutamill.mechanism.rows import matrix_of

G = 9.81


def simulate(parts, dt, end, **options):
    """March a mechanism from its assembled state to the time `end`; returns its state."""
    system = System(*parts, **options)
    system.march(end, dt)
    return system.state


def pendulum(start_angle):
    """A point mass of 1 kg on a pin at the origin, 1 m of arm, `start_angle` from straight down."""
    place = (math.sin(start_angle), 0.0, -math.cos(start_angle))
    return [Body("bob", 1.0, 1e-10 * np.eye(3), place)], [
        Joint("pin", JointKind.REVOLUTE, GROUND, "bob", (0.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    ]


def pendulum_angle(start_angle, t):
    """theta(t) = 2 asin(k sn(K - w0 t)), k = sin(theta0/2), w0 = sqrt(g/L)."""
    k = math.sin(start_angle / 2)
    return 2 * math.asin(k * ellipj(ellipk(k * k) - math.sqrt(G) * t, k * k)[0])


def test_attitude_turned_by_a_vector_is_that_of_its_sine_and_cosine():
    # below 1 rad a series, above the functions themselves; ten roundings of numbers of size 1 at most
    axis = np.array([2.0, -1.0, 2.0]) / 3.0
    for angle in np.linspace(0.0, 1.2, 49):
        out = np.empty(4)
        turn_quaternion(np.array([1.0, 0.0, 0.0, 0.0]), *(angle * axis), out)
        assert (
            np.abs(out - [math.cos(angle / 2), *(math.sin(angle / 2) * axis)]).max()
            < 10 * np.finfo(float).eps
        )


def test_pendulum_follows_the_elliptic_path_with_second_order():
    start_angle = -math.pi / 2
    for t in (1.0, 2.0):
        angles = []
        for dt in (1e-3, 5e-4):
            x, _, z = simulate(pendulum(start_angle), dt, t).position[0]
            angles.append(math.atan2(x, -z))
        exact = pendulum_angle(start_angle, t)
        # second order: halving the step leaves a quarter of the error (first order: a half, third: an eighth)
        assert abs(angles[1] - exact) < G * 5e-4**2
        assert 3.5 < (angles[0] - exact) / (angles[1] - exact) < 4.5


def test_pendulum_returns_after_its_elliptic_period():
    start_angle = math.radians(120.0)
    period = 4 * ellipk(math.sin(start_angle / 2) ** 2) / math.sqrt(G)
    errors = []
    for n in (2000, 4000):
        x, _, z = simulate(pendulum(start_angle), period / n, period).position[0]
        errors.append(abs(math.atan2(x, -z) - start_angle))
        # second order of the step over the time scale sqrt(L/g)
        assert errors[-1] < G * (period / n) ** 2
    assert errors[1] < errors[0] / 3.5


def heavy_top_path(t):
    """Mass centre of the benchmark heavy top from Euler's equations about the pivot, by DOP853 to 1e-12."""
    mass, arm = 15.0, np.array([0.0, 1.0, 0.0])
    about_pivot = np.diag([0.234375, 0.46875, 0.234375]) + mass * (np.eye(3) - np.outer(arm, arm))

    def rates(_, y):
        q, w = y[:4] / np.linalg.norm(y[:4]), y[4:]
        weight = matrix_of(q).T @ np.array([0.0, 0.0, -mass * G])
        dw = np.linalg.solve(about_pivot, np.cross(arm, weight) - np.cross(w, about_pivot @ w))
        dv = 0.5 * (q[0] * w + np.cross(q[1:], w))
        return np.array([-0.5 * q[1:] @ w, *dv, *dw])

    y = solve_ivp(
        rates, (0.0, t), [1.0, 0.0, 0.0, 0.0, 0.0, 150.0, -4.61538], method="DOP853", rtol=1e-12, atol=1e-13
    ).y[:, -1]
    return matrix_of(y[:4] / np.linalg.norm(y[:4])) @ arm


def test_heavy_top_converges_to_its_path_with_second_order():
    # Geradin and Cardona 2001; Bruls and Cardona 2010
    parts = (
        [
            Body(
                "top",
                15.0,
                np.diag([0.234375, 0.46875, 0.234375]),
                (0.0, 1.0, 0.0),
                velocity=(4.61538, 0.0, 0.0),
                angular_velocity=(0.0, 150.0, -4.61538),
            )
        ],
        [Joint("pivot", JointKind.SPHERICAL, GROUND, "top", (0.0, 0.0, 0.0))],
    )
    exact = heavy_top_path(0.5)
    one, two = (simulate(parts, dt, 0.5).position[0].copy() for dt in (2e-4, 1e-4))
    assert np.linalg.norm(two - exact) < 1e-3
    # second order: halving the step leaves a quarter of the error (first order: a half, third: an eighth)
    assert 3.5 < np.linalg.norm(one - exact) / np.linalg.norm(two - exact) < 4.5


def test_symmetric_top_precesses_steadily_at_the_rate_of_the_quadratic():
    mass, arm, transverse, axial, spin, tilt = 1.0, 0.1, 0.012, 0.002, 200.0, 0.5
    # I1 cos(theta) W^2 - I3 w3 W + m g l = 0, slow root
    a, b, c = transverse * math.cos(tilt), -axial * spin, mass * G * arm
    rate = (-b - math.sqrt(b * b - 4 * a * c)) / (2 * a)
    axis = np.array([math.sin(tilt), 0.0, math.cos(tilt)])
    turning = rate * np.array([0.0, 0.0, 1.0]) + (spin - rate * math.cos(tilt)) * axis
    body = Body(
        "top",
        mass,
        np.diag([transverse - mass * arm**2] * 2 + [axial]),
        arm * axis,
        quaternion=(math.cos(tilt / 2), 0.0, math.sin(tilt / 2), 0.0),
        velocity=np.cross(turning, arm * axis),
        angular_velocity=turning,
    )
    end, azimuths = 0.5, []
    for dt in (1e-4, 5e-5):
        x, y, z = simulate(
            ([body], [Joint("pivot", JointKind.SPHERICAL, GROUND, "top", (0.0, 0.0, 0.0))]), dt, end
        ).position[0]
        azimuths.append(math.atan2(y, x))
        assert abs(z - arm * math.cos(tilt)) < arm * (spin * dt) ** 2
    assert abs(azimuths[1] - rate * end) < 1e-4
    # second order: the extrapolation is an order of magnitude nearer than the finer run, to the angle's
    # round-off
    assert abs((4 * azimuths[1] - azimuths[0]) / 3 - rate * end) < 0.1 * abs(azimuths[1] - rate * end) + 1e-8


def test_free_body_flips_with_the_elliptic_period():
    # Landau and Lifshitz, Mechanics, section 37: spin about the middle axis, I1 < I2 < I3
    i1, i2, i3, w1, w2 = 1.0, 2.0, 3.0, 0.01, 10.0
    energy, momentum = i1 * w1**2 + i2 * w2**2, (i1 * w1) ** 2 + (i2 * w2) ** 2
    # M^2 < 2 E I2 here
    modulus = (i3 - i2) * (momentum - energy * i1) / ((i2 - i1) * (energy * i3 - momentum))
    rate = math.sqrt((i2 - i1) * (energy * i3 - momentum) / (i1 * i2 * i3))
    if modulus > 1.0:
        modulus, rate = 1.0 / modulus, rate * math.sqrt(modulus)
    period = 4 * ellipk(modulus) / rate
    periods = []
    for n in (16000, 32000):
        dt = period / n
        parts = (
            [Body("brick", 1.0, np.diag([i1, i2, i3]), (0.0, 0.0, 0.0), angular_velocity=(w1, w2, 0.0))],
            [],
        )
        system = System(*parts, gravity=(0.0, 0.0, 0.0))
        state = system.state
        before = np.diag([i1, i2, i3]) @ state.angular_velocity[0]
        system.march(0.7 * n * dt, dt)
        crossing, last = 0.0, None
        for k in range(
            round(0.7 * n), round(0.8 * n)
        ):  # the middle spin passes zero upwards at 3/4 of a period
            spin = (matrix_of(state.quaternion[0]).T @ state.angular_velocity[0])[1]
            if last is not None and last < 0.0 <= spin:
                crossing = (k - spin / (spin - last)) * dt
            last = spin
            system.step(dt)
        periods.append(crossing / 0.75)
        R = matrix_of(state.quaternion[0])
        after = R @ np.diag([i1, i2, i3]) @ R.T @ state.angular_velocity[0]
        assert np.linalg.norm(after - before) < 1e-14 * n * np.linalg.norm(before)
    # the flip starts from a tilt of w1/w2 = 1e-3, which the scheme shifts by order (w2 dt)^2 = 3e-6: 3e-3 of
    # it
    assert abs(periods[1] / period - 1.0) < 3e-3
    assert abs(periods[0] - period) > 3.5 * abs(periods[1] - period)
