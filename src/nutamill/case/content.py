"""What no file of tables may hold, whatever it describes: endless nesting or lists, and text that upsets a
screen.

A finding is (key, what, hint), as in `nutamill.case.mill_checks`.
"""

from collections.abc import Iterator
from typing import Any

from nutamill.base.errors import printable
from nutamill.base.schema import spelled

MOST_DEPTH = 20
"""Tables and lists within each other [1]."""
MOST_ENTRIES = 1000
"""Keys of a table, and tables of a list [1]."""
MOST_CHARACTERS = 1000
"""Length of a text [1]."""
MOST_KEY_CHARACTERS = 100
"""Length of one part of a key [1]."""
MOST_INTEGER = 2**63 - 1
"""Largest whole number; what a result file can store [1]."""

Finding = tuple[tuple[str | int, ...], str, str]


def shape_finding(content: dict[str, Any]) -> Finding | None:
    """Return the first table or list that is nested too deeply or holds too much, or None without one."""
    waiting: list[tuple[tuple[str | int, ...], Any]] = [((), content)]
    while waiting:
        key, value = waiting.pop()
        if len(key) > MOST_DEPTH:
            return key[:3], f"is nested more than {MOST_DEPTH} levels deep", ""
        tables = isinstance(value, (list, tuple)) and any(isinstance(inner, dict) for inner in value)
        if (isinstance(value, dict) or tables) and len(value) > MOST_ENTRIES:
            return key, f"must hold at most {MOST_ENTRIES} keys or tables, got {len(value)}", ""
        if isinstance(value, dict):
            waiting += [
                ((*key, inner), below)
                for inner, below in value.items()
                if isinstance(below, (dict, list, tuple))
            ]
        elif isinstance(value, (list, tuple)):
            waiting += [
                ((*key, k), below) for k, below in enumerate(value) if isinstance(below, (dict, list, tuple))
            ]
    return None


def text_findings(content: dict[str, Any]) -> Iterator[Finding]:
    """Yield every key and text that cannot be shown on one line, and every whole number that is too large."""
    waiting: list[tuple[tuple[str | int, ...], Any]] = [((), content)]
    while waiting:
        key, value = waiting.pop()
        if isinstance(value, dict):
            for name in value:
                if len(str(name)) > MOST_KEY_CHARACTERS or printable(str(name)) != str(name):
                    what = f"a key must be one line of at most {MOST_KEY_CHARACTERS} characters"
                    yield key, f"{what}, got {spelled(str(name))}", ""
            waiting += [((*key, name), inner) for name, inner in value.items()]
        elif isinstance(value, (list, tuple)):
            waiting += [((*key, k), inner) for k, inner in enumerate(value)]
        elif isinstance(value, str) and (len(value) > MOST_CHARACTERS or printable(value) != value):
            what = f"must be one line of at most {MOST_CHARACTERS} characters without control characters"
            yield key, f"{what}, got {spelled(value)}", ""
        elif isinstance(value, int) and abs(value) > MOST_INTEGER:
            yield key, f"must be a whole number of at most {MOST_INTEGER}, got {spelled(value)}", ""
