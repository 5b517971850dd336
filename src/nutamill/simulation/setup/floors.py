"""Whether a region of the charge is on the charge's side of the walls, and has a wall below it."""

from collections.abc import Sequence

import numpy as np

from nutamill.base.errors import Fault
from nutamill.base.required import required
from nutamill.case.machine import Machine
from nutamill.case.walls import RegionEntry
from nutamill.charge.filling.fill_walls import in_room
from nutamill.charge.walls.surface import Surface, SurfaceKind
from nutamill.simulation.setup.regions import region_points
from nutamill.simulation.setup.walls import world_surfaces

RAYS = 500
"""Points of a region from which the way down is looked at [1]."""

ENDLESS = (SurfaceKind.PLANE, SurfaceKind.CYLINDER)
"""Kinds that bound the charge wherever it is; a region beyond one of them is outside."""


def region_faults(machine: Machine) -> list[Fault]:
    """Return the regions that are outside of the walls, or have no wall below them."""
    return [fault for region in machine.regions if (fault := _fault(machine, region))]


def _fault(machine: Machine, region: RegionEntry) -> Fault | None:
    """Return what is wrong with the position of a region among the walls, or None if nothing is."""
    points, surfaces = region_points(machine, region, RAYS), world_surfaces(machine)
    for surface in surfaces:
        if surface.kind in ENDLESS and not in_room([surface], points).any():
            what = f'is outside of the walls: all of it is behind wall "{surface.name}"'
            return Fault(f"regions.{region.name}", what, "Move it to the charge's side of that wall")
    down = np.array(machine.gravity, float)
    if not down.any():
        return None
    down /= np.linalg.norm(down)
    if lid := _lid_below(surfaces, points, down):
        what = f'is outside of the walls: wall "{lid}" is below it and faces away'
        return Fault(f"regions.{region.name}", what, "Move it to the charge's side of that wall")
    if _have_floor(surfaces, points, down):
        return None
    what = "has no floor: no wall is below it, and the charge would fall out"
    return Fault(f"regions.{region.name}", what, "Add a wall below it, or turn the one there around")


def _have_floor(surfaces: Sequence[Surface], points: np.ndarray, down: np.ndarray) -> bool:
    """Return whether a wall is below any of the points [m] (n, 3), world. `down` has the length 1."""
    return any(
        crosses(surface, (points - np.asarray(surface.origin)) @ axes, down @ axes).any()
        for surface in sorted(surfaces, key=lambda one: one.kind == SurfaceKind.MESH_PATCH)
        for axes in [np.asarray(surface.rotation, float)]
    )


def _lid_below(surfaces: Sequence[Surface], points: np.ndarray, down: np.ndarray) -> str:
    """Return the name of a disc that faces away from all points [m] (n, 3), world, which have nothing but it
    below them before another disc.

    The name is empty where there is none.
    """
    discs = [surface for surface in surfaces if surface.kind == SurfaceKind.DISC]
    others = [surface for surface in surfaces if surface.kind != SurfaceKind.DISC]
    if not discs or _have_floor(others, points, down):
        return ""
    ways = np.stack([_way_to_disc(disc, points, down) for disc in discs])
    nearest = ways.argmin(axis=0)
    first = discs[nearest[0]]
    alone = bool((nearest == nearest[0]).all() and np.isfinite(ways.min(axis=0)).all())
    return first.name if alone and np.asarray(first.rotation)[:, 2] @ down > 0.0 else ""


def _way_to_disc(disc: Surface, points: np.ndarray, down: np.ndarray) -> np.ndarray:
    """Return how far it is down to a disc [m] (n,), infinite where it is not below a point."""
    axes = np.asarray(disc.rotation, float)
    start, way = (points - np.asarray(disc.origin)) @ axes, down @ axes
    if way[2] == 0.0:
        return np.full(len(points), np.inf)
    far = -start[:, 2] / way[2]
    foot = start + far[:, None] * way
    met = (far > 0.0) & (np.hypot(foot[:, 0], foot[:, 1]) <= disc.size[0])
    return np.where(met, far, np.inf)


