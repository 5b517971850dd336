"""Grid and patches of the statistics of a charge, and the recorded quantities.

The grid is cylindrical, around the regions of the charge, along the z axis of the body that the machine names
for its fields.  It is fixed to that body, or rotates about that axis with the angle of a drive.
"""

import functools
import math
from typing import NamedTuple

import numpy as np

from nutamill.base.required import required
from nutamill.case.machine import Machine
from nutamill.charge.kernels.impacts import FINE, bin_edges
from nutamill.charge.measures.statistics import (
    FIELD_SUMS,
    MOST_NEIGHBOURS,
    WALL_SUMS,
    StatisticsPlan,
    statistics_plan,
)
from nutamill.charge.model import ChargeModel, ChargeState
from nutamill.charge.walls.patches import ANGLE_HEIGHT, ANGLE_RADIUS, FACE_HEIGHT, PatchTable, patch_table
from nutamill.charge.walls.surface import Surface, SurfaceKind
from nutamill.simulation.setup.carriers import carrier_index, carriers_of
from nutamill.simulation.setup.charge import loading_share
from nutamill.simulation.setup.kinds import particle_kinds
from nutamill.simulation.setup.particles import charge_particles
from nutamill.simulation.setup.walls import region_corners, seen_from, world_surfaces

SECTORS = 36
"""Cells and patches around the chamber [1]: 10 deg each."""
MOST_ACROSS, MOST_UP = 10, 30
"""Most cells along radius and height [1]."""
FACES = 6
"""Faces of a rib [1]."""
MESH_POINTS = 1e6
"""Number of points on a mesh's patch that sample the areas of its parts [1]."""

ROUND = (SurfaceKind.CYLINDER, SurfaceKind.TUBE, SurfaceKind.SPHERE_CAP, SurfaceKind.BALL)
"""Kinds of surfaces whose area is the same on every height."""


class Grid(NamedTuple):
    """The cylindrical grid of the fields."""

    carrier: int
    """Index of the body to which it is fixed, among the carriers [1]."""
    origin: tuple[float, float, float]
    """Centre of its lower end [m], axes of that body from the mass centre."""
    radius: float
    """Its radius [m]."""
    height: float
    """Its height [m]."""
    cells: tuple[int, int, int]
    """Cells along radius, azimuth and height [1]: two diameters of the largest particle wide, within limits
    of their number.
    """


@functools.lru_cache(maxsize=8)
def field_grid(machine: Machine) -> Grid:
    """Return the grid of the fields of a machine's charge."""
    number = carrier_index(machine, machine.fields.body or machine.regions[0].body)
    carrier = carriers_of(machine)[number]
    corners = np.concatenate([region_corners(machine, region) for region in machine.regions])
    seen = (corners - carrier.position) @ carrier.rotation
    low, high = seen.min(axis=0), seen.max(axis=0)
    middle = 0.5 * (low + high)
    radius, height = float(np.hypot(*(seen - middle)[:, :2].T).max()), float(high[2] - low[2])
    width = 4.0 * float(charge_particles(machine).bounding_radius.max())
    across, up = min(max(round(radius / width), 2), MOST_ACROSS), min(max(round(height / width), 4), MOST_UP)
    origin = (float(middle[0]), float(middle[1]), float(low[2]))
    return Grid(number, origin, radius, height, (across, SECTORS, up))


