"""Look for files and read text, whatever their names and sizes."""

import errno
from pathlib import Path

MOST_CASE_TEXT = 5_000_000
"""Longest text of a case or of any other file of tables [bytes]."""
MOST_RECORD_TEXT = 200_000_000
"""Longest text of a table of measured values [bytes]."""


def is_file(path: str | Path) -> bool:
    """Return whether there is a regular file of this name. A name the system cannot hold names none."""
    try:
        return Path(path).is_file()
    except (OSError, ValueError):
        return False


def exists(path: str | Path) -> bool:
    """Return whether there is anything of this name. Nothing has a name that the system cannot hold."""
    try:
        return Path(path).exists()
    except (OSError, ValueError):
        return False


def is_folder(path: str | Path) -> bool:
    """Return whether there is a folder of this name. A name the system cannot hold names none."""
    try:
        return Path(path).is_dir()
    except (OSError, ValueError):
        return False


def read_text(path: str | Path, most: int) -> str:
    """Return the UTF-8 text of a file or pipe, with plain line ends and without a byte order mark.

    Parameters
    ----------
    most : longest text that is read [bytes]; a device that never ends is given up there

    Raises
    ------
    OSError : the file cannot be read, or is longer than `most`
    UnicodeDecodeError : it is no UTF-8 text
    """
    with open(path, "rb") as file:
        content = file.read(most + 1)
    if len(content) > most:
        raise OSError(errno.EFBIG, f"it is longer than {most / 1e6:g} MB")
    return content.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
