"""The short case file a new case begins with: a base, and the keys people change."""

import os
from pathlib import Path

from nutamill.base.library import library_file
from nutamill.case.mill import load_mill
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
    ("run", "snapshots", "the charge as it lies, for pictures"),
)
"""Table, key and note of each line."""


def starter(base: str, file: Path) -> str:
    """Return the TOML text of a new case `file` on a `base`, which is a library name or another file.

    Raises
    ------
    CaseError : the base is none, or has faults
    """
    case = load_mill(base)
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
    for home, key, note in KEYS:
        if key not in content[home]:
            continue
        if home != table:
            lines += ["", f"[{home}]"]
            table = home
        lines.append(f"{f'{key:10} = {toml_value(content[home][key])}':40}  # {note}")
    return "\n".join(lines) + "\n"
