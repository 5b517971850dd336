"""Walls on different bodies that reach into each other: as assembled, on the way of a drive, or during a run.

Solid walls are boxes, rods, balls and closed meshes with the charge outside.  Two of them may not share a
place.  Discs, tubes, cones and caps have no thickness: a shaft may be built through one, but no drive may
move a part through one that it was not in as assembled.  Planes and cylinders are endless, and a machine may
well cross them.

Two boxes are compared exactly, other shapes by points on their surfaces.
"""

import functools
import itertools
import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from nutamill.base.errors import Fault, StepError
from nutamill.base.frames import rotation_matrix
from nutamill.base.units import in_unit, shown
from nutamill.case.machine import JointEntry, Machine
from nutamill.case.placement import axes_along
from nutamill.case.walls import WallEntry
from nutamill.simulation.setup.carriers import Carrier, carriers_of
from nutamill.simulation.setup.solid_shapes import (
    depth_inside,
    is_sheet,
    is_solid,
    pierces,
    surface_points,
)

TOUCH = 1e-9
"""Depth up to which two walls only touch, over the larger of their sizes [1]: round-off of positions."""

STEP = math.radians(1.0)
"""Angle between the positions of a driven body that are looked at [rad]."""

STEPS = 360
"""Positions of a body on a linear drive that are looked at [1]."""

Poses = dict[str, tuple[np.ndarray, np.ndarray]]
"""Mass centre [m] (3,) and rotation (3, 3) of bodies by name, world."""


class SolidWall(NamedTuple):
    """A wall that ends, in the axes of the body that carries it from the mass centre."""

    entry: WallEntry
    """The wall."""
    carrier: Carrier
    """The body."""
    origin: np.ndarray
    """Its own point [m] (3,)."""
    axes: np.ndarray
    """Its own axes as columns (3, 3)."""
    points: np.ndarray
    """Points of its surface in its own axes [m] (n, 3)."""

    @property
    def label(self) -> str:
        """Name of wall and body, for messages."""
        return f'wall "{self.entry.name}" of {self.carrier.name}'

    @property
    def size(self) -> float:
        """Largest distance of a point of it from its own point [m]."""
        return float(np.linalg.norm(self.points, axis=1).max())

    def placed(self, poses: Poses) -> tuple[np.ndarray, np.ndarray]:
        """Return its own point [m] and its axes, world."""
        position, rotation = poses[self.carrier.name]
        return position + rotation @ self.origin, rotation @ self.axes


def box_overlap(one: SolidWall, two: SolidWall, poses: Poses) -> float:
    """Return the depth [m] to which two boxes reach into each other, negative where they are apart: the
    smallest overlap of their shadows on the axes that can separate boxes.

    Source: S. Gottschalk, M. C. Lin and D. Manocha, "OBBTree", SIGGRAPH 1996.
    """
    (p, a), (q, b) = one.placed(poses), two.placed(poses)
    crossed = np.cross(a.T[:, None, :], b.T[None, :, :]).reshape(9, 3)
    lengths = np.linalg.norm(crossed, axis=1)
    crossed = crossed[lengths > 1e-9] / lengths[lengths > 1e-9, None]
    directions = np.concatenate([a.T, b.T, crossed])
    halves = [0.5 * np.array(wall.entry.size) for wall in (one, two)]
    reach = np.abs(directions @ a) @ halves[0] + np.abs(directions @ b) @ halves[1]
    return float((reach - np.abs(directions @ (q - p))).min())


def overlap(machine: Machine, one: SolidWall, two: SolidWall, poses: Poses) -> float:
    """Return the depth [m] to which two solid walls reach into each other, negative or minus infinity where
    they are apart: that of the deepest point of the surface of either in the other.
    """
    (p, a), (q, b) = one.placed(poses), two.placed(poses)
    if np.linalg.norm(q - p) > one.size + two.size:
        return -math.inf
    if one.entry.shape == two.entry.shape == "box":
        return box_overlap(one, two, poses)
    of_one, of_two = (p + one.points @ a.T - q) @ b, (q + two.points @ b.T - p) @ a
    return max(
        float(depth_inside(machine, wall.entry, points).max())
        for wall, points in ((two, of_one), (one, of_two))
    )


