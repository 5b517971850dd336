"""A file that is whole at every instant: it is never changed in place, only replaced by a finished copy.

A copy is made beside the file, the room it will need is reserved, the copy is changed and flushed to the
disk, and then renamed over the file, which a file system does at once or not at all.  A process that is
killed leaves the file as it was, and perhaps a hidden ``.part`` file, which the next writer removes.

The room is reserved by plain system calls because libraries that write (HDF5 for one) cannot close a file
properly on a full disk and may take the process down with them.
"""

import contextlib
import errno
import glob
import os
import secrets
import shutil
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import BinaryIO

from nutamill.base.errors import CaseError, Fault, OutputError, ResultError
from nutamill.base.files import exists

FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""Errors of the system that mean: no room."""
PAGES = (".html", ".htm")
"""Ends of file names of pages."""
RESULTS = (".h5", ".hdf5")
"""Ends of file names of results."""
SPARE = 16 * 2**20
"""Room that must stay free on the disk beyond what is written [bytes]."""


def replace_file(
    path: Path, edit: Callable[[Path], None], room: int, start: bytes | BinaryIO | None = None
) -> None:
    """Replace `path` by a copy that `edit` has changed. At every instant `path` is the old file or the new
    one.

    Parameters
    ----------
    path : the file; its folder must exist
    edit : changes the copy, whose path it is given
    room : upper bound of the growth [bytes]
    start : content to start from instead of a copy; an open file is read from its beginning

    Raises
    ------
    OutputError : no room, or the system refuses; the file is as it was and no part of a new one is left
    """
    with io_errors(path):
        needed = room + _size(path, start)
        check_room(path, needed)
    part: Path | None = None
    try:
        with io_errors(path, needed):
            part = _new_part(path)
            _write_start(part, path, start)
            _reserve(part, needed)
            edit(part)
            with part.open("r+b") as written:
                os.fsync(written.fileno())
            part.replace(path)
            _flush_folder(path.parent)
    finally:
        if part is not None:
            with contextlib.suppress(OSError):  # the first error is the one to report
                part.unlink(missing_ok=True)


def write_whole(path: str | Path, content: str | bytes) -> Path:
    """Write a file of this content, or put it in place of the one there. Its folder is made if needed. Raises
    as `replace_file`.
    """
    path = Path(path)
    make_folder(path)
    replace_file(path, lambda _: None, 0, content.encode("utf-8") if isinstance(content, str) else content)
    return path


def put_in_place(new: Path, path: Path) -> None:
    """Rename the finished file `new` to `path`, in place of the file there. Raises ResultError if the system
    refuses.
    """
    with io_errors(path):
        new.replace(path)
        _flush_folder(path.parent)


def refuse_suffix(path: Path, suffixes: Sequence[str]) -> None:
    """Raise CaseError for a file to be written whose name does not end with one of `suffixes`."""
    if path.suffix.lower() not in suffixes:
        what = f'must end with {", ".join(suffixes)}, got "{path.suffix}"'
        raise CaseError(
            Fault(str(path), what, f"Write e.g. {path.with_suffix(suffixes[0])}" if path.name else "")
        )


def check_writable(path: Path, suffixes: Sequence[str]) -> None:
    """Make the folder of a file to be written and try the place, before the work whose outcome it will hold.

    Raises
    ------
    CaseError : the name does not end with one of `suffixes`
    OutputError : the system refuses
    """
    refuse_suffix(path, suffixes)
    make_folder(path)
    with io_errors(path):
        new = not exists(path)
        path.open("ab").close()
        if new:
            path.unlink()


def make_folder(path: Path) -> None:
    """Make the folder of the file `path`, if there is none. Raises OutputError if the system refuses."""
    with io_errors(path):
        path.parent.mkdir(parents=True, exist_ok=True)


def tidy(path: Path) -> None:
    """Remove the copies that killed writers of `path` have left beside it."""
    for left in path.parent.glob(f".{glob.escape(path.name)}.*.part"):
        with contextlib.suppress(OSError):  # the writer that follows reports a folder that cannot be changed
            left.unlink(missing_ok=True)


def check_room(path: Path, needed: int) -> None:
    """Raise OutputError if writing `needed` bytes to `path` would leave less than the reserve `SPARE` on its
    disk.
    """
    free = shutil.disk_usage(path.parent).free
    if free < needed + SPARE:
        reserve = f"a reserve of {megabytes(SPARE)} must stay free"
        raise _no_room(path, f"needs {megabytes(needed)}, {megabytes(free)} are free, and {reserve}")


@contextlib.contextmanager
def io_errors(path: Path, needed: int = 0) -> Iterator[None]:
    """Turn an OSError into an OutputError that names the file, and on a full disk the bytes that are
    needed.
    """
    try:
        yield
    except ResultError:
        raise
    except OSError as error:
        if error.errno in FULL:
            limit = {
                errno.EDQUOT: "the quota of this disk is reached",
                errno.EFBIG: "the system limits files to a smaller size",
            }
            why = limit.get(error.errno, "the disk is full")
            raise _no_room(
                path, f"needs {megabytes(needed)}, {why}" if needed else f"has failed, {why}"
            ) from error
        raise OutputError(
            f'{path}: cannot be written, the system reports "{error.strerror or error}". Choose '
            "another place."
        ) from error


def megabytes(size: float) -> str:
    """Format a size in bytes as text in MB."""
    return f"{size / 1e6:.1f} MB"


def _no_room(path: Path, why: str) -> OutputError:
    unchanged = " The file is unchanged since it was last saved." if exists(path) else ""
    return OutputError(f"{path}: saving {why}. Free some room, or choose another place.{unchanged}")


def _size(path: Path, start: bytes | BinaryIO | None) -> int:
    """Return the size of the content that a copy starts from [bytes]."""
    if start is None:
        return path.stat().st_size
    return len(start) if isinstance(start, bytes) else os.fstat(start.fileno()).st_size


def _new_part(path: Path) -> Path:
    """Create an empty hidden file beside `path`: a new one always, never one that stood there or that a link
    points to.
    """
    part = path.with_name(f".{path.name}.{os.getpid()}-{secrets.token_hex(4)}.part")
    flags = (
        os.O_CREAT | os.O_EXCL | os.O_WRONLY | getattr(os, "O_NOFOLLOW", 0)
    )  # O_EXCL alone refuses links where there is no such flag
    os.close(os.open(part, flags, 0o666))
    return part


def _write_start(part: Path, path: Path, start: bytes | BinaryIO | None) -> None:
    """Fill the new `part` with the content to start from."""
    if start is None:
        shutil.copyfile(path, part)
    elif isinstance(start, bytes):
        part.write_bytes(start)
    else:
        start.seek(0)
        with part.open("wb") as copy:
            shutil.copyfileobj(start, copy)


def _reserve(part: Path, size: int) -> None:
    """Reserve `size` bytes on the disk for `part`, where the system can."""
    if not hasattr(os, "posix_fallocate"):
        return
    with part.open("r+b") as file:
        try:
            os.posix_fallocate(file.fileno(), 0, size)
        except OSError as error:
            if error.errno not in (errno.EOPNOTSUPP, errno.EINVAL):  # a file system without reservation
                raise


def _flush_folder(folder: Path) -> None:
    """Bring the new name to the disk, where the system can: after a power failure the file is then the new
    one.
    """
    if not hasattr(os, "O_DIRECTORY"):  # Windows cannot open a folder
        return
    with contextlib.suppress(
        OSError
    ):  # a file system that cannot flush a folder; the file is whole either way
        opened = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
        try:
            os.fsync(opened)
        finally:
            os.close(opened)
