"""The regions that charge is put into: their free volume, and the random fill of each.

A region is filled in axes that point upwards: its own where its axis is nearly upright, else world axes.
"""

import functools
import math
from typing import NamedTuple

import numpy as np

from nutamill.base.required import required
from nutamill.case.charge import Portion
from nutamill.case.machine import Machine
from nutamill.case.placement import axes_along, region_axes
from nutamill.case.walls import RegionEntry
from nutamill.charge.filling.fill import fill_cylinder, random_attitudes
from nutamill.charge.filling.fill_walls import fill_between, in_room
from nutamill.charge.filling.room import Room, cylinder_room
from nutamill.charge.particles.particles import Particles
from nutamill.charge.walls.surface import Surface, SurfaceKind
from nutamill.charge.walls.triangles import normals_and_areas
from nutamill.simulation.setup.walls import meshed_walls, region_corners, wall_mesh, world_surfaces

UPRIGHT = math.cos(math.radians(45.0))
"""Cosine of the angle between gravity and the axis of a region up to which it is filled along its axis."""

SAMPLES = 200_000
"""Points that sample the share of a region which walls take [1]; its error is about 0.1 % of the region."""

NEAR = 1e-9
"""Length by which a wall may reach into a region without counting as in it [m]."""


class FillAxes(NamedTuple):
    """Axes in which a region is filled."""

    origin: np.ndarray
    """Origin [m] (3,), world."""
    rotation: np.ndarray
    """Rotation (3, 3) from these axes to world axes, z upwards."""

    def seen(self, surface: Surface) -> Surface:
        """Return a surface given in world axes in these."""
        return Surface(
            surface.name,
            surface.kind,
            0,
            surface.material,
            tuple(self.rotation.T @ (np.asarray(surface.origin) - self.origin)),
            self.rotation.T @ np.asarray(surface.rotation),
            surface.size,
            surface.mesh,
            surface.patch,
        )


def region_of(machine: Machine, part: Portion) -> RegionEntry:
    """Return the region of a part of the charge: the one it names, or the only one."""
    if part.region is None:
        return machine.regions[0]
    return next(region for region in machine.regions if region.name == part.region)


def region_middle(machine: Machine, region: RegionEntry) -> np.ndarray:
    """Return the middle of the box around a region along its axes [m] (3,), world as assembled."""
    axes = region_axes(region)
    seen = region_corners(machine, region) @ axes
    return axes @ (0.5 * (seen.min(axis=0) + seen.max(axis=0)))


def region_surfaces(region: RegionEntry) -> list[Surface]:
    """Return the bounds of a region as surfaces, world axes.

    The inside of a mesh, a wall itself, has none.
    """
    axes, point = region_axes(region), np.array(region.point)
    if region.shape == "mesh":
        return []
    if region.shape == "cylinder":
        size = (required(region.radius), 0.0, 0.0)
        sides = [Surface("region", SurfaceKind.CYLINDER, 0, 0, point, axes, size)]
        ends = [(2, -1.0, point), (2, 1.0, point + required(region.height) * axes[:, 2])]
    else:
        half, sides = 0.5 * np.array(required(region.size)), []
        ends = [(k, sign, point + sign * half[k] * axes[:, k]) for k in range(3) for sign in (-1.0, 1.0)]
    return sides + [
        Surface("region", SurfaceKind.PLANE, 0, 0, at, axes_along(-sign * axes[:, k], axes[:, (k + 1) % 3]))
        for k, sign, at in ends
    ]


def walls_within(machine: Machine, region: RegionEntry) -> list[Surface]:
    """Return the walls that reach into a region, world axes as assembled, with its own mesh."""
    corners, own = region_corners(machine, region), region_axes(region)
    within = []
    for surface in world_surfaces(machine):
        local = (corners - surface.origin) @ np.asarray(surface.rotation)
        if _far_from(surface, local):
            free = True
        elif surface.kind in (SurfaceKind.PLANE, SurfaceKind.DISC):
            free = local[:, 2].min() >= -NEAR
        elif surface.kind == SurfaceKind.CYLINDER:
            along = own.T @ np.asarray(surface.rotation)[:, 2]
            offset = (np.array(region.point) - surface.origin) @ np.asarray(surface.rotation)
            coaxial = region.shape == "cylinder" and math.hypot(*along[:2]) < NEAR
            reach = (
                math.hypot(*offset[:2]) + required(region.radius)
                if coaxial
                else np.hypot(*local[:, :2].T).max()
            )
            free = reach <= surface.size[0] + NEAR
        elif surface.kind == SurfaceKind.TUBE:
            free = float(np.hypot(*local[:, :2].T).max()) <= surface.size[0] + NEAR
        elif surface.kind == SurfaceKind.BOX:
            size = np.asarray(surface.size)
            free = bool((local.max(axis=0) < -size).any() or (local.min(axis=0) > size).any())
        elif surface.kind == SurfaceKind.MESH_PATCH:
            vertices = required(surface.mesh).vertices
            away = (local.max(axis=0) < vertices.min(axis=0)) | (local.min(axis=0) > vertices.max(axis=0))
            free = bool(away.any())
        else:
            free = False
        if not free:
            within.append(surface)
    return within


