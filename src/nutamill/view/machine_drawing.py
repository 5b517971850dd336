"""A machine given part by part as triangles, for pictures: its walls, and rods from each body to its joints.

Walls are drawn as far as the regions of the charge reach.  Nothing is computed from these shapes.
"""

import math
from collections.abc import Mapping

import numpy as np

from nutamill.analysis.replay import rotation_of
from nutamill.case.drawing import GROUND
from nutamill.case.machine import Machine
from nutamill.case.placement import axes_along, quaternion_of, shape_corners
from nutamill.case.walls import WallEntry
from nutamill.result import WallMesh
from nutamill.view.drawing import DARK, GLASS, STEEL, Part, Solid, box, joined, revolved, ring

THICKNESS = 0.02
"""Thickness of a wall, and radius of the rod of a joint, over the size of the machine [1]."""

UPRIGHT = 0.7
"""Cosine of the tilt up to which a plane or a disc is a floor [1]; others are drawn as glass."""

ARCS = 12
"""Pieces of the meridian of a cap [1]."""


def machine_solids(
    machine: Machine, opening: float = 0.0, walls: Mapping[str, WallMesh] | None = None
) -> tuple[Part, ...]:
    """Return the parts of a machine, each in the axes of its body from the mass centre.

    Parameters
    ----------
    opening : cylinders, cones and caps are cut open over this azimuth [rad]
    walls : meshed walls, as a result keeps them
    """
    poses = {GROUND: (np.zeros(3), np.eye(3))}
    for body in machine.bodies:
        poses[body.name] = (np.array(body.position), rotation_of(quaternion_of(body.turn)))
    meshes, parts = dict(walls or {}), []
    corners = drawn_corners(machine)
    size = float(np.linalg.norm(np.ptp(corners, axis=0)))
    for number, wall in enumerate(machine.walls):
        origin, rotation = poses[wall.body]
        upright = wall.axis[2] > UPRIGHT * math.hypot(*wall.axis)
        cover = wall.shape in ("plane", "disc") and not upright  # of a floor one sees the charge on it
        glass = cover or wall.charge_side == "inside" or wall.shape in ("cylinder", "cone", "cap")
        look = (GLASS, 0.3) if glass else (STEEL, 1.0)
        if wall.shape == "mesh":
            mesh = meshes.get(f"walls[{number}]")
            if mesh is not None:
                parts.append(Part(wall.name, wall.body, mesh.vertices, mesh.triangles, *look))
            continue
        solid = _solid(wall, corners, THICKNESS * size, opening)
        axes = axes_along(wall.axis, wall.across)
        world = np.array(wall.point) + solid.vertices @ axes.T
        parts.append(Part(wall.name, wall.body, (world - origin) @ rotation, solid.triangles, *look))
    names = {"charge", *(wall.name for wall in machine.walls)}
    for body in machine.bodies:
        rods = _rods(machine, body.name, 0.5 * THICKNESS * size)
        walled = any(wall.body == body.name for wall in machine.walls)
        if len(rods) > 1 or not walled:  # a hub alone would float between its walls
            origin, rotation = poses[body.name]
            solid = joined(*rods)
            name = f"{body.name}_body" if body.name in names else body.name
            parts.append(Part(name, body.name, (solid.vertices - origin) @ rotation, solid.triangles, DARK))
    return tuple(parts)


def drawn_corners(machine: Machine) -> np.ndarray:
    """Return points [m] (n, 3), world as assembled, that a picture of the machine must hold."""
    shapes = [shape_corners(region) for region in machine.regions]
    points = [corners for corners in shapes if corners is not None]
    points.append(np.array([body.position for body in machine.bodies]))
    points += [np.array([joint.point]) for joint in machine.joints]
    corners = np.concatenate(points)
    if float(np.ptp(corners, axis=0).max()) <= 0.0:
        corners = np.concatenate([corners - 0.1, corners + 0.1])
    return corners


def _solid(wall: WallEntry, corners: np.ndarray, thick: float, opening: float) -> Solid:
    """Return a wall in its own axes, as far as `corners` [m] (n, 3), world, reach."""
    seen = (corners - wall.point) @ axes_along(wall.axis, wall.across)
    reach = float(np.hypot(seen[:, 0], seen[:, 1]).max())
    low, high = float(seen[:, 2].min()), float(seen[:, 2].max())
    if wall.shape == "plane":
        return ring(0.0, min(reach, 1.5 * _width(corners)), -thick, 0.0)
    if wall.size is not None:
        return box(*wall.size)
    radius = float(wall.radius or 0.0)
    if wall.shape == "disc":
        return ring(0.0, radius, -thick, 0.0)
    if wall.shape == "rod":
        return ring(0.0, radius, 0.0, float(wall.height or 0.0))
    if wall.shape == "tube":
        return ring(radius, radius + thick, 0.0, float(wall.height or 0.0), opening, -0.5 * math.pi)
    if wall.shape == "cylinder":
        return ring(radius, radius + thick, low, high, opening, -0.5 * math.pi)
    if wall.shape == "cone":
        end, height = float(wall.end_radius or 0.0), float(wall.height or 0.0)
        meridian = [(radius, 0.0), (radius + thick, 0.0), (end + thick, height), (end, height)]
        return revolved(meridian, opening, -0.5 * math.pi)
    if wall.shape == "ball":
        rise = np.linspace(0.0, math.pi, ARCS + 1)
        return revolved([(radius * math.sin(a), -radius * math.cos(a)) for a in rise])
    angle = np.linspace(0.0, float(wall.angle or math.pi), ARCS + 1)
    inner = [(radius * math.sin(a), -radius * math.cos(a)) for a in angle]
    outer = [((radius + thick) * math.sin(a), -(radius + thick) * math.cos(a)) for a in angle]
    return revolved([*outer, *reversed(inner)], opening, -0.5 * math.pi)


def _width(corners: np.ndarray) -> float:
    """Return the largest extent of points [m]."""
    return float(np.ptp(corners, axis=0).max())


def _rods(machine: Machine, body: str, radius: float) -> list[Solid]:
    """Return rods of a `radius` [m] from the mass centre of a body to its joints and springs, world."""
    centre = next(np.array(one.position) for one in machine.bodies if one.name == body)
    points = [joint.point for joint in machine.joints if body in joint.between]
    points += [bushing.point for bushing in machine.bushings if body in bushing.between]
    rods = [ring(0.0, 2.0 * radius, -2.0 * radius, 2.0 * radius).at(*centre)]
    for point in points:
        along = np.array(point) - centre
        length = float(np.linalg.norm(along))
        if length > radius:
            solid = ring(0.0, radius, 0.0, length)
            rods.append(Solid(centre + solid.vertices @ axes_along(along).T, solid.triangles))
    return rods
