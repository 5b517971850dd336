"""From files and overrides to one nested dict, each key with the place it came from.

A case is read in layers: the base (and its base), the file, the values after ``--set``.  A later layer wins,
key by key.
"""

import re
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from nutamill.base.errors import CaseError, Fault
from nutamill.base.files import MOST_CASE_TEXT, is_file, is_folder, read_text
from nutamill.base.library import (
    CHARGES,
    FOLDER,
    MOUNTS,
    charge_sets,
    library_file,
    library_names,
    mount_sets,
    shape_file,
    shape_sets,
    similar,
)
from nutamill.base.schema import spelled
from nutamill.case.content import shape_finding
from nutamill.case.drive import read_profile
from nutamill.case.toml.locate import key_lines, key_parts
from nutamill.case.toml.mesh_file import pin_mesh

MOST_BASES = 20
"""Files in a chain of bases [1]."""
EXCLUSIVE_KEYS = (
    ("diameter", "sizes", "distribution"),
    ("mass", "count", "fill"),
    ("ramp", "profile"),
    ("restitution", "damping_ratio"),
)
"""Mutually exclusive keys of a table; the later layer wins."""

Key = tuple[str | int, ...]


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
        """The layer of TOML text; `shown` is what messages call it."""
        content = _parsed(text, shown)
        _refuse_shape(content, {(): shown})
        lines = {key: f"{shown}:{line}" for key, line in key_lines(text).items()} if content else {}
        return cls(content, {(): shown, **lines}, folder or Path.cwd())


def read_layer(name: str | Path) -> Layer:
    """The one layer of a file, whatever it describes.

    Raises
    ------
    CaseError : no such file, no text, or no TOML
    """
    path, shown = _find(name)
    return Layer.of_text(_text(path, shown), shown, path.parent)


def read_layers(name: str | Path, _above: tuple[Path, ...] = ()) -> list[Layer]:
    """Layers of a case file or library name, the base first.

    Raises
    ------
    CaseError : no such file or name, no text, no TOML, or a base that leads back to the file
    """
    path, shown = _find(name)
    layer = Layer.of_text(_text(path, shown), shown, path.parent)
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
    """The layer of ``key=value`` texts, and those that are none.

    A value that is no TOML is taken as text, so that quotes may be left out.
    """
    content: dict[str, Any] = {}
    places: dict[Key, str] = {}
    faults = []
    for text in overrides:
        key, equals, value = text.partition("=")
        try:
            path = key_parts(key.strip())
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
        _put(content, path, _value(value.strip()))
        places[path] = places[_with_indices(path)] = "--set"
    _refuse_shape(content, {(): "--set"})
    return Layer(content, places, Path.cwd()), faults


def python_layer(changes: dict[str, Any]) -> Layer:
    """The layer of Python changes ``{"drive.speed": 73.3}``; their place is the key alone."""
    content: dict[str, Any] = {}
    for key, value in changes.items():
        _put(content, key_parts(key), _copied(value))
    return Layer(content, {key_parts(key): "" for key in changes}, Path.cwd())


def merge(layers: list[Layer]) -> tuple[dict[str, Any], dict[Key, str], list[Fault]]:
    """One nested dict, the place of each key, and what is wrong with the files they name, which are read
    here.
    """
    content: dict[str, Any] = {}
    places: dict[Key, str] = {}
    faults: list[Fault] = []
    for layer in layers:
        _refuse_shape(layer.content, layer.places)
        for expand in (_expand_mount_set, _expand_charge, _expand_profile, _pin_meshes):
            try:
                expand(layer)
            except CaseError as error:
                faults += error.faults
        _overlay(content, layer.content)
        places.update(layer.places)
        # a key inside an inline table has no line of its own: without this its place would be that of an
        # earlier layer
        places.update({key: _nearest(layer.places, key) for key in _keys(layer.content)})
    return content, places, faults


def placed(places: dict[Key, str], key: Key) -> str:
    """``where`` of a fault at a key: the key with the place of its nearest known parent."""
    place = _nearest(places, key)
    dotted = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in key).lstrip(".")
    if not place or not dotted:
        return place or dotted or "case"
    return f"{place} {dotted}" if place == "--set" else f"{place}: {dotted}"


