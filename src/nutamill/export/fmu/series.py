"""The recorded series of a machine as a list of sums, products and resultants of the columns of a row.

The compiled kernels write a row; what `nutamill.simulation.setup.readout` makes of it in NumPy for a result
file, an FMU does number by number from this list, in the same order, with the same bits.
"""

from typing import NamedTuple

from nutamill.simulation.setup.model import Model, State
from nutamill.simulation.setup.readout import LOSSES, STORED, WORKS

LEDGER = "ledger_residual"


class Term(NamedTuple):
    """A term of a series."""

    slot: int
    """Column of the row, or number of columns plus index of a series above [1]."""
    sign: float
    """Factor of its value [1]: 1, -1, or 0 for a constant."""
    zero: float
    """What is taken off [SI]."""


class Made(NamedTuple):
    """A series that is computed."""

    name: str
    """Its name; empty for a sum that only others use."""
    take: str
    """As `nutamill.case.machine.QuantityEntry.take`."""
    terms: list[Term]
    """What it is taken of."""


def made_series(model: Model, state: State) -> tuple[list[Made], dict[str, int]]:
    """Return the computed series in order, and the slot of every series by name.

    Parameters
    ----------
    model, state : of a machine without charge, at the start
    """
    readout, first = model.readout, state.first_row
    slots, n_columns = readout.columns(), readout.n_columns
    at_first = {name: float(values[0]) for name, values in readout.values(first[None, :], first).items()}
    made: list[Made] = []

    def add(name: str, take: str, terms: list[Term]) -> int:
        made.append(Made(name, take, terms))
        return n_columns + len(made) - 1

    def total(names: list[str]) -> Term:
        return Term(add("", "sum", [Term(slots[name], 1.0, 0.0) for name in names]), 1.0, 0.0)

    groups = readout.table.groups
    works = [name for name in slots if name.endswith("_work") and any(groups[group] for group in WORKS)]
    lost = [name for name in slots if name.endswith("_loss") and name.startswith(tuple(LOSSES.values()))]
    parts = [total(list(STORED)), *([total(lost)] if lost else [])]
    if works:
        parts.append(total(works)._replace(sign=-1.0))
    starts = readout.table.starts
    energy = float(sum(first[starts.mechanism_energy + k] for k in range(len(STORED))))
    slots[LEDGER] = add(LEDGER, "sum", [*parts, Term(0, 0.0, energy)])
    for entry in model.machine.quantities:
        terms = []
        for source in entry.of:
            sign, name = (-1.0, source[1:]) if source.startswith("-") else (1.0, source)
            terms.append(Term(slots[name], sign, sign * at_first[name] if entry.zeroed else 0.0))
        slots[entry.name] = add(entry.name, entry.take, terms)
    return made, slots
