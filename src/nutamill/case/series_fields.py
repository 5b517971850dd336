"""What the series of a machine are, those among them that its file names as quantities."""

from dataclasses import replace

from nutamill.base.errors import CaseError
from nutamill.case.machine import Machine, QuantityEntry
from nutamill.result.fields import Field, series_field

PRODUCTS = {
    frozenset(("N m", "rad/s")): "W",
    frozenset(("N", "m/s")): "W",
    frozenset(("N m", "rad")): "J",
    frozenset(("N", "m")): "J",
}
"""Units of products that have a name of their own."""


def machine_field(machine: Machine, name: str) -> Field:
    """Return what a series of a machine is: as the tables of fields declare it, else a quantity by what it is
    taken of.

    Raises
    ------
    CaseError : no such series
    """
    try:
        return series_field(name)
    except CaseError:
        entry = next((entry for entry in machine.quantities if entry.name == name), None)
        if entry is None:
            raise
    return _quantity_field(entry, [machine_field(machine, source.removeprefix("-")) for source in entry.of])


def _quantity_field(entry: QuantityEntry, sources: list[Field]) -> Field:
    """Return what a quantity is, by the series that it is taken of."""
    units = [source.unit for source in sources]
    unit = {"product": PRODUCTS.get(frozenset(units), "*".join(units)), "lag": "rad"}
    label = entry.name.replace("_", " ")
    meaning = f"{entry.take} of {', '.join(entry.of)}" + (", zeroed at the start" if entry.zeroed else "")
    return replace(
        sources[0], name=entry.name, label=label, meaning=meaning, unit=unit.get(entry.take, units[0])
    )
