"""Meshed walls after some time of wear, as mesh files for the next run."""

from pathlib import Path

import numpy as np

from nutamill.analysis.wear import Wear
from nutamill.base.atomic_file import write_whole
from nutamill.base.errors import CaseError, Fault
from nutamill.base.required import required
from nutamill.base.units import in_unit, shown
from nutamill.case.machine import Machine
from nutamill.charge.walls.mesh import Mesh
from nutamill.charge.walls.patches import ANGLE_RADIUS
from nutamill.charge.walls.triangles import normals_and_areas
from nutamill.simulation.setup.statistics import wall_patches
from nutamill.simulation.setup.walls import meshed_walls, world_surfaces

BEND = 0.01
"""Share of the largest eigenvalue below which the normals at a corner count as one direction [1]: facets of a
round that bend by less than 11 degrees.
"""


def write_worn(machine: Machine, wear: Wear, time: float, folder: Path) -> list[Path]:
    """Write the meshed walls of a machine after some `time` [s] of wear, each as OBJ in the axes and unit of
    its own file, and return the paths.

    Raises
    ------
    CaseError : no meshed wall, a mesh file that is missing or has changed, or so much wear that triangles
        turn over
    OutputError : the system refuses
    """
    walls = meshed_walls(machine)
    if not walls:
        what = "the walls of this machine are exact shapes, only meshes can be written worn"
        raise CaseError(Fault(wear.path, what, "Give the chamber as a mesh ([chamber.mesh])"))
    table, surfaces = wall_patches(machine), world_surfaces(machine)
    patches = [s for s, surface in enumerate(surfaces) if surface.mesh is not None]
    begins = [k for k, s in enumerate(patches) if surfaces[s].patch == 0]
    written = []
    for wall, first, end in zip(walls, begins, [*begins[1:], len(patches)], strict=True):
        own = patches[first:end]
        mesh, file = required(surfaces[own[0]].mesh), Path(required(wall.file))
        depths = np.zeros(mesh.faces.shape)
        for s in own:
            grid = time * wear.depth[int(table.first[s]) : int(table.first[s + 1])]
            faces = np.flatnonzero(mesh.patch == surfaces[s].patch)
            depths[faces] = depth_at(
                mesh.vertices[mesh.faces[faces]],
                grid.reshape(-1, int(table.rows[s])),
                int(table.kind[s]) == ANGLE_RADIUS,
                *table.range[s],
            )
        moved = worn_corners(mesh, depths)
        _refuse_turned(mesh, moved, file.name, time)
        text = [f"v {x!r} {y!r} {z!r}" for x, y, z in in_unit(moved, required(wall.unit)).tolist()]
        # the triangles of a mesh around the charge look inwards
        outwards = mesh.faces[:, :: -1 if mesh.keep == "inside" else 1] + 1
        text += [f"f {a} {b} {c}" for a, b, c in outwards.tolist()]
        path = folder / f"{wall.name}-worn-{in_unit(time, 'h'):g}h.obj"
        written.append(write_whole(path, ("\n".join(text) + "\n").encode()))
    return written


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
