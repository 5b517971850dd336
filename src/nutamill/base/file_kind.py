"""Recognise what a file is, so that a command which gets another kind of file names what it got and which
command takes it.
"""

import tomllib
from enum import Enum
from pathlib import Path
from typing import Any

from nutamill.base.errors import CaseError, Fault
from nutamill.base.library import library_file

MOST = 5_000_000
"""Bytes of a file that are examined; a longer text is none of the files that commands take [1]."""
MECHANISM = (
    "bodies",
    "joints",
    "bushings",
    "springs",
    "torques",
    "forces",
    "stops",
    "gears",
    "drives",
    "linear_drives",
    "unbalance_motors",
)
"""Lists of tables of a mechanism."""
MILL = ("mechanism", "chamber", "drive", "charge", "contact", "materials", "mounts", "frame", "run")
"""Tables of a case of a mill."""
SIGNATURES = {b"\x89PNG": "PICTURE", b"\xff\xd8\xff": "PICTURE", b"%PDF": "DOCUMENT", b"<!DOC": "DOCUMENT"}
"""First bytes of files that no command reads."""
HDF5 = b"\x89HDF\r\n\x1a\n"


class FileKind(Enum):
    """What a file can be: how a message calls it, and the command that takes it."""

    CASE = "a case of a mill", "nutamill run {}"
    MECHANISM = "a mechanism", "nutamill run {}"
    SWEEP = "a sweep file", "nutamill sweep {}"
    FIT = "a fit file", "nutamill fit {}"
    IDENTIFY = "an identification file", "nutamill identify {}"
    RATINGS = "a file of ratings", "nutamill life RESULT.h5 {}"
    ORE = "an ore file", "nutamill breakage RESULT.h5 --ore {}"
    MAPPING = "a mapping of a test file", "nutamill import TEST.csv --map {}"
    PAPER = "the data of a paper", "nutamill validate {}"
    RESULT = "a result", "nutamill show {}"
    MOUNT_TEST = "a mount test", "nutamill mount-test {}"
    RECORD = "a table of measured values", "nutamill import {} --map MAPPING.toml"
    MESH = "a mesh", ""
    PICTURE = "a picture", ""
    DOCUMENT = "a document", ""
    FOLDER = "a folder", "nutamill report {}"

    def __init__(self, label: str, command: str):
        self.label = label
        self.command = command


def file_kind(name: str | Path) -> FileKind | None:
    """Return what a file, a folder or the name of a published mill is, or None where that is unknown."""
    if library_file(str(name)):
        return FileKind.CASE
    path = Path(name)
    try:
        if path.is_dir():
            return FileKind.FOLDER
        if not path.is_file():  # a pipe is not read twice
            return None
        with path.open("rb") as file:
            if (content := file.read(len(HDF5))) == HDF5:
                return FileKind.RESULT
            content += file.read(MOST)
    except (OSError, ValueError):
        return None
    return _kind_of_bytes(content, path.suffix.lower())


def refuse_other_kind(name: str | Path, *wanted: FileKind) -> None:
    """Raise CaseError for a file that is known to be of another kind than those wanted."""
    if fault := other_kind(name, *wanted):
        raise CaseError(fault)


def other_kind(name: str | Path, *wanted: FileKind) -> Fault | None:
    """Return the fault of a file that is known to be of another kind than those wanted, else None."""
    given = file_kind(name)
    if given is None or given in wanted:
        return None
    hint = f"It is for: {given.command.format(name)}" if given.command else ""
    return Fault(str(name), f"must be {wanted[0].label}, got {given.label}", hint)


def _kind_of_bytes(content: bytes, suffix: str) -> FileKind | None:
    """Return the kind of a file that is no HDF5 file, by its first bytes, its suffix, or the tables in it."""
    for signature, kind in SIGNATURES.items():
        if content.startswith(signature):
            return FileKind[kind]
    if suffix in (".stl", ".obj"):
        return FileKind.MESH
    if suffix in (".csv", ".tdms", ".mat", ".uff", ".unv"):
        heads = content.split(b"\n", 1)[0].lower()
        return FileKind.MOUNT_TEST if b"displacement" in heads and b"force" in heads else FileKind.RECORD
    try:
        return kind_of_tables(tomllib.loads(content.decode("utf-8-sig")))
    except (ValueError, RecursionError):
        return None


def kind_of_tables(tables: dict[str, Any]) -> FileKind | None:
    """Return the kind of a TOML file by its tables, or None for a file without any that decide."""
    if any(isinstance(tables.get(part), list) for part in MECHANISM):
        return FileKind.MECHANISM
    if any(isinstance(tables.get(table), dict) for table in MILL):
        return FileKind.CASE
    telling = {
        FileKind.FIT: ("free", "target"),
        FileKind.SWEEP: ("sweep",),
        FileKind.IDENTIFY: ("unknown", "learn", "predict"),
        FileKind.RATINGS: ("bearings", "sections"),
        FileKind.ORE: ("drop_weight", "tavares"),
        FileKind.MAPPING: ("channel",),
        FileKind.PAPER: ("configurations", "rows"),
        FileKind.CASE: ("base",),
    }
    return next((kind for kind, names in telling.items() if any(name in tables for name in names)), None)
