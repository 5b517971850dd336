"""A closed triangle mesh as a wall: checked, and cut into smooth patches.

The one rule of orientation: a mesh bounds a solid and its normals point out of that solid (corners
counter-clockwise, seen from outside), as every drawing program writes it.  ``keep`` names the side of the
charge: ``"outside"`` of a rib or of a vessel drawn as a body, ``"inside"`` of a mesh that is the room
itself.  In a `Mesh` all normals point to the charge.

A *patch* is a smooth part: triangles joined by edges that bend little.  A particle has at most one contact
with a patch, as with a plane or a cylinder, and one memory of friction for it, which survives the seams
between its triangles.  An edge parts two patches if it bends by more than `CREASE`, or if it is hollow and
bends so tightly that a particle does not fit into the round: there a particle touches both flanks at once, so
they must not be one patch.
"""

import functools
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy import ndimage
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from nutamill.base.errors import CaseError, Fault
from nutamill.base.units import in_unit
from nutamill.charge.walls.triangles import (
    cells_near,
    directed_edges,
    normals_and_areas,
    signed_volumes,
    winding_number,
)

CREASE = np.radians(40.0)
"""An edge that bends more parts two patches [rad]."""

FLAT = np.radians(0.2)
"""An edge that bends less never does [rad]: a flat face in a file is flat to a few digits only."""

SAME = 1e-6
"""Corners nearer than this share of the mesh's diagonal are one; files in single precision keep seven digits
[1].
"""

MOST_TRIANGLES = 500_000
"""Triangles of one mesh [1]."""

TRIANGLES_PER_GIGABYTE = 500_000
"""About the number of triangles that take 1 GB while the walls are made [1]."""

NAMED = 5
"""Triangles that a message names [1]."""

SIDE_CELLS = 40
"""Cells along the longest side of the grid that separates inside and outside [1]."""


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """A closed mesh whose normals point to the charge; made by `closed_mesh`.

    Attributes
    ----------
    name : for messages
    vertices : corners [m] (V, 3)
    faces : corners of each triangle [1] (T, 3), counter-clockwise seen from the charge
    patch : number of the patch of each triangle [1] (T,)
    keep : the side of the solid the charge is on
    volume : of the solid [m^3]
    """

    name: str
    vertices: np.ndarray
    faces: np.ndarray
    patch: np.ndarray
    keep: Literal["inside", "outside"]
    volume: float

    @property
    def n_patches(self) -> int:
        """Number of patches [1]."""
        return int(self.patch.max()) + 1

    @property
    def corners(self) -> np.ndarray:
        """Corners of each triangle [m] (T, 3, 3)."""
        return self.vertices[self.faces]


def closed_mesh(
    name: str,
    vertices: np.ndarray,
    faces: np.ndarray,
    keep: Literal["inside", "outside"],
    particle_radius: float,
) -> Mesh:
    """Return a wall of triangles, checked and cut into patches.

    Parameters
    ----------
    name : for messages, say the file
    vertices, faces : corners [m] (V, 3) and the corners of each triangle [1] (T, 3), normals out of the
        solid; corners may be repeated
    keep : the side of the solid the charge is on
    particle_radius : of the largest particle [m]; hollow edges rounder than it do not part patches

    Raises
    ------
    CaseError : triangles that are degenerate, double, turned, without a neighbour or with too many, or a mesh
        inside out; each fault names its triangles, counted from 1
    """
    vertices, faces = np.array(vertices, float), np.array(faces, int)
    if (
        len(faces) == 0
        or vertices.ndim != 2
        or vertices.shape[1] != 3
        or faces.ndim != 2
        or faces.shape[1] != 3
    ):
        raise CaseError(
            Fault(name, f"must be triangles, got arrays of shape {vertices.shape} and {faces.shape}")
        )
    if len(faces) > MOST_TRIANGLES:
        raise CaseError(_too_fine(name, len(faces), particle_radius))
    if not np.isfinite(vertices).all() or faces.min() < 0 or faces.max() >= len(vertices):
        raise CaseError(Fault(name, "must have finite corners, and triangles of corners that are there"))
    tolerance = SAME * float(np.linalg.norm(np.ptp(vertices, axis=0)))
    vertices, faces = _joined(vertices, faces, tolerance)
    faults = _triangle_faults(name, vertices, faces, tolerance)
    # each check needs a mesh that passes the one before
    faults = faults or _edge_faults(name, vertices, faces)
    faults = faults or _shell_faults(name, vertices, faces)
    if faults:
        raise CaseError(*faults)
    volume = float(signed_volumes(vertices[faces]).sum())
    if keep == "inside":
        faces = faces[:, ::-1].copy()
    return Mesh(name, vertices, faces, _cut(vertices, faces, particle_radius), keep, volume)


