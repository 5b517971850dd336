"""The motion in a result: the pose of every body and the position of every particle, by snapshot.

All bodies of a mill as drawn but the intermediate shaft are held at the nutation point or turn about an axis
through it, so that this point and their attitudes place them (docs/conventions.md, frames).  The bodies of a
machine given part by part are placed by their mass centres.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from nutamill.analysis.source import any_case_of
from nutamill.base.errors import ResultError
from nutamill.case.drawing import BODIES, CHAMBER, CROSS, GROUND, SHAFT
from nutamill.result import Result, Snapshots


class Pose(NamedTuple):
    """Where a body is."""

    origin: np.ndarray
    """The point its parts are drawn from [m] (3,), world: of a mill the nutation point, of ground and
    intermediate shaft where it was assembled; of a machine given part by part the mass centre.
    """
    rotation: np.ndarray
    """``R_WB`` (3, 3)."""


class Frame(NamedTuple):
    """One moment of a run."""

    time: float
    """Simulated time [s]."""
    bodies: dict[str, Pose]
    """Pose of every body and of the ground."""
    positions: np.ndarray
    """Centres of the particles by id [m] (n, 3), world; none where the chamber is empty."""
    velocities: np.ndarray
    """Their velocities [m/s] (n, 3), world axes."""
    radii: np.ndarray
    """Their radii [m] (n,), of a clump that of the sphere of its volume."""
    home: str
    """The body in whose axes the charge is shown: that of its fields, of a mill the chamber; the ground where
    the file names none.
    """

    def at_home(self) -> np.ndarray:
        """Return the positions in axes of the body `home`, from the point its parts are drawn from [m]
        (n, 3).
        """
        pose = self.bodies[self.home]
        return (self.positions - pose.origin) @ pose.rotation


def rotation_of(quaternion: np.ndarray) -> np.ndarray:
    """Return the rotation matrices ``R_WB`` (..., 3, 3) of unit quaternions (w, x, y, z), (..., 4)."""
    return Rotation.from_quat(np.roll(quaternion, -1, axis=-1)).as_matrix()  # SciPy has the scalar last


def between(first: Frame, second: Frame, share: float) -> Frame:
    """Return a moment between two frames: bodies turn about a fixed axis, particles move straight in axes of
    the body `home`.

    Parameters
    ----------
    first, second : frames of the same run
    share : how far from the first to the second [1]
    """
    if share == 0.0:
        return first
    bodies = {name: _pose_between(pose, second.bodies[name], share) for name, pose in first.bodies.items()}
    home = bodies[first.home]
    own = (1.0 - share) * first.at_home() + share * second.at_home()
    return first._replace(
        time=(1.0 - share) * first.time + share * second.time,
        bodies=bodies,
        positions=home.origin + own @ home.rotation.T,
        velocities=(1.0 - share) * first.velocities + share * second.velocities,
    )


def _pose_between(first: Pose, second: Pose, share: float) -> Pose:
    turn = Rotation.from_matrix(first.rotation.T @ second.rotation).as_rotvec()
    rotation = first.rotation @ Rotation.from_rotvec(share * turn).as_matrix()
    return Pose((1.0 - share) * first.origin + share * second.origin, rotation)


def particle_snapshots(result: Result) -> tuple[Snapshots, np.ndarray]:
    """Return the snapshots of particles, and the crank angles at them [rad], (n_snapshots,).

    Raises
    ------
    ResultError : no snapshots of particles
    """
    snapshots = result.snapshots
    if not len(snapshots) or "chamber_floor" not in snapshots[0]:
        raise ResultError(f"{result.path}: holds no snapshots of particles. Run it with run.snapshots.")
    return snapshots, np.interp(
        snapshots.time, result.series["time"].values, result.series["crank_angle"].values
    )


def chosen_snapshots(result: Result, most: int | None = None) -> list[int]:
    """Choose the numbers of the snapshots to show: all, or evenly spaced ones, at most `most`.

    Raises
    ------
    ResultError : no snapshots, or those of a version that did not keep the size of the particles
    """
    count = len(result.snapshots)
    if not count:
        raise ResultError(
            f"{result.path}: holds no snapshots, which a motion is shown from. "
            'Run the case with run.snapshots = { rate = "200 Hz", last = "0.5 s" } and to its end.'
        )
    first = result.snapshots[0]
    if missing := {"body_positions", "body_attitudes"} - set(first):
        raise ResultError(
            f"{result.path}: its snapshots hold no {', '.join(sorted(missing))}. Run the case again."
        )
    if "positions" in first and "radii" not in first:
        raise ResultError(
            f"{result.path}: its snapshots must keep the radii of the particles, an older version "
            "left them out. Run it again."
        )
    step = 1 if most is None else -(-count // most)
    return list(range(count - 1, -1, -step))[::-1]


def replay(result: Result, numbers: list[int]) -> Iterator[Frame]:
    """Yield the moments of these snapshots, read one by one. The bearing cross has its mass centre at the
    nutation point.
    """
    still, empty, case = np.zeros(3), np.empty((0, 3)), any_case_of(result)
    for number in numbers:
        snapshot = result.snapshots[number]
        rotations = rotation_of(np.asarray(snapshot["body_attitudes"], float))
        places = np.asarray(snapshot["body_positions"], float)
        if case.drawing is None:
            names, home = [body.name for body in case.machine.bodies], case.machine.fields.body or GROUND
            names += [motor.name for motor in case.machine.unbalance_motors]
            origins = list(places)
        else:
            names, home = list(BODIES), CHAMBER
            origins = [still if name == SHAFT else places[BODIES.index(CROSS)] for name in BODIES]
        bodies = {name: Pose(*pose) for name, *pose in zip(names, origins, rotations, strict=True)}
        bodies[GROUND] = Pose(still, np.eye(3))
        positions, velocities = (
            np.asarray(snapshot.get(name, empty), float) for name in ("positions", "velocities")
        )
        yield Frame(
            float(snapshot["time"]),
            bodies,
            positions,
            velocities,
            np.asarray(snapshot.get("radii", np.empty(0)), float),
            home,
        )
