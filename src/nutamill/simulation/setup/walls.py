"""The walls of a machine as surfaces of the charge engine, and the mesh files of some of them.

The only room that imports trimesh, which is an optional package.
"""

import dataclasses
import functools
import hashlib
import logging
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np

from nutamill.base.errors import CaseError, Fault, missing_extra
from nutamill.base.required import required
from nutamill.base.units import in_unit, shown, si_value
from nutamill.case.machine import Machine
from nutamill.case.placement import axes_along, shape_corners
from nutamill.case.walls import RegionEntry, WallEntry
from nutamill.charge.walls.mesh import Mesh, closed_mesh
from nutamill.charge.walls.mesh_patches import mesh_surfaces
from nutamill.charge.walls.surface import Surface, SurfaceKind
from nutamill.result import WallMesh
from nutamill.simulation.setup.carriers import Carrier, carriers_of

FORMATS = (".stl", ".obj")
"""Suffixes of the files that are read."""

FAR_OFF = 30.0
"""Ratio of sizes from which the unit counts as wrong [1]; units differ by 10 at least, most by 1000."""

FACES = {"-x": (0, -1.0), "+x": (0, 1.0), "-y": (1, -1.0), "+y": (1, 1.0), "-z": (2, -1.0), "+z": (2, 1.0)}
"""Faces of a box: axis and sign of the outward normal."""


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


def material_order(machine: Machine) -> list[str]:
    """Return the names of the materials of the charge, then of the walls it touches, in the order of their
    numbers in the engine.
    """
    return list(dict.fromkeys([*machine.charge.materials, *machine.wall_materials.values()]))


def wall_surfaces(machine: Machine) -> list[Surface]:
    """Return the walls as surfaces in the axes of the bodies that carry them, from their mass centres.

    Raises
    ------
    CaseError : a mesh file that cannot be used
    """
    carriers = carriers_of(machine)
    return [seen_from(surface, carriers[surface.body]) for surface in world_surfaces(machine)]


def seen_from(surface: Surface, carrier: Carrier) -> Surface:
    """Return a surface given in world axes in those of a body, from its mass centre."""
    rotation = carrier.rotation
    return dataclasses.replace(
        surface,
        origin=rotation.T @ (np.asarray(surface.origin) - carrier.position),
        rotation=rotation.T @ np.asarray(surface.rotation),
    )


@functools.lru_cache(maxsize=8)
def world_surfaces(machine: Machine) -> tuple[Surface, ...]:
    """Return the walls as surfaces in world axes as assembled. Raises as `wall_surfaces` does."""
    names, materials = [carrier.name for carrier in carriers_of(machine)], material_order(machine)
    return tuple(
        surface
        for wall in machine.walls
        for surface in _surfaces_of(machine, wall, names.index(wall.body), materials.index(wall.material))
    )


def _surfaces_of(machine: Machine, wall: WallEntry, body: int, material: int) -> list[Surface]:
    """Return the surfaces of one wall, world axes as assembled."""
    point, axes = np.array(wall.point, float), axes_along(wall.axis, wall.across)
    if wall.shape == "mesh":
        pieces = mesh_surfaces(wall_mesh(machine, wall), body, material, list(point))
        return [dataclasses.replace(piece, rotation=axes) for piece in pieces]
    if wall.shape == "box" and wall.charge_side == "inside":
        half = 0.5 * np.array(wall.size)
        return [
            Surface(
                f"{wall.name} {face}",
                SurfaceKind.PLANE,
                body,
                material,
                point + sign * half[k] * axes[:, k],
                axes_along(-sign * axes[:, k], axes[:, (k + 1) % 3]),
            )
            for face, (k, sign) in FACES.items()
        ]
    if wall.shape == "rod":
        point = point + 0.5 * required(wall.height) * axes[:, 2]
    kind = SurfaceKind[wall.shape.upper()] if wall.shape != "cap" else SurfaceKind.SPHERE_CAP
    return [Surface(wall.name.replace("_", " "), kind, body, material, point, axes, _size(wall))]


def _size(wall: WallEntry) -> tuple[float, ...]:
    """Return the `Surface.size` of a wall."""
    if wall.shape == "plane":
        return 0.0, 0.0, 0.0
    if wall.shape == "box":
        return tuple(0.5 * length for length in required(wall.size))
    radius = required(wall.radius)
    if wall.shape == "tube":
        return radius, required(wall.height), 0.0
    if wall.shape == "rod":
        return radius, 0.5 * required(wall.height), 0.0
    if wall.shape == "cone":
        return radius, required(wall.end_radius), required(wall.height)
    if wall.shape == "cap":
        return radius, required(wall.angle), 0.0
    return radius, 0.0, 0.0


def meshed_walls(machine: Machine) -> list[WallEntry]:
    """Return the walls that are meshes."""
    return [wall for wall in machine.walls if wall.shape == "mesh"]