def _too_fine(name, n, particle_radius) -> Fault:
    """Return the message of a mesh of `n` triangles, more than there can be."""
    gigabytes = n / TRIANGLES_PER_GIGABYTE
    chord = f"{in_unit(0.01 * particle_radius, 'mm'):.2g} mm"
    what = f"must have at most {MOST_TRIANGLES} triangles, got {n}, which take about {gigabytes:.1f} GB"
    hint = (
        f"Export it with a coarser tolerance: a distance of {chord} from the drawing, a hundredth of a "
        "particle's radius, is fine enough"
    )
    return Fault(name, what, hint)


def _joined(vertices, faces, tolerance) -> tuple[np.ndarray, np.ndarray]:
    """Merge corners that are equal but for rounding: an STL file repeats each corner in every triangle."""
    vertices, index = np.unique(vertices, axis=0, return_inverse=True)
    faces = index.reshape(-1)[faces]
    pairs = cKDTree(vertices).query_pairs(tolerance, output_type="ndarray")
    n = len(vertices)
    _, group = connected_components(coo_matrix((np.ones(len(pairs)), pairs.T), (n, n)), directed=False)
    _, first, index = np.unique(group, return_index=True, return_inverse=True)
    return vertices[first], index[faces]


def _listed(triangles) -> str:
    """Return the numbers of triangles, counted from 1, the first few."""
    shown = ", ".join(str(int(t) + 1) for t in triangles[:NAMED])
    return shown + (f" and {len(triangles) - NAMED} more" if len(triangles) > NAMED else "")


def _triangle_faults(name, vertices, faces, tolerance) -> list[Fault]:
    """Return triangles without area, and triangles that are given twice."""
    faults = []
    corners = vertices[faces]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    _, areas = normals_and_areas(corners)
    thin = np.flatnonzero(2.0 * areas <= tolerance * longest)
    if len(thin):
        what = (
            "every triangle must have an area, these are degenerate (two corners the same, or all in a "
            f"line): {_listed(thin)}"
        )
        faults.append(Fault(f"{name}: triangle {thin[0] + 1}", what, "Clean the mesh of degenerate faces"))
    _, first, index = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_inverse=True)
    twice = np.flatnonzero(first[index.reshape(-1)] != np.arange(len(faces)))
    if len(twice):
        original = int(first[index.reshape(-1)[twice[0]]])
        what = (
            f"a triangle must be given once, this one repeats triangle {original + 1}; repeated: "
            f"{_listed(twice)}"
        )
        faults.append(Fault(f"{name}: triangle {twice[0] + 1}", what, "Clean the mesh of double faces"))
    return faults


