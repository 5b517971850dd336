"""Walls that are solid bodies, or end: points on their surface, and how deep a point is inside of them.

Points are in the axes of the wall from its own point: the centre of box and ball, the lower end of a tube.
"""

import math

import numpy as np

from nutamill.base.required import required
from nutamill.case.machine import Machine
from nutamill.case.walls import WallEntry
from nutamill.charge.walls.mesh import on_charge_side
from nutamill.simulation.setup.walls import wall_mesh

AROUND = 48
"""Points around a circle [1]: they leave out 0.2 % of its radius."""
ACROSS = 12
"""Points along a length, at least [1]."""
MOST = 200
"""Points along a length, at most [1]."""
SOLID = ("box", "rod", "ball", "mesh")
"""Shapes with a volume, where the charge is outside."""
SHEETS = ("disc", "tube", "cone", "cap")
"""Shapes that end and have no thickness."""


def is_solid(wall: WallEntry) -> bool:
    """Return whether a wall has a volume that nothing else can be in."""
    return wall.shape in SOLID and wall.charge_side == "outside"


def is_sheet(wall: WallEntry) -> bool:
    """Return whether a wall ends and has no thickness, so that a part may be built through it."""
    return wall.shape in SHEETS


def surface_points(machine: Machine, wall: WallEntry) -> np.ndarray:
    """Return points of the surface of a wall that ends [m] (n, 3)."""
    if wall.shape == "mesh":
        mesh = wall_mesh(machine, wall)
        return np.concatenate([mesh.vertices, mesh.corners.mean(axis=1)])
    if wall.shape == "box":
        half = 0.5 * np.array(required(wall.size))
        shares = [_along(2.0 * size, half.min()) for size in half]
        grid = np.stack(np.meshgrid(*shares, indexing="ij"), axis=-1).reshape(-1, 3)
        return half * (2.0 * grid[(np.abs(grid - 0.5) == 0.5).any(axis=1)] - 1.0)
    radius = required(wall.radius)
    if wall.shape in ("ball", "cap"):
        end = math.pi if wall.shape == "ball" else required(wall.angle)
        rise = end * _along(end * radius, 0.5 * radius)
        return _revolved(radius * np.sin(rise), -radius * np.cos(rise))
    if wall.shape == "disc":
        return _revolved(radius * _along(radius, radius), np.zeros(ACROSS))
    height, end = required(wall.height), required(wall.end_radius) if wall.shape == "cone" else radius
    share = _along(height, min(radius, height))
    side = _revolved(radius + (end - radius) * share, height * share)
    if wall.shape != "rod":
        return side
    inwards = radius * _along(radius, radius)
    ends = [_revolved(inwards, np.full(len(inwards), at)) for at in (0.0, height)]
    return np.concatenate([side, *ends])


def depth_inside(machine: Machine, wall: WallEntry, points: np.ndarray) -> np.ndarray:
    """Return how deep points [m] (n, 3) are inside of a solid wall [m] (n,), negative outside. In a mesh it
    is the distance to the nearest of its `surface_points`.
    """
    if wall.shape == "box":
        return (0.5 * np.array(required(wall.size)) - np.abs(points)).min(axis=1)
    if wall.shape == "mesh":
        return _depth_in_mesh(machine, wall, points)
    radius = required(wall.radius)
    if wall.shape == "ball":
        return radius - np.linalg.norm(points, axis=1)
    height = required(wall.height)
    side = radius - np.hypot(points[:, 0], points[:, 1])
    return np.minimum(side, np.minimum(points[:, 2], height - points[:, 2]))


def pierces(wall: WallEntry, points: np.ndarray, touch: float) -> bool:
    """Return whether the points [m] (n, 3) of a convex solid are on both sides of a sheet, within its ends,
    by more than `touch` [m].
    """
    across, up, radius = np.hypot(points[:, 0], points[:, 1]), points[:, 2], required(wall.radius)
    if wall.shape == "disc":
        side, within = up, across <= radius
    elif wall.shape == "cap":
        distance = np.hypot(across, up)
        side, within = radius - distance, -up >= distance * math.cos(required(wall.angle))
    else:
        height = required(wall.height)
        end = required(wall.end_radius) if wall.shape == "cone" else radius
        side, within = radius + (end - radius) * up / height - across, (up >= 0.0) & (up <= height)
    return bool((side[within] > touch).any() and (side[within] < -touch).any())


def _along(length: float, finest: float) -> np.ndarray:
    """Return shares from 0 to 1 of a length [m], a quarter of `finest` [m] apart, if not too fine."""
    count = int(min(max(4.0 * length / finest, ACROSS), MOST)) if finest > 0.0 else ACROSS
    return np.linspace(0.0, 1.0, count)


def _revolved(radius: np.ndarray, height: np.ndarray) -> np.ndarray:
    """Return the points of circles about z of these radii at these heights [m] (n * AROUND, 3)."""
    angle = 2.0 * math.pi * np.arange(AROUND) / AROUND
    x, y = np.outer(radius, np.cos(angle)), np.outer(radius, np.sin(angle))
    return np.stack([x, y, np.repeat(height[:, None], AROUND, axis=1)], axis=-1).reshape(-1, 3)


def _depth_in_mesh(machine: Machine, wall: WallEntry, points: np.ndarray) -> np.ndarray:
    """Return the depth of points inside of a mesh [m] (n,), minus infinity outside."""
    mesh, depth = wall_mesh(machine, wall), np.full(len(points), -np.inf)
    near = ((points > mesh.vertices.min(axis=0)) & (points < mesh.vertices.max(axis=0))).all(axis=1)
    inside = np.flatnonzero(near)
    if not len(inside):
        return depth
    inside = inside[~on_charge_side(mesh, points[inside])]
    surface = surface_points(machine, wall)
    for index in inside:
        depth[index] = np.linalg.norm(surface - points[index], axis=1).min()
    return depth
