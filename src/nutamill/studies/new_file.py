"""A first file of each kind, and the JSON schema by which editors complete and check it."""

import json
from importlib import resources
from pathlib import Path
from string import Template
from typing import Any

from nutamill.analysis.measured_mapping import Mapping
from nutamill.analysis.ratings import Ratings
from nutamill.base.atomic_file import refuse_suffix, write_whole
from nutamill.base.errors import CaseError, Fault, OutputError
from nutamill.base.files import exists
from nutamill.base.library import similar
from nutamill.case.machine import Machine
from nutamill.case.mill import Case
from nutamill.case.starter import starter
from nutamill.case.toml.schema import file_schema
from nutamill.studies.fit_file import FitFile
from nutamill.studies.sweep_file import SweepFile

KINDS: dict[str, type] = {
    "mill": Case,
    "mechanism": Machine,
    "sweep": SweepFile,
    "fit": FitFile,
    "ratings": Ratings,
    "mapping": Mapping,
}
"""What can be written, and what its content is."""
NEXT = {
    "mill": "nutamill check {}",
    "mechanism": "nutamill check {}",
    "sweep": "nutamill sweep {}",
    "fit": "nutamill fit {}",
    "ratings": "nutamill life RESULT.h5 {}",
    "mapping": "nutamill import TEST.csv --map {}",
}
"""The command that a file of each kind is for."""
WITH_BASE = ("mill", "sweep", "fit")
"""Kinds of files that begin with a case."""


def schema_of(kind: str) -> dict[str, Any]:
    """Return the JSON schema of a kind of file.

    Raises
    ------
    CaseError : no such kind
    """
    _refuse_kind(kind)
    return file_schema(KINDS[kind])


def write_new(kind: str, file: Path, base: str | None = None) -> Path:
    """Write a file to begin with, and its schema beside it, and return the path of the schema.

    The first line of the file names the schema, as editors with Taplo (Even Better TOML) read it.

    Parameters
    ----------
    kind : a name of `KINDS`
    file : the file, which must not be there yet
    base : the case that it begins with; the NuMill if None

    Raises
    ------
    CaseError : no such kind or base, or the file exists
    OutputError : the system refuses
    """
    _refuse_kind(kind)
    refuse_suffix(file, (".toml",))
    if base is not None and kind not in WITH_BASE:
        raise CaseError(Fault("--from", f"has no use for a file of kind {kind}", "Leave it out"))
    if kind == "mill":
        text = starter(base or "numill", file)
    else:
        template = resources.files("nutamill") / "data" / "starters" / f"{kind}.toml"
        text = Template(template.read_text(encoding="utf-8")).safe_substitute(base=base or "numill")
    if exists(file):
        raise CaseError(Fault(str(file), "exists already", "Choose another name"))
    schema = file.with_name(f"nutamill-{kind}.schema.json")
    try:
        if not file.parent.exists():
            file.parent.mkdir(parents=True)
        with file.open("x", encoding="utf-8") as stream:
            stream.write(f"#:schema ./{schema.name}\n{text}")
    except FileExistsError:
        raise CaseError(Fault(str(file), "exists already", "Choose another name")) from None
    except OSError as error:
        raise OutputError(
            f'{file}: cannot be written, the system reports "{error.strerror}". Choose another place.'
        ) from None
    write_whole(schema, json.dumps(schema_of(kind), indent=1) + "\n")
    return schema


def _refuse_kind(kind: str) -> None:
    """Raise CaseError for what is no kind of file."""
    if kind not in KINDS:
        what = f'must be one of {", ".join(KINDS)}, got "{kind}"'
        raise CaseError(Fault("kind of file", what, similar(kind, list(KINDS))))
