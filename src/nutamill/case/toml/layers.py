"""Layers of a case: the base (and its base), the file, the values after ``--set`` or of a call in Python.

Each knows the place of each of its keys; `nutamill.case.toml.merge` makes one case of them.
"""

import re
import sys
import tomllib
from pathlib import Path
from typing import Any, NamedTuple

from nutamill.base.errors import CaseError, Fault
from nutamill.base.files import MOST_CASE_TEXT, is_file, is_folder, read_text
from nutamill.base.library import FOLDER, library_file, library_names, similar
from nutamill.base.schema import spelled
from nutamill.case.content import shape_finding
from nutamill.case.toml.addresses import (
    Key,
    dotted,
    entry_number,
    is_tables,
    no_entry,
    placed,
    typed_key,
)
from nutamill.case.toml.locate import key_lines

MOST_BASES = 20
"""Files in a chain of bases [1]."""


class Layer(NamedTuple):
    """One source of keys."""

    content: dict[str, Any]
    """Nested tables."""
    places: dict[Key, str]
    """Where each key stands, ``mymill.toml:14``; the empty key is the whole source."""
    folder: Path
    """Where its relative file names begin."""

    @classmethod
    def of_text(cls, text: str, shown: str, folder: Path | None = None) -> "Layer":
        """Return the layer of TOML text. Messages call it `shown`."""
        content = parsed(text, shown)
        refuse_shape(content, {(): shown})
        lines = {key: f"{shown}:{line}" for key, line in key_lines(text).items()} if content else {}
        return cls(content, {(): shown, **lines}, folder or Path.cwd())


def read_layer(name: str | Path) -> Layer:
    """Read the one layer of a file of any kind.

    Raises
    ------
    CaseError : no such file, no text, or no TOML
    """
    path, shown = _find(name)
    return Layer.of_text(text_of(path, shown), shown, path.parent)


def read_layers(name: str | Path, _above: tuple[Path, ...] = ()) -> list[Layer]:
    """Read the layers of a case file or library name, the base first.

    Raises
    ------
    CaseError : no such file or name, no text, no TOML, or a base that leads back to the file
    """
    path, shown = _find(name)
    layer = Layer.of_text(text_of(path, shown), shown, path.parent)
    base = layer.content.pop("base", None)
    if base is None:
        return [layer]
    place = f"{layer.places[('base',)]}: base"
    if not isinstance(base, str):
        raise CaseError(
            Fault(place, f"must be a name or a file, got {base!r}", f"Known: {', '.join(library_names())}")
        )
    if path.resolve() in _above:
        raise CaseError(Fault(place, f'"{base}" leads back to this file', "Remove one base of the circle"))
    if len(_above) >= MOST_BASES:
        raise CaseError(
            Fault(place, f"the chain of bases is longer than {MOST_BASES} files", "Use fewer bases")
        )
    if library_file(base) is None and not is_file(path.parent / base):
        raise CaseError(
            Fault(place, f'no mill and no file is called "{base}"', similar(base, library_names()))
        )
    below = base if library_file(base) else path.parent / base
    return [*read_layers(below, (*_above, path.resolve())), layer]


def override_layer(overrides: list[str]) -> tuple[Layer, list[Fault]]:
    """Return the layer of ``key=value`` texts, and the texts that have another form.

    A value that is no TOML is taken as text, so that quotes may be left out.
    """
    content: dict[str, Any] = {}
    places: dict[Key, str] = {}
    faults = []
    for text in overrides:
        key, equals, value = text.partition("=")
        try:
            path = typed_key(key.strip())
        except (ValueError, RecursionError):
            path = ()
        if not equals or not path:
            faults.append(
                Fault(
                    "--set",
                    f"must be key=value, got {spelled(text)}",
                    'Write e.g. --set drive.speed="500 rpm"',
                )
            )
            continue
        try:
            _put(content, path, _value(value.strip()), "--set")
        except CaseError as error:
            faults += error.faults
        places[path] = "--set"
    refuse_shape(content, {(): "--set"})
    return Layer(content, places, Path.cwd()), faults


def python_layer(changes: dict[str, Any]) -> Layer:
    """Return the layer of Python changes ``{"drive.speed": 73.3}``.

    Messages show the key alone as their place.

    Raises
    ------
    CaseError : not a dotted key, or an entry that a list among the changes lacks
    """
    content: dict[str, Any] = {}
    places: dict[Key, str] = {}
    for key, value in changes.items():
        try:
            path = typed_key(key)
        except (ValueError, RecursionError):
            raise CaseError(Fault(spelled(key), "must be a dotted key", 'Write e.g. "drive.speed"')) from None
        _put(content, path, copied(value), "")
        places[path] = ""
    return Layer(content, places, Path.cwd())


