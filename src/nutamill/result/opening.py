"""Opens a result file for reading, after checking that it is ours and that it refers to no other file."""

from pathlib import Path

import h5py
import numpy as np

from nutamill.base.errors import ResultError
from nutamill.base.files import is_file
from nutamill.result.layout import FORMAT, FORMAT_VERSION

DEEPEST = 8
"""Groups inside each other that a file may have [1]; a result has four."""


def opened(path: Path) -> h5py.File:
    """Return the file, open for reading.

    Raises
    ------
    ResultError : no such file, cut off, no result of this package, written by a newer one, or referring to
        other files
    """
    if not is_file(path):
        raise ResultError(
            f"{path}: must be a result file, there is none of this name. Look in results/ or run the "
            "case first."
        )
    try:
        file = h5py.File(path, "r")
    except Exception as fault:  # HDF5 raises many kinds on a damaged file
        if path.read_bytes()[:8] == b"\x89HDF\r\n\x1a\n":
            raise ResultError(
                f"{path}: is cut off or damaged ({fault}). Copy it again, or run the case again."
            ) from fault
        raise ResultError(
            f"{path}: is no result file (HDF5). Give the .h5 file that `nutamill run` has written."
        ) from fault
    try:
        _check_format(file, path)
        refuse_outside_storage(file, path)
    except BaseException:
        file.close()
        raise
    return file


def _check_format(file: h5py.File, path: Path) -> None:
    """Check the attributes that name format and version."""
    try:
        kind, version = file.attrs.get("format"), file.attrs.get("format_version")
        kind = kind.decode() if isinstance(kind, bytes) else kind
    except Exception as fault:
        raise ResultError(
            f"{path}: its root attributes are damaged ({fault}). Copy it again, or run the case again."
        ) from fault
    if not isinstance(kind, str) or kind != FORMAT:
        raise ResultError(
            f"{path}: is an HDF5 file, but no result of nutamill."
            " Give the file that `nutamill run` has written."
        )
    if not isinstance(version, (int, np.integer)) or version < 1:
        raise ResultError(
            f"{path}: is damaged: its format version must be a whole number from 1 on, got {version!r}."
            " Copy it again, or run the case again."
        )
    if version > FORMAT_VERSION:
        raise ResultError(
            f"{path}: written by format {version}, this version reads up to {FORMAT_VERSION}. Update "
            "the package."
        )


def refuse_outside_storage(file: h5py.File, path: Path) -> None:
    """Raise ResultError if anything in `file` would read or write outside of it, or is no plain group or
    dataset.

    HDF5 follows external links, external storage and virtual datasets to any file of the user who opens the
    file, for writing as well.  A result needs none of them, nor soft links, and links are examined here
    without following them.
    """
    try:
        faults = _outside_storage(file.id, b"")
    except Exception as fault:
        raise ResultError(
            f"{path}: is damaged: its groups cannot be listed ({fault}). Copy it again, or run the "
            "case again."
        ) from fault
    if faults:
        raise ResultError(
            f"{path}: must hold all its numbers itself, {faults[0]}. Do not use this file: it could "
            "read or overwrite other files."
        )


def _outside_storage(group: h5py.h5g.GroupID, above: bytes) -> list[str]:
    """Return what in a group and the groups inside it refers to something outside. `above` is its path."""
    faults: list[str] = []
    try:
        names = list(group)
    except Exception:
        if above.startswith(
            b"/checkpoints/"
        ):  # a checkpoint that cannot be listed is neither read nor written, only deleted
            return []
        raise
    for name in names:
        path = (above + b"/" + name).decode("utf-8", "replace").lstrip("/")
        link = group.links.get_info(name)
        if link.type != h5py.h5l.TYPE_HARD:
            faults.append(
                f"{path} is a link" + (" to another file" if link.type == h5py.h5l.TYPE_EXTERNAL else "")
            )
            continue
        try:
            thing = h5py.h5o.open(group, name)
        except Exception:  # damaged: what cannot be opened here cannot be read or written later
            continue
        if isinstance(thing, h5py.h5g.GroupID):
            if above.count(b"/") >= DEEPEST:
                raise ValueError(f"{path} stands in more than {DEEPEST} groups")
            faults += _outside_storage(thing, above + b"/" + name)
        elif isinstance(thing, h5py.h5d.DatasetID):
            storage = thing.get_create_plist()
            if storage.get_layout() == h5py.h5d.VIRTUAL:
                faults.append(f"{path} is a virtual dataset")
            elif storage.get_external_count():
                faults.append(f"{path} stores its numbers in another file")
    return faults
