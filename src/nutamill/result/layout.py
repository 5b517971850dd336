"""What writer and reader of a result file share: the layout's words, its checks, and its small parts."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import h5py
import numpy as np

from nutamill.errors import ResultError

FORMAT = "nutamill result"
FORMAT_VERSION = 1
BEFORE = ("rows", "snapshots", "statistics")
"""Attributes of a checkpoint: how much had been recorded before it."""


class Checkpoint(NamedTuple):
    """A state kept for resuming."""

    time: float
    """Simulated time [s]."""
    groups: dict[str, dict[str, np.ndarray]]
    """Arrays of the state, in groups."""
    attributes: dict[str, Any]
    """Numbers and texts that belong to the state and are no arrays."""


class WallMesh(NamedTuple):
    """A meshed wall as the run had it, for pictures."""

    vertices: np.ndarray
    """Corners [m] (n, 3), chamber axes from the nutation point."""
    triangles: np.ndarray
    """Corners of each triangle [1], int32 (m, 3), counter-clockwise seen from outside the solid."""


def opened(path: Path) -> h5py.File:
    """The file, open for reading, checked to be ours and whole."""
    if not path.is_file():
        raise ResultError(f"{path}: must be a result file, there is none of this name. Look in results/ or run the case first.")
    try:
        file = h5py.File(path, "r")
    except OSError as fault:
        if h5py.is_hdf5(path):
            raise ResultError(
                f"{path}: must be whole, it is cut off or damaged ({fault}). Copy it again, or run the case again."
            ) from fault
        raise ResultError(f"{path}: must be a result file (HDF5), it is not. Give the .h5 file that `nutamill run` has written.") from fault
    if file.attrs.get("format") != FORMAT:
        file.close()
        raise ResultError(
            f"{path}: must be a result of nutamill, it is an HDF5 file of another kind. Give the file that `nutamill run` has written."
        )
    version = int(file.attrs["format_version"])
    if version > FORMAT_VERSION:
        file.close()
        raise ResultError(f"{path}: written by format {version}, this version reads up to {FORMAT_VERSION}. Update the package.")
    return file


def write_attributes(group: h5py.Group, values: Mapping[str, Any]) -> None:
    """Numbers and texts as attributes, nested tables as groups of attributes."""
    for key, value in values.items():
        if isinstance(value, Mapping):
            write_attributes(group.create_group(key), value)
        else:
            group.attrs[key] = value


def read_attributes(group: h5py.Group, inner: bool = True) -> dict[str, Any]:
    """What `write_attributes` wrote, as plain Python numbers and texts; `inner`: with the nested tables."""
    values = {key: value.item() if isinstance(value, np.generic) else value for key, value in group.attrs.items()}
    return values | ({key: read_attributes(table) for key, table in group.items()} if inner else {})
