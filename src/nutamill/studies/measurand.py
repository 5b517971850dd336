"""What a campaign compares with a measurement: a series of a result, a quantity of the papers, or a natural
frequency about rest.
"""

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

from nutamill.analysis.values import Reading, reading_of
from nutamill.analysis.windows import PAPER_WINDOW
from nutamill.base import units
from nutamill.base.errors import CaseError, Fault, ResultError
from nutamill.base.library import similar
from nutamill.base.schema import spelled
from nutamill.base.steady import NO_ESTIMATE, Estimate
from nutamill.case import Case, Machine
from nutamill.case.toml.keys import si_of
from nutamill.design.modes import machine_modes
from nutamill.design.preflight import oscillations
from nutamill.result import open_result
from nutamill.simulation.setup.model import recorded_fields
from nutamill.studies.papers.quantities import QUANTITIES
from nutamill.studies.table import Outcome

MODE = "natural_frequency"
"""Word that names a natural frequency, followed by its number."""


class Measurand(NamedTuple):
    """A quantity, how it is called, and its unit."""

    what: Reading | str | int
    """What is read from a result, the name of a quantity of the papers, or the number of a mode, counted
    from 1.
    """
    label: str
    """What to call it in a table."""
    unit: str
    """Its SI unit, ``1`` for a plain number."""


def measurand_of(text: str, where: str, machine: Machine) -> Measurand:
    """Return what a text names: a series, ``rms`` or ``swing`` and a series, ``natural_frequency 1``, or a
    quantity of the papers such as ``resonance_time``.

    Parameters
    ----------
    machine : the machine whose file may name quantities of its own

    Raises
    ------
    CaseError : no such series or mode, or a series that the machine does not record
    """
    word, _, number = text.partition(" ")
    if word != MODE and text in QUANTITIES:
        observable = QUANTITIES[text]
        unit = next(iter(units.UNITS[observable.kind])) if observable.kind else "1"
        return Measurand(text, observable.label, unit)
    if word != MODE:
        reading = reading_of(text, where, machine)
        refuse_unrecorded([reading], [machine], where)
        by = "" if reading.by == "mean" else f" ({reading.by})"
        return Measurand(reading, f"{reading.field.label}{by}", reading.field.unit)
    if not number.isdigit() or int(number) < 1:
        what = f'must number the mode from 1, got "{text}"'
        raise CaseError(Fault(where, what, f'Write "{MODE} 1"'))
    return Measurand(int(number), f"natural frequency {number}", "Hz")


def refuse_unrecorded(readings: Sequence[Reading], machines: Iterable[Machine], where: str) -> None:
    """Raise CaseError for readings of series that none of the machines records."""
    missing = dict.fromkeys(reading.series for reading in readings)
    names: list[str] = []
    for machine in machines:
        names = [field.name for field in recorded_fields(machine)]
        missing = {name: None for name in missing if name not in names}
        if not missing:
            return
    raise CaseError(
        *(Fault(where, f'the machine records no series "{name}"', similar(name, names)) for name in missing)
    )


def si_in(unit: str, given: Any, where: str) -> float:
    """Return the SI value of what was given for a quantity of this SI unit: text with a unit, or a plain
    number where the unit is ``1``.

    Raises
    ------
    CaseError : no unit, or one of another kind
    """
    kind = next((kind for kind, table in units.UNITS.items() if unit in table), None)
    if kind is not None:
        return si_of(given, kind, where)
    if unit != "1":
        raise CaseError(Fault(where, f"has a unit that no key has, {unit}", "Take one of its factors"))
    if isinstance(given, bool) or not isinstance(given, (int, float)):
        raise CaseError(Fault(where, f"must be a number without a unit, got {spelled(given)}"))
    return float(given)


def value_in(outcome: Outcome, what: Reading | str, last: float = PAPER_WINDOW) -> Estimate:
    """Return the steady mean of a series or of a quantity of the papers in a finished run, NaN where the run
    has none.

    Parameters
    ----------
    last : length of the window of a quantity of the papers [s]
    """
    if isinstance(what, Reading):
        return outcome.values.get(what, NO_ESTIMATE)
    measure = QUANTITIES[what].measure
    assert measure is not None  # only natural frequencies have none
    with open_result(outcome.file) as result:
        try:
            return measure(result, last)
        except ResultError:
            return NO_ESTIMATE


def rest_frequency(case: Case | Machine, number: int) -> float:
    """Return a natural frequency about rest [Hz], of a mill on its mounts with rigid bars as they are, NaN if
    there are fewer.
    """
    mill = case.drawing
    if mill is not None:
        frequencies = [frequency for frequency, _ in oscillations(mill)]
    else:
        frequencies = [float(frequency) for frequency in machine_modes(case).frequency]
    return frequencies[number - 1] if number <= len(frequencies) else float("nan")
