"""Mesh files as walls: read them, check their size, and measure them before a run.

The only room that imports trimesh, which is an optional package.
"""

import functools
import hashlib
import logging
import math
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np

from nutamill.base.errors import CaseError, Fault, missing_extra
from nutamill.base.units import UNITS, Kind
from nutamill.case import Case
from nutamill.case.drawing import MeshFile
from nutamill.charge.filling.room import Room, cylinder_room
from nutamill.charge.walls.mesh import Mesh, closed_mesh
from nutamill.charge.walls.mesh_patches import mesh_surfaces
from nutamill.charge.walls.surface import Surface
from nutamill.charge.walls.triangles import normals_and_areas

FORMATS = (".stl", ".obj")
"""Suffixes of the files that are read."""

FAR_OFF = 30.0
"""Ratio of sizes from which the unit counts as wrong [1]; units differ by 10 at least, most by 1000."""


class MeshFacts(NamedTuple):
    """The facts about a mesh that `nutamill check` prints."""

    name: str
    """Name of the file."""
    triangles: int
    """Number of triangles [1]."""
    patches: int
    """Number of smooth patches [1]."""
    volume: float
    """Volume enclosed [m^3]."""
    volume_drawn: float | None
    """Volume of the chamber as drawn [m^3]; None for a wall."""
    off_drawing: float | None
    """Largest distance of the chamber's mesh from bore, floor and ceiling as drawn [m]; None for a wall."""


def meshes_surfaces(case: Case, body: int, materials: list[str], mass_centre: np.ndarray) -> list[Surface]:
    """Return the patches of the chamber's mesh, if it has one, and of the solids of ``[[walls]]``.

    Parameters
    ----------
    body : index of the chamber among the bodies that carry surfaces
    materials : names of the materials in the order of their numbers
    mass_centre : of the chamber [m] (3,), in chamber axes from the nutation point
    """
    surfaces = []
    for table, mesh in _meshes(case).values():
        material = case.chamber.material if table is case.chamber.mesh else table.material
        surfaces += mesh_surfaces(mesh, body, materials.index(material), np.array(table.at) - mass_centre)
    return surfaces


def chamber_mesh(case: Case) -> Mesh:
    """Return the space inside the chamber, in the axes of its file; the charge is inside.

    Raises
    ------
    CaseError : the file is missing, differs from the one of the case, has no mesh, is not closed, or has
        another size than the drawing
    """
    return _mesh(case, case.chamber.mesh, "inside", "chamber.mesh")


def wall_meshes(case: Case) -> list[Mesh]:
    """Return the solids of ``[[walls]]``, each in the axes of its file; the charge is outside.

    Raises
    ------
    CaseError : as `chamber_mesh`, or a solid outside the chamber
    """
    meshes = [_mesh(case, wall, "outside", f"walls[{number}]") for number, wall in enumerate(case.walls)]
    room = room_box(case) if meshes else None
    for number, (wall, mesh) in enumerate(zip(case.walls, meshes, strict=True)):
        placed = mesh.vertices + wall.at
        low, high = placed.min(axis=0), placed.max(axis=0)
        if (low > room[1]).any() or (high < room[0]).any():
            axis = int(np.argmax(np.maximum(low - room[1], room[0] - high)))
            what = (
                f"{mesh.name} spans {'xyz'[axis]} = {_span(low[axis], high[axis])}, the chamber "
                f"{_span(*room[:, axis])}"
            )
            hint = (
                "Move it into the chamber: `at` is the position of the file's origin in chamber axes from "
                "the nutation point"
            )
            raise CaseError(Fault(f"walls[{number}].at", what, hint))
    return meshes


def placed_walls(case: Case) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return every mesh of a case in its position, by its key in the case, for the result.

    Corners [m] (n, 3), chamber axes from the nutation point, and triangles [1], int32 (m, 3),
    counter-clockwise from outside the solid.
    """
    return {
        # the triangles of a mesh around the charge look inwards
        key: (
            mesh.vertices + table.at,
            np.array(mesh.faces[:, :: -1 if mesh.keep == "inside" else 1], np.int32),
        )
        for key, (table, mesh) in _meshes(case).items()
    }


def _tables(case: Case) -> dict[str, MeshFile]:
    """Return the tables of a case that name a mesh file, by their keys, the chamber's first."""
    chamber = {"chamber.mesh": case.chamber.mesh} if case.chamber.mesh is not None else {}
    return chamber | {f"walls[{number}]": wall for number, wall in enumerate(case.walls)}


