"""The motion of a chamber that nutates about its upper end, and does not spin."""

import math

import numpy as np

TILT = math.atan2(0.039, 0.366)
SPEED = 60.0


def tilted(crank_angle):
    """Attitude (w, x, y, z) of a chamber whose lower end is swung towards the crank and that does not
    spin.
    """
    half = -0.5 * TILT
    return np.array(
        [math.cos(half), -math.sin(crank_angle) * math.sin(half), math.cos(crank_angle) * math.sin(half), 0.0]
    )


def turned(crank_angle):
    return np.array([math.cos(crank_angle / 2), 0.0, 0.0, math.sin(crank_angle / 2)])


def matrix(q):
    w, v = q[0], q[1:]
    skew = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    return np.eye(3) + 2 * w * skew + 2 * skew @ skew
