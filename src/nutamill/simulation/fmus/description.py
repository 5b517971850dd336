"""What the description of an FMU declares, read without running any of its code."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from nutamill.base.errors import CaseError, Fault, missing_extra
from nutamill.simulation.fmus.archive import opened

DESCRIPTION = "modelDescription.xml"
MOST_DESCRIPTION = 100_000_000
"""Largest description [bytes]."""
PLAIN = ("", "-", "1", "dimensionless")
"""Names of units that say nothing of a quantity: some programs give them to every variable."""
REAL = ("Real", "Float64")
"""Types of the variables that can be mapped."""


class Unit(NamedTuple):
    """A unit as an FMU declares it."""

    name: str
    """Its name."""
    exponents: tuple[int, ...] | None
    """Exponents of kg, m, s, A, K, mol, cd, rad [1]; None if the FMU does not give them."""
    factor: float
    """SI value of one [1]."""
    offset: float
    """SI value of zero [1]."""


class Variable(NamedTuple):
    """A variable of an FMU."""

    name: str
    """Its name."""
    reference: int
    """Value reference [1]."""
    causality: str
    """Causality: input, output, parameter, calculatedParameter, local or independent."""
    variability: str
    """Variability: constant, fixed, tunable, discrete or continuous."""
    type: str
    """Type by its name in FMI 2 or 3."""
    is_array: bool
    """Whether it is an array of FMI 3."""
    start: str | None
    """Start value as written."""
    unit: Unit | None
    """Its unit; None if it has none but that of a plain number."""


@dataclass(frozen=True, slots=True)
class FmuDescription:
    """An FMU for co-simulation."""

    path: Path
    """The archive."""
    version: int
    """Version of FMI [1]: 2 or 3."""
    model: str
    """Name of the model."""
    model_version: str
    """Version of the model; empty if not given."""
    tool: str
    """Program that made it; empty if not given."""
    token: str
    """GUID or instantiation token."""
    identifier: str
    """Name of its libraries."""
    can_roll_back: bool
    """Whether its state can be got and set."""
    can_serialise: bool
    """Whether its state can be stored in a file."""
    own_step: float
    """Step inside the FMU that it declares [s], 0 if it declares none."""
    variables: dict[str, Variable]
    """Its variables by name."""

    @property
    def title(self) -> str:
        """Model, version and program in one line."""
        by = f", made by {self.tool}" if self.tool else ""
        version = f" {self.model_version}" if self.model_version else ""
        return f"{self.model}{version}, FMI {self.version}{by}"


def fmpy() -> Any:
    """Import FMPy. Raise NotInstalledError if it is missing."""
    try:
        import fmpy
    except ImportError:
        raise missing_extra("An FMU", "FMPy", "fmu") from None
    return fmpy


def read_description(path: Path, where: str) -> FmuDescription:
    """Read the description of an FMU for co-simulation.

    Parameters
    ----------
    path : the archive
    where : key of the file, for messages

    Raises
    ------
    CaseError : no FMU, an FMI version or kind that is not taken, no library for this platform
    NotInstalledError : FMPy is missing
    """
    library = fmpy()
    with opened(path, where) as archive:
        names = archive.namelist()
        if DESCRIPTION not in names:
            raise CaseError(Fault(where, f"{path.name} holds no {DESCRIPTION}", "It is no FMU"))
        if archive.getinfo(DESCRIPTION).file_size > MOST_DESCRIPTION:
            raise CaseError(Fault(where, f"the description of {path.name} is too large to be one"))
        written = re.search(rb"fmiVersion\s*=\s*[\"']([^\"']*)", archive.read(DESCRIPTION))
        number = "" if written is None else written[1].decode(errors="replace")
        version = number.partition(".")[0]
        if number and version not in ("2", "3"):
            what = f"{path.name} is an FMU of FMI {number}; FMI 2 and 3 are taken"
            raise CaseError(Fault(where, what, "Export it with FMI 2.0 or 3.0"))
        described = _parsed(library, path, where)
    simulation = described.coSimulation
    if simulation is None:
        what = f"{path.name} is for model exchange only: it brings no solver"
        raise CaseError(Fault(where, what, "Export it for co-simulation"))
    platform = library.platform_tuple if version == "3" else library.platform
    folder, ending = f"binaries/{platform}/", library.sharedLibraryExtension
    if f"{folder}{simulation.modelIdentifier}{ending}" not in names:
        there = sorted({name.split("/")[1] for name in names if name.startswith("binaries/") and name[9:]})
        what = f"{path.name} has no library for {platform}, it has {', '.join(there) or 'none'}"
        raise CaseError(Fault(where, what, "Export it for this platform"))
    return FmuDescription(
        path,
        int(version),
        described.modelName,
        described.version or "",
        described.generationTool or "",
        described.guid,
        simulation.modelIdentifier,
        bool(simulation.canGetAndSetFMUstate),
        bool(simulation.canSerializeFMUstate),
        float(getattr(simulation, "fixedInternalStepSize", None) or 0.0),
        _variables(described),
    )


def _parsed(library: Any, path: Path, where: str) -> Any:
    """Return FMPy's model description."""
    try:
        return library.read_model_description(str(path), validate=False)
    except Exception as error:  # a parser of another package: whatever it raises is a fault of the file
        lines = str(error).strip().splitlines() or [type(error).__name__]
        what = f"the description of {path.name} cannot be read: {lines[0]}"
        raise CaseError(Fault(where, what, "Export it again")) from None


def _variables(described: Any) -> dict[str, Variable]:
    """Return the variables of a description by name."""
    units = {}
    for unit in described.unitDefinitions or []:
        base = unit.baseUnit
        exponents = None
        if base is not None:
            exponents = tuple(
                int(getattr(base, k) or 0) for k in ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
            )
        factor, offset = (1.0, 0.0) if base is None else (float(base.factor), float(base.offset))
        units[unit.name] = Unit(unit.name, exponents, factor, offset)
    variables = {}
    for entry in described.modelVariables:
        declared = entry.unit or getattr(entry.declaredType, "unit", None) or ""
        variables[entry.name] = Variable(
            entry.name,
            int(entry.valueReference),
            entry.causality or "local",
            entry.variability or "continuous",
            entry.type,
            bool(entry.dimensions),
            entry.start,
            None if _is_plain(unit := units.get(declared, Unit(declared, None, 1.0, 0.0))) else unit,
        )
    return variables


def _is_plain(unit: Unit) -> bool:
    """Return whether a unit is that of a plain number."""
    number = unit.exponents is not None and not any(unit.exponents) and unit[2:] == (1.0, 0.0)
    return number or unit.name in PLAIN
