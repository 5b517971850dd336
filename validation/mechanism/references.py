"""Reference solutions: closed forms, published end values, and high-accuracy integrations in minimal
coordinates (SI).
"""

import math

import numpy as np
from scipy.integrate import solve_ivp
from scipy.special import ellipj, ellipk

G = 9.81


def pendulum(time: np.ndarray) -> np.ndarray:
    """Place (n, 2) of a point on a 1 m arm released at rest at (-1, 0): theta = 2 asin(k sn(K - w t)), k =
    sin(pi/4).
    """
    k, w = math.sin(-math.pi / 4), math.sqrt(G)
    angle = 2.0 * np.arcsin(k * ellipj(ellipk(k * k) - w * time, k * k)[0])
    return np.column_stack([np.sin(angle), -np.cos(angle)])


def four_bars(time: np.ndarray, windows: int = 2) -> np.ndarray:
    """Place (n, 2) of the first upright's upper end: one angle, (m (N+1)/3 + m N) L^2 w' = (m (N+1)/2 + m N)
    g L sin(angle).
    """
    inertia, moment = (windows + 1) / 3 + windows, ((windows + 1) / 2 + windows) * G
    path = solve_ivp(
        lambda _, y: [y[1], moment / inertia * math.sin(y[0])], (0.0, time[-1]), [0.0, 1.0], method="DOP853", rtol=1e-12, atol=1e-12,
        t_eval=time,
    )  # fmt: skip
    return np.column_stack([np.sin(path.y[0]), np.cos(path.y[0])])


SQUEEZER_START = {
    "k1": -0.0617138900142764,
    "k3": 0.455279819163070,
    "k5": 0.487364979543843,
    "k7": 1.23054744454982,
}
"""Angles beta, gamma, delta, epsilon at the start [rad]: Hairer and Wanner 1996, section VII.7."""
SQUEEZER_END = {
    "k1": 15.81077119629904,
    "k3": 0.04082224013073101,
    "k5": 0.5244099658805304,
    "k7": 1.048080741042263,
}
"""The same at 0.03 s: Mazzia and Magherini, Test Set for Initial Value Problem Solvers, 2008, problem 3."""


def governor(time: np.ndarray) -> np.ndarray:
    """Height (n,) of the slider of the stiff flyball governor.

    Lagrange's equations of the angle t of the rods from straight down and the height s of the slider; the
    angular momentum about the shaft, J(t) w, is kept.  A rod with its point mass: mass m, centre c from the
    hinge, transverse and axial inertia I, A; the hinge at radius a.  J = J0 + 2 (m (a + c sin t)^2 + I sin^2
    t + A cos^2 t).
    """
    rod, point, slider, a, middle, free = 0.3, 5.0, 3.0, 0.05, 0.5, 0.5
    m = rod + point
    c = (rod * 0.5 + point) / m
    transverse = rod * (1 + 1e-4) / 12 + rod * (c - 0.5) ** 2 + point * (1 - c) ** 2
    axial, fixed = rod * 1e-4 / 6, 0.3 * 1e-4 / 6 + slider * 0.01 / 6

    def turning(t):
        return fixed + 2 * (
            m * (a + c * math.sin(t)) ** 2 + transverse * math.sin(t) ** 2 + axial * math.cos(t) ** 2
        )

    begin = math.radians(60.0)
    momentum = turning(begin) * math.tau

    def rates(_, y):
        t, s, dt, ds = y
        x, z = middle * math.sin(t), 1 - middle * math.cos(t) - s
        length = math.hypot(x, z)
        stretch = (x * middle * math.cos(t) * dt + z * (middle * math.sin(t) * dt - ds)) / length
        pull = 8e5 * (length - free) + 4e4 * stretch
        along_t = (x * middle * math.cos(t) + z * middle * math.sin(t)) / length
        slope = 2 * (
            2 * m * (a + c * math.sin(t)) * c * math.cos(t)
            + 2 * (transverse - axial) * math.sin(t) * math.cos(t)
        )
        about = 0.25 * (momentum / turning(t)) ** 2 * slope - m * G * c * math.sin(t) - pull * along_t
        return [dt, ds, about / (m * c * c + transverse), 2 * pull * z / length / slider - G]

    path = solve_ivp(
        rates, (0.0, time[-1]), [begin, 0.5, 0.0, 0.0], method="Radau", rtol=1e-10, atol=1e-12, t_eval=time
    )
    return path.y[1]