def _find(name: str | Path) -> tuple[Path, str]:
    """Return the file of a library name or path, and its name in messages."""
    if isinstance(name, str) and (path := library_file(name)):
        return path, path.name
    path = Path(name)
    if is_file(path):
        return path, str(name) if path.parent != FOLDER else path.name
    if is_folder(path):
        raise CaseError(Fault(str(name), "must be a case file, got a folder"))
    if path.suffix:
        near = [file.name for file in path.parent.glob("*.toml")] if is_folder(path.parent) else []
        raise CaseError(
            Fault(
                str(name),
                "file not found",
                similar(path.name, near) or f"Check the name; nutamill new {name} writes a case",
            )
        )
    raise CaseError(
        Fault(str(name), "no mill and no file has this name", similar(str(name), library_names()))
    )


def text_of(path: Path, shown: str) -> str:
    """Return the text of a file. Raises CaseError, under the name `shown`, if the file cannot be read."""
    try:
        return read_text(path, MOST_CASE_TEXT)
    except UnicodeDecodeError as error:
        raise CaseError(
            Fault(shown, f"must be UTF-8 text, got byte {error.object[error.start]:#04x} at {error.start}")
        ) from None
    except OSError as error:
        raise CaseError(Fault(shown, f"cannot be read: {error.strerror}")) from None


def parsed(text: str, shown: str) -> dict[str, Any]:
    """Parse TOML text into tables. A fault of syntax names line, column and, where it can, the cure."""
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        message = str(error)
    except RecursionError:
        raise CaseError(Fault(shown, "is nested too deeply")) from None
    except ValueError:  # the interpreter reads no decimal number of more digits
        digits = sys.get_int_max_str_digits()
        line = next(
            (n for n, line in enumerate(text.splitlines(), 1) if re.search(rf"\d{{{digits}}}", line)), 1
        )
        raise CaseError(
            Fault(f"{shown}:{line}", f"holds a whole number of more than {digits} digits")
        ) from None
    position = re.search(r" \(at (?:line (\d+), column (\d+)|end of document)\)$", message)
    lines = text.splitlines() or [""]
    line, column = (
        (int(position[1]), int(position[2])) if position and position[1] else (len(lines), len(lines[-1]) + 1)
    )
    line = min(line, len(lines))
    what, hint = message[: position.start()] if position else message, ""
    bare = _BARE.match(lines[line - 1].rstrip()[:MOST_LINE])
    if "overwrite a value" in what or "twice" in what:
        named = re.match(r"\s*\[*\s*([^=\]]*[^=\]\s])", lines[line - 1][:MOST_LINE])
        what, hint = f"{named[1] if named else 'a key or table'} appears twice", "Keep one of the two"
    elif bare:
        value = bare[2].rstrip()
        what = "units need quotes" if re.match(r"[+-]?[\d.]", value) else "text needs quotes"
        hint = f'Write {bare[1]} = "{value}"'
    elif re.match(r"\s*[\w.\-]+\s*=\s*(#.*)?$", lines[line - 1]):
        what = "no value after ="
    raise CaseError(Fault(f"{shown}:{line}:{column}", what[0].lower() + what[1:], hint)) from None


_BARE = re.compile(r"\s*([\w.\-\"]+)\s*=\s*([^\"'\[{#\s][^#\"'=]*)(?:#.*)?$")
"""A key and a value that lacks its quotes."""
MOST_LINE = 500
"""Characters of a line that are searched for the cure of a fault [1]."""


def refuse_shape(content: dict[str, Any], places: dict[Key, str]) -> None:
    """Raise CaseError where tables are nested too deeply or hold too much."""
    if finding := shape_finding(content):
        key, what, hint = finding
        raise CaseError(Fault(placed(places, key), what, hint))


def _value(text: str) -> Any:
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except (ValueError, RecursionError):
        return text


def _put(content: Any, path: Key, value: Any, source: str) -> None:
    """Set one key.

    A table takes the place of a scalar in its way, and an entry of a list of tables is changed in place.
    """
    for depth, part in enumerate(path):
        if is_tables(content):
            number = entry_number(content, part)
            if number is None:
                where = placed({(): source}, path[: depth + 1])
                raise CaseError(Fault(where, *no_entry(content, dotted(path[:depth]), part)))
            part = number
        elif depth + 1 < len(path) and not (
            isinstance(content.get(part), dict) or is_tables(content.get(part))
        ):
            content[part] = {}
        if depth + 1 == len(path):
            content[part] = value
        content = content[part]


def copied(value: Any) -> Any:
    """Return a copy of nested tables and lists of tables. Other values are shared."""
    if isinstance(value, dict):
        return {key: copied(inner) for key, inner in value.items()}
    return [copied(inner) for inner in value] if is_tables(value) else value
