"""Boxes on different bodies that reach into each other: as assembled, on the way of a drive, or during a run.

Only boxes with the charge outside count: they are the solid walls whose two sides are known.  A plane or a
cylinder is endless, and a machine may well cross it.
"""

import functools
import itertools
import math
from typing import NamedTuple

import numpy as np

from nutamill.base.errors import Fault, StepError
from nutamill.base.frames import rotation_matrix
from nutamill.base.units import in_unit, shown
from nutamill.case.machine import DriveEntry, Machine
from nutamill.case.placement import axes_along
from nutamill.simulation.setup.carriers import Carrier, carriers_of

TOUCH = 1e-9
"""Depth up to which two boxes only touch [m]."""

STEP = math.radians(1.0)
"""Angle between the positions of a driven body that are looked at [rad]."""


class SolidBox(NamedTuple):
    """A box that a body carries, with the charge outside."""

    name: str
    """Name of the wall."""
    carrier: Carrier
    """The body."""
    centre: np.ndarray
    """Its middle [m] (3,), in the axes of the body from its mass centre."""
    axes: np.ndarray
    """Its axes as columns (3, 3), in those of the body."""
    half: np.ndarray
    """Half its lengths [m] (3,)."""

    @property
    def label(self) -> str:
        """Name of wall and body, for messages."""
        return f'wall "{self.name}" of {self.carrier.name}'


def penetration(first: SolidBox, second: SolidBox, poses: dict[str, tuple[np.ndarray, np.ndarray]]) -> float:
    """Return the depth [m] to which two boxes reach into each other, negative where they are apart: the
    smallest overlap of their shadows on the axes that can separate boxes.

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
def box_pairs(machine: Machine) -> tuple[tuple[SolidBox, SolidBox], ...]:
    """Return the pairs of boxes on different bodies that no fixed joint connects."""
    carriers, boxes = {carrier.name: carrier for carrier in carriers_of(machine)}, []
    for wall in machine.walls:
        if wall.shape == "box" and wall.charge_side == "outside":
            carrier, half = carriers[wall.body], 0.5 * np.array(wall.size)
            centre = carrier.rotation.T @ (np.array(wall.point) - carrier.position)
            axes = carrier.rotation.T @ axes_along(wall.axis, wall.across)
            boxes.append(SolidBox(wall.name, carrier, centre, axes, half))
    fixed = {frozenset(joint.between) for joint in machine.joints if joint.kind == "fixed"}
    return tuple(
        (one, two)
        for one, two in itertools.combinations(boxes, 2)
        if one.carrier.name != two.carrier.name
        and frozenset((one.carrier.name, two.carrier.name)) not in fixed
    )


def box_faults(machine: Machine) -> list[Fault]:
    """Return the boxes that reach into each other as assembled, or that a drive turns into each other before
    the end of the run.
    """
    poses = {carrier.name: (carrier.position, carrier.rotation) for carrier in carriers_of(machine)}
    faults = []
    for one, two in box_pairs(machine):
        depth = penetration(one, two, poses)
        if depth > TOUCH:
            what = f"reaches {shown(depth, 'mm', '.3g')} into {one.label} as assembled"
            faults.append(Fault(f"walls.{two.name}", what, "Move one of the two"))
        elif sweep := _sweep(machine, one, two, poses):
            drive, angle = sweep
            what = (
                f'moves into {one.label} when drive "{drive.name}" has turned {in_unit(angle, "deg"):.0f} deg'
            )
            faults.append(Fault(f"walls.{two.name}", what, "Move one of the two, or end the run earlier"))
    return faults


def _sweep(machine, one, two, poses) -> tuple[DriveEntry, float] | None:
    """Return the drive between the bodies of two boxes that turns them into each other, and its angle [rad]
    then, or None if there is none.
    """
    for drive in machine.drives:
        joint = next(joint for joint in machine.joints if joint.name == drive.joint)
        if joint.kind != "revolute" or set(joint.between) != {one.carrier.name, two.carrier.name}:
            continue
        position, rotation = poses[joint.between[1]]
        axis, point = np.asarray(joint.axis, float) / np.linalg.norm(joint.axis), np.array(joint.point)
        turned = np.empty((3, 3))
        for angle in np.arange(STEP, min(_angle_turned(drive, machine.run.end), math.tau) + STEP, STEP):
            rotation_matrix(np.array([math.cos(angle / 2), *(math.sin(angle / 2) * axis)]), turned)
            moved = {joint.between[1]: (point + turned @ (position - point), turned @ rotation)}
            if penetration(one, two, poses | moved) > TOUCH:
                return drive, float(angle)
    return None


def _angle_turned(drive: DriveEntry, end: float) -> float:
    """Return the angle [rad] through which a drive turns its joint until `end` [s]."""
    times, speeds = drive.breakpoints()
    within = np.append(times[times < end], end)
    return float(np.trapezoid(np.interp(within, times, speeds), within))


def boxes_met(
    machine: Machine, position: np.ndarray, quaternion: np.ndarray, time: float
) -> StepError | None:
    """Return the fault of a run whose bodies, at mass centres [m] (n, 3) with attitudes (n, 4), have boxes
    that reach into each other at `time` [s], or None if there is none.
    """
    pairs = box_pairs(machine)
    if not pairs:
        return None
    poses = {}
    for carrier in {box.carrier.name: box.carrier for pair in pairs for box in pair}.values():
        rotation = np.empty((3, 3))
        rotation_matrix(quaternion[carrier.body], rotation)
        poses[carrier.name] = (position[carrier.body], rotation)
    for one, two in pairs:
        if (depth := penetration(one, two, poses)) > TOUCH:
            return StepError(
                f"{one.label} and {two.label} reach {shown(depth, 'mm', '.3g')} into each other at "
                f"t = {time:.6g} s. Walls do not stop each other: give the bodies a stop, or move the walls."
            )
    return None