def _edge_faults(name, vertices, faces) -> list[Fault]:
    """Return edges with one triangle or more than two, and triangles turned against their neighbours."""
    faults = []
    edges, of_side, upward = directed_edges(faces)
    count = np.bincount(of_side.ravel(), minlength=len(edges))
    for bad, must, hint in (
        (
            count == 1,
            "closed: each edge must have two triangles, this one has no neighbour",
            "Close the holes",
        ),
        (
            count > 2,
            "simple: each edge must have two triangles, one has more",
            "Give touching solids as meshes of their own",
        ),
    ):
        if bad.any():
            triangles = np.flatnonzero(bad[of_side].any(axis=1))
            a, b = vertices[edges[np.flatnonzero(bad)[0]]]
            first = np.flatnonzero((of_side == np.flatnonzero(bad)[0]).any(axis=1))
            where = f"{name}: triangle{'s' if len(first) > 1 else ''} {_listed(first)}"
            what = (
                f"the mesh must be {must}, from {_point(a)} to {_point(b)}; triangles with such edges: "
                f"{_listed(triangles)}"
            )
            faults.append(Fault(where, what, hint))
    turned = np.zeros(0, int) if faults else _turned(faces, of_side, upward, len(edges))
    if len(turned):
        what = (
            "all triangles must turn the same way, these are inverted against their neighbours: "
            f"{_listed(turned)}"
        )
        faults.append(
            Fault(f"{name}: triangle {turned[0] + 1}", what, "Make the normals consistent, out of the solid")
        )
    return faults


def _point(p) -> str:
    return "(" + ", ".join(f"{in_unit(x, 'mm'):.4g}" for x in p) + ") mm"


