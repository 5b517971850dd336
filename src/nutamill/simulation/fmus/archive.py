"""The archive of an FMU: what may be in it, its content unpacked, and a digest."""

import hashlib
import stat
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path, PurePosixPath

from nutamill.base.errors import CaseError, Fault, reason

MOST_UNPACKED = 2**31
"""Largest content of an FMU [bytes]."""
MOST_MEMBERS = 100_000
"""Largest number of files in an FMU [1]."""
REGULAR = (0, stat.S_IFREG, stat.S_IFDIR)
"""Kinds of members that are unpacked: those without a kind, files and folders."""


@contextmanager
def opened(path: Path, where: str) -> Iterator[zipfile.ZipFile]:
    """Open the archive of an FMU whose members are all harmless, and close it.

    Parameters
    ----------
    path : the file
    where : key of the file, for messages

    Raises
    ------
    CaseError : no archive, a damaged one, or a member that is not a file inside it
    """
    try:
        with zipfile.ZipFile(path) as archive:
            if faults := [Fault(where, what) for what in _unsafe(archive.infolist())]:
                raise CaseError(*faults)
            yield archive
    except (OSError, zipfile.BadZipFile, zlib.error, EOFError, RuntimeError) as error:
        raise CaseError(
            Fault(where, f"{path.name} cannot be read as an FMU: {reason(error)}", "Export it again")
        ) from None


def _unsafe(members: list[zipfile.ZipInfo]) -> Iterator[str]:
    """Yield what is wrong with the members of an archive."""
    if len(members) > MOST_MEMBERS:
        yield f"holds {len(members)} files, more than {MOST_MEMBERS}"
    if (size := sum(member.file_size for member in members)) > MOST_UNPACKED:
        yield f"holds {size} bytes when it is unpacked, more than {MOST_UNPACKED}"
    for member in members:
        name = member.filename.replace("\\", "/")
        path = PurePosixPath(name)
        if path.is_absolute() or ".." in path.parts or ":" in name:
            yield f'holds the name "{member.filename}", which leads out of the archive'
        elif stat.S_IFMT(member.external_attr >> 16) not in REGULAR:
            yield f'holds "{member.filename}", which is a link or a device'


def unpack(path: Path, folder: Path, where: str) -> None:
    """Write the content of an FMU into an empty folder. Raise as `opened`."""
    with opened(path, where) as archive:
        for member in archive.infolist():
            target = folder / member.filename.replace("\\", "/")
            if member.is_dir():
                target.mkdir(parents=True, exist_ok=True)
                continue
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(archive.read(member))
            target.chmod(0o700)


def check_digest(path: Path, expected: str, where: str) -> None:
    """Raise CaseError if the content of a file is not that of the digest [SHA-256, hexadecimal]."""
    try:
        digest = hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError as error:
        raise CaseError(Fault(where, f"{path} cannot be read: {reason(error)}")) from None
    if digest != expected:
        what = f"{path} has changed: SHA-256 {digest[:12]}, the case was read with {expected[:12]}"
        raise CaseError(Fault(where, what, "Put the file back, or read the case again"))
