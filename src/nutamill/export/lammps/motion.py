"""The recorded motion of the chamber, as seen from the chamber itself.

LAMMPS has no wall that nutates.  Its particles therefore move in the axes of the chamber, where the walls
are at rest, and feel the forces of the moving frame.
"""

from typing import NamedTuple

import numpy as np
from scipy.interpolate import make_interp_spline

from nutamill.analysis.replay import rotation_of

DEGREE = 5
"""Degree of the splines through position and quaternion [1]: accelerations are then of fourth order."""
FEWEST = 2 * (DEGREE + 1)
"""Snapshots that a motion needs [1]: every second of them carries a spline too, for the error."""
GAIN = 2.0 ** (DEGREE + 1)
"""Error of the motion through every second snapshot, over that through all [1]."""
TURN = 0.02
"""Rotation of the chamber in a stretch of constant slopes [rad]: forces are then good to ``TURN**2 / 8``."""


class ChamberMotion:
    """Position and attitude of a body between snapshots.

    Parameters
    ----------
    time : of the snapshots [s] (n,)
    position : mass centre of the body [m] (n, 3), world
    quaternion : attitude of the body (n, 4)
    """

    def __init__(self, time: np.ndarray, position: np.ndarray, quaternion: np.ndarray):
        # q and -q are the same attitude: each is taken next to the one before it
        flips = np.sum(quaternion[1:] * quaternion[:-1], axis=1) < 0.0
        signs = np.cumprod(np.where(np.concatenate([[False], flips]), -1.0, 1.0))
        self.time = time
        self._poses = np.column_stack([position, quaternion * signs[:, None]])
        self._spline = make_interp_spline(time, self._poses, DEGREE)

    def pose(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return mass centres [m] (n, 3) and rotation matrices (n, 3, 3) from body to world axes."""
        poses = self._spline(time)
        return poses[:, :3], rotation_of(poses[:, 3:] / np.linalg.norm(poses[:, 3:], axis=1)[:, None])

    def twist(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return velocities of the mass centre [m/s] (n, 3), world axes, and angular velocities [rad/s]
        (n, 3), body axes.
        """
        moved = self._spline(time, 1)
        return moved[:, :3], _doubled(self._spline(time)[:, 3:], moved[:, 3:])

    def acceleration(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return accelerations of the mass centre [m/s^2] (n, 3), world axes, and angular accelerations
        [rad/s^2] (n, 3), body axes.
        """
        moved = self._spline(time, 2)
        return moved[:, :3], _doubled(self._spline(time)[:, 3:], moved[:, 3:])

    def error(self, reach: float) -> float:
        """Return an estimate of the error of the position of a wall [m], at `reach` [m] from the mass centre:
        the distance from the motion through every second snapshot, over `GAIN`.
        """
        coarse = ChamberMotion(self.time[::2], self._poses[::2, :3], self._poses[::2, 3:])
        between = self.time[1 : 2 * len(coarse.time) - 1 : 2]
        (place, rotation), (other, turned) = self.pose(between), coarse.pose(between)
        shift = np.linalg.norm(place - other, axis=1)
        turn = np.linalg.norm(rotation - turned, axis=(1, 2))  # at least the angle between the two
        return float((shift + reach * turn).max()) / GAIN


class Stretches(NamedTuple):
    """Pieces of time in which gravity and the motion of the chamber change linearly, chamber axes."""

    steps: np.ndarray
    """Steps in each [1], int64 (n,)."""
    at_start: np.ndarray
    """Gravity less the acceleration of the mass centre [m/s^2] (3), angular velocity [rad/s] (3) and angular
    acceleration [rad/s^2] (3) at the start of each (n, 9).
    """
    slope: np.ndarray
    """Change of the same in a step (n, 9)."""


def stretches(motion: ChamberMotion, gravity: np.ndarray, dt: float) -> Stretches:
    """Cut the time of a motion, from its first snapshot to its last, into stretches.

    Parameters
    ----------
    motion : of the chamber
    gravity : acceleration of gravity [m/s^2] (3,), world axes
    dt : step [s]
    """
    total = round((motion.time[-1] - motion.time[0]) / dt)
    fastest = np.linalg.norm(motion.twist(motion.time)[1], axis=1).max()
    orbit = np.linalg.norm(motion.acceleration(motion.time)[1], axis=1).max() / max(fastest, 1e-30)
    length = max(1, min(total, int(TURN / max(fastest, orbit, 1e-30) / dt)))
    edges = np.append(np.arange(0, total, length), total)
    time = np.minimum(motion.time[0] + edges * dt, motion.time[-1])
    _, rotation = motion.pose(time)
    _, spin = motion.twist(time)
    acceleration, turning = motion.acceleration(time)
    felt = np.einsum("nji,nj->ni", rotation, gravity - acceleration)
    values, steps = np.hstack([felt, spin, turning]), np.diff(edges)
    return Stretches(steps, values[:-1], np.diff(values, axis=0) / steps[:, None])


def _doubled(quaternion: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """Return twice the vector part of ``conj(q) r``, over the square of q (n, 3): of the first rate of q the
    angular velocity, of the second the angular acceleration, both in body axes.
    """
    w, v = quaternion[:, :1], quaternion[:, 1:]
    part = w * rate[:, 1:] - rate[:, :1] * v - np.cross(v, rate[:, 1:])
    return 2.0 * part / np.sum(quaternion * quaternion, axis=1)[:, None]