def _neighbours(of_side, n_edges) -> np.ndarray:
    """Return the two triangles of each edge [1] (E, 2), of a mesh whose edges all have two."""
    return (np.argsort(of_side.ravel(), kind="stable") // 3).reshape(n_edges, 2)


def _groups(n, pairs) -> np.ndarray:
    """Return the number of the connected group of each of `n` triangles, in the order of their first."""
    _, group = connected_components(coo_matrix((np.ones(len(pairs)), pairs.T), (n, n)), directed=False)
    _, first, index = np.unique(group, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(first))[index]


def _turned(faces, of_side, upward, n_edges) -> np.ndarray:
    """Return triangles that turn against the greater part of their shell: the two triangles of an edge must
    pass it in opposite ways.
    """
    pairs = _neighbours(of_side, n_edges)
    way = upward.ravel()[np.argsort(of_side.ravel(), kind="stable")].reshape(n_edges, 2)
    agreeing = _groups(len(faces), pairs[way[:, 0] != way[:, 1]])
    shell = _groups(len(faces), pairs)
    size = np.bincount(agreeing)
    right = {s: max(np.unique(agreeing[shell == s]), key=lambda g: size[g]) for s in range(shell.max() + 1)}
    return np.flatnonzero([right[s] != a for s, a in zip(shell, agreeing, strict=True)])


def _shell_faults(name, vertices, faces) -> list[Fault]:
    """Return shells whose normals point into the solid.

    The shell of a cavity is within another and points into the cavity.
    """
    edges, of_side, _ = directed_edges(faces)
    shell = _groups(len(faces), _neighbours(of_side, len(edges)))
    corners = vertices[faces]
    volumes = np.bincount(shell, signed_volumes(corners - corners[0, 0]))
    faults = []
    for s, volume in enumerate(volumes):
        first = int(np.flatnonzero(shell == s)[0])
        within = (
            round(float(winding_number(corners[first, :1], corners[shell != s])[0]))
            if len(volumes) > 1
            else 0
        )
        where = f"{name}: triangle {first + 1}"
        if volume < 0.0 and within <= 0:
            what = (
                f"the normals must point out of the solid, this shell of {(shell == s).sum()} triangles "
                "is inverted"
            )
            faults.append(Fault(where, what, "Flip the normals"))
        elif volume > 0.0 and within > 0:
            what = f"shells must not be inside each other, this shell of {(shell == s).sum()} triangles does"
            faults.append(
                Fault(
                    where,
                    what,
                    "Give solids that overlap as meshes of their own; the normals of a cavity point into it",
                )
            )
    return faults


def _cut(vertices, faces, particle_radius) -> np.ndarray:
    """Return the number of the smooth patch of each triangle."""
    edges, of_side, _ = directed_edges(faces)
    pairs = _neighbours(of_side, len(edges))
    corners = vertices[faces]
    normals, areas = normals_and_areas(corners)
    first, second = normals[pairs[:, 0]], normals[pairs[:, 1]]
    bend = np.arctan2(np.linalg.norm(np.cross(first, second), axis=1), (first * second).sum(axis=1))
    # seen from the charge an edge is hollow if the other triangle rises in front of the first
    rise = corners[pairs[:, 1]].mean(axis=1) - vertices[edges[:, 0]]
    hollow = (rise * first).sum(axis=1) > 0.0
    length = np.linalg.norm(vertices[edges[:, 1]] - vertices[edges[:, 0]], axis=1)
    # radius of the round a row of such strips makes: width of a strip (height of its triangles over the edge)
    # over the bend
    radius = (areas[pairs].sum(axis=1) / length) / np.maximum(bend, 1e-12)
    parted = (bend > CREASE) | (hollow & (bend > FLAT) & (radius < particle_radius))
    return _groups(len(faces), pairs[~parted])


def on_charge_side(mesh: Mesh, points: np.ndarray) -> np.ndarray:
    """Return whether each of the `points` [m] (n, 3), in the mesh's axes, is on the side of the charge (n,).

    The winding number decides, in each of the regions that the triangles leave of a coarse grid once, and for
    points in a cell that a triangle passes for each.
    """
    corners = mesh.corners
    corner, size, regions, within = _sides(mesh)
    index = np.floor((points - corner) / size).astype(int)
    gridded = ((index >= 0) & (index < regions.shape)).all(axis=1)
    region = regions[tuple(np.where(gridded[:, None], index, 0).T)]
    wound = np.where(gridded, within[region], 0.0)
    close = gridded & (region == 0)
    wound[close] = winding_number(points[close], corners)
    return np.round(wound) == (0.0 if mesh.keep == "outside" else -1.0)


@functools.lru_cache(maxsize=16)
def _sides(mesh: Mesh) -> tuple[np.ndarray, float, np.ndarray, np.ndarray]:
    """Return low corner [m] (3,) and cell size [m] of a coarse grid around a mesh, the region of each cell
    that no triangle passes (0 where one does), and the winding number of each region.
    """
    corners = mesh.corners
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    size = float((high - low).max()) / SIDE_CELLS
    corner, cells = low - 1.5 * size, np.ceil((high - low) / size).astype(int) + 3
    passed = np.zeros(cells, bool)
    first, last = (
        np.floor((end - corner) / size).astype(int) for end in (corners.min(axis=1), corners.max(axis=1))
    )
    # of a triangle smaller than a cell, all cells of the box around it
    small = (last - first <= 1).all(axis=1)
    for offset in np.ndindex(2, 2, 2):
        passed[tuple(np.minimum(first[small] + offset, last[small]).T)] = True
    numbers = passed.reshape(-1)
    for triangle in corners[~small]:
        # half the diagonal of a cell, and a little
        numbers[cells_near(triangle, corner, size, cells, 0.87 * size)[0]] = True
    regions, _ = ndimage.label(~passed)
    return corner, size, regions, winding_of_regions(regions, corners, corner, size)


def winding_of_regions(
    regions: np.ndarray, corners: np.ndarray, corner: np.ndarray, size: float
) -> np.ndarray:
    """Return the winding number of each connected region of free cells by its number, 0 unused."""
    numbers, first = np.unique(regions, return_index=True)
    middles = corner + size * (np.stack(np.unravel_index(first, regions.shape), axis=1) + 0.5)
    out = np.zeros(int(numbers.max()) + 1)
    free = numbers > 0
    out[numbers[free]] = winding_number(middles[free], corners)
    return out
