"""Content that a layer gives by a name: sets of mounts and charges, shapes, profiles, meshes and FMUs."""

import tomllib
from pathlib import Path
from typing import Any

from nutamill.base.errors import CaseError, Fault
from nutamill.base.files import is_file
from nutamill.base.library import (
    CHARGES,
    MOUNTS,
    charge_sets,
    mount_sets,
    shape_file,
    shape_sets,
    similar,
)
from nutamill.case.drive import read_profile
from nutamill.case.toml.addresses import Key, entries_of, placed
from nutamill.case.toml.layers import Layer, parsed, text_of
from nutamill.case.toml.named_file import pin_file

EXCLUSIVE_KEYS = (
    ("diameter", "sizes", "distribution"),
    ("mass", "count", "fill"),
    ("ramp", "profile"),
    ("free_length", "preload"),
    ("force", "table"),
    ("restitution", "damping_ratio"),
)
"""Mutually exclusive keys of a table; the later layer wins."""


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
    portions: list[tuple[Key, dict[str, Any]]] = [(("charge",), charge)]
    portions += [(("charge", "part", part), portion) for part, portion in entries_of(charge.get("part"))]
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
    portion["shapes"] = {"source": name, **parsed(text_of(file, file.name), file.name)}


def _expand_profile(layer: Layer) -> None:
    """Read the files that ``drive.profile`` and the profiles of drives and unbalance motors name."""
    tables: list[tuple[Key, Any]] = [(("drive",), layer.content.get("drive"))]
    for table in ("drives", "unbalance_motors"):
        tables += [((table, part), drive) for part, drive in entries_of(layer.content.get(table))]
    for key, drive in tables:
        if isinstance(drive, dict) and isinstance(name := drive.get("profile"), str):
            del drive["profile"]  # should the file be wrong, the rest of the case can still be checked
            drive["profile"] = read_profile(
                name, placed(layer.places, (*key, "profile"), layer.content), [layer.folder, Path.cwd()]
            )


def _pin_files(layer: Layer) -> None:
    """Find the files that ``chamber.mesh``, ``walls`` and ``fmus`` name."""
    chamber = layer.content.get("chamber")
    named: list[tuple[Key, Any]] = [
        (("chamber", "mesh"), chamber.get("mesh") if isinstance(chamber, dict) else None)
    ]
    for name in ("walls", "fmus"):
        named += [((name, part), table) for part, table in entries_of(layer.content.get(name))]
    faults: list[Fault] = []
    for key, table in named:
        if isinstance(table, dict):
            try:
                pin_file(
                    table, placed(layer.places, (*key, "file"), layer.content), [layer.folder, Path.cwd()]
                )
            except CaseError as error:
                faults += error.faults
    if faults:
        raise CaseError(*faults)


EXPANSIONS = (_expand_mount_set, _expand_charge, _expand_profile, _pin_files)
"""What is done with each layer before it is merged over the others."""
