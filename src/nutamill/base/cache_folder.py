"""Choose the folder of compiled kernels and settled beds: the user's cache folder, or a temporary one where
that cannot be written.
"""

import atexit
import functools
import os
import shutil
import sys
import tempfile
from pathlib import Path

VARIABLE = "NUMBA_CACHE_DIR"
"""Environment variable with the folder of the compiled kernels, for those who want another one."""


def cache_folder() -> Path:
    """Return the folder of the compiled kernels. That of the settled beds is beside it."""
    return _chosen()[0]


def cache_trouble() -> str:
    """Return in one sentence why nothing is stored from one run to the next, or "" if all is well."""
    return _chosen()[1]


def beds_folder() -> Path:
    """Return the folder of the settled beds."""
    return cache_folder().parent / "beds"


@functools.cache
def _chosen() -> tuple[Path, str]:
    """Choose and create the folder of the compiled kernels, and return it with what is wrong with the
    preferred one.
    """
    wanted = _wanted()
    try:
        _try(wanted)
        return wanted, ""
    except OSError as error:
        reason = f"{wanted} cannot be written ({error.strerror})"
    hint = f"Set {VARIABLE} to a folder that can be written"
    try:
        temporary = Path(tempfile.mkdtemp(prefix="nutamill-"))
        folder = temporary / "kernels"
        _try(folder)
    except OSError:
        return (
            wanted,
            f"compiled kernels and settled beds are not stored: {reason}, and no temporary folder can be "
            f"made. {hint}.",
        )
    os.environ[VARIABLE] = str(folder)  # for the processes that this one starts
    atexit.register(_remove, temporary, os.getpid())
    return (
        folder,
        f"compiled kernels and settled beds are stored only until this process ends: {reason}. {hint}.",
    )


def _wanted() -> Path:
    """Return `VARIABLE` if set, else the user's cache folder on this system."""
    if given := os.environ.get(VARIABLE):
        return Path(given)
    home = Path(os.path.expanduser("~"))  # not Path.home(), which fails for a user without one
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA") or home / "AppData" / "Local"
    elif sys.platform == "darwin":
        base = home / "Library" / "Caches"
    else:
        base = os.environ.get("XDG_CACHE_HOME") or home / ".cache"
    return Path(base) / "nutamill" / "kernels"


def _try(folder: Path) -> None:
    """Make a folder and a file in it. Raises OSError if that is refused."""
    folder.mkdir(parents=True, exist_ok=True)
    tempfile.TemporaryFile(dir=folder).close()


def _remove(folder: Path, owner: int) -> None:
    """Remove a temporary folder, in the process that has made it."""
    if os.getpid() == owner:
        shutil.rmtree(folder, ignore_errors=True)
