"""A file that is whole at every instant: it is never changed in place, only replaced by a finished copy.

A copy is made beside the file, the room it will need is reserved, the copy is changed and flushed to the disk, and then
renamed over the file, which a file system does at once or not at all.  A process that is killed leaves the file as it was,
and perhaps a hidden ``.part`` file, which the next writer removes.

The room is reserved by plain system calls because libraries that write (HDF5 for one) cannot close a file properly on a
full disk and may take the process down with them.
"""

import contextlib
import errno
import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

from nutamill.errors import OutputError, ResultError

FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""What the system says when there is no room."""
SPARE = 16 * 2**20
"""Room that must stay free on the disk beyond what is written [bytes]."""


def replace_file(path: Path, edit: Callable[[Path], None], room: int, start: bytes | None = None) -> None:
    """Put in place of `path` a copy that `edit` has changed; at every instant `path` is the old file or the new one.

    Parameters
    ----------
    path : the file; its folder must exist
    edit : changes the copy, whose path it is given
    room : upper bound of the growth [bytes]
    start : content to start from instead of a copy

    Raises
    ------
    ResultError : no room, or the system refuses; the file is as it was and no part of a new one is left
    """
    needed = room + (path.stat().st_size if start is None else len(start))
    if shutil.disk_usage(path.parent).free < needed + SPARE:
        raise _full(path, needed)
    part = path.with_name(_part(path, os.getpid()))
    try:
        with io_errors(path, needed):
            if start is None:
                shutil.copyfile(path, part)
            else:
                part.write_bytes(start)
            _reserve(part, needed)
            edit(part)
            with part.open("r+b") as written:
                os.fsync(written.fileno())
            part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def write_whole(path: str | Path, content: str | bytes) -> Path:
    """Write a file of this content, or put it in place of the one there; its folder is made if needed. Raises as `replace_file`."""
    path = Path(path)
    with io_errors(path):
        path.parent.mkdir(parents=True, exist_ok=True)
    replace_file(path, lambda _: None, 0, content.encode("utf-8") if isinstance(content, str) else content)
    return path


def tidy(path: Path) -> None:
    """Remove what killed writers of `path` have left beside it."""
    for left in path.parent.glob(_part(path, "*")):
        left.unlink(missing_ok=True)


@contextlib.contextmanager
def io_errors(path: Path, needed: int = 0) -> Iterator[None]:
    """Word a failure of the system as a ResultError that names the file, and the bytes needed and free on a full disk."""
    try:
        yield
    except ResultError:
        raise
    except OSError as fault:
        if fault.errno in FULL:
            raise _full(path, needed) from fault
        raise OutputError(
            f"{path}: must be writable, the system says: {fault.strerror or fault}. Choose another place with --to."
        ) from fault


def _part(path: Path, owner: str | int) -> str:
    return f".{path.name}.{owner}.part"


def _full(path: Path, needed: int) -> OutputError:
    free = shutil.disk_usage(path.parent).free
    return OutputError(
        f"{path}: saving needs {needed} bytes of room, {free} bytes are free (or a quota is reached). "
        "Free some room and resume; a file of this name is whole as of its last commit."
    )


def _reserve(part: Path, size: int) -> None:
    """Reserve `size` bytes on the disk for `part`, where the system can."""
    if not hasattr(os, "posix_fallocate"):
        return
    with part.open("r+b") as file:
        try:
            os.posix_fallocate(file.fileno(), 0, size)
        except OSError as fault:
            if fault.errno not in (errno.EOPNOTSUPP, errno.EINVAL):  # a file system without reservation
                raise