def _nearest(places: dict[Key, str], key: Key) -> str:
    """Place of a key or of its nearest known parent."""
    return next((places[key[:n]] for n in range(len(key), -1, -1) if key[:n] in places), "")


def _keys(content: dict[str, Any], above: Key = ()) -> Iterator[Key]:
    """All keys of a nested dict."""
    for key, value in content.items():
        yield (*above, key)
        inner = value if isinstance(value, dict) else dict(enumerate(value)) if _is_tables(value) else {}
        yield from _keys(inner, (*above, key))


def _find(name: str | Path) -> tuple[Path, str]:
    """File of a library name or path, and what to call it."""
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


def _text(path: Path, shown: str) -> str:
    try:
        return read_text(path, MOST_CASE_TEXT)
    except UnicodeDecodeError as error:
        raise CaseError(
            Fault(shown, f"must be UTF-8 text, got byte {error.object[error.start]:#04x} at {error.start}")
        ) from None
    except OSError as error:
        raise CaseError(Fault(shown, f"cannot be read: {error.strerror}")) from None


def _parsed(text: str, shown: str) -> dict[str, Any]:
    """Tables of TOML text; a fault of syntax names line, column and, where it can, the cure."""
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


def _refuse_shape(content: dict[str, Any], places: dict[Key, str]) -> None:
    """Raise CaseError where tables are nested too deeply or hold too much."""
    if finding := shape_finding(content):
        key, what, hint = finding
        raise CaseError(Fault(placed(places, key), what, hint))


def _value(text: str) -> Any:
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except (ValueError, RecursionError):
        return text


def _put(content: dict[str, Any], path: Key, value: Any) -> None:
    """Set one key; a scalar in the way of a table gives way."""
    for part in path[:-1]:
        if not isinstance(content.get(part), dict):
            content[part] = {}
        content = content[part]
    content[path[-1]] = value


def _overlay(below: dict[str, Any], above: dict[str, Any]) -> None:
    """Lay one nested dict over another, in place."""
    for group in EXCLUSIVE_KEYS:
        if any(key in above for key in group):
            for other in group:
                below.pop(other, None)
    if above.get("kind") in ("spheres", "none"):
        below.pop("shapes", None)
    if _is_tables(above.get("part")):
        below.clear()  # parts describe the whole charge, and so does a charge of one part
    elif above and "part" not in above:
        below.pop("part", None)
    for key, value in above.items():
        under = below.get(key)
        if (
            isinstance(value, dict)
            and isinstance(under, dict)
            and "law" not in value
            and "clumps" not in value
        ):
            _overlay(under, value)
        elif isinstance(value, dict) and _is_tables(under) and all(_indices(under, part) for part in value):
            for part, inner in value.items():
                _overlay(under[_indices(under, part)[0]], inner)
        else:
            below[key] = _copied(value)


def _is_tables(value: Any) -> bool:
    """Whether a value is a list of tables."""
    return (
        isinstance(value, (list, tuple)) and bool(value) and all(isinstance(inner, dict) for inner in value)
    )


def _indices(tables: list[dict[str, Any]], part: str) -> list[int]:
    """Return the index of the table that `part` names, by number or by name; empty if there is none."""
    if part.isdigit():
        return [int(part)] if int(part) < len(tables) else []
    return [number for number, table in enumerate(tables) if table.get("name") == part][:1]


def _with_indices(path: Key) -> Key:
    """A dotted key with the numbers of a list's tables as numbers."""
    return tuple(int(part) if part.isdigit() else part for part in path)


def _copied(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _copied(inner) for key, inner in value.items()}
    return [_copied(inner) for inner in value] if _is_tables(value) else value


def _expand_mount_set(layer: Layer) -> None:
    """Put the values of ``mounts.set`` beneath the layer's own keys of [mounts]."""
    mounts = layer.content.get("mounts")
    if not isinstance(mounts, dict) or not isinstance(mounts.get("set"), (str, int)):
        return
    name = mounts["set"] = str(mounts["set"])  # after --set, a name of digits is read as a number
    if name not in mount_sets():
        del mounts["set"]
        raise CaseError(
            Fault(
                placed(layer.places, ("mounts", "set")),
                f'no set of mounts is called "{name}"',
                similar(name, mount_sets()),
            )
        )
    values = tomllib.loads((MOUNTS / f"{name}.toml").read_text(encoding="utf-8"))
    for key, value in values.items():
        mounts.setdefault(key, value)
        layer.places.setdefault(("mounts", key), layer.places.get(("mounts", "set"), ""))


