"""The short case file a new case begins with: a base, and the keys people change."""

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from nutamill.base.library import library_file
from nutamill.case.mill import load_case
from nutamill.case.toml.write import toml_value

KEYS = (
    ("mechanism", "mounting", '"flexible" or "rigid"'),
    ("mounts", "set", 'published sets: "printed", "bending-0.030", "343"'),
    ("drive", "speed", "steady speed of the driveshaft"),
    ("drive", "ramp", 'or instead: profile = "speed.csv", with columns time [s], speed [rpm]'),
    ("chamber", "ribs", "number of ribs; their size stands in [chamber.rib]"),
    ("charge", "kind", '"spheres", "clumps" (with shapes), or "none" for an empty chamber'),
    ("charge", "set", "a published charge; keys beside it override it"),
    (
        "charge",
        "material",
        "one of [materials.*]; for several write a [[charge.part]] for each, with these keys",
    ),
    (
        "charge",
        "diameter",
        'or instead: sizes = [["4 mm", 0.3], ["5 mm", 0.7]], shares of the mass; or a distribution',
    ),
    (
        "charge",
        "mass",
        "all particles together; or instead: count, or fill, the share of the chamber as a settled bed",
    ),
    ("charge", "count", "number of particles; or instead: mass, or fill"),
    ("run", "until", 'simulated time at the end, or "steady"'),
    ("run", "dt", '"auto" or e.g. "3 us"'),
    ("run", "coupling", '"prescribed", "staggered" or "iterated"'),
    ("run", "threads", '"auto" or a number'),
    ("run", "seed", "of the placement of the charge"),
    ("run", "snapshots", "the particles over time, for pictures"),
)
"""Table, key and note of each line."""
LISTED = (
    ("bodies", "mass", "of the body"),
    ("springs", "stiffness", "of the spring"),
    ("drives", "speed", "steady speed"),
    ("drives", "ramp", "or instead: profile"),
    ("linear_drives", "speed", "steady speed"),
    ("unbalance_motors", "speed", "steady speed"),
    ("unbalance_motors", "ramp", "or instead: profile"),
)
"""List of parts with names, key and note of each line."""


def starter(base: str, file: Path) -> str:
    """Return the TOML text of a new case `file` on a `base`, which is a library name or another file.

    Raises
    ------
    CaseError : the base is none, or has faults
    """
    case = load_case(base)
    named = base if library_file(base) else os.path.relpath(base, file.parent)
    content = case.model_dump(mode="json", by_alias=True, exclude_none=True)
    lines = [
        "# Values carry their unit. What is left out is as in the base.",
        f"# nutamill show {file.name}   prints the whole file; nutamill check {file.name}   says "
        "what to expect.",
        "schema = 1",
        f"title  = {toml_value(f'{file.stem}, from {base}')}",
        f"base   = {toml_value(named)}",
    ]
    table = ""
    for home, key, value, note in _entries(content):
        if home != table:
            lines += ["", f"[{home}]"]
            table = home
        lines.append(f"{f'{key:10} = {toml_value(value)}':40}  # {note}")
    return "\n".join(lines) + "\n"


def _entries(content: dict[str, Any]) -> Iterator[tuple[str, str, Any, str]]:
    """Yield table, key, value and note of each line, of the keys that the content has."""
    for home in dict.fromkeys(home for home, _, _ in LISTED):
        for part in content.get(home, []):
            named = [(key, note) for list_of, key, note in LISTED if list_of == home]
            yield from (
                (f"{home}.{part['name']}", key, part[key], note) for key, note in named if key in part
            )
    for home in dict.fromkeys(home for home, _, _ in KEYS):
        keys = [(key, note) for table, key, note in KEYS if table == home]
        yield from (
            (home, key, content[home][key], note) for key, note in keys if key in content.get(home, {})
        )
        for number, part in enumerate(content[home].get("part", []) if home in content else []):
            yield from ((f"{home}.part.{number}", key, part[key], note) for key, note in keys if key in part)
