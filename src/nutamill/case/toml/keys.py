"""One key of a case: what kind of quantity it takes, and what a case holds there."""

import math
import typing
from typing import Any

from nutamill.base import units
from nutamill.base.errors import CaseError, Fault
from nutamill.base.schema import Quantity, spelled
from nutamill.case.case_file import CaseFile
from nutamill.case.machine import Machine
from nutamill.case.mill import Case
from nutamill.case.toml.addresses import numbered, typed_key
from nutamill.case.toml.messages import fields_at

KINDS = (Case, Machine)
"""What case files describe."""


def quantity_at(key: str) -> Quantity | None:
    """Return the kind of quantity that a dotted key takes, or None for counts, ratios, texts and unknown
    keys.
    """
    try:
        *table, last = typed_key(key)
    except ValueError:
        return None
    fields = (fields_at(kind, tuple(table)).get(last) for kind in KINDS)
    field = next((field for field in fields if field is not None), None)
    return None if field is None else _quantity([*field.metadata, field.annotation])


def _quantity(marks: typing.Iterable[Any]) -> Quantity | None:
    """Return the mark of a quantity among metadata, or within an optional type."""
    for mark in marks:
        if isinstance(mark, Quantity):
            return mark
        if inner := _quantity(typing.get_args(mark)):
            return inner
    return None


def unit_at(key: str) -> str:
    """Return the SI unit of the value of a dotted key, ``1`` for a plain number."""
    quantity = quantity_at(key)
    return next(iter(units.UNITS[quantity.kind])) if quantity else "1"


def si_at(key: str, given: Any, where: str) -> float:
    """Return the SI value of what was given for a dotted key: text with a unit, or a plain number where the
    key takes one.

    Raises
    ------
    CaseError : another kind of quantity, no unit, or no number
    """
    quantity = quantity_at(key)
    if quantity is not None:
        return si_of(given, quantity.kind, where)
    if isinstance(given, bool) or not isinstance(given, (int, float)) or not math.isfinite(given):
        raise CaseError(Fault(where, f"must be a plain number, got {spelled(given)}"))
    return float(given)


def si_of(given: Any, kind: units.Kind, where: str) -> float:
    """Return the SI value of text with a unit. Raises CaseError for other text."""
    if not isinstance(given, str):
        raise CaseError(
            Fault(where, f"needs a unit, got {spelled(given)}", f'Write e.g. "{units.example(kind)}"')
        )
    try:
        return units.parse(given, kind)
    except units.UnitError as error:
        raise CaseError(Fault(where, error.what, error.hint)) from None


def held(case: CaseFile, key: str) -> Any:
    """Return the SI value of a case at a dotted key, or None where there is nothing."""
    value: Any = case.model_dump(by_alias=True)
    for part in numbered(value, typed_key(key)):
        try:
            value = value[part]
        except (KeyError, IndexError, TypeError):
            return None
    return value