def _expand_charge(layer: Layer) -> None:
    """Put the values of ``charge.set`` beneath the layer's own keys of [charge], and read the shapes that
    `charge.shapes` names.

    A part of a charge may have a set and shapes of its own.
    """
    charge = layer.content.get("charge")
    if not isinstance(charge, dict):
        return
    parts = charge.get("part")
    within = dict(enumerate(parts)) if _is_tables(parts) else parts if isinstance(parts, dict) else {}
    portions = [
        (("charge",), charge),
        *((("charge", "part", number), part) for number, part in within.items() if isinstance(part, dict)),
    ]
    faults: list[Fault] = []
    for key, portion in portions:
        try:
            _expand_charge_set(layer, key, portion)
            _expand_shapes(layer, key, portion)
        except CaseError as error:
            faults += error.faults
    if faults:
        raise CaseError(*faults)


def _expand_charge_set(layer: Layer, key: Key, portion: dict[str, Any]) -> None:
    name = portion.get("set")
    if not isinstance(name, str):
        return
    if name not in charge_sets():
        del portion["set"]
        raise CaseError(
            Fault(
                placed(layer.places, (*key, "set")),
                f'no set of charges is called "{name}"',
                similar(name, charge_sets()),
            )
        )
    values = tomllib.loads((CHARGES / f"{name}.toml").read_text(encoding="utf-8"))
    for own, value in values.items():
        if not any(other in portion for group in EXCLUSIVE_KEYS if own in group for other in group):
            portion.setdefault(own, value)
            layer.places.setdefault((*key, own), layer.places.get((*key, "set"), ""))


def _expand_shapes(layer: Layer, key: Key, portion: dict[str, Any]) -> None:
    """Read the file of shapes that ``shapes`` names: one of the library, or one beside the case."""
    name = portion.get("shapes")
    if not isinstance(name, str):
        return
    portion["shapes"] = {
        "clumps": [[[0, 0, 0, 1]]]
    }  # should the file be wrong, the rest of the case can still be checked
    where = placed(layer.places, (*key, "shapes"))
    files = [shape_file(name), layer.folder / name, Path.cwd() / name]
    file = next((file for file in files if file is not None and is_file(file)), None)
    if file is None:
        raise CaseError(
            Fault(where, f'no set of shapes and no file is called "{name}"', similar(name, shape_sets()))
        )
    portion["shapes"] = {"source": name, **_parsed(_text(file, file.name), file.name)}


def _expand_profile(layer: Layer) -> None:
    """Read the files that ``drive.profile`` and the profiles of ``drives`` name."""
    drives = layer.content.get("drives")
    tables: list[tuple[Key, Any]] = [(("drive",), layer.content.get("drive"))]
    tables += [(("drives", k), drive) for k, drive in enumerate(drives if isinstance(drives, list) else ())]
    for key, drive in tables:
        if isinstance(drive, dict) and isinstance(name := drive.get("profile"), str):
            del drive["profile"]  # should the file be wrong, the rest of the case can still be checked
            drive["profile"] = read_profile(
                name, placed(layer.places, (*key, "profile")), [layer.folder, Path.cwd()]
            )


def _pin_meshes(layer: Layer) -> None:
    """Find the mesh files that ``chamber.mesh`` and ``walls`` name."""
    chamber, walls = layer.content.get("chamber"), layer.content.get("walls")
    named: list[tuple[Key, Any]] = [
        (("chamber", "mesh"), chamber.get("mesh") if isinstance(chamber, dict) else None)
    ]
    named += [
        (("walls", k), wall) for k, wall in enumerate(walls if isinstance(walls, (list, tuple)) else ())
    ]
    faults: list[Fault] = []
    for key, table in named:
        if isinstance(table, dict):
            try:
                pin_mesh(table, placed(layer.places, (*key, "file")), [layer.folder, Path.cwd()])
            except CaseError as error:
                faults += error.faults
    if faults:
        raise CaseError(*faults)
