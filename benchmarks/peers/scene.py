"""The case all engines are given, and what is read from each of them in the same way.

A chamber (a closed cylinder) nutates without spin about the nutation point O: its attitude at crank angle
theta is ``R = Rz(theta) Ry(-alpha) Rz(-theta)``, its angular velocity ``W = w (z - R z)``, z up.  *World*
axes rest; *chamber* axes are those of R, from O.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

BLOCK = 0.25
"""Revolutions in one block of time; the scatter of a mean is taken over blocks [1]."""


@dataclass(frozen=True, slots=True)
class Law:
    """Numbers of the contact law of one pair: linear spring and dashpot, tangential and rolling springs with
    a limit each.
    """

    stiffness: float
    """Normal stiffness [N/m]."""
    tangential: float
    """Tangential stiffness [N/m]."""
    damping_rate: float
    """Dashpot over reduced mass [1/s]."""
    restitution: float
    """What that dashpot gives [1]."""
    sliding: float
    """Coefficient of sliding friction [1]."""
    rolling: float
    """Coefficient of rolling friction [1]."""
    reduced_mass: float
    """[kg]."""


@dataclass(frozen=True, slots=True)
class Scene:
    """One state of one charge in the nutating chamber: equal spheres, their laws, the motion of the walls,
    the substep.
    """

    name: str
    """For the table."""
    diameter: float
    """[m]."""
    density: float
    """[kg/m^3]."""
    pair: Law
    """Between spheres."""
    wall: Law
    """Between a sphere and the chamber."""
    bore: float
    """Radius of the chamber [m]."""
    floor: float
    """Floor, in chamber axes along z [m]."""
    ceiling: float
    """Ceiling, in chamber axes along z [m]."""
    tilt: float
    """Nutation angle alpha [rad]."""
    speed: float
    """Of the crank [rad/s]."""
    angle: float
    """Crank angle theta of the state [rad]."""
    gravity: float
    """[m/s^2]."""
    substep: float
    """[s]."""
    particles: np.ndarray
    """Position [m], velocity [m/s] and spin [rad/s] (n, 9), world axes."""

    @property
    def n(self) -> int:
        """Number of spheres [1]."""
        return len(self.particles)

    @property
    def mass(self) -> float:
        """Of one sphere [kg]."""
        return self.density * np.pi * self.diameter**3 / 6

    @property
    def revolution(self) -> float:
        """Substeps in one revolution of the crank [1]."""
        return 2 * np.pi / self.speed / self.substep

    def crank_angle(self, time: np.ndarray | float) -> np.ndarray:
        """Crank angle [rad] `time` after the state [s]."""
        return self.angle + self.speed * np.asarray(time)

    def attitude(self, theta: float) -> np.ndarray:
        """Rotation matrix (3, 3) from chamber to world axes at crank angle `theta` [rad]."""
        c, s = np.cos(theta), np.sin(theta)
        about_z = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        c, s = np.cos(self.tilt), np.sin(self.tilt)
        about_y = np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])
        return about_z @ about_y @ about_z.T

    def turning(self, theta: float) -> np.ndarray:
        """Angular velocity of the chamber [rad/s] (3,), world axes, at crank angle `theta` [rad]."""
        s, c = np.sin(self.tilt), np.cos(self.tilt)
        return self.speed * np.array([s * np.cos(theta), s * np.sin(theta), 1 - c])

    def to_chamber(self, particles: np.ndarray, theta: float) -> np.ndarray:
        """Positions, velocities and spins (n, 9) from world axes to those seen in the moving chamber."""
        rotation, turning = self.attitude(theta), self.turning(theta)
        x, v, w = particles[:, :3], particles[:, 3:6], particles[:, 6:]
        return np.hstack([x @ rotation, (v - np.cross(turning, x)) @ rotation, (w - turning) @ rotation])

    def to_world(self, particles: np.ndarray, theta: float) -> np.ndarray:
        """The inverse of `to_chamber`."""
        rotation, turning = self.attitude(theta), self.turning(theta)
        x = particles[:, :3] @ rotation.T
        v = particles[:, 3:6] @ rotation.T + np.cross(turning, x)
        return np.hstack([x, v, particles[:, 6:] @ rotation.T + turning])


@dataclass(frozen=True, slots=True)
class Record:
    """What an engine tells of its run; times count from the state of the scene."""

    time: np.ndarray
    """Of the samples of the wrench [s] (n,)."""
    wrench: np.ndarray
    """Force [N] and moment about O [N m] of the charge on the chamber (n, 6), world axes."""
    snapshot_time: np.ndarray
    """Of the snapshots [s] (k,)."""
    snapshots: np.ndarray
    """Particles (k, n, 9) as `Scene.particles`, in any order."""


QUANTITIES = {
    "force_r": ("radial force", "N"),
    "force_t": ("tangential force", "N"),
    "power": ("power from wall", "W"),
    "translation": ("kinetic energy, translation", "J"),
    "kinetic": ("kinetic energy, with rotation", "J"),
    "pairs": ("pair contacts per particle", "1"),
    "walls": ("wall contacts per particle", "1"),
}
"""What is compared: name for people and unit."""


def readings(scene: Scene, record: Record) -> dict[str, tuple[float, float]]:
    """Mean and scatter (standard deviation of the means of blocks of time) of each of `QUANTITIES`.

    Radial is towards the crank pin, tangential against its motion; power is what the wall gives the charge:
    less the moment about O times the chamber's angular velocity.
    """
    theta = scene.crank_angle(record.time)
    force, moment = record.wrench[:, :3], record.wrench[:, 3:]
    c, s = np.cos(theta), np.sin(theta)
    turning = np.array([scene.turning(angle) for angle in theta])
    series = {
        "force_r": force[:, 0] * c + force[:, 1] * s,
        "force_t": force[:, 0] * s - force[:, 1] * c,
        "power": -(moment * turning).sum(axis=1),
    }
    means = {name: over_blocks(scene, record.time, values) for name, values in series.items()}
    seen = np.array(
        [
            _of_snapshot(scene, p, scene.crank_angle(t))
            for p, t in zip(record.snapshots, record.snapshot_time, strict=True)
        ]
    )
    for column, name in enumerate(("translation", "kinetic", "pairs", "walls")):
        means[name] = over_blocks(scene, record.snapshot_time, seen[:, column])
    return means


def _of_snapshot(scene: Scene, particles: np.ndarray, theta: float) -> tuple[float, float, float, float]:
    """Kinetic energy of translation and with rotation [J], pair and wall contacts per particle [1]."""
    local = scene.to_chamber(particles, theta)[:, :3]
    radius = scene.diameter / 2
    translation = 0.5 * scene.mass * (particles[:, 3:6] ** 2).sum()
    rotation = 0.2 * scene.mass * radius**2 * (particles[:, 6:] ** 2).sum()
    pairs = cKDTree(local).count_neighbors(cKDTree(local), scene.diameter) - scene.n
    walls = (
        (np.hypot(local[:, 0], local[:, 1]) > scene.bore - radius).sum()
        + (local[:, 2] < scene.floor + radius).sum()
        + (local[:, 2] > scene.ceiling - radius).sum()
    )
    return translation, translation + rotation, pairs / 2 / scene.n, walls / scene.n


def over_blocks(scene: Scene, time: np.ndarray, values: np.ndarray) -> tuple[float, float]:
    """Mean, and standard deviation of the means of at least four blocks of time, `BLOCK` long where there is
    room.
    """
    span = time[-1] - time[0]
    blocks = max(4, round(span * scene.speed / (2 * np.pi) / BLOCK))
    edges = np.linspace(time[0], time[-1] * (1 + 1e-12), blocks + 1)
    number = np.clip(np.searchsorted(edges, time, side="right") - 1, 0, blocks - 1)
    means = [values[number == block].mean() for block in range(blocks) if (number == block).any()]
    return float(np.mean(values)), float(np.std(means, ddof=1)) if len(means) > 1 else float("nan")
