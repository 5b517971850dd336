"""Addresses of keys: what a user types, which entry of a list it means, and how a message writes it.

An entry of a list of tables is addressed by its name, ``bodies.box.mass``, or by its number from 0,
``walls.0.material``.  Messages write a number in brackets, ``walls[0].material``; that may be typed too.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from nutamill.base.library import similar
from nutamill.base.schema import spelled
from nutamill.case.toml.locate import key_parts

MOST_NAMED = 20
"""Entries that a message names before it counts the rest [1]."""
MOST_DIGITS = 9
"""Digits of the number of an entry [1]."""

Key = tuple[str | int, ...]

_NUMBER = re.compile(rf"[0-9]{{1,{MOST_DIGITS}}}")
_BRACKETS = re.compile(r"\[([0-9]+)\]")
_NAME = re.compile(r"(?![0-9]+$)[A-Za-z0-9_-]+")
"""Names that need no quotes in a dotted key and are no numbers."""


def typed_key(dotted: str) -> tuple[str, ...]:
    """Return the parts of a key as a user types it.

    ``walls[0].unit`` has those of ``walls.0.unit``.

    Raises
    ------
    ValueError : not a dotted key
    """
    quoted = '"' in dotted or "'" in dotted
    return key_parts(dotted if quoted else _BRACKETS.sub(r".\1", dotted))


def is_tables(value: Any) -> bool:
    """Return whether a value is a list of tables."""
    return (
        isinstance(value, (list, tuple))
        and bool(value)
        and all(isinstance(inner, Mapping) for inner in value)
    )


def entries_of(value: Any) -> Iterator[tuple[str | int, dict[str, Any]]]:
    """Yield number and table of each entry of a list, or address and changes of each entry that a layer
    changes.
    """
    listed = value if isinstance(value, (list, tuple)) else ()
    for part, table in value.items() if isinstance(value, dict) else enumerate(listed):
        if isinstance(table, dict):
            yield part, table


def entry_number(tables: Sequence[Mapping[str, Any]], part: str | int) -> int | None:
    """Return the number of the entry that a name or a number addresses, or None if there is none."""
    if isinstance(part, int) or _NUMBER.fullmatch(part):
        return int(part) if int(part) < len(tables) else None
    return next((number for number, table in enumerate(tables) if table.get("name") == part), None)


def entry_label(tables: Sequence[Any], number: int) -> str | int:
    """Return the name by which an entry is addressed, or its number where it has no name of its own."""
    if not is_tables(tables):
        return number
    name = tables[number].get("name")
    named = isinstance(name, str) and _NAME.fullmatch(name) and entry_number(tables, name) == number
    return name if named else number


def numbered(content: Any, key: Key) -> Key:
    """Return a key with every entry of a list by its number."""
    return tuple(part if number is None else number for part, _, number in _along(content, key))


def labelled(content: Any, key: Key) -> Key:
    """Return a key with every entry of a list by its name, where it has one."""
    return tuple(
        part if number is None else entry_label(tables, number)
        for part, tables, number in _along(content, key)
    )


def _along(content: Any, key: Key) -> Iterator[tuple[str | int, Any, int | None]]:
    """Yield each part of a key, the table or list it is in, and the number of the entry it means."""
    inner = content
    for part in key:
        listed = isinstance(inner, (list, tuple)) if isinstance(part, int) else is_tables(inner)
        number = entry_number(inner, part) if listed else None
        yield part, inner, number
        if number is not None:
            inner = inner[number]
        else:
            inner = inner.get(part) if isinstance(inner, Mapping) else None


def no_entry(tables: Sequence[Mapping[str, Any]], where: str, part: str | int) -> tuple[str, str]:
    """Return what is wrong with the address of an entry that is not there, and what to write instead.

    Parameters
    ----------
    tables : the list
    where : its dotted key
    part : the name or number that was typed
    """
    what = f"no such entry, got {spelled(part)}"
    labels = [entry_label(tables, number) for number in range(len(tables))]
    names = [label for label in labels if isinstance(label, str)]
    if not names:
        last = f"{where}.0" if len(tables) == 1 else f"{where}.0 to {where}.{len(tables) - 1}"
        return what, f"The entries have no names. Write {last}"
    near = similar(str(part), names)
    rest = f" and {len(labels) - MOST_NAMED} more" if len(labels) > MOST_NAMED else ""
    known = f"Known: {', '.join(map(str, labels[:MOST_NAMED]))}{rest}"
    return what, f"{near} {known}" if near.startswith("Did") else known


def dotted(key: Key) -> str:
    """Return a key as messages write it: ``bodies.box.between[1]``."""
    return "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in key).lstrip(".")


def placed(places: Mapping[Key, str], key: Key, content: Any = None) -> str:
    """Return ``where`` of a fault: a key with the place of its nearest known parent.

    Parameters
    ----------
    places : where each key stands, entries of lists by their number
    key : the key
    content : the tables it is in, whose entries are then named
    """
    place = nearest(places, key)
    shown = dotted(key if content is None else labelled(content, key))
    if not place or not shown:
        return place or shown or "case"
    return f"{place} {shown}" if place == "--set" else f"{place}: {shown}"


def nearest(places: Mapping[Key, str], key: Key) -> str:
    """Return the place of a key or of its nearest known parent, or empty without any."""
    return next((places[key[:n]] for n in range(len(key), -1, -1) if key[:n] in places), "")