def _pierced(solid: SolidWall, sheet: SolidWall, poses: Poses) -> bool:
    """Return whether a solid reaches through a sheet."""
    (p, a), (q, b) = solid.placed(poses), sheet.placed(poses)
    points = (p + solid.points @ a.T - q) @ b
    return pierces(sheet.entry, points, TOUCH * (solid.size + sheet.size))


def _touching(one: SolidWall, two: SolidWall) -> float:
    """Return the depth up to which two walls only touch [m]."""
    return TOUCH * max(one.size, two.size)


@functools.lru_cache(maxsize=16)
def ending_walls(machine: Machine) -> tuple[SolidWall, ...]:
    """Return the walls that end, solid or not."""
    carriers, walls = {carrier.name: carrier for carrier in carriers_of(machine)}, []
    for entry in machine.walls:
        if is_solid(entry) or is_sheet(entry):
            carrier = carriers[entry.body]
            origin = carrier.rotation.T @ (np.array(entry.point) - carrier.position)
            axes = carrier.rotation.T @ axes_along(entry.axis, entry.across)
            walls.append(SolidWall(entry, carrier, origin, axes, surface_points(machine, entry)))
    return tuple(walls)


@functools.lru_cache(maxsize=16)
def solid_pairs(machine: Machine) -> tuple[tuple[SolidWall, SolidWall], ...]:
    """Return the pairs of solid walls on bodies that are not rigidly joined."""
    groups = _rigid_groups(machine)
    solid = [wall for wall in ending_walls(machine) if is_solid(wall.entry)]
    return tuple(
        (one, two)
        for one, two in itertools.combinations(solid, 2)
        if groups[one.carrier.name] != groups[two.carrier.name]
    )


def wall_faults(machine: Machine) -> list[Fault]:
    """Return the walls that reach into each other as assembled, or that a drive moves into each other before
    the end of the run.
    """
    poses = {carrier.name: (carrier.position, carrier.rotation) for carrier in carriers_of(machine)}
    faults, met = [], set()
    for one, two in solid_pairs(machine):
        depth = overlap(machine, one, two, poses)
        if depth > _touching(one, two):
            what = f"reaches {shown(depth, 'mm', '.3g')} into {one.label} as assembled"
            faults.append(Fault(f"walls.{two.entry.name}", what, "Move one of the two"))
            met.add(frozenset((one.entry.name, two.entry.name)))
    return faults + _swept(machine, poses, met)


def _swept(machine: Machine, poses: Poses, met: set[frozenset[str]]) -> list[Fault]:
    """Return the walls that a drive moves into each other, one fault for each pair that is not in `met`."""
    groups, walls = _rigid_groups(machine), ending_walls(machine)
    faults = []
    for name, joint, motions in _motions(machine):
        still, moving = (groups.get(body, body) for body in joint.between)
        pairs = [
            (one, two) if is_solid(one.entry) else (two, one)
            for one, two in itertools.combinations(walls, 2)
            if {groups[one.carrier.name], groups[two.carrier.name]} == {still, moving}
            and (is_solid(one.entry) or is_solid(two.entry))
        ]
        pairs = [
            (one, two)
            for one, two in pairs
            if is_solid(two.entry) or not (one.entry.shape == "mesh" or _pierced(one, two, poses))
        ]
        bodies = [body for body in poses if groups[body] == moving]
        for words, place, turn in motions if pairs else ():
            moved = dict(poses)
            for body in bodies:
                moved[body] = place + turn @ poses[body][0], turn @ poses[body][1]
            for one, two in pairs:
                key = frozenset((one.entry.name, two.entry.name))
                if key not in met and _meet(machine, one, two, moved):
                    met.add(key)
                    what = f'moves into {one.label} when drive "{name}" has {words}'
                    hint = "Move one of the two, or end the run earlier"
                    faults.append(Fault(f"walls.{two.entry.name}", what, hint))
    return faults


