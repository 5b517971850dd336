"""A case as a form: every number and word of it that a user may change, table by table, from the schema."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from nutamill.base import units
from nutamill.case.machine import Machine
from nutamill.case.mill import Case
from nutamill.case.titles import leaves
from nutamill.case.toml.addresses import is_tables, numbered, typed_key
from nutamill.case.toml.explain import choices_of, plain_text
from nutamill.case.toml.keys import quantity_at
from nutamill.case.toml.messages import fields_at
from nutamill.case.toml.notes import Notes
from nutamill.case.toml.write import toml_value

ASIDE = ("schema", "title", "changed_from")
"""Keys at the top that are no numbers of the machine."""
FILES = ("file", "sha256", "source", "profile", "shapes", "mesh", "clumps")
"""Parts of keys that name files or hold their content: a form leaves them to the case file."""
SI = re.compile(r" \[[^\]]*\]")
"""The SI unit in a description: the value beside it shows its own."""
LONGEST = 200
"""Characters of a value that a form offers for changing [1]."""


class FormKey(NamedTuple):
    """One key of a form."""

    key: str
    """Dotted key, as after ``--set``."""
    value: str
    """Present value as a file writes it, without the quotes of text; empty where the case leaves it out."""
    meaning: str
    """What it is, one line."""
    takes: str
    """Kind of quantity, ``whole number``, ``number``, ``list`` or ``text``."""
    units: tuple[str, ...]
    """Units that its text may have; none for plain numbers."""
    choices: tuple[str, ...]
    """The words it may hold; none where it takes anything."""
    mark: str
    """``published``, ``fitted to a published number`` or ``assumed``, where the case file marks it."""
    note: str
    """What the case file notes beside it."""


def form_of(name: str | Path, case: Case | Machine) -> list[FormKey]:
    """Return every key of a case that a form offers: those it holds, then those its tables leave out.

    Parameters
    ----------
    name : the case file, or machine of the package, that the notes stand in
    case : the case, with what was changed
    """
    content = case.model_dump(mode="json", by_alias=True, exclude_none=True)
    notes, top = Notes(name), type(case)
    entries = []
    for key, value in leaves({part: inner for part, inner in content.items() if part not in ASIDE}):
        path = typed_key(key)
        text = value if isinstance(value, str) else toml_value(value)
        if not set(path).isdisjoint((*FILES, "name")) or len(text) > LONGEST or value == []:
            continue
        field = fields_at(top, path[:-1]).get(path[-1])
        if field is not None:
            entries.append(_entry(key, text, field, *notes.of(numbered(content, path))))
    return entries + list(_left_out(top, content, ""))


def _left_out(top: type[Case] | type[Machine], table: Any, above: str) -> Iterator[FormKey]:
    """Yield the keys that the tables of a case leave out and that take a number or a word."""
    tables = {key: inner for key, inner in table.items() if isinstance(inner, dict) and key not in FILES}
    for key, inner in tables.items():
        home = f"{above}.{key}".lstrip(".")
        for part, field in fields_at(top, typed_key(home)).items():
            dotted = f"{home}.{part}"
            plain = quantity_at(dotted) is not None or choices_of(field.annotation) or _number(field)
            if part not in inner and part not in FILES and plain:
                yield _entry(dotted, "", field, "", "")
        if not is_tables(inner):
            yield from _left_out(top, inner, home)


def _entry(key: str, value: str, field: Any, mark: str, note: str) -> FormKey:
    """Return the entry of a key whose field is known."""
    quantity = quantity_at(key)
    choices = tuple(str(choice) for choice in choices_of(field.annotation))
    if field.annotation is bool:
        choices = ("true", "false")
    number = "" if choices else _number(field)
    takes = str(quantity.kind) if quantity else number or ("list" if value[:1] == "[" else "text")
    known = tuple(units.UNITS[quantity.kind]) if quantity else ()
    meaning = SI.sub("", plain_text(field.description).replace("`", ""))
    return FormKey(key, value, meaning, takes, known, choices, mark, note)


def _number(field: Any) -> str:
    """Return what kind of plain number a field takes, empty where it takes none."""
    text = str(field.annotation)
    if "tuple" in text or "dict" in text:
        return ""
    return "whole number" if "int" in text else "number" if "float" in text else ""
