"""A result as one VTKHDF file, which ParaView 5.13 or newer plays: the charge and the parts of the machine
over time.

Layout: a PartitionedDataSetCollection of PolyData, each with its ``Steps``; what does not
change (triangles, radii) is stored once, points per step.  HDF5's newest layout is not used and nothing but
gzip compresses, because VTK reads neither the one nor the other.

Source: VTK, "VTKHDF file format", version 2.3 (docs.vtk.org)
"""

from pathlib import Path

import h5py
import numpy as np

from nutamill.analysis.replay import Frame, chosen_snapshots, replay
from nutamill.analysis.source import any_case_of
from nutamill.base.atomic_file import check_writable, replace_file
from nutamill.result import Result
from nutamill.view.drawing import Part
from nutamill.view.drawn import drawn

VERSION = (2, 3)
SUFFIXES = (".vtkhdf", ".hdf")
"""Ends of the file names that ParaView reads as VTKHDF."""
PACKED = {"compression": "gzip", "shuffle": True}
CELLS = ("Vertices", "Lines", "Polygons", "Strips")
CHARGE = "charge"


def write_vtkhdf(result: Result, path: str | Path) -> Path:
    """Write all snapshots of a result for ParaView, and return the path.

    The charge carries ``velocity`` [m/s] and ``radius`` [m], for glyphs or point Gaussians, and
    ``contact_force`` [N] and ``material`` where the snapshots hold them.  Each part of the machine is a
    surface.

    Raises
    ------
    CaseError : a file name that does not end as ParaView wants it
    ResultError : no snapshots, or the file cannot be written
    """
    path = Path(path)
    check_writable(path, SUFFIXES)
    numbers = chosen_snapshots(result)
    parts = drawn(any_case_of(result), walls=result.walls).parts
    particles = len(result.snapshots[0].get("radii", ()))
    numbers_in_all = len(numbers) * (9 * particles + 3 * sum(len(part.vertices) for part in parts))

    def fill(part: Path) -> None:
        with h5py.File(part, "w", libver=("earliest", "v110")) as file:
            _fill(file, result, numbers, parts, particles)

    replace_file(path, fill, room=4 * numbers_in_all + 2**22, start=b"")
    return path


def _fill(
    file: h5py.File, result: Result, numbers: list[int], parts: tuple[Part, ...], particles: int
) -> None:
    """Write the whole file."""
    times = result.snapshots.time[numbers]
    root = file.create_group("VTKHDF", track_order=True)
    _is_a(root, "PartitionedDataSetCollection")
    assembly = root.create_group("Assembly", track_order=True)
    groups = {}
    for index, part in enumerate(parts):
        groups[part.name] = _surface(root, part, times)
        _listed(root, assembly, part.name, index)
    if particles:
        groups[CHARGE] = _cloud(root, result.snapshots[numbers[0]], times)
        _listed(root, assembly, CHARGE, len(parts))
    for step, (frame, number) in enumerate(zip(replay(result, numbers), numbers, strict=True)):
        for part in parts:
            pose = frame.bodies[part.body]
            _put(groups[part.name], step, pose.origin + part.vertices @ pose.rotation.T)
        if particles:
            _put_charge(groups[CHARGE], step, frame, result.snapshots[number])


def _surface(root: h5py.Group, part: Part, times: np.ndarray) -> h5py.Group:
    """Write a part of the machine: triangles once, points per step."""
    group = _poly_data(root, part.name, times, len(part.vertices), {"Polygons": part.triangles})
    group["Steps"].create_group("PointDataOffsets")
    return group


def _cloud(root: h5py.Group, first: dict, times: np.ndarray) -> h5py.Group:
    """Write the charge: a vertex for each particle once, points and what they carry per step."""
    n, steps = len(first["radii"]), len(times)
    group = _poly_data(root, CHARGE, times, n, {"Vertices": np.arange(n)[:, None]})
    carried, offsets = group.create_group("PointData"), group["Steps"].create_group("PointDataOffsets")
    for name, width in (("velocity", 3), *((name, 1) for name, array in _SCALARS.items() if array in first)):
        shape = (steps * n, width) if width > 1 else (steps * n,)
        carried.create_dataset(name, shape, "f4", chunks=(n, *shape[1:]), **PACKED)
        offsets[name] = n * np.arange(steps)
    carried["radius"] = first["radii"]
    offsets["radius"] = np.zeros(steps, int)
    return group


_SCALARS = {"contact_force": "contact_forces", "material": "materials"}
"""Point data of the charge and the arrays of snapshots they come from."""


def _poly_data(
    root: h5py.Group, name: str, times: np.ndarray, n: int, cells: dict[str, np.ndarray]
) -> h5py.Group:
    """Create an empty PolyData of `n` points per step whose cells never change."""
    group, steps = root.create_group(name, track_order=True), len(times)
    _is_a(group, "PolyData")
    group["NumberOfPoints"] = np.full(steps, n)
    group.create_dataset("Points", (steps * n, 3), "f4", chunks=(n, 3), **PACKED)
    timing = group.create_group("Steps")
    timing.attrs["NSteps"] = steps
    timing["Values"] = times
    timing["PartOffsets"] = np.arange(steps)
    timing["NumberOfParts"] = np.ones(steps, int)
    timing["PointOffsets"] = n * np.arange(steps)
    timing["CellOffsets"] = np.zeros((steps, len(CELLS)), int)
    timing["ConnectivityIdOffsets"] = np.zeros((steps, len(CELLS)), int)
    for kind in CELLS:
        corners = cells.get(kind, np.empty((0, 1), int))
        cells = group.create_group(kind)
        cells["NumberOfCells"] = np.full(steps, len(corners))
        cells["NumberOfConnectivityIds"] = np.full(steps, corners.size)
        cells["Offsets"] = np.arange(len(corners) + 1) * corners.shape[1]
        cells["Connectivity"] = corners.astype(np.int64).ravel()
    return group


def _put(group: h5py.Group, step: int, points: np.ndarray) -> None:
    group["Points"][step * len(points) : (step + 1) * len(points)] = points


def _put_charge(group: h5py.Group, step: int, frame: Frame, snapshot: dict) -> None:
    """Write places and what they carry of one step."""
    _put(group, step, frame.positions)
    rows = slice(step * len(frame.positions), (step + 1) * len(frame.positions))
    group["PointData/velocity"][rows] = frame.velocities
    for name, array in _SCALARS.items():
        if array in snapshot:
            group[f"PointData/{name}"][rows] = snapshot[array]


def _is_a(group: h5py.Group, kind: str) -> None:
    """Write the two attributes of the kind of a group. VTK wants a text of fixed length."""
    group.attrs["Version"] = np.array(VERSION, "i8")
    group.attrs.create("Type", np.bytes_(kind), dtype=h5py.string_dtype("ascii", len(kind)))


def _listed(root: h5py.Group, assembly: h5py.Group, name: str, index: int) -> None:
    """Give a part its number and its place in the tree that ParaView shows."""
    root[name].attrs["Index"] = index
    branch = assembly.create_group(name.replace(" ", "_"), track_order=True)
    branch[name] = h5py.SoftLink(f"/VTKHDF/{name}")