def heavy_top(time: np.ndarray) -> np.ndarray:
    """Mass centre (n, 3) of the heavy top: Euler's equations about the pivot."""
    mass, arm = 15.0, np.array([0.0, 1.0, 0.0])
    about = np.diag([0.234375, 0.46875, 0.234375]) + mass * (np.eye(3) - np.outer(arm, arm))

    def rates(_, y):
        q, w = y[:4] / np.linalg.norm(y[:4]), y[4:]
        turn = np.cross(arm, mass * turned_back(q, np.array([0.0, 0.0, -G])))
        dw = np.linalg.solve(about, turn - np.cross(w, about @ w))
        return np.array([-0.5 * q[1:] @ w, *(0.5 * (q[0] * w + np.cross(q[1:], w))), *dw])

    path = solve_ivp(
        rates,
        (0.0, time[-1]),
        [1, 0, 0, 0, 0, 150, -4.61538],
        method="DOP853",
        rtol=1e-12,
        atol=1e-13,
        t_eval=time,
    )
    return np.array([turned(q / np.linalg.norm(q), arm) for q in path.y[:4].T])


def free_body(time: np.ndarray) -> np.ndarray:
    """Attitude (n, 4) of the body with inertias 1, 2, 3 kg m^2 that starts at (0.01, 10, 0) rad/s and feels
    no moment.
    """
    inertia = np.array([1.0, 2.0, 3.0])

    def rates(_, y):
        q, w = y[:4], y[4:]
        return np.array(
            [
                -0.5 * q[1:] @ w,
                *(0.5 * (q[0] * w + np.cross(q[1:], w))),
                *(-np.cross(w, inertia * w) / inertia),
            ]
        )

    path = solve_ivp(
        rates,
        (0.0, time[-1]),
        [1, 0, 0, 0, 0.01, 10, 0],
        method="DOP853",
        rtol=1e-13,
        atol=1e-13,
        t_eval=time,
    )
    return (path.y[:4] / np.linalg.norm(path.y[:4], axis=0)).T


def slider_crank(time: np.ndarray) -> np.ndarray:
    """Acceleration (n,) of the piston of a 100 mm crank with a 300 mm rod at 600 rpm, by complex-step
    derivatives of its place.
    """
    speed, r, l, h = 600 * math.pi / 30, 0.1, 0.3, 1e-30

    def rate(angle):  # dx/d(angle)
        return -r * np.sin(angle) - r**2 * np.sin(angle) * np.cos(angle) / np.sqrt(
            l**2 - (r * np.sin(angle)) ** 2
        )

    return speed**2 * np.imag(rate(speed * time + 1j * h)) / h


def universal_joint(time: np.ndarray) -> np.ndarray:
    """Speed (n,) of the shaft driven at 10 rad/s through a universal joint at 0.3 rad: cos b / (1 - sin^2 b
    sin^2 angle).
    """
    bend, speed = 0.3, 10.0
    return speed * math.cos(bend) / (1 - (math.sin(bend) * np.sin(speed * time)) ** 2)


def turned(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """A vector turned by a unit quaternion (w, x, y, z)."""
    return v + 2.0 * np.cross(q[1:], np.cross(q[1:], v) + q[0] * v)


def turned_back(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """A vector turned by the inverse of a unit quaternion."""
    return turned(q * [1.0, -1.0, -1.0, -1.0], v)
