"""Meshes and FMUs that a case names: files beside the case file, identified by their content."""

import hashlib
from pathlib import Path
from typing import Any

from nutamill.base.errors import CaseError, Fault
from nutamill.case.drive import existing_file


def pin_file(table: dict[str, Any], where: str, folders: list[Path]) -> None:
    """Write the full path of a file and the digest of its content into its table, unless the digest is
    there already.

    A case that has been read once, as a result file keeps it, can so be read again where the file is not;
    whoever uses the file compares the digest.

    Parameters
    ----------
    table : with the key ``file``
    where : file, line and key, for messages
    folders : where a relative name is looked for, in order

    Raises
    ------
    CaseError : no such file, or one that cannot be read
    """
    name = table.get("file")
    if not isinstance(name, str) or "sha256" in table:
        return
    path = existing_file(name, where, folders)
    try:
        table["sha256"] = hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError as error:
        raise CaseError(Fault(where, f"{name} cannot be read: {error.strerror}")) from None
    table["file"] = str(path)