def _cut(machine: Machine, surface: Surface, corners: np.ndarray) -> tuple[int, int, int, float, float]:
    """Return the patches of a surface given in world axes, in the form of `patch_table`.

    `corners` [m] (n, 3) are those of the regions.
    """
    across, around, up = field_grid(machine).cells
    kind, size = surface.kind, surface.size
    local = (corners - surface.origin) @ np.asarray(surface.rotation)
    low, high = float(local[:, 2].min()), float(local[:, 2].max())
    if kind == SurfaceKind.PLANE:
        return ANGLE_RADIUS, around, across, 0.0, float(np.hypot(*local[:, :2].T).max())
    if kind == SurfaceKind.CYLINDER:
        return ANGLE_HEIGHT, around, up, low, high
    if kind == SurfaceKind.DISC:
        return ANGLE_RADIUS, around, across, 0.0, size[0]
    if kind == SurfaceKind.TUBE:
        return ANGLE_HEIGHT, around, up, 0.0, size[1]
    if kind == SurfaceKind.ROD:
        return ANGLE_HEIGHT, around, up, -size[1], size[1]
    if kind == SurfaceKind.BALL:
        return ANGLE_HEIGHT, around, up, -size[0], size[0]
    if kind == SurfaceKind.BOX:
        return FACE_HEIGHT, FACES, up, max(low, -size[2]), min(high, size[2])
    if kind == SurfaceKind.CONE:
        return ANGLE_HEIGHT, around, up, 0.0, size[2]
    if kind == SurfaceKind.SPHERE_CAP:
        return ANGLE_HEIGHT, around, up, -size[0], -size[0] * math.cos(size[1])
    if required(surface.mesh).keep == "outside":
        return ANGLE_HEIGHT, 1, 1, 0.0, 1.0
    points, _, upright = _mesh_points(surface)
    if abs(upright) > 0.7:  # rather a floor than a wall
        return ANGLE_RADIUS, around, across, 0.0, float(np.hypot(points[:, 0], points[:, 1]).max())
    return ANGLE_HEIGHT, around, up, float(points[:, 2].min()), float(points[:, 2].max())


def _mesh_points(surface: Surface) -> tuple[np.ndarray, np.ndarray, float]:
    """Return points spread evenly over each triangle of a mesh's patch [m] (n, 3), the area of each [m^2]
    (n,), surface axes, and the mean z component of the normal [1].
    """
    mesh = required(surface.mesh)
    corners = mesh.vertices[mesh.faces[mesh.patch == surface.patch]]
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normals = 0.5 * np.cross(a, b)
    areas = np.linalg.norm(normals, axis=1)
    k = int(np.clip(math.sqrt(MESH_POINTS / len(areas)), 3, 60))
    # middles of the k^2 equal parts of a triangle
    row, column = (part.ravel() for part in np.meshgrid(np.arange(k), np.arange(k), indexing="ij"))
    up, down = row + column < k, row + column < k - 1
    u, v = (np.concatenate([part[up] + 1 / 3, part[down] + 2 / 3]) / k for part in (row, column))
    points = corners[:, :1] + u[:, None] * a[:, None, :] + v[:, None] * b[:, None, :]
    return points.reshape(-1, 3), np.repeat(areas / (k * k), k * k), float(normals[:, 2].sum() / areas.sum())


@functools.lru_cache(maxsize=8)
def wall_patches(machine: Machine) -> PatchTable:
    """Return the patches of the surfaces of a machine's walls."""
    corners = np.concatenate([region_corners(machine, region) for region in machine.regions])
    return patch_table([_cut(machine, surface, corners) for surface in world_surfaces(machine)])


def charge_survey(machine: Machine, model: ChargeModel, state: ChargeState, substep: float) -> StatisticsPlan:
    """Return grid and patches of the charge of a machine, for its substep [s]."""
    grid = field_grid(machine)
    on, volumes = machine.run.statistics, _pebble_volumes(machine)
    extent = (grid.radius, 0.0, grid.height)
    return statistics_plan(model, state, substep, grid.carrier, grid.origin, grid.cells, extent, on, volumes)


def _pebble_volumes(machine: Machine) -> np.ndarray:
    """Return the solid volume of every sphere [m^3] by id: the share of a pebble in the volume of its
    particle, which is less than the sum of overlapping spheres.
    """
    particles = charge_particles(machine)
    shares = [shape.radii**3 / (shape.radii**3).sum() for shape in particles.shapes]
    return np.concatenate(
        [volume * shares[shape] for volume, shape in zip(particles.volume, particles.shape_of, strict=True)]
    )


class PairType(NamedTuple):
    """Two kinds of bodies that can touch."""

    name: str
    """``steel-acrylic wall``, or ``steel 4 mm-steel 5 mm`` where a material has several classes of size."""
    materials: str
    """Name of the pair of materials."""
    diameters: tuple[float, float]
    """Diameters of the particles of mean volume [m]; not a number for a wall."""
    share: float
    """Share of the work of loading that the first takes [1]."""
    types: list[int]
    """Its types in `nutamill.charge.kernels.impacts`."""