def _meshes(case: Case) -> dict[str, tuple[MeshFile, Mesh]]:
    """Return table and mesh of each of `_tables`; raise as `chamber_mesh` and `wall_meshes`."""
    tables = _tables(case)
    chamber = [chamber_mesh(case)] if case.chamber.mesh is not None else []
    return {key: (tables[key], mesh) for key, mesh in zip(tables, chamber + wall_meshes(case), strict=True)}


def _span(low: float, high: float) -> str:
    return f"{1e3 * low:.4g} to {1e3 * high:.4g} mm"


def _mesh(case: Case, table: MeshFile, keep: Literal["inside", "outside"], where: str) -> Mesh:
    smallest, largest = _radii(case)
    mesh = _read(table.file, table.sha256, _metres(table), keep, largest)
    drawn = math.hypot(case.chamber.inner_diameter, case.chamber.inner_diameter, case.chamber.height)
    low = drawn / FAR_OFF if keep == "inside" else smallest
    size = float(np.linalg.norm(np.ptp(mesh.vertices, axis=0)))
    if low <= size <= FAR_OFF * drawn:
        return mesh
    fitting = [
        unit
        for unit in ("mm", "m", "cm", "in", "um")
        if low <= size / _metres(table) * UNITS[Kind.LENGTH][unit] <= 3.0 * drawn
    ]
    what = f"{Path(table.file).name} in {table.unit} is {size:.3g} m large, the chamber is {drawn:.3g} m"
    raise CaseError(
        Fault(
            f"{where}.unit",
            what,
            f'In {fitting[0]}? Write unit = "{fitting[0]}"' if fitting else "Check the file",
        )
    )


def _radii(case: Case) -> tuple[float, float]:
    """Return the radius [m] of the smallest and of the largest particle of the charge; 0 for an empty
    chamber.
    """
    sizes = [diameter for part in case.charge.parts for diameter in part.size_range] or [0.0]
    return min(sizes) / 2, max(sizes) / 2


def _metres(table: MeshFile) -> float:
    return UNITS[Kind.LENGTH][table.unit]


@functools.lru_cache(maxsize=32)
def _read(
    file: str, sha256: str, metres: float, keep: Literal["inside", "outside"], particle_radius: float
) -> Mesh:
    """Read the mesh of a file in metres, cut for particles up to a radius; cached, because several rooms use
    it.
    """
    path = Path(file)
    if path.suffix.lower() not in FORMATS:
        raise CaseError(
            Fault(
                path.name,
                f"must be a file of the kinds {' and '.join(FORMATS)}, got {path.suffix or 'no suffix'}",
            )
        )
    try:
        content = path.read_bytes()
    except OSError as error:
        what = f"cannot be read: {error.strerror} ({path})"
        raise CaseError(
            Fault(path.name, what, f"A run needs the mesh its case was made with, SHA-256 {sha256}")
        ) from None
    if hashlib.sha256(content).hexdigest() != sha256:
        what = "has changed since the case was read"
        raise CaseError(
            Fault(
                path.name,
                what,
                "Restore the file, or begin a new run; a case file needs no sha256",
            )
        )
    return closed_mesh(path.name, *_triangles(path, metres), keep, particle_radius)


def _triangles(path: Path, metres: float) -> tuple[np.ndarray, np.ndarray]:
    """Return corners [m] (V, 3) and triangles (T, 3) as in the file."""
    try:
        import trimesh
    except ImportError:
        raise missing_extra(f"{path.name}: reading a mesh", "the package trimesh", "mesh") from None
    logger = logging.getLogger("trimesh")
    level = logger.level
    try:
        logger.setLevel(logging.CRITICAL)  # it logs tracebacks of its attempts
        # neither merged nor repaired: triangles have the numbers of the file, and faults are refused
        loaded = trimesh.load_mesh(path, process=False)
        vertices, faces = np.asarray(loaded.vertices, float), np.asarray(loaded.faces, int)
    except Exception as error:  # trimesh has no class for a bad file
        raise CaseError(Fault(path.name, f"cannot be read as a mesh: {error}")) from None
    finally:
        logger.setLevel(level)
    if not len(faces):
        raise CaseError(Fault(path.name, "has no triangles", "Is it a mesh file, and whole?"))
    return metres * vertices, faces


