"""Grid and patches of the statistics of a charge in its chamber, and the recorded quantities.

The grid has its origin in the middle of the chamber's floor and its z axis along the chamber's.  It rotates
with the crank.
"""

import math

import numpy as np

from nutamill.case import Case
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
from nutamill.simulation.setup.charge import CHAMBER_CARRIER, chamber_surfaces, material_order
from nutamill.simulation.setup.particles import charge_particles
from nutamill.simulation.setup.rigid_parts import whole_chamber

SECTORS = 36
"""Cells and patches around the chamber [1]: 10 deg each."""
MOST_ACROSS, MOST_UP = 10, 30
"""Most cells along radius and height [1]."""
FACES = 6
"""Faces of a rib [1]."""
MESH_POINTS = 1e6
"""Number of points on a mesh's patch that sample the areas of its parts [1]."""


def chamber_cells(case: Case) -> tuple[int, int, int]:
    """Return the cells along radius, azimuth and height [1]: two diameters of the largest particle wide,
    within limits of their number.
    """
    width = 4.0 * float(charge_particles(case).bounding_radius.max())
    across = min(max(round(case.chamber.inner_diameter / 2 / width), 2), MOST_ACROSS)
    return across, SECTORS, min(max(round(case.chamber.height / width), 4), MOST_UP)


def _cut(case: Case, surface: Surface) -> tuple[int, int, int, float, float]:
    """Return the patches of a surface, in the form of `patch_table`."""
    across, around, up = chamber_cells(case)
    if surface.kind == SurfaceKind.CYLINDER:
        return ANGLE_HEIGHT, around, up, 0.0, case.chamber.height
    if surface.kind == SurfaceKind.PLANE:
        return ANGLE_RADIUS, around, across, 0.0, case.chamber.inner_diameter / 2
    if surface.kind == SurfaceKind.BOX:
        # a rib's box begins as far below the floor as it reaches into the charge: rows of the free part
        depth, _, half = surface.size
        return FACE_HEIGHT, FACES, up, depth - half, half
    if surface.mesh.keep == "outside":
        return ANGLE_HEIGHT, 1, 1, 0.0, 1.0
    points, _, upright = _mesh_points(surface)
    if abs(upright) > 0.7:  # rather a floor than a wall
        return ANGLE_RADIUS, around, across, 0.0, float(np.hypot(points[:, 0], points[:, 1]).max())
    return ANGLE_HEIGHT, around, up, float(points[:, 2].min()), float(points[:, 2].max())


def _mesh_points(surface: Surface) -> tuple[np.ndarray, np.ndarray, float]:
    """Return points spread evenly over each triangle of a mesh's patch [m] (n, 3), the area of each [m^2]
    (n,), surface axes, and the mean z component of the normal [1].
    """
    mesh = surface.mesh
    corners = mesh.vertices[mesh.faces[mesh.patch == surface.patch]]
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normals = 0.5 * np.cross(a, b)
    areas = np.linalg.norm(normals, axis=1)
    k = int(np.clip(math.sqrt(MESH_POINTS / len(areas)), 3, 60))
    # middles of the k^2 equal parts of a triangle
    u, v = (part.ravel() for part in np.meshgrid(np.arange(k), np.arange(k), indexing="ij"))
    up, down = u + v < k, u + v < k - 1
    u, v = (
        np.concatenate([u[up] + 1 / 3, u[down] + 2 / 3]) / k,
        np.concatenate([v[up] + 1 / 3, v[down] + 2 / 3]) / k,
    )
    points = corners[:, :1] + u[:, None] * a[:, None, :] + v[:, None] * b[:, None, :]
    return points.reshape(-1, 3), np.repeat(areas / (k * k), k * k), float(normals[:, 2].sum() / areas.sum())


def chamber_patches(case: Case) -> PatchTable:
    """Return the patches of the chamber's surfaces."""
    return patch_table([_cut(case, surface) for surface in chamber_surfaces(case)])


def chamber_survey(case: Case, model: ChargeModel, state: ChargeState, substep: float) -> StatisticsPlan:
    """Return the grid in the chamber of `case`, for its charge and its substep [s]."""
    floor = np.array([0.0, 0.0, -case.chamber.floor_depth]) - whole_chamber(case.chamber).mass_centre
    extent = (case.chamber.inner_diameter / 2, 0.0, case.chamber.height)
    on, volumes = case.run.statistics, _pebble_volumes(case)
    return statistics_plan(
        model, state, substep, CHAMBER_CARRIER, tuple(floor), chamber_cells(case), extent, on, volumes
    )


