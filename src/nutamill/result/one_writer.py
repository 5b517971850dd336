"""A lock for the time a run writes its result file: two runs must not write the same one.

The lock is an exclusive transaction of SQLite on an empty file beside the result.  Python brings SQLite
along, it locks on POSIX systems and on Windows alike, and the system ends the lock with its process, however
that dies (docs/decisions/015-one-writer.md).
"""

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from nutamill.base.atomic_file import io_errors, make_folder
from nutamill.base.errors import ResultError

if TYPE_CHECKING:
    import sqlite3

BUSY = 5
"""Error code of SQLite for a file that another transaction has locked."""


@contextlib.contextmanager
def one_writer(path: Path) -> Iterator[None]:
    """Hold the lock on the result file `path`. The folder is made if needed.

    On a file system without locks, and in a Python without SQLite, nothing is locked.

    Raises
    ------
    ResultError : another run writes the file now, or its folder cannot be written
    """
    make_folder(path)
    lock = path.with_name(f".{path.name}.lock")
    with io_errors(path):
        connection = _connected(lock, path)
    try:
        yield
    finally:
        with contextlib.suppress(OSError):  # Windows removes no open file, and has another moment below
            lock.unlink()
        if connection is not None:
            connection.close()
            if os.name == "nt":
                with contextlib.suppress(OSError):
                    lock.unlink()


def _connected(lock: Path, path: Path) -> "sqlite3.Connection | None":
    """Return a connection that holds `lock`, or None where nothing can be locked."""
    try:
        import sqlite3
    except ImportError:
        return None
    while True:
        lock.touch()
        connection = sqlite3.connect(lock, timeout=0.0, isolation_level=None, check_same_thread=False)
        try:
            before = lock.stat()
            connection.execute("BEGIN EXCLUSIVE")
            if os.path.samestat(before, lock.stat()):
                return connection
        except FileNotFoundError:
            pass  # the last holder has removed its file meanwhile, so that the lock on it means nothing
        except sqlite3.DatabaseError as error:
            connection.close()
            if error.sqlite_errorcode == BUSY:
                raise ResultError(
                    f"{path}: is being written by another run. Wait until it ends, stop it, or "
                    "choose another file."
                ) from None
            return None
        connection.close()
