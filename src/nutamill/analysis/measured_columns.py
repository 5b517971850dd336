"""Columns of test files: CSV, TDMS, MAT and UFF, each as times and values."""

import csv
import math
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from nutamill.analysis.measured_mapping import Mapping
from nutamill.base.errors import CaseError, Fault, missing_extra
from nutamill.base.files import is_file
from nutamill.base.library import similar


class Column(NamedTuple):
    """One channel of a test file."""

    values: np.ndarray
    """As recorded (n,)."""
    time: np.ndarray | None
    """Its times [s] (n,), where the file holds them."""


def read_columns(path: str | Path, mapping: Mapping) -> dict[str, Column]:
    """Return the columns a mapping names, by their names in the file.

    Raises
    ------
    CaseError : no such file, a kind of file that is not read, columns that are not there, rows that hold no
        number
    NotInstalledError : a library of the extra ``daq`` is missing
    """
    path = Path(path)
    if not is_file(path):
        raise CaseError(Fault(str(path), "must be a test file, there is none of this name", "Check the path"))
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise CaseError(
            Fault(
                str(path),
                f'must be one of {", ".join(READERS)}, got "{path.suffix}"',
                "Export the test as CSV",
            )
        )
    wanted = [channel.column for channel in mapping.channel.values()] + (
        [mapping.time] if mapping.time else []
    )
    held = reader(path, mapping, wanted)
    missing = [name for name in dict.fromkeys(wanted) if name not in held]
    if missing:
        raise CaseError(
            *(
                Fault(
                    f"{path}: column {name}",
                    "is not in the file",
                    similar(name, list(held), cutoff=0.6),
                )
                for name in missing
            )
        )
    faults = []
    for name in wanted:
        bad = np.flatnonzero(~np.isfinite(held[name].values))
        if len(bad):
            what = (
                f"must hold numbers, row {bad[0] + 1} of {len(held[name].values)} does not ({len(bad)} "
                "in all)"
            )
            faults.append(Fault(f"{path}: column {name}", what, "Repair or cut the file"))
    if faults:
        raise CaseError(*faults)
    return {name: held[name] for name in wanted}


def _csv(path: Path, mapping: Mapping, wanted: list[str]) -> dict[str, Column]:
    """Read a text file: a line of names, then numbers. Non-numeric cells become NaN."""
    with _whole(path), path.open(encoding="utf-8-sig", newline="", errors="replace") as file:
        rows = list(csv.reader(file, delimiter=mapping.separator))[mapping.skip :]
    if not rows:
        raise CaseError(
            Fault(
                str(path),
                "needs a line of names and lines of numbers, got none",
                "Check `skip` of the mapping",
            )
        )
    names = [name.strip() for name in rows[0]]
    body = [row for row in rows[1:] if any(cell.strip() for cell in row)]
    return {
        name: Column(
            np.array(
                [_number(row[index]) if index < len(row) else math.nan for row in body]
                if name in wanted
                else []
            ),
            None,
        )
        for index, name in enumerate(names)
    }


def _number(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        return math.nan


def _tdms(path: Path, mapping: Mapping, wanted: list[str]) -> dict[str, Column]:
    """Read National Instruments TDMS: channels ``group/channel``, or ``channel`` where only one has that
    name.
    """
    nptdms = _library("nptdms", path)
    held: dict[str, Column] = {}
    with _whole(path):
        for group in nptdms.TdmsFile.read(path).groups():
            for channel in group.channels():
                values = np.asarray(channel[:], float)
                step = channel.properties.get("wf_increment")
                start = channel.properties.get("wf_start_offset", 0.0)
                column = Column(values, start + step * np.arange(len(values)) if step else None)
                held[f"{group.name}/{channel.name}"] = column
                held.setdefault(channel.name, column)
    return held


def _mat(path: Path, mapping: Mapping, wanted: list[str]) -> dict[str, Column]:
    """Read MATLAB up to version 7: variables by name, and a column of a matrix as ``data(3)``, counted from
    1.
    """
    from scipy.io import loadmat

    with path.open("rb") as file:
        if file.read(10) == b"MATLAB 7.3":
            raise CaseError(
                Fault(
                    str(path), "needs a MAT file of version 7 or earlier, got version 7.3", "Save it with -v7"
                )
            )
    with _whole(path):
        variables = loadmat(path)
    held = {}
    for name, array in variables.items():
        if name.startswith("__") or not isinstance(array, np.ndarray) or array.dtype.kind not in "fiu":
            continue
        if min(array.shape) == 1:
            held[name] = Column(array.ravel().astype(float), None)
        else:
            held |= {
                f"{name}({k + 1})": Column(array[:, k].astype(float), None) for k in range(array.shape[1])
            }
    return held


def _uff(path: Path, mapping: Mapping, wanted: list[str]) -> dict[str, Column]:
    """Read sets 58 of the universal file format, by their first identification line."""
    pyuff = _library("pyuff", path)
    with _whole(path):
        sets = pyuff.UFF(str(path)).read_sets()
    sets = sets if isinstance(sets, list) else [sets]
    held = {str(each["id1"]).strip(): each for each in sets if each["type"] == 58}
    faults = [
        Fault(f"{path}: {name}", "must be a record over time, got complex numbers", NO_SPECTRA)
        for name, each in held.items()
        if name in wanted and np.iscomplexobj(each["data"])
    ]
    if faults:
        raise CaseError(*faults)
    return {
        name: Column(np.asarray(each["data"], float), np.asarray(each["x"], float))
        for name, each in held.items()
        if not np.iscomplexobj(each["data"])
    }


NO_SPECTRA = "Spectra and frequency responses are not read; export the time record"
"""What to do about a channel that is no record over time."""

READERS: dict[str, Callable[[Path, Mapping, list[str]], dict[str, Column]]] = {
    ".csv": _csv,
    ".txt": _csv,
    ".tdms": _tdms,
    ".mat": _mat,
    ".uff": _uff,
    ".unv": _uff,
}
"""Kinds of files by their ending."""


def _library(name: str, path: Path):
    """Import a library of the extra ``daq``."""
    import importlib

    try:
        return importlib.import_module(name)
    except ImportError as fault:
        raise missing_extra(f"{path}: reading {path.suffix}", f"the package {name}", "daq") from fault


class _whole:
    """Words whatever a reader of a foreign format raises on a file that is damaged."""

    def __init__(self, path: Path):
        self._path = path

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind, value, trace) -> None:
        if value is not None and isinstance(value, Exception):
            raise CaseError(
                Fault(
                    str(self._path), f"must be a whole {self._path.suffix} file ({value})", "Export it again"
                )
            ) from value
