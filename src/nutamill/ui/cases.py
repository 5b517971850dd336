"""Cases for the page: what there is, the form of one, its faults, its check sheet, a file of the changes."""

import re
from pathlib import Path
from typing import Any, NamedTuple

from nutamill.base.atomic_file import write_whole
from nutamill.base.errors import CaseError, Fault
from nutamill.base.file_kind import FileKind, file_kind
from nutamill.base.library import library_file, library_names
from nutamill.base.schema import spelled
from nutamill.case import Case, Machine, load_case
from nutamill.case.toml.form import FormKey, form_of
from nutamill.case.toml.layers import override_layer
from nutamill.case.toml.write import toml_value
from nutamill.design.check import check
from nutamill.simulation.setup.altered import turning_drive
from nutamill.simulation.setup.quick import quick
from nutamill.ui.folder import Folder

CASES = (".toml",)
"""Ends of names of case files."""
FIRST = "numill"
"""Name of the machine that the page begins with."""
LONGEST_VALUE = 1000
"""Characters of a value that the page sends [1]."""


class Asked(NamedTuple):
    """A case with changes, as the page asks for it."""

    name: str | Path
    """Machine of the package, or case file."""
    changes: dict[str, str]
    """New values by dotted key, as after ``--set``."""
    quick: bool = False
    """Whether its demonstration is asked for."""


class Sheet(NamedTuple):
    """A case as a form, or its faults."""

    title: str
    """Title of the case with the changes; empty with faults."""
    faults: list[str]
    """What is wrong; none for a case that can be run."""
    warnings: list[str]
    """What is possible but odd."""
    entries: list[FormKey]
    """Keys of the form, with the changes where there are no faults."""
    demonstration: bool
    """Whether it has one: a drive whose ramp is shortened."""


def catalogue(folder: Folder) -> list[dict[str, str]]:
    """Return name and title of every machine of the package and of every case file of the folder."""
    files = {name: library_file(name) for name in library_names()}
    short = {name for name, file in files.items() if file is not None and file.stem != name}
    machines = [{"name": name, "title": load_case(name).title} for name in files if name not in short]
    kinds = (FileKind.CASE, FileKind.MECHANISM)
    own = [name for name in folder.listed(*CASES) if file_kind(folder.root / name) in kinds]
    return machines + [{"name": name, "title": ""} for name in own]


def first() -> str:
    """Return the machine that the page begins with."""
    file = library_file(FIRST)
    return file.stem if file is not None else FIRST


def asked(folder: Folder, request: dict[str, Any]) -> Asked:
    """Return what a request asks for.

    Raises
    ------
    CaseError : a file outside the folder, or changes that are no texts by key
    """
    name, changes = request.get("case"), request.get("changes", {})
    known = isinstance(name, str) and library_file(name) is not None
    if not isinstance(changes, dict) or not all(
        isinstance(value, str) and len(value) <= LONGEST_VALUE for value in changes.values()
    ):
        what = f"must be texts by key, of at most {LONGEST_VALUE} characters each"
        raise CaseError(Fault("changes", what, "Reload the page"))
    return Asked(
        name if known and isinstance(name, str) else folder.file(name, *CASES),
        changes,
        bool(request.get("quick")),
    )


def loaded(what: Asked) -> Case | Machine:
    """Return a case with its changes.

    Raises
    ------
    CaseError : every fault, or a change of a key that the form does not offer
    """
    if what.changes:
        offered = {entry.key for entry in form_of(what.name, load_case(what.name))}
        if strange := [key for key in what.changes if key not in offered]:
            hint = "Change it in the case file"
            raise CaseError(*(Fault(spelled(key), "is no key of this form", hint) for key in strange))
    case = load_case(what.name, [f"{key}={value}" for key, value in what.changes.items()])
    return quick(case) if what.quick else case


def sheet(what: Asked) -> Sheet:
    """Return the form of a case with its changes, or its faults beside the form without them.

    Raises
    ------
    CaseError : a case that has faults before anything is changed
    """
    base = load_case(what.name)
    try:
        case = loaded(what._replace(quick=False))
    except CaseError as error:
        faults = [str(fault).removeprefix("--set ") for fault in error.faults]
        return Sheet("", faults, [], form_of(what.name, base), _has_demonstration(base))
    warnings = [str(warning) for warning in case.warnings]
    return Sheet(case.title or case.name, [], warnings, form_of(what.name, case), _has_demonstration(case))


def _has_demonstration(case: Case | Machine) -> bool:
    """Return whether a case has a drive whose ramp a demonstration shortens."""
    try:
        turning_drive(case.machine)
    except CaseError:
        return False
    return True


def check_lines(what: Asked) -> list[str]:
    """Return what is known of a case before it is run, as `nutamill check` prints it with the forecast of its
    table. Raise CaseError for every fault.
    """
    return check(loaded(what)).lines()


def save_changes(folder: Folder, what: Asked, name: object) -> str:
    """Write a case file of a base and the changes, directly in the folder, and return its name.

    Raises
    ------
    CaseError : a case with faults, or a name that cannot be used
    OutputError : the system refuses
    """
    path = folder.new_file(name, *CASES)
    loaded(what)
    content = override_layer([f"{key}={value}" for key, value in what.changes.items()])[0].content
    base = what.name if isinstance(what.name, str) else folder.name_of(what.name)
    title = re.sub(r"[-_]+", " ", path.stem)
    lines = [
        "# Values carry their unit. What is left out is as in the base.",
        "schema = 1",
        f"title  = {toml_value(f'{title}, from {base}')}",
        f"base   = {toml_value(base)}",
        *_tables(content, ()),
    ]
    write_whole(path, "\n".join(lines) + "\n")
    return folder.name_of(path)


def _tables(content: dict[str, Any], above: tuple[str, ...]) -> list[str]:
    """Return the lines of the tables of the changes."""
    plain = {key: value for key, value in content.items() if not isinstance(value, dict)}
    lines = ["", f"[{'.'.join(above)}]"] if plain and above else []
    lines += [f"{key} = {toml_value(value)}" for key, value in plain.items()]
    for key, value in content.items():
        if isinstance(value, dict):
            lines += _tables(value, (*above, key))
    return lines
