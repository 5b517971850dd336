"""Solid walls on different bodies that reach into each other: as assembled, on the way of a drive, or during
a run.

Boxes, rods, balls and meshes with the charge outside count: they are the walls whose two sides are known.  A
plane or a cylinder is endless, and a machine may well cross it.
"""

import functools
import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from nutamill.base.errors import Fault, StepError
from nutamill.base.frames import rotation_matrix, rotation_matrix_of
from nutamill.base.required import required
from nutamill.base.units import in_unit, shown
from nutamill.case.loads import LinearDriveEntry
from nutamill.case.machine import DriveEntry, JointEntry, Machine
from nutamill.case.placement import axes_along
from nutamill.case.walls import WallEntry
from nutamill.simulation.setup.carriers import Carrier, carriers_of
from nutamill.simulation.setup.solid_triangles import (
    ball_triangles,
    box_triangles,
    rod_triangles,
    solids_meet,
)
from nutamill.simulation.setup.walls import wall_mesh

AnyDrive = DriveEntry | LinearDriveEntry

Poses = dict[str, tuple[np.ndarray, np.ndarray]]
"""Mass centre [m] (3,) and rotation (3, 3) of each body by name, world."""

TOUCH = 1e-9
"""Depth up to which two walls only touch [m]."""

STEP = math.radians(1.0)
"""Largest angle between the positions of a driven body that are looked at [rad]."""

MOST = 7200
"""Positions on the way of a drive that are looked at, at most [1]."""

SOLID = ("box", "rod", "ball", "mesh")
"""Shapes of solid walls."""


@dataclass(frozen=True, slots=True, eq=False)
class SolidWall:
    """A solid wall that a body carries, with the charge outside."""

    name: str
    """Name of the wall."""
    carrier: Carrier
    """The body."""
    centre: np.ndarray
    """The middle of the box around it [m] (3,), in the axes of the body from its mass centre."""
    axes: np.ndarray
    """The axes of this box as columns (3, 3), in those of the body."""
    half: np.ndarray
    """Half the lengths of this box [m] (3,)."""
    triangles: np.ndarray | None
    """Its triangles [m] (n, 3, 3), in axes of this box from its middle; None for a box, which is exact."""

    @property
    def label(self) -> str:
        """Name of wall and body, for messages."""
        return f'wall "{self.name}" of {self.carrier.name}'

    def placed(self, poses: Poses) -> np.ndarray:
        """Return its triangles [m] (n, 3, 3), world."""
        own = box_triangles(self.half) if self.triangles is None else self.triangles
        position, rotation = poses[self.carrier.name]
        return position + (self.centre + own @ self.axes.T) @ rotation.T


def meeting(first: SolidWall, second: SolidWall, poses: Poses) -> str:
    """Return how far two solid walls reach into each other, as text.

    The text is empty where they do not.  The depth is known of boxes alone.
    """
    depth = penetration(first, second, poses)
    if depth <= TOUCH:
        return ""
    if first.triangles is None and second.triangles is None:
        return f" {shown(depth, 'mm', '.3g')}"
    return " some way" if solids_meet(first.placed(poses), second.placed(poses)) else ""


def penetration(first: SolidWall, second: SolidWall, poses: Poses) -> float:
    """Return the depth [m] to which the boxes around two solid walls reach into each other, negative where
    they are apart: the smallest overlap of their shadows on the axes that can separate boxes.

    `poses` are mass centre [m] (3,) and rotation (3, 3) of each body by name, world.  Source: S. Gottschalk,
    M. C. Lin and D. Manocha, "OBBTree", SIGGRAPH 1996.
    """
    (p, R), (q, S) = poses[first.carrier.name], poses[second.carrier.name]
    apart = q + S @ second.centre - p - R @ first.centre
    a, b = R @ first.axes, S @ second.axes
    crossed = np.cross(a.T[:, None, :], b.T[None, :, :]).reshape(9, 3)
    lengths = np.linalg.norm(crossed, axis=1)
    crossed = crossed[lengths > 1e-9] / lengths[lengths > 1e-9, None]
    directions = np.concatenate([a.T, b.T, crossed])
    reach = np.abs(directions @ a) @ first.half + np.abs(directions @ b) @ second.half
    return float((reach - np.abs(directions @ apart)).min())