def _meet(machine: Machine, one: SolidWall, two: SolidWall, poses: Poses) -> bool:
    """Return whether a solid reaches into another wall, solid or not."""
    if is_solid(two.entry):
        return overlap(machine, one, two, poses) > _touching(one, two)
    return _pierced(one, two, poses)


def _motions(
    machine: Machine,
) -> Iterator[tuple[str, JointEntry, Iterator[tuple[str, np.ndarray, np.ndarray]]]]:
    """Yield each drive by name, its joint, and the motions of body b of the joint until the end of the run, a
    turn at most: in words, and as displacement [m] (3,) of the origin and rotation (3, 3), world.
    """
    joints = {joint.name: joint for joint in machine.joints}
    for drive in machine.drives:
        joint = joints[drive.joint]
        if joint.kind == "revolute":
            times, speeds = drive.breakpoints()
            yield drive.name, joint, _turns(joint, abs(_passed(times, speeds, machine.run.end)[-1]))
    for slide in machine.linear_drives:
        times, speeds = (np.array(column) for column in zip(*slide.speeds, strict=True))
        travel = _passed(times, speeds, machine.run.end)
        yield slide.name, joints[slide.joint], _slides(joints[slide.joint], travel)


def _turns(joint: JointEntry, angle: float) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """Yield the motions of a joint that turns through an angle [rad], or once round."""
    axis, point = np.asarray(joint.axis, float) / np.linalg.norm(joint.axis or (1.0,)), np.array(joint.point)
    for turned in np.arange(STEP, min(angle, math.tau) + STEP, STEP):
        turn = np.empty((3, 3))
        rotation_matrix(np.array([math.cos(turned / 2), *(math.sin(turned / 2) * axis)]), turn)
        yield f"turned {in_unit(turned, 'deg'):.0f} deg", point - turn @ point, turn


def _slides(joint: JointEntry, travel: np.ndarray) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """Yield the motions of a joint that slides through travels [m] (n,)."""
    axis = np.asarray(joint.axis, float) / np.linalg.norm(joint.axis or (1.0,))
    for way in np.linspace(travel.min(), travel.max(), STEPS):
        yield f"moved {shown(float(way), 'mm', '.3g')}", way * axis, np.eye(3)


def _passed(times: np.ndarray, speeds: np.ndarray, end: float) -> np.ndarray:
    """Return the angle [rad] or travel [m] of a drive at 0, at some times between, and at `end` [s]."""
    fine = np.unique(np.concatenate([np.linspace(0.0, end, STEPS), times[times < end]]))
    speed = np.interp(fine, times, speeds)
    return np.concatenate([[0.0], np.cumsum(0.5 * np.diff(fine) * (speed[1:] + speed[:-1]))])


def _rigid_groups(machine: Machine) -> dict[str, str]:
    """Return for each body one that it is rigidly joined to, the same for all of them."""
    groups = {carrier.name: carrier.name for carrier in carriers_of(machine)}
    groups |= {body.name: body.name for body in machine.bodies}
    for joint in (joint for joint in machine.joints if joint.kind == "fixed"):
        one, two = (groups.setdefault(body, body) for body in joint.between)
        groups = {body: one if group == two else group for body, group in groups.items()}
    return groups


def walls_met(
    machine: Machine, position: np.ndarray, quaternion: np.ndarray, time: float
) -> StepError | None:
    """Return the fault of a run whose bodies, at mass centres [m] (n, 3) with attitudes (n, 4), have solid
    walls that reach into each other at `time` [s], or None.
    """
    pairs = solid_pairs(machine)
    poses: Poses = {}
    for carrier in {wall.carrier.name: wall.carrier for pair in pairs for wall in pair}.values():
        rotation = np.empty((3, 3))
        rotation_matrix(quaternion[carrier.body], rotation)
        poses[carrier.name] = (position[carrier.body], rotation)
    for one, two in pairs:
        if (depth := overlap(machine, one, two, poses)) > _touching(one, two):
            return StepError(
                f"{one.label} and {two.label} reach {shown(depth, 'mm', '.3g')} into each other at "
                f"t = {time:.6g} s. Walls do not stop each other: give the bodies a stop, or move the walls."
            )
    return None