def crosses(surface: Surface, start: np.ndarray, way: np.ndarray) -> np.ndarray:
    """Return whether rays from points [m] (n, 3) along the unit vector `way`, both in surface axes, meet the
    surface (n,).
    """
    kind, size = surface.kind, surface.size
    if kind == SurfaceKind.PLANE:
        return np.asarray((start[:, 2] > 0.0) & (way[2] < 0.0))
    if kind == SurfaceKind.CYLINDER:
        return (np.hypot(start[:, 0], start[:, 1]) < size[0]) & bool(np.hypot(*way[:2]) > 1e-9)
    if kind == SurfaceKind.BOX:
        return _meets_box(start, way, np.asarray(size))
    if kind == SurfaceKind.DISC:
        with np.errstate(divide="ignore", invalid="ignore"):
            foot = start - start[:, 2:] * (way / way[2])
        return (start[:, 2] > 0.0) & (way[2] < 0.0) & (np.hypot(foot[:, 0], foot[:, 1]) <= size[0])
    if kind in (SurfaceKind.CONE, SurfaceKind.TUBE):
        bottom, top, height = size if kind == SurfaceKind.CONE else (size[0], size[0], size[1])
        slope = (top - bottom) / height
        across, radius = start[:, :2], bottom + slope * start[:, 2]
        roots = _roots(
            way[:2] @ way[:2] - (slope * way[2]) ** 2,
            across @ way[:2] - radius * slope * way[2],
            (across**2).sum(axis=1) - radius**2,
        )
        heights = start[:, 2] + roots * way[2]
        return ((roots > 0.0) & (heights >= 0.0) & (heights <= height)).any(axis=0)
    if kind == SurfaceKind.BALL:
        roots = _roots(1.0, start @ way, (start**2).sum(axis=1) - size[0] ** 2)
        return np.asarray((roots > 0.0).any(axis=0))
    if kind == SurfaceKind.ROD:
        return _meets_rod(start, way, size[0], size[1])
    if kind == SurfaceKind.SPHERE_CAP:
        roots = _roots(1.0, start @ way, (start**2).sum(axis=1) - size[0] ** 2)
        heights = start[:, 2] + roots * way[2]
        return ((roots > 0.0) & (-heights >= size[0] * np.cos(size[1]))).any(axis=0)
    return _meets_mesh(surface, start, way) if surface.patch == 0 else np.zeros(len(start), bool)


def _meets_rod(start: np.ndarray, way: np.ndarray, radius: float, half: float) -> np.ndarray:
    """Return whether rays meet a rod of a radius and half a height [m] about the origin (n,): there is then a
    time at which they are between its ends and within its radius.
    """
    across = start[:, :2]
    sides = _roots(way[:2] @ way[:2], across @ way[:2], (across**2).sum(axis=1) - radius**2)
    if way[:2] @ way[:2] < 1e-12:
        inside = (across**2).sum(axis=1) < radius**2
        sides = np.where(inside, np.array([[-np.inf], [np.inf]]), np.nan)
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = np.sort(np.stack([(-half - start[:, 2]) / way[2], (half - start[:, 2]) / way[2]]), axis=0)
    if way[2] == 0.0:
        ends = np.where(np.abs(start[:, 2]) < half, np.array([[-np.inf], [np.inf]]), np.nan)
    first, last = np.fmax(sides[0], ends[0]), np.fmin(sides[1], ends[1])
    met = ~np.isnan(sides[0]) & ~np.isnan(ends[0])
    return met & (first <= last) & (last > 0.0)


def _roots(a: float, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Return both roots (2, n) of a t^2 + 2 b t + c = 0, or NaN where there is none."""
    with np.errstate(invalid="ignore", divide="ignore"):
        if abs(a) < 1e-12:
            return np.stack([-0.5 * c / b, np.full(len(c), np.nan)])
        half = np.sqrt(b * b - a * c)
        return np.stack([(-b - half) / a, (-b + half) / a])


def _meets_box(start: np.ndarray, way: np.ndarray, half: np.ndarray) -> np.ndarray:
    """Return whether rays meet a box of half sizes `half` [m] about the origin (n,)."""
    with np.errstate(divide="ignore", invalid="ignore"):
        times = np.stack([(-half - start) / way, (half - start) / way])
    beside = (way == 0.0) & (np.abs(start) >= half)
    first = np.where(way == 0.0, -np.inf, times.min(axis=0)).max(axis=1)
    last = np.where(way == 0.0, np.inf, times.max(axis=0)).min(axis=1)
    return ~beside.any(axis=1) & (first <= last) & (last > 0.0)


def _meets_mesh(surface: Surface, start: np.ndarray, way: np.ndarray) -> np.ndarray:
    """Return whether rays meet a triangle of a mesh from the side of the charge (n,).

    Source: T. Moeller and B. Trumbore, "Fast, minimum storage ray/triangle intersection", J. Graphics Tools
    2, 21-28 (1997).
    """
    mesh = required(surface.mesh)
    corners = mesh.vertices[mesh.faces]
    one, two = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    facing = np.cross(one, two) @ way < 0.0
    corners, one, two = corners[facing, 0], one[facing], two[facing]
    normal = np.cross(way, two)
    scale = (normal * one).sum(axis=1)
    met = np.zeros(len(start), bool)
    for number, point in enumerate(start):
        gap = point - corners
        u = (gap * normal).sum(axis=1) / scale
        across = np.cross(gap, one)
        v, time = across @ way / scale, (across * two).sum(axis=1) / scale
        met[number] = ((u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (time > 0.0)).any()
    return met