def pair_types(machine: Machine) -> list[PairType]:
    """Return the pairs of kinds that can touch and whose impacts are counted: with LAMMPS, those with walls
    alone.
    """
    kinds = particle_kinds(machine)
    n, types = len(kinds.kinds), []
    for pair in machine.touching:
        if machine.charge.engine is not None and not pair.wall:
            continue
        others = kinds.numbers(pair.second)
        for a in kinds.numbers(pair.first):
            for b in others[:1] if pair.wall else others:
                one, two = kinds.kinds[a], kinds.kinds[b]
                if pair.wall:
                    name, far, numbers = f"{one.name}-{pair.second} wall", math.nan, [(n + a) * n + b]
                elif a <= b or pair.first != pair.second:
                    name, far, numbers = (
                        f"{one.name}-{two.name}",
                        two.diameter,
                        sorted({a * n + b, b * n + a}),
                    )
                else:
                    continue
                near = one.diameter, one.diameter if pair.wall else far
                share = loading_share(machine, pair.first, pair.second, near)
                types.append(PairType(name, pair.name, (one.diameter, far), share, numbers))
    return types


def statistics_axes(machine: Machine, plan: StatisticsPlan) -> dict[str, np.ndarray]:
    """Return the axes of the recorded arrays by the names of `nutamill.result.fields.STATISTICS_AXES`."""
    edges, pairs = bin_edges(), pair_types(machine)
    radius = np.linspace(0.0, plan.extent[0], plan.cells[0] + 1)
    angle = np.linspace(0.0, math.tau, plan.cells[1] + 1)
    height = np.linspace(plan.extent[1], plan.extent[2], plan.cells[2] + 1)
    ring = 0.5 * np.diff(radius**2) * angle[1]
    return {
        "pair": np.array([pair.name for pair in pairs]),
        "pair_materials": np.array([pair.materials for pair in pairs]),
        "pair_first": np.array([pair.diameters[0] for pair in pairs]),
        "pair_second": np.array([pair.diameters[1] for pair in pairs]),
        "pair_share": np.array([pair.share for pair in pairs]),
        "part": np.array(["normal", "tangential", "loading"]),
        "energy": np.sqrt(edges[1:] * edges[:-1]),
        "radius": 0.5 * (radius[1:] + radius[:-1]),
        "azimuth": 0.5 * (angle[1:] + angle[:-1]),
        "height": 0.5 * (height[1:] + height[:-1]),
        "cell_volume": np.repeat(ring[:, None], plan.cells[2], axis=1) * np.diff(height),
        "neighbours": np.arange(MOST_NEIGHBOURS),
        **patch_axes(machine),
    }


def patch_axes(machine: Machine) -> dict[str, np.ndarray]:
    """Return surface, position and area of every patch, in the axes of the grid's body as assembled."""
    table, grid = wall_patches(machine), field_grid(machine)
    carrier = carriers_of(machine)[grid.carrier]
    columns: dict[str, list] = {
        name: [] for name in ("patch_surface", "patch_column", "patch_azimuth", "patch_along", "patch_area")
    }
    for s, surface in enumerate(seen_from(one, carrier) for one in world_surfaces(machine)):
        rows = int(table.rows[s])
        count = int(table.first[s + 1] - table.first[s]) // rows
        low, high = table.range[s]
        edges = np.linspace(low, high, rows + 1)
        azimuth = np.full(count, math.nan)
        if table.kind[s] != FACE_HEIGHT:
            angle = (np.arange(count) + 0.5) * math.tau / count
            across, along, _ = np.asarray(surface.rotation) @ np.stack(
                [np.cos(angle), np.sin(angle), np.zeros(count)]
            )
            azimuth = np.mod(np.arctan2(along, across), math.tau)
        lift = 0.0 if table.kind[s] == ANGLE_RADIUS else float(surface.origin[2]) - grid.origin[2]
        columns["patch_surface"] += [surface.name] * (count * rows)
        columns["patch_column"] += list(np.repeat(np.arange(count), rows))
        columns["patch_azimuth"] += list(np.repeat(azimuth, rows))
        columns["patch_along"] += list(np.tile(0.5 * (edges[1:] + edges[:-1]) + lift, count))
        columns["patch_area"] += list(_areas(surface, int(table.kind[s]), edges, count).ravel())
    return {name: np.array(values) for name, values in columns.items()}


