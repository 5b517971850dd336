"""Mapped variables of an FMU: the one that a name stands for, its unit, and what is wrong with it."""

import math
import re
from typing import NamedTuple

from nutamill.base.errors import Fault
from nutamill.base.library import similar
from nutamill.base.schema import spelled
from nutamill.base.units import UNITS, Kind, UnitError, parse
from nutamill.simulation.fmus.description import REAL, FmuDescription, Unit, Variable

EXPONENTS = {
    Kind.LENGTH: (0, 1, 0),
    Kind.ANGLE: (0, 0, 0),
    Kind.VELOCITY: (0, 1, -1),
    Kind.SPEED: (0, 0, -1),
    Kind.ACCELERATION: (0, 1, -2),
    Kind.RAMP: (0, 0, -2),
    Kind.FORCE: (1, 1, -2),
    Kind.TORQUE: (1, 2, -2),
}
"""Exponents of kg, m, s of the kinds of quantities that are exchanged."""
TURNS = (Kind.ANGLE, Kind.SPEED, Kind.RAMP)
"""Kinds that have the radian in them, which FMI counts and SI does not."""
WHOLE_TYPES = (
    "Integer",
    "Enumeration",
    "Int8",
    "UInt8",
    "Int16",
    "UInt16",
    "Int32",
    "UInt32",
    "Int64",
    "UInt64",
)
START_TYPES = {"Boolean": bool, "String": str, "Binary": None} | dict.fromkeys(WHOLE_TYPES, int)
"""Python's types of start values by FMI's; what is not here takes a number."""


class Signal(NamedTuple):
    """A mapped variable."""

    name: str
    """Its name."""
    reference: int
    """Value reference [1]."""
    factor: float
    """SI value of one in the FMU, negative where the mapping has a minus sign [1]."""


class Start(NamedTuple):
    """A start value or a parameter."""

    name: str
    """Its name."""
    reference: int
    """Value reference [1]."""
    type: str
    """Type of FMI 2 or 3."""
    value: bool | int | float | str
    """The value, in the FMU's unit."""


class Names:
    """The variables of one FMU, looked up by the names of a mapping; faults are collected.

    Attributes
    ----------
    faults : what was wrong with the names so far
    inputs, outputs : signals in the order in which they are exchanged
    """

    def __init__(self, fmu: FmuDescription, units: dict[str, str], where: str):
        self._fmu, self._units, self._where = fmu, units, where
        self.faults: list[Fault] = []
        self.inputs: list[Signal] = []
        self.outputs: list[Signal] = []
        for name in units:
            self.variable(name, f"{where}.units")

    def variable(self, name: str, where: str) -> Variable | None:
        """Return the variable of a name, or None with a fault."""
        if (known := self._fmu.variables.get(name)) is None:
            what = f'the FMU has no variable "{name}"'
            self.faults.append(Fault(where, what, similar(name, list(self._fmu.variables))))
        return known

    def input(self, name: str, kind: Kind | None, where: str) -> int:
        """Return the place of an input among the exchanged ones, -1 for an empty name or a fault."""
        return self._signal(name, kind, where, self.inputs, ("input",))

    def output(self, name: str, kind: Kind | None, where: str) -> int:
        """Return the place of an output among the exchanged ones, -1 for an empty name or a fault."""
        return self._signal(name, kind, where, self.outputs, ("output", "local"))

    def check_link(self, name: str, source: "Names", output: str, where: str) -> None:
        """Add a fault if an input and the output of another FMU that it is set to have different units."""
        given, wanted = (names._fmu.variables.get(key) for names, key in ((source, output), (self, name)))
        if given is None or wanted is None or given.unit is None or wanted.unit is None:
            return
        if given.unit[1:] != wanted.unit[1:] or (given.unit[1] is None and given.unit != wanted.unit):
            what = f'"{name}" has the unit {wanted.unit.name}, "{output}" has {given.unit.name}'
            self.faults.append(Fault(where, what, "Link variables of the same unit"))

    def start(self, name: str, value: bool | int | float | str, where: str) -> Start | None:
        """Return a start value, or None with a fault."""
        if (known := self.variable(name, where)) is None:
            return None
        if known.causality in ("calculatedParameter", "independent") or known.variability == "constant":
            self.faults.append(Fault(where, f'"{name}" cannot be set: it is computed or constant'))
            return None
        takes = START_TYPES.get(known.type, float)
        fits = isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
        if takes is not float:
            fits = takes is not None and type(value) is takes
        if not fits or known.is_array:
            kind = "an array" if known.is_array else f"of type {known.type}"
            self.faults.append(Fault(where, f'"{name}" is {kind}, got {spelled(value)}'))
            return None
        return Start(name, known.reference, known.type, float(value) if takes is float else value)

    def _signal(
        self, given: str, kind: Kind | None, where: str, signals: list[Signal], causalities: tuple[str, ...]
    ) -> int:
        if not given:
            return -1
        name = given.removeprefix("-")
        if (known := self.variable(name, where)) is None:
            return -1
        if known.causality not in causalities:
            what = f'"{name}" is no {causalities[0]} of the FMU but: {known.causality}'
            hint = "A run cannot change it: give it under start" if "arameter" in known.causality else ""
            self.faults.append(Fault(where, what, hint))
            return -1
        if known.type not in REAL or known.is_array:
            what = f'"{name}" is {"an array" if known.is_array else f"of type {known.type}"}'
            self.faults.append(Fault(where, what, "A mapped variable is a single real number"))
            return -1
        factor = 1.0 if kind is None else self._factor(known, kind, where)
        if factor is None:
            return -1
        if any(signal.reference == known.reference for signal in signals) and signals is self.inputs:
            self.faults.append(Fault(where, f'"{name}" is set twice'))
            return -1
        signals.append(Signal(name, known.reference, -factor if given.startswith("-") else factor))
        return len(signals) - 1

    def _factor(self, known: Variable, kind: Kind, where: str) -> float | None:
        """Return the SI value of one of a variable that holds a `kind`, or None with a fault."""
        given = self._units.get(known.name)
        if known.unit is None and given is None:
            return 1.0
        if known.unit is not None and given is not None and known.unit.name != given:
            what = f'"{known.name}" has the unit {known.unit.name}, the case says {given}'
            self.faults.append(Fault(where, what, "Leave it out of units"))
            return None
        unit = known.unit or Unit(str(given), None, 1.0, 0.0)
        if (factor := unit_factor(unit, kind)) is None:
            si = next(iter(UNITS[kind]))
            what = f'"{known.name}" has the unit {unit.name}, which is no unit of {kind} like {si}'
            self.faults.append(Fault(where, what))
        return factor


def unit_factor(unit: Unit, kind: Kind) -> float | None:
    """Return the SI value of one `unit`, or None if it is no unit of this kind.

    Between a frequency and a speed of rotation nothing is guessed: 1/s is no speed.
    """
    text = re.sub(r"([A-Za-z])(-?\d)", r"\1^\2", unit.name.replace(".", " "))
    for name in (unit.name, text):
        try:
            return parse(f"1 {name}", kind)
        except UnitError:
            continue
    if kind is Kind.ANGLE and unit.name in ("1", ""):
        return 1.0
    if unit.exponents is None or unit.offset != 0.0 or any(unit.exponents[3:7]):
        return None
    fits = unit.exponents[:3] == EXPONENTS[kind]
    if kind in TURNS and unit.exponents[7] != 1:
        return None
    return unit.factor if fits else None
