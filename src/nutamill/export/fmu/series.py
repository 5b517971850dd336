"""The recorded series of a machine as a list of sums, products and resultants of the columns of a row.

The compiled kernels write a row; what `nutamill.simulation.setup.readout` makes of it in NumPy for a result
file, an FMU does number by number from this list, in the same order, with the same bits.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from nutamill.simulation.row import CONTACT_TERMS
from nutamill.simulation.setup.model import Model, State
from nutamill.simulation.setup.particles import charge_mass
from nutamill.simulation.setup.readout import LOSSES, STORED, WORKS

LEDGER = "ledger_residual"


class Term(NamedTuple):
    """A term of a series."""

    slot: int
    """Column of the row, or number of columns plus index of a series above [1]."""
    sign: float
    """Factor of its value: 1, -1, 0 for a constant, or what turns a time into an impulse."""
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
    model, state : of a machine, at the start
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
    works = [name for name in works if name != "interface_work"]
    lost = [name for name in slots if name.endswith("_loss") and name.startswith(tuple(LOSSES.values()))]
    stored = list(STORED)
    if model.charge is not None:
        stored.append("kinetic_energy_charge")
        lost += _add_charge(model, first, slots, add)
        if model.machine.run.coupling == "prescribed":  # an imposed motion supplies the work
            works.append("interface_work")
    parts = [total(stored), *([total(lost)] if lost else [])]
    if works:
        parts.append(total(works)._replace(sign=-1.0))
    slots[LEDGER] = add(LEDGER, "sum", [*parts, Term(0, 0.0, readout.start_energy(first))])
    for entry in model.machine.quantities:
        terms = []
        for source in entry.of:
            sign, name = (-1.0, source[1:]) if source.startswith("-") else (1.0, source)
            terms.append(Term(slots[name], sign, sign * at_first[name] if entry.zeroed else 0.0))
        slots[entry.name] = add(entry.name, entry.take, terms)
    return made, slots


def _add_charge(
    model: Model, first: np.ndarray, slots: dict[str, int], add: Callable[[str, str, list[Term]], int]
) -> list[str]:
    """Add the series of the charge that are computed, and return the names of its losses, in the order of the
    ledger.
    """
    at = model.readout.table.column

    def column(group: str, name: str, sign: float = 1.0) -> Term:
        return Term(at(group, name), sign, 0.0)

    kinetic = [column("charge_energy", f"kinetic_{kind}") for kind in ("translational", "rotational")]
    slots["kinetic_energy_charge"] = add("kinetic_energy_charge", "sum", kinetic)
    potential = [Term(slots["potential_energy"], 1.0, 0.0), column("ledger", "gravity", -1.0)]
    slots["potential_energy"] = add("potential_energy", "sum", potential)
    names = [f"{where}_{term}" for where in ("pair", "wall") for term in CONTACT_TERMS]
    elastic = [Term(slots["elastic_energy"], 1.0, 0.0), *(column("charge_energy", name) for name in names)]
    slots["elastic_energy"] = add("elastic_energy", "sum", elastic)
    losses: dict[str, list[Term]] = {}
    for where in ("pair", "wall"):
        for term in CONTACT_TERMS:
            name = f"{where}_{term}"
            at_start = Term(0, 0.0, -float(first[at("charge_energy", name)]))
            terms = [at_start, column("charge_energy", name, -1.0), column("ledger", name, -1.0)]
            losses[f"{name}_loss"] = terms
        if model.machine.contact.film != "none":
            losses[f"{where}_film_loss"] = [column("ledger", f"{where}_film", -1.0)]
    losses["substep_loss"] = [column("ledger", "scheme", -1.0)]
    slots |= {name: add(name, "sum", terms) for name, terms in losses.items()}
    defect = []
    for k, axis in enumerate("xyz"):
        weight = charge_mass(model.machine) * model.machine.gravity[k]
        began = float(first[at("momentum", axis)])
        terms = [Term(at("momentum", axis), 1.0, began), column("charge_impulse", axis)]
        terms.append(Term(at("time", "time"), -weight, -weight * float(first[at("time", "time")])))
        defect.append(Term(add("", "sum", terms), 1.0, 0.0))
    slots["interface_impulse_defect"] = add("interface_impulse_defect", "resultant", defect)
    return list(losses)