def _areas(surface: Surface, kind: int, edges: np.ndarray, count: int) -> np.ndarray:
    """Return the free area of the patches of a surface [m^2] (columns, rows), cut at `edges` [m] along its
    second coordinate.
    """
    rows = len(edges) - 1
    steps = np.diff(edges)
    if surface.kind == SurfaceKind.BOX:
        half_in_wall = edges[0] > -surface.size[2]
        return _rib_areas(surface, steps) if half_in_wall else _box_areas(surface, steps)
    if surface.kind == SurfaceKind.CONE:
        bottom, top, height = surface.size
        radii = bottom + (top - bottom) * 0.5 * (edges[1:] + edges[:-1]) / height
        slope = math.hypot(1.0, (top - bottom) / height)
        return np.tile(radii * steps * slope * math.tau / count, (count, 1))
    if surface.kind == SurfaceKind.ROD:
        sides = np.tile(steps * surface.size[0] * math.tau / count, (count, 1))
        sides[:, [0, -1]] += math.pi * surface.size[0] ** 2 / count  # its flat ends
        return sides
    # a zone of a sphere has the area of the cylinder about it
    if surface.kind in ROUND:
        return np.tile(steps * surface.size[0] * math.tau / count, (count, 1))
    if surface.kind in (SurfaceKind.PLANE, SurfaceKind.DISC):
        return np.tile(0.5 * np.diff(edges**2) * math.tau / count, (count, 1))
    points, areas, _ = _mesh_points(surface)
    along = np.hypot(points[:, 0], points[:, 1]) if kind == ANGLE_RADIUS else points[:, 2]
    row = np.clip(((along - edges[0]) / (edges[-1] - edges[0]) * rows).astype(int), 0, rows - 1)
    column = np.minimum(
        (np.mod(np.arctan2(points[:, 1], points[:, 0]) / math.tau, 1.0) * count).astype(int), count - 1
    )
    return np.bincount(column * rows + row, areas, count * rows).reshape(count, rows)


def _rib_areas(surface: Surface, steps: np.ndarray) -> np.ndarray:
    """Return the free area [m^2] (6, rows) of the faces of a rib: the face to the axis, two flanks, and the
    top in its last row.
    """
    depth, half_width, _ = surface.size
    areas = np.zeros((FACES, len(steps)))
    areas[0] = 2.0 * half_width * steps
    areas[2] = areas[3] = depth * steps
    areas[5, -1] = 2.0 * half_width * depth
    return areas


def _box_areas(surface: Surface, steps: np.ndarray) -> np.ndarray:
    """Return the area [m^2] (6, rows) of the faces of a box that stands free, its ends in the last rows."""
    x, y, _ = surface.size
    areas = np.zeros((FACES, len(steps)))
    areas[0] = areas[1] = 2.0 * y * steps
    areas[2] = areas[3] = 2.0 * x * steps
    areas[4, 0] = areas[5, -1] = 4.0 * x * y
    return areas


def recorded_sums(
    machine: Machine, plan: StatisticsPlan, per_cut: float, sums: dict[str, np.ndarray]
) -> dict[str, np.ndarray]:
    """Return sums in small units (`nutamill.charge.measures.totals.gathered`) as recorded quantities in
    SI, named as in `nutamill.result.fields.STATISTICS`. `per_cut` [1/J] are the small units of the cutting
    energy.
    """
    interval = 1.0 / machine.run.series_rate
    book = np.stack([sums["spectra"][pair.types].sum(axis=0) for pair in pair_types(machine)])
    walls = sums["walls"] * (interval / plan.per_wall)
    fields = (sums["fields"] * (interval / plan.per_field)).reshape(*plan.cells, len(FIELD_SUMS))
    return {
        "sampled_time": interval * sums["samples"][0],
        "impact_number": book[..., 0].astype(float),
        "impact_energy": book[..., 1] * (bin_edges()[:-1] / FINE),
        **{f"wall_{name}": walls[:, k] for k, name in enumerate(WALL_SUMS)},
        "wall_cutting_energy": sums["cut"] / per_cut,
        **{f"cell_{name}": fields[..., k] for k, name in enumerate(FIELD_SUMS)},
        "neighbour_time": interval * sums["neighbours"],
    }