@functools.lru_cache(maxsize=16)
def solid_pairs(machine: Machine) -> tuple[tuple[SolidWall, SolidWall], ...]:
    """Return the pairs of solid walls on different bodies that no fixed joint connects. Raises as
    `nutamill.simulation.setup.walls.wall_mesh` does.
    """
    carriers = {carrier.name: carrier for carrier in carriers_of(machine)}
    solids = [
        _solid(machine, wall, carriers[wall.body])
        for wall in machine.walls
        if wall.shape in SOLID and wall.charge_side == "outside"
    ]
    fixed = {frozenset(joint.between) for joint in machine.joints if joint.kind == "fixed"}
    return tuple(
        (one, two)
        for one, two in itertools.combinations(solids, 2)
        if one.carrier.name != two.carrier.name
        and frozenset((one.carrier.name, two.carrier.name)) not in fixed
    )


def _solid(machine: Machine, wall: WallEntry, carrier: Carrier) -> SolidWall:
    """Return a wall of a machine as a solid in the axes of its body."""
    axes, middle, triangles = axes_along(wall.axis, wall.across), np.zeros(3), None
    if wall.shape == "box":
        half = 0.5 * np.array(wall.size)
    elif wall.shape == "rod":
        radius, half_height = required(wall.radius), 0.5 * required(wall.height)
        half, middle = np.array([radius, radius, half_height]), np.array([0.0, 0.0, half_height])
        triangles = rod_triangles(radius, half_height)
    elif wall.shape == "ball":
        half, triangles = np.full(3, required(wall.radius)), ball_triangles(required(wall.radius))
    else:
        mesh = wall_mesh(machine, wall)
        low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
        half, middle = 0.5 * (high - low), 0.5 * (low + high)
        triangles = mesh.vertices[mesh.faces] - middle
    centre = carrier.rotation.T @ (np.array(wall.point) + axes @ middle - carrier.position)
    return SolidWall(wall.name, carrier, centre, carrier.rotation.T @ axes, half, triangles)


def solid_faults(machine: Machine) -> list[Fault]:
    """Return the solid walls that reach into each other as assembled, or that a drive moves into each other
    before the end of the run.
    """
    poses = {carrier.name: (carrier.position, carrier.rotation) for carrier in carriers_of(machine)}
    faults = []
    for one, two in solid_pairs(machine):
        if depth := meeting(one, two, poses):
            what = f"reaches{depth} into {one.label} as assembled"
            faults.append(Fault(f"walls.{two.name}", what, "Move one of the two"))
        elif way := _way(machine, one, two, poses):
            what = f"moves into {one.label} when {way}"
            faults.append(Fault(f"walls.{two.name}", what, "Move one of the two, or end the run earlier"))
    return faults


def _way(machine: Machine, one: SolidWall, two: SolidWall, poses: Poses) -> str:
    """Return which drive between the bodies of two solid walls moves them into each other, and how far it has
    moved then, as text.

    The text is empty where none does.
    """
    between = {one.carrier.name, two.carrier.name}
    for drive, joint in _drives_between(machine, between):
        position, rotation = poses[joint.between[1]]
        axis, point = np.asarray(required(joint.axis), float), np.array(joint.point)
        axis = axis / np.linalg.norm(axis)
        turned = np.empty((3, 3))
        for moved in _positions(drive, machine.run.end, *_sizes(one, two, poses, point, axis)):
            if joint.kind == "prismatic":
                pose = position + moved * axis, rotation
            else:
                rotation_matrix(np.array([math.cos(moved / 2), *(math.sin(moved / 2) * axis)]), turned)
                pose = point + turned @ (position - point), turned @ rotation
            if meeting(one, two, poses | {joint.between[1]: pose}):
                if joint.kind == "prismatic":
                    return f'linear drive "{drive.name}" has travelled {shown(moved, "mm", ".3g")}'
                return f'drive "{drive.name}" has turned {in_unit(moved, "deg"):.0f} deg'
    return ""


