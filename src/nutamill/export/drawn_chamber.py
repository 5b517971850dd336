"""The exact walls of a cylindrical region as one closed mesh: bore, floor and ceiling."""

import itertools
from typing import NamedTuple

import numpy as np

from nutamill.base.errors import CaseError, Fault
from nutamill.base.required import required
from nutamill.case.machine import Machine
from nutamill.case.placement import region_axes
from nutamill.case.walls import RegionEntry
from nutamill.charge.walls.mesh import Mesh, closed_mesh
from nutamill.charge.walls.surface import Surface, SurfaceKind
from nutamill.simulation.setup.walls import world_surfaces

FACETS = 72
"""Facets around the bore [1]: their prism has 0.13 % less volume than the cylinder."""
ROWS = 30
"""Rows of triangles along the bore, and from the middle of floor and ceiling to the rim [1]."""
NEAR = 1e-9
"""Distance within which a corner is on a wall [m]."""
FLAT = (SurfaceKind.PLANE, SurfaceKind.DISC)
ROUND = (SurfaceKind.CYLINDER, SurfaceKind.TUBE)


class DrawnChamber(NamedTuple):
    """A region's walls as a mesh, world axes as assembled."""

    mesh: Mesh
    """Its triangles, normals to the charge."""
    wall_of: np.ndarray
    """Number of the surface that each triangle is on [1] (T,)."""


def drawn_chamber(machine: Machine, region: RegionEntry) -> DrawnChamber:
    """Return the walls of a cylindrical region as a mesh.

    Raises
    ------
    CaseError : a region of another shape, ribs or other walls within it, or ends without a wall
    """
    surfaces = world_surfaces(machine)
    own = [wall for wall in machine.walls if wall.body == region.body]
    shapes = {"cylinder", "tube", "plane", "disc"}
    others = [wall.name for wall in own if wall.shape not in shapes]
    if region.shape != "cylinder" or others:
        what = "can be written worn if it is a smooth cylinder with flat ends"
        got = f"has the walls {', '.join(others)}" if others else f"is a {region.shape}"
        raise CaseError(Fault(region.name, f"{what}, this one {got}", "Draw it as a mesh ([chamber.mesh])"))
    vertices, faces = _can(required(region.radius), required(region.height))
    vertices = np.array(region.point) + vertices @ region_axes(region).T
    mesh = closed_mesh(region.name, vertices, faces, "inside", 0.0)
    wall_of = np.full(len(mesh.faces), -1)
    for s, surface in enumerate(surfaces):
        on = is_on(surface, mesh.vertices)
        wall_of[on[mesh.faces].all(axis=1) & (wall_of < 0)] = s
    if (wall_of < 0).any():
        what = f"{int((wall_of < 0).sum())} of {len(wall_of)} triangles of its cylinder are on no wall"
        raise CaseError(Fault(region.name, what, "Draw it as a mesh ([chamber.mesh])"))
    return DrawnChamber(mesh, wall_of)


def is_on(surface: Surface, points: np.ndarray) -> np.ndarray:
    """Return whether points [m] (n, 3) are on a plane, disc, cylinder or tube, in the axes it is given in."""
    local = (points - surface.origin) @ np.asarray(surface.rotation)
    if surface.kind in FLAT:
        return np.abs(local[:, 2]) < NEAR
    if surface.kind in ROUND:
        return np.abs(np.hypot(local[:, 0], local[:, 1]) - surface.size[0]) < NEAR
    return np.zeros(len(points), bool)


def _can(radius: float, height: float) -> tuple[np.ndarray, np.ndarray]:
    """Return corners [m] and triangles of a closed cylinder on z = 0, normals outwards."""
    angle = 2.0 * np.pi * np.arange(FACETS) / FACETS
    around = np.column_stack([np.cos(angle), np.sin(angle)])
    # rings from the middle of the floor up the bore to the middle of the ceiling
    out, up = np.linspace(0.0, 1.0, ROWS + 1)[1:], np.linspace(0.0, 1.0, ROWS + 1)
    scale = np.concatenate([out, np.ones(ROWS), out[::-1][1:]])
    level = np.concatenate([np.zeros(ROWS), up[1:], np.ones(ROWS - 1)])
    rings = [
        np.column_stack([radius * r * around, np.full(FACETS, height * z)])
        for r, z in zip(scale, level, strict=True)
    ]
    vertices = np.concatenate([[[0.0, 0.0, 0.0]], *rings, [[0.0, 0.0, height]]])
    first = 1 + FACETS * np.arange(len(rings))
    here, there = np.arange(FACETS), (np.arange(FACETS) + 1) % FACETS
    faces = [np.column_stack([np.zeros(FACETS, int), first[0] + there, first[0] + here])]
    for low, high in itertools.pairwise(first):
        faces.append(np.column_stack([low + here, low + there, high + there]))
        faces.append(np.column_stack([low + here, high + there, high + here]))
    last = np.full(FACETS, len(vertices) - 1)
    faces.append(np.column_stack([first[-1] + here, first[-1] + there, last]))
    return vertices, np.concatenate(faces)
