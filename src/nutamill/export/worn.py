"""Walls after some time of wear, as mesh files for the next run."""

import dataclasses
from pathlib import Path
from typing import NamedTuple

import numpy as np

from nutamill.analysis.wear import Wear
from nutamill.base.atomic_file import write_whole
from nutamill.base.errors import CaseError, Fault
from nutamill.base.required import required
from nutamill.base.units import in_unit, shown
from nutamill.case import Case, Machine
from nutamill.case.expansion import chamber_rotation
from nutamill.charge.walls.mesh import Mesh
from nutamill.charge.walls.patches import ANGLE_RADIUS, PatchTable
from nutamill.charge.walls.triangles import normals_and_areas
from nutamill.export.drawn_chamber import drawn_chamber
from nutamill.simulation.setup.statistics import wall_patches
from nutamill.simulation.setup.walls import meshed_walls, world_surfaces

BEND = 0.01
"""Share of the largest eigenvalue below which the normals at a corner count as one direction [1]: facets of a
round that bend by less than 11 degrees.
"""


class WornWall(NamedTuple):
    """A wall to be written: a mesh, and how each of its triangles is worn."""

    name: str
    """Name of its file."""
    unit: str
    """Unit of its file."""
    mesh: Mesh
    """Its triangles, in the axes of its file [m]."""
    depths: np.ndarray
    """Depth at the corners of each triangle [m] (T, 3)."""


def write_worn(case: Case | Machine, wear: Wear, time: float, folder: Path) -> list[Path]:
    """Write the walls of a case after some `time` [s] of wear as OBJ files, and return the paths.

    Meshed walls are written in the axes and unit of their own files.  Without any, each cylindrical region is
    written as a mesh of its bore and ends, in mm: of a drawn mill in the axes of ``[chamber.mesh]``, else in
    world axes as assembled.

    Raises
    ------
    CaseError : statistics of another version, a region that is no smooth cylinder, a mesh file that is
        missing or has changed, or so much wear that triangles turn over
    OutputError : the system refuses
    """
    machine = case.machine
    patches = int(wall_patches(machine).first[-1])
    if len(wear.depth) != patches:
        what = f"its statistics have {len(wear.depth)} patches of the walls, this version makes {patches}"
        raise CaseError(Fault(wear.path, what, "Run the case again"))
    walls = _meshed(machine, wear, time) if meshed_walls(machine) else _drawn(case, wear, time)
    written = []
    for wall in walls:
        moved = worn_corners(wall.mesh, wall.depths)
        _refuse_turned(wall.mesh, moved, wall.name, time)
        text = [f"v {x!r} {y!r} {z!r}" for x, y, z in in_unit(moved, wall.unit).tolist()]
        # the triangles of a mesh around the charge look inwards
        outwards = wall.mesh.faces[:, :: -1 if wall.mesh.keep == "inside" else 1] + 1
        text += [f"f {a} {b} {c}" for a, b, c in outwards.tolist()]
        path = folder / f"{wall.name}-worn-{in_unit(time, 'h'):g}h.obj"
        written.append(write_whole(path, ("\n".join(text) + "\n").encode()))
    return written


def _meshed(machine: Machine, wear: Wear, time: float) -> list[WornWall]:
    """Return the meshed walls of a machine after some time [s]."""
    table, surfaces = wall_patches(machine), world_surfaces(machine)
    patches = [s for s, surface in enumerate(surfaces) if surface.mesh is not None]
    begins = [k for k, s in enumerate(patches) if surfaces[s].patch == 0]
    worn = []
    for wall, first, end in zip(meshed_walls(machine), begins, [*begins[1:], len(patches)], strict=True):
        own = patches[first:end]
        mesh = required(surfaces[own[0]].mesh)
        depths = np.zeros(mesh.faces.shape)
        for s in own:
            faces = np.flatnonzero(mesh.patch == surfaces[s].patch)
            depths[faces] = depth_on(table, s, wear, time, mesh.vertices[mesh.faces[faces]])
        worn.append(WornWall(wall.name, required(wall.unit), mesh, depths))
    return worn