def _far_from(surface: Surface, corners: np.ndarray) -> bool:
    """Return whether a disc, tube, rod or ball is so far from the region with these corners [m] (n, 3),
    surface axes, that spheres about both do not meet.
    """
    a, b, _ = surface.size
    bounds = {
        SurfaceKind.DISC: (0.0, a),
        SurfaceKind.TUBE: (0.5 * b, math.hypot(a, 0.5 * b)),
        SurfaceKind.ROD: (0.0, math.hypot(a, b)),
        SurfaceKind.BALL: (0.0, a),
    }
    if surface.kind not in bounds:
        return False
    height, radius = bounds[surface.kind]
    middle = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
    reach = float(np.linalg.norm(corners - middle, axis=1).max())
    return float(np.linalg.norm(middle - [0.0, 0.0, height])) >= radius + reach


@functools.lru_cache(maxsize=16)
def free_volume(machine: Machine, region: RegionEntry) -> float:
    """Return the volume of a region that no wall takes [m^3]: as given, or that of its shape less that of the
    solids in it, by sampling where they are no whole meshes.
    """
    if region.free_volume is not None:
        return region.free_volume
    inside = walls_within(machine, region)
    solids = [mesh for s in inside if s.patch == 0 and (mesh := s.mesh) and mesh.keep == "outside"]
    if region.shape == "mesh":
        wall = next(wall for wall in machine.walls if wall.name == region.wall)
        whole = wall_mesh(machine, wall).volume
    else:
        whole = required(region.shape_volume)
    others = [s for s in inside if s.kind != SurfaceKind.MESH_PATCH]
    meshes = sum(mesh.volume for mesh in solids)
    return (whole - meshes) * (_share_free(machine, region, others) if others else 1.0)


def _share_free(machine: Machine, region: RegionEntry, walls: list[Surface]) -> float:
    """Return the share of a region that walls leave, by sampling it at evenly spread points."""
    return float(in_room(walls, region_points(machine, region, SAMPLES)).mean())


def region_points(machine: Machine, region: RegionEntry, number: int) -> np.ndarray:
    """Return the points in a region [m] (n, 3), world as assembled, out of a `number` that are evenly spread
    over the box around it.
    """
    axes = region_axes(region)
    seen = region_corners(machine, region) @ axes
    root = 1.2207440846057596  # of x^4 = x + 1: M. Roberts' sequence
    spread = np.mod(0.5 + np.outer(np.arange(1, number + 1), root ** -np.arange(1.0, 4.0)), 1.0)
    low, high = seen.min(axis=0), seen.max(axis=0)
    points = (low + spread * (high - low)) @ axes.T
    mesh = [s for s in world_surfaces(machine) if s.mesh is not None and s.mesh.keep == "inside"]
    return points[in_room(region_surfaces(region) or mesh, points)]


@functools.lru_cache(maxsize=16)
def charge_room(machine: Machine, region: RegionEntry) -> Room:
    """Return the room that a region offers: its free volume, and the area of its bounds and of the walls in
    it.
    """
    area = sum(_box_area(s) for s in walls_within(machine, region) if s.kind == SurfaceKind.BOX)
    for wall in meshed_walls(machine):
        if wall.charge_side == "outside" or wall.name == region.wall:
            area += float(normals_and_areas(wall_mesh(machine, wall).corners)[1].sum())
    if region.shape == "cylinder":
        area += cylinder_room(required(region.radius), 0.0, required(region.height)).area
    elif region.shape == "box":
        x, y, z = required(region.size)
        area += 2.0 * (x * y + y * z + z * x)
    return Room(free_volume(machine, region), area)


def _box_area(box: Surface) -> float:
    """Return the area of the long faces of a box that stands half in a wall [m^2]."""
    x, y, z = box.size
    return 4.0 * z * (x + y)


def fill_frame(machine: Machine, region: RegionEntry) -> FillAxes:
    """Return the axes in which a region is filled, with its point or middle as their origin."""
    axes, up = region_axes(region), -np.array(machine.gravity, float)
    if not up.any():
        up = axes[:, 2]
    up = up / np.linalg.norm(up)
    if axes[:, 2] @ up >= UPRIGHT:
        origin = region_middle(machine, region) if region.shape == "mesh" else np.array(region.point)
        return FillAxes(origin, axes)
    return FillAxes(region_middle(machine, region), axes_along(up))


def filled(machine: Machine, region: RegionEntry, particles: Particles, seed: int) -> Particles:
    """Return particles at random positions in a region without overlaps, world axes as assembled.

    Raises
    ------
    CaseError : more than the region holds, or particles that cannot be placed
    """
    frame, within = fill_frame(machine, region), walls_within(machine, region)
    upright = np.allclose(frame.rotation, region_axes(region), rtol=0.0, atol=1e-12)
    if region.shape == "cylinder" and upright and all(s.kind == SurfaceKind.BOX for s in within):
        boxes = [(seen.origin, seen.rotation, seen.size) for seen in map(frame.seen, within)]
        placed = fill_cylinder(particles, required(region.radius), 0.0, required(region.height), boxes, seed)
        return placed.placed(placed.centre @ frame.rotation.T + frame.origin, placed.attitude)
    surfaces = [frame.seen(surface) for surface in (*region_surfaces(region), *within)]
    corners = (region_corners(machine, region) - frame.origin) @ frame.rotation
    low, high = corners.min(axis=0), corners.max(axis=0)
    room = charge_room(machine, region)
    positions = fill_between(particles.bounding_radius, surfaces, low, high, room, seed)
    attitudes = None if particles.spheres_only else random_attitudes(particles.number, seed)
    return particles.placed(positions @ frame.rotation.T + frame.origin, attitudes)