def indirect_pairs(machine: Machine) -> list[tuple[SolidWall, SolidWall]]:
    """Return the pairs of solid walls that are apart as assembled and between whose bodies no drive acts."""
    poses = {carrier.name: (carrier.position, carrier.rotation) for carrier in carriers_of(machine)}
    return [
        (one, two)
        for one, two in solid_pairs(machine)
        if not meeting(one, two, poses)
        and not any(_drives_between(machine, {one.carrier.name, two.carrier.name}))
    ]


def _drives_between(machine: Machine, bodies: set[str]) -> Iterator[tuple[AnyDrive, JointEntry]]:
    """Yield the drives of joints between two bodies, with their joints."""
    joints = {joint.name: joint for joint in machine.joints if set(joint.between) == bodies}
    drives: list[AnyDrive] = [*machine.drives, *machine.linear_drives]
    for drive in drives:
        if drive.joint in joints:
            yield drive, joints[drive.joint]


def _sizes(one: SolidWall, two: SolidWall, poses: Poses, point: np.ndarray, axis: np.ndarray):
    """Return half the thickness of the thinner of two solid walls, and the largest distance of their corners
    from an axis [m].
    """
    corners = np.concatenate([wall.placed(poses) for wall in (one, two)]).reshape(-1, 3) - point
    thin = min(one.half.min(), two.half.min())
    return float(thin), float(np.linalg.norm(np.cross(corners, axis), axis=1).max())


def _positions(drive: AnyDrive, end: float, thin: float, reach: float) -> np.ndarray:
    """Return angles [rad] or travels [m] on the way of a drive until `end` [s], from the first on: within one
    turn, and so near to each other that no wall at a distance `reach` [m] passes another of half a thickness
    `thin` [m] between two of them.
    """
    if isinstance(drive, LinearDriveEntry):
        times, speeds = (np.array(column) for column in zip(*drive.speeds, strict=True))
        at = np.linspace(0.0, end, MOST + 1)
        speed = np.interp(at, times, speeds)
        travel = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(at))])
        path = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(travel)))])
        count = max(1, min(MOST, math.ceil(path[-1] / thin)))
        return np.interp(np.linspace(0.0, path[-1], count + 1)[1:], path, travel)
    step = STEP / max(1, min(math.ceil(STEP * reach / thin), math.floor(MOST * STEP / math.tau)))
    return np.arange(step, min(_angle_turned(drive, end), math.tau) + step, step)


def _angle_turned(drive: DriveEntry, end: float) -> float:
    """Return the angle [rad] through which a drive turns its joint until `end` [s]."""
    times, speeds = drive.breakpoints()
    within = np.append(times[times < end], end)
    return float(np.trapezoid(np.interp(within, times, speeds), within))


def solids_met(
    machine: Machine, position: np.ndarray, quaternion: np.ndarray, time: float
) -> StepError | None:
    """Return the fault of a run whose bodies, at mass centres [m] (n, 3) with attitudes (n, 4), have solid
    walls that reach into each other at `time` [s], or None if there is none.
    """
    pairs = solid_pairs(machine)
    if not pairs:
        return None
    poses = {}
    for carrier in {wall.carrier.name: wall.carrier for pair in pairs for wall in pair}.values():
        poses[carrier.name] = (position[carrier.body], rotation_matrix_of(quaternion[carrier.body]))
    for one, two in pairs:
        if depth := meeting(one, two, poses):
            return StepError(
                f"{one.label} and {two.label} reach{depth} into each other at "
                f"t = {time:.6g} s. Walls do not stop each other: give the bodies a stop, or move the walls."
            )
    return None