def wall_mesh(machine: Machine, wall: WallEntry) -> Mesh:
    """Return the mesh of a wall, in the axes of its file.

    Raises
    ------
    CaseError : the file is missing, differs from the one of the case, has no mesh, is not closed, or has
        another size than is expected of it
    """
    smallest, largest = _radii(machine)
    file, unit = required(wall.file), required(wall.unit)
    mesh = _read(file, wall.sha256, _metres(unit), wall.charge_side, largest)
    if wall.extent is None:
        return mesh
    low = wall.extent / FAR_OFF if wall.charge_side == "inside" else smallest
    size = float(np.linalg.norm(np.ptp(mesh.vertices, axis=0)))
    if low <= size <= FAR_OFF * wall.extent:
        if wall.charge_side == "outside":
            _refuse_elsewhere(machine, wall, mesh)
        return mesh
    fitting = [
        other
        for other in ("mm", "m", "cm", "in", "um")
        if low <= size / _metres(unit) * _metres(other) <= 3.0 * wall.extent
    ]
    what = f"{Path(file).name} in {unit} is {size:.3g} m large, the chamber is {wall.extent:.3g} m"
    hint = f'In {fitting[0]}? Write unit = "{fitting[0]}"' if fitting else "Check the file"
    raise CaseError(Fault(f"{machine.key_of_wall(wall.name)}.unit", what, hint))


def _refuse_elsewhere(machine: Machine, wall: WallEntry, mesh: Mesh) -> None:
    """Raise CaseError for a solid that reaches into no region of the charge on its body, in the axes of that
    body.
    """
    carrier = next(one for one in carriers_of(machine) if one.name == wall.body)
    solid = np.array(wall.point) + mesh.vertices @ axes_along(wall.axis, wall.across).T
    low, high = _box(solid @ carrier.rotation)
    for region in (one for one in machine.regions if one.body == wall.body):
        lowest, highest = _box(region_corners(machine, region) @ carrier.rotation)
        if (low <= highest).all() and (high >= lowest).all():
            return
    if all(one.body != wall.body for one in machine.regions):
        return
    axis = int(np.argmax(np.maximum(low - highest, lowest - high)))
    what = (
        f"{mesh.name} spans {'xyz'[axis]} = {_span(low[axis], high[axis])}, the {region.name} "
        f"{_span(lowest[axis], highest[axis])}"
    )
    hint = f"Move it into the {region.name}: look at its position and its unit"
    key = machine.key_of_wall(wall.name)
    raise CaseError(Fault(f"{key}.point" if key == f"walls.{wall.name}" else f"{key}.at", what, hint))


def _box(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return low and high corner of the box around points [m] (n, 3)."""
    return corners.min(axis=0), corners.max(axis=0)


def _span(low: float, high: float) -> str:
    return f"{in_unit(low, 'mm'):.4g} to {shown(high, 'mm')}"


@functools.lru_cache(maxsize=16)
def region_corners(machine: Machine, region: RegionEntry) -> np.ndarray:
    """Return the corners of a region [m] (n, 3), world as assembled.

    Those of a cylinder are points on its rims.
    """
    corners = shape_corners(region)
    if corners is not None:
        return corners
    return placed_corners(machine, next(wall for wall in machine.walls if wall.name == region.wall))


def placed_corners(machine: Machine, wall: WallEntry) -> np.ndarray:
    """Return the vertices [m] (n, 3) of a meshed wall, world as assembled."""
    return np.array(wall.point) + wall_mesh(machine, wall).vertices @ axes_along(wall.axis, wall.across).T


def placed_walls(machine: Machine) -> dict[str, WallMesh]:
    """Return every meshed wall in its position, by its key in the case, for the result."""
    carriers = {carrier.name: carrier for carrier in carriers_of(machine)}
    placed = {}
    for wall in meshed_walls(machine):
        mesh, carrier = wall_mesh(machine, wall), carriers[wall.body]
        corners = (placed_corners(machine, wall) - carrier.position) @ carrier.rotation
        # the triangles of a mesh around the charge look inwards
        faces = np.array(mesh.faces[:, :: -1 if mesh.keep == "inside" else 1], np.int32)
        placed[machine.stored_wall(wall.name)] = WallMesh(corners, faces, wall.body)
    return placed


def _radii(machine: Machine) -> tuple[float, float]:
    """Return the radius [m] of the smallest and of the largest particle of the charge, or 0 without one."""
    sizes = [diameter for part in machine.charge.parts for diameter in part.size_range] or [0.0]
    return min(sizes) / 2, max(sizes) / 2


def _metres(unit: str) -> float:
    return si_value(1.0, unit)


@functools.lru_cache(maxsize=32)
def _read(
    file: str, sha256: str, metres: float, keep: Literal["inside", "outside"], particle_radius: float
) -> Mesh:
    """Read the mesh of a file in metres, cut for particles up to a radius.

    Several rooms use it, so the result is cached.
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


def mesh_facts(machine: Machine) -> list[MeshFacts]:
    """Return the facts about the meshes of a machine."""
    meshes = [wall_mesh(machine, wall) for wall in meshed_walls(machine)]
    return [MeshFacts(mesh.name, len(mesh.faces), mesh.n_patches, mesh.volume) for mesh in meshes]


def digests(machine: Machine) -> dict[str, str]:
    """Return the SHA-256 of each mesh file of a machine by its key, for the provenance of a result."""
    return {
        f"{machine.stored_wall(wall.name)}.sha256": required(wall.sha256) for wall in meshed_walls(machine)
    }
