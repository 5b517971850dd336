"""What one key of a case means: quantity, choices, present value, and the note on it in the machine file."""

import difflib
import typing
from typing import Any

from nutamill.base import units
from nutamill.base.errors import CaseError, Fault
from nutamill.base.library import LONGEST_WORD
from nutamill.base.schema import spelled
from nutamill.case import load_case
from nutamill.case.titles import leaves
from nutamill.case.toml.addresses import entry_label, labelled, numbered, typed_key
from nutamill.case.toml.keys import quantity_at
from nutamill.case.toml.messages import fields_at
from nutamill.case.toml.notes import Notes

ENTRY = "NAME"
"""Stands for the name of an entry of a list of tables."""

LISTED = 40
"""Keys of a table that are listed before the rest is counted [1]."""


def explained(key: str, name: str = "numill") -> list[str]:
    """Return what a key takes, what it means, and what it holds in a case.

    Parameters
    ----------
    key : dotted key, as ``chamber.ribs``; of a table, as ``chamber``, its keys are listed
    name : a case file, or a machine of the package

    Raises
    ------
    CaseError : no such key, or a case with faults
    """
    case = load_case(name)
    content = case.model_dump(mode="json", by_alias=True, exclude_none=True)
    try:
        path = typed_key(key)
    except ValueError:
        path = ()
    top = type(case)
    field = fields_at(top, path[:-1]).get(path[-1]) if path else None
    if field is None:
        if path and (own := fields_at(top, path)) and _at(content, path):
            return [f"{key}: an entry of {'.'.join(path[:-1])}", *_listed(key, own)]
        raise _unknown(key, content, top)
    lines = [f"{key}: {plain_text(field.description) or 'a table'}"]
    entries = fields_at(top, (*path, ENTRY))
    if inner := fields_at(top, path) or entries:
        if entries:
            tables = _at(content, path)
            labels = (
                tables if isinstance(tables, dict) else (entry_label(tables, n) for n in range(len(tables)))
            )
            named = [str(label) for label in labels]
            lines.append(f"  {len(named)} in {name}: {', '.join(named)}" if named else f"  none in {name}")
            key = f"{key}.{named[0] if named else ENTRY}"
        return lines + _listed(key, inner)
    lines.append(f"  takes   {_takes(key, field)}")
    value = dict(leaves(content)).get(".".join(map(str, labelled(content, path))))
    if value is not None:
        lines.append(f"  value   {value if isinstance(value, str) else spelled(value)} in {name}")
    mark, note = Notes(name).of(numbered(content, path))
    if mark:
        lines.append(f"  source  {mark}")
    if note:
        lines.append(f"  note    {note}")
    return lines


def _listed(key: str, fields: dict[str, Any]) -> list[str]:
    """Return a line for each key of a table."""
    listed = [f"  {key}.{part:20} {plain_text(one.description)}" for part, one in fields.items()]
    return listed[:LISTED]


def _at(content: dict[str, Any], path: tuple[str, ...]) -> Any:
    """Return what a case holds under a key, or nothing where it has no such key."""
    inner: Any = content
    for part in numbered(content, path):
        try:
            inner = inner[part]
        except (KeyError, IndexError, TypeError):
            return ()
    return inner


def _takes(key: str, field: Any) -> str:
    """Return what kind of value a key takes, with an example."""
    quantity = quantity_at(key)
    if quantity is not None:
        word = f' or "{quantity.word}"' if quantity.word else ""
        names = ", ".join(units.UNITS[quantity.kind])
        return f'{quantity.kind}, e.g. "{units.example(quantity.kind)}"{word}; units: {names}'
    choices = choices_of(field.annotation)
    if choices:
        return ", ".join(f'"{choice}"' if isinstance(choice, str) else str(choice) for choice in choices)
    text = str(field.annotation)
    return "a whole number" if "int" in text else "a plain number" if "float" in text else "text or a table"


def choices_of(kind: Any) -> tuple[Any, ...]:
    """Return the words that a key may hold, also within an optional type."""
    if typing.get_origin(kind) is typing.Literal:
        return typing.get_args(kind)
    return next((choices for part in typing.get_args(kind) if (choices := choices_of(part))), ())


def _unknown(key: str, content: dict[str, Any], top: type) -> CaseError:
    """Return the error of a key that is none, with the keys that were probably meant."""
    known = sorted({*(name for name, _ in leaves(content)), *fields_at(top, ())})
    lasts = [name.rpartition(".")[2] for name in known]
    near = difflib.get_close_matches(key.rpartition(".")[2][:LONGEST_WORD], lasts, n=1, cutoff=0.6)
    meant = [name for name, last in zip(known, lasts, strict=True) if last in near][:LISTED]
    tables = ", ".join(fields_at(top, ()))
    hint = f"Did you mean {', '.join(meant)}?" if meant else f"Tables: {tables}"
    return CaseError(Fault(spelled(key), "is no key of this case", hint))


def plain_text(description: str | None) -> str:
    """Return a description as one line without the marks of code."""
    return " ".join((description or "").replace("``", "").split())