def _drawn(case: Case | Machine, wear: Wear, time: float) -> list[WornWall]:
    """Return the exact walls of the regions of a case after some time [s]."""
    machine = case.machine
    table, surfaces = wall_patches(machine), world_surfaces(machine)
    rotation = np.eye(3) if case.drawing is None else chamber_rotation(case.drawing)
    worn = []
    for region in machine.regions:
        mesh, wall_of = drawn_chamber(machine, region)
        depths = np.zeros(mesh.faces.shape)
        for s in np.unique(wall_of):
            surface, faces = surfaces[s], np.flatnonzero(wall_of == s)
            local = (mesh.vertices[mesh.faces[faces]] - surface.origin) @ np.asarray(surface.rotation)
            depths[faces] = depth_on(table, int(s), wear, time, local)
        own = dataclasses.replace(mesh, vertices=mesh.vertices @ rotation)
        worn.append(WornWall(region.name, "mm", own, depths))
    return worn


def depth_on(table: PatchTable, s: int, wear: Wear, time: float, points: np.ndarray) -> np.ndarray:
    """Return the depth [m] after some `time` [s] at points [m] (..., 3) of surface `s`, in its own axes."""
    grid = time * wear.depth[int(table.first[s]) : int(table.first[s + 1])]
    radial = int(table.kind[s]) == ANGLE_RADIUS
    return depth_at(points, grid.reshape(-1, int(table.rows[s])), radial, *table.range[s])


def depth_at(points: np.ndarray, grid: np.ndarray, radial: bool, low: float, high: float) -> np.ndarray:
    """Return the depth [m] at points in surface axes [m] (..., 3), on straight lines between the middles of
    the patches.

    Parameters
    ----------
    grid : depth of the patches [m] (n_azimuth, n_along); the azimuth is periodic
    radial : whether the second coordinate is the distance from the z axis, not z
    low, high : ends of the second coordinate [m]
    """
    sectors, rows = grid.shape
    across = np.hypot(points[..., 0], points[..., 1]) if radial else points[..., 2]
    place = np.clip((across - low) / (high - low) * rows - 0.5, 0.0, rows - 1.0)
    turn = np.arctan2(points[..., 1], points[..., 0]) / (2.0 * np.pi) * sectors - 0.5
    i, j = np.floor(turn).astype(int), np.minimum(np.floor(place).astype(int), max(rows - 2, 0))
    u, v = turn - i, place - j
    right, up = (i + 1) % sectors, np.minimum(j + 1, rows - 1)
    i = i % sectors
    return (1.0 - u) * ((1.0 - v) * grid[i, j] + v * grid[i, up]) + u * (
        (1.0 - v) * grid[right, j] + v * grid[right, up]
    )


def worn_corners(mesh: Mesh, depths: np.ndarray) -> np.ndarray:
    """Return the vertices [m] (V, 3) after every triangle has moved by its depth away from the charge.

    A vertex moves so that the planes of its triangles move by their depths, in the sense of least squares
    weighed by their angles there; where they are nearly one plane, along its normal.

    Parameters
    ----------
    depths : depth at the corners of each triangle [m] (T, 3)

    Source
    ------
    J. A. Baerentzen and H. Aanaes, IEEE Trans. Vis. Comput. Graph. 11 (2005) 243-253: weights by angle do
    not depend on how a facet is cut into triangles
    """
    corners = mesh.vertices[mesh.faces]
    normals, _ = normals_and_areas(corners)
    matrix, force = np.zeros((len(mesh.vertices), 3, 3)), np.zeros((len(mesh.vertices), 3))
    for k in range(3):
        a, b = (corners[:, (k + step) % 3] - corners[:, k] for step in (1, 2))
        angle = np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(axis=1))
        np.add.at(matrix, mesh.faces[:, k], angle[:, None, None] * normals[:, :, None] * normals[:, None, :])
        np.add.at(force, mesh.faces[:, k], (angle * depths[:, k])[:, None] * normals)
    inverse = np.linalg.pinv(matrix, rcond=BEND, hermitian=True)
    return mesh.vertices - np.einsum("vij,vj->vi", inverse, force)


def _refuse_turned(mesh: Mesh, moved: np.ndarray, name: str, time: float) -> None:
    """Raise CaseError where wear has turned triangles over."""
    before, _ = normals_and_areas(mesh.vertices[mesh.faces])
    after, _ = normals_and_areas(moved[mesh.faces])
    turned = int(((before * after).sum(axis=1) <= 0.0).sum())
    if turned:
        what = f"after {shown(time, 'h')} the wear is deeper than its triangles are large, {turned} turn over"
        raise CaseError(Fault(name, what, "Take a shorter time, run again with the worn mesh, and repeat"))