def mesh_facts(case: Case) -> list[MeshFacts]:
    """Return the facts about the meshes of a case, the chamber's first."""
    facts = []
    if case.chamber.mesh is not None:
        mesh, chamber = chamber_mesh(case), case.chamber
        drawn = 0.25 * math.pi * chamber.inner_diameter**2 * chamber.height
        off = distance_from_drawing(case, mesh.corners + case.chamber.mesh.at)
        facts.append(MeshFacts(mesh.name, len(mesh.faces), mesh.n_patches, mesh.volume, drawn, off))
    return facts + [
        MeshFacts(m.name, len(m.faces), m.n_patches, m.volume, None, None) for m in wall_meshes(case)
    ]


def distance_from_drawing(case: Case, corners: np.ndarray) -> float:
    """Return the largest distance [m] of triangles `corners` [m] (T, 3, 3), in chamber axes from the nutation
    point, from the chamber as drawn.

    Sampled at corners, middles of sides and middles of triangles; a facet is farthest from a bore at the
    middle of a side.
    """
    chamber = case.chamber
    points = np.concatenate(
        [corners, 0.5 * (corners + np.roll(corners, 1, axis=1)), corners.mean(axis=1, keepdims=True)], axis=1
    )
    x, y, z = points.reshape(-1, 3).T
    out = np.hypot(x, y) - chamber.inner_diameter / 2
    over = np.maximum(-chamber.floor_depth - z, z + chamber.ceiling_depth)
    outside = np.hypot(np.maximum(out, 0.0), np.maximum(over, 0.0))
    return float(np.where((out > 0.0) | (over > 0.0), outside, -np.maximum(out, over)).max())


def free_volume(case: Case) -> float:
    """Return the free volume for the charge [m^3]: that of the chamber, as drawn or meshed, less the ribs and
    the solids of ``[[walls]]``.
    """
    chamber = case.chamber
    ribs = 0.25 * math.pi * chamber.inner_diameter**2 * chamber.height - chamber.free_volume
    room = chamber_mesh(case).volume - ribs if chamber.mesh is not None else chamber.free_volume
    return room - sum(mesh.volume for mesh in wall_meshes(case))


def charge_room(case: Case) -> Room:
    """Return the room that the charge is placed in: its free volume, and the area of chamber, ribs and meshed
    walls.
    """
    chamber, rib = case.chamber, case.chamber.rib
    height = min(rib.length, chamber.height) if rib else 0.0
    boxes = [((), (), np.array([rib.depth, rib.width, height]) / 2) for _ in range(chamber.ribs)]
    area = cylinder_room(
        0.5 * chamber.inner_diameter, 0.0, chamber.height, boxes
    ).area  # a mesh of it has about as much
    return Room(
        free_volume(case),
        area + sum(float(normals_and_areas(mesh.corners)[1].sum()) for mesh in wall_meshes(case)),
    )


def room_box(case: Case) -> np.ndarray:
    """Return low and high corner of a box around the chamber [m] (2, 3), in chamber axes from the nutation
    point.
    """
    chamber = case.chamber
    if chamber.mesh is not None:
        vertices = chamber_mesh(case).vertices + chamber.mesh.at
        return np.stack([vertices.min(axis=0), vertices.max(axis=0)])
    radius = chamber.inner_diameter / 2
    return np.array([[-radius, -radius, -chamber.floor_depth], [radius, radius, -chamber.ceiling_depth]])


def digests(case: Case) -> dict[str, str]:
    """Return the SHA-256 of each mesh file of a case by its key, for the provenance of a result."""
    return {f"{key}.sha256": table.sha256 for key, table in _tables(case).items()}
