"""What a case looks like: the solids of its machine, and the cameras that show them."""

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from nutamill.analysis.replay import rotation_of
from nutamill.base.errors import CaseError, Fault
from nutamill.case import Case, Machine
from nutamill.case.placement import quaternion_of, shape_corners
from nutamill.result import WallMesh
from nutamill.view.cameras import VIEWS, Camera, View, camera_of
from nutamill.view.drawing import Part, machine_parts
from nutamill.view.machine_drawing import drawn_corners, machine_solids

LENS = math.radians(30.0)
"""Angle of view of the cameras of a machine given part by part [rad]."""


class Appearance(NamedTuple):
    """A machine in front of its cameras."""

    parts: tuple[Part, ...]
    """Its solids."""
    cameras: dict[View, Camera]
    """Its cameras by name."""
    floor: float
    """Height from which those of the charge count [m], in axes of `nutamill.analysis.replay.Frame.home`."""
    reach: float
    """Size of the machine [m]."""


def drawn(
    case: Case | Machine, opening: float = 0.0, walls: Mapping[str, WallMesh] | None = None
) -> Appearance:
    """Return the machine of a case, as drawn or part by part.

    Parameters
    ----------
    opening : the vessel is cut open over this azimuth [rad]
    walls : meshed walls, as a result keeps them
    """
    mill = case.drawing
    if mill is None:
        return _part_by_part(case.machine, opening, walls)
    return Appearance(
        machine_parts(mill, opening, walls=walls),
        {view: camera_of(view, mill) for view in VIEWS},
        -mill.chamber.floor_depth,
        mill.mounts.depth + mill.chamber.inner_diameter,
    )


def camera_called(machine: Appearance, view: str) -> Camera:
    """Return the camera of a machine by its name. Raises CaseError where it has none of this name."""
    if view not in machine.cameras:
        known = ", ".join(machine.cameras)
        raise CaseError(
            Fault("--camera", f'a machine without a chamber has no camera "{view}"', f"Known: {known}")
        )
    return machine.cameras[view]


def _part_by_part(machine: Machine, opening: float, walls: Mapping[str, WallMesh] | None) -> Appearance:
    """Return a machine given part by part, with cameras from the front and from above."""
    corners = drawn_corners(machine)
    low, high = corners.min(axis=0), corners.max(axis=0)
    middle, size = 0.5 * (low + high), float(np.linalg.norm(high - low))
    away = 0.62 * size / math.tan(0.5 * LENS)
    front, above = np.array([0.35, -1.0, 0.4]), np.array([0.0, 0.0, 1.0])
    eye = middle + away * front / np.linalg.norm(front)
    upright, across = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])
    cameras: dict[View, Camera] = {
        "front": Camera(eye, middle, upright, LENS, (), rides=False),
        "axis": Camera(middle + away * above, middle, across, LENS, (), rides=False),
    }
    return Appearance(machine_solids(machine, opening, walls), cameras, _floor(machine, corners), size)


def _floor(machine: Machine, corners: np.ndarray) -> float:
    """Return the height from which those of the charge count [m]: of the lowest corner of the regions, or of
    `corners` [m] (n, 3), world, in axes of the body in whose axes the charge is shown.
    """
    home = next((body for body in machine.bodies if body.name == machine.fields.body), None)
    if home is None:
        return float(corners[:, 2].min())
    regions = [shape_corners(region) for region in machine.regions if region.body == home.name]
    inside = np.concatenate([known for known in regions if known is not None] or [corners])
    own = (inside - np.array(home.position)) @ rotation_of(quaternion_of(home.turn))
    return float(own[:, 2].min())
