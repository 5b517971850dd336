"""A first file of each kind, and the JSON schema by which editors complete and check it."""

import json
from importlib import resources
from pathlib import Path
from string import Template
from typing import Any

from nutamill.analysis.breakage.ore import Ore
from nutamill.analysis.measured_mapping import Mapping
from nutamill.analysis.ratings import Ratings
from nutamill.analysis.values import Reading, default_readings
from nutamill.base.atomic_file import refuse_suffix, write_whole
from nutamill.base.errors import CaseError, Fault, OutputError
from nutamill.base.files import exists
from nutamill.base.library import similar
from nutamill.case.machine import Machine
from nutamill.case.mill import Case, load_case
from nutamill.case.starter import starter
from nutamill.case.toml.schema import file_schema
from nutamill.studies.fit_file import FitFile
from nutamill.studies.identify.identify_file import IdentifyFile
from nutamill.studies.measurand import MODE
from nutamill.studies.sweep_file import SweepFile

KINDS: dict[str, type] = {
    "mill": Case,
    "mechanism": Machine,
    "sweep": SweepFile,
    "fit": FitFile,
    "identify": IdentifyFile,
    "ratings": Ratings,
    "ore": Ore,
    "mapping": Mapping,
}
"""What can be written, and what its content is."""
NEXT = {
    "mill": "nutamill check {}",
    "mechanism": "nutamill check {}",
    "sweep": "nutamill sweep {}",
    "fit": "nutamill fit {}",
    "identify": "nutamill identify {}",
    "ratings": "nutamill life RESULT.h5 {}",
    "ore": "nutamill breakage RESULT.h5 --ore {}",
    "mapping": "nutamill import TEST.csv --map {}",
}
"""The command that a file of each kind is for."""
CHANGED = (
    ("drives", "speed"),
    ("springs", "stiffness"),
    ("linear_drives", "speed"),
    ("unbalance_motors", "speed"),
    ("bodies", "mass"),
)
"""List of parts and key that the first sweep of a machine varies: the first that it has."""
FREE = (("springs", "stiffness"), ("bodies", "mass"))
"""List of parts and key that the first fit or identification of a machine leaves free."""
WITH_BASE = ("mill", "sweep", "fit", "identify")
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
    case = load_case(base or "numill") if kind in WITH_BASE else None
    machine = None if case is None or case.drawing is not None else case.machine
    text = starter(base or "numill", file) if kind == "mill" else _filled(kind, base or "numill", machine)
    form = "mechanism" if kind == "mill" and machine is not None else kind
    if exists(file):
        raise CaseError(Fault(str(file), "exists already", "Choose another name"))
    schema = file.with_name(f"nutamill-{form}.schema.json")
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
    write_whole(schema, json.dumps(schema_of(form), indent=1) + "\n")
    return schema


def _filled(kind: str, base: str, machine: Machine | None) -> str:
    """Return the text of a file of a kind. For a `machine` given part by part it names what that has."""
    file = f"{kind}.toml" if machine is None else f"{kind}-of-parts.toml"
    template = (resources.files("nutamill") / "data" / "starters" / file).read_text(encoding="utf-8")
    return Template(template).safe_substitute({} if machine is None else _facts(kind, machine), base=base)


def _facts(kind: str, machine: Machine) -> dict[str, str]:
    """Return what a first sweep, fit or identification of a machine names: a key with a value below and one
    above its own, what is read of a run, and a quantity with its unit to fit to.
    """
    content = machine.model_dump(mode="json", by_alias=True, exclude_none=True)
    key, value = next(
        (f"{home}.{part['name']}.{name}", part[name])
        for home, name in (CHANGED if kind == "sweep" else FREE)
        for part in content.get(home, [])
        if name in part
    )
    number, unit = value.split(" ", 1)
    readings = default_readings(machine.with_("charge.kind", "none"))
    sprung = bool(machine.springs or machine.bushings) or not readings
    return {
        "key": key,
        "value": value,
        "less": f"{0.8 * float(number):g} {unit}",
        "more": f"{1.2 * float(number):g} {unit}",
        "readings": json.dumps([_named(one) for one in default_readings(machine)]),
        "quantity": f"{MODE} 1" if sprung else _named(readings[0]),
        "unit": "Hz" if sprung else readings[0].field.unit,
    }


def _named(reading: Reading) -> str:
    """Return a reading as a file names it."""
    return reading.series if reading.by == "mean" else f"{reading.by} {reading.series}"


def _refuse_kind(kind: str) -> None:
    """Raise CaseError for what is no kind of file."""
    if kind not in KINDS:
        what = f'must be one of {", ".join(KINDS)}, got "{kind}"'
        raise CaseError(Fault("kind of file", what, similar(kind, list(KINDS))))