def _pebble_volumes(case: Case) -> np.ndarray:
    """Return the solid volume of every sphere [m^3] by id: the share of a pebble in the volume of its
    particle, which is less than the sum of overlapping spheres.
    """
    particles = charge_particles(case)
    shares = [shape.radii**3 / (shape.radii**3).sum() for shape in particles.shapes]
    return np.concatenate(
        [volume * shares[shape] for volume, shape in zip(particles.volume, particles.shape_of, strict=True)]
    )


def pair_types(case: Case) -> list[tuple[str, list[int]]]:
    """Return the kinds of pairs that can touch: name, and its types in `nutamill.charge.kernels.impacts`."""
    names = material_order(case)
    n, types = len(names), []
    for pair in case.touching:
        a, b = names.index(pair.first), names.index(pair.second)
        types.append((pair.name, [(n + a) * n + b] if pair.wall else sorted({a * n + b, b * n + a})))
    return types


def statistics_axes(case: Case, plan: StatisticsPlan) -> dict[str, np.ndarray]:
    """Return the axes of the recorded arrays by the names of `nutamill.result.fields.STATISTICS_AXES`."""
    edges = bin_edges()
    radius = np.linspace(0.0, plan.extent[0], plan.cells[0] + 1)
    angle = np.linspace(0.0, math.tau, plan.cells[1] + 1)
    height = np.linspace(plan.extent[1], plan.extent[2], plan.cells[2] + 1)
    ring = 0.5 * np.diff(radius**2) * angle[1]
    return {
        "pair": np.array([name for name, _ in pair_types(case)]),
        "part": np.array(["normal", "tangential"]),
        "energy": np.sqrt(edges[1:] * edges[:-1]),
        "radius": 0.5 * (radius[1:] + radius[:-1]),
        "azimuth": 0.5 * (angle[1:] + angle[:-1]),
        "height": 0.5 * (height[1:] + height[:-1]),
        "cell_volume": np.repeat(ring[:, None], plan.cells[2], axis=1) * np.diff(height),
        "neighbours": np.arange(MOST_NEIGHBOURS),
        **_patches(case),
    }


def _patches(case: Case) -> dict[str, np.ndarray]:
    """Return surface, position and area of every patch."""
    table = chamber_patches(case)
    floor = -case.chamber.floor_depth - whole_chamber(case.chamber).mass_centre[2]
    columns: dict[str, list] = {
        name: [] for name in ("patch_surface", "patch_column", "patch_azimuth", "patch_along", "patch_area")
    }
    for s, surface in enumerate(chamber_surfaces(case)):
        rows = int(table.rows[s])
        count = int(table.first[s + 1] - table.first[s]) // rows
        edges = np.linspace(*table.range[s], rows + 1)
        azimuth = np.full(count, math.nan)
        if table.kind[s] != FACE_HEIGHT:
            angle = (np.arange(count) + 0.5) * math.tau / count
            across, along, _ = np.asarray(surface.rotation) @ np.stack(
                [np.cos(angle), np.sin(angle), np.zeros(count)]
            )
            azimuth = np.mod(np.arctan2(along, across), math.tau)
        lift = 0.0 if table.kind[s] == ANGLE_RADIUS else surface.origin[2] - floor
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
    if surface.kind == SurfaceKind.BOX:
        return _rib_areas(surface, np.diff(edges))
    if surface.kind == SurfaceKind.CYLINDER:
        return np.tile(np.diff(edges) * surface.size[0] * math.tau / count, (count, 1))
    if surface.kind == SurfaceKind.PLANE:
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


def recorded_sums(
    case: Case, plan: StatisticsPlan, per_cut: float, sums: dict[str, np.ndarray]
) -> dict[str, np.ndarray]:
    """Return sums in small units (`nutamill.charge.measures.statistics.gathered`) as recorded quantities in
    SI, named as in `nutamill.result.fields.STATISTICS`; `per_cut` [1/J] are the small units of the cutting
    energy.
    """
    interval = 1.0 / case.run.series_rate
    book = np.stack([sums["spectra"][types].sum(axis=0) for _, types in pair_types(case)])
    walls = sums["walls"] * (interval / plan.per_wall)
    fields = (sums["fields"] * (interval / plan.per_field)).reshape(*plan.cells, len(FIELD_SUMS))
    return {
        "sampled_time": np.float64(interval * sums["samples"][0]),
        "impact_number": book[..., 0].astype(float),
        "impact_energy": book[..., 1] * (bin_edges()[:-1] / FINE),
        **{f"wall_{name}": walls[:, k] for k, name in enumerate(WALL_SUMS)},
        "wall_cutting_energy": sums["cut"] / per_cut,
        **{f"cell_{name}": fields[..., k] for k, name in enumerate(FIELD_SUMS)},
        "neighbour_time": interval * sums["neighbours"],
    }
