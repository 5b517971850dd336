"""Every recorded quantity, declared once: its name in file, dataset and figures, symbol, unit, meaning, axes
and point.

The writer takes names, the result file stores what stands here beside the numbers, figures take their axis
labels from here.  Some names carry a part of the machine, for instance ``mount_{mount}_force_x``:
``mount_2_force_x`` is a name, and so is ``frame_corner_acceleration_z`` of the sensor called ``frame_corner``
in the case file.

Signs are those of docs/conventions.md.
"""

import difflib
import functools
import re
from collections.abc import Sequence
from dataclasses import replace

from nutamill.base.errors import CaseError, Fault
from nutamill.result.fields.charge import SNAPSHOT, STATISTICS, STATISTICS_AXES
from nutamill.result.fields.field import Field
from nutamill.result.fields.mill import JOINTS, SERIES, TURNING, known_joints
from nutamill.result.fields.parts import PART_SERIES

__all__ = [
    "JOINTS",
    "PART_SERIES",
    "SERIES",
    "SNAPSHOT",
    "STATISTICS",
    "STATISTICS_AXES",
    "TURNING",
    "Field",
    "expand",
    "known_joints",
    "series_field",
    "snapshot_field",
    "statistics_field",
]

_NAME = "[a-z][a-z0-9_]*"
_PARTS = {
    "mount": "[1-9][0-9]*",
    "body": "|".join(TURNING),
    **dict.fromkeys(
        (
            *("sensor", "joint", "bushing", "spring", "torque", "force", "stop", "gear", "drive", "carrier"),
            "fmu",
        ),
        _NAME,
    ),
}
_SERIES = {field.name: field for field in SERIES}
_SNAPSHOT = {field.name: field for field in SNAPSHOT}
_STATISTICS = {field.name: field for field in STATISTICS + STATISTICS_AXES}


def _pattern(template: str) -> str:
    return re.sub(r"\\{(\w+)\\}", lambda part: f"(?P<{part[1]}>{_PARTS[part[1]]})", re.escape(template))


_TEMPLATES = tuple(
    (re.compile(_pattern(field.name)), field) for field in (*PART_SERIES, *SERIES) if "{" in field.name
)


def _filled(field: Field, **part: object) -> Field:
    """Return `field` with the parts of the machine put in its texts, with spaces instead of underscores where
    people read.
    """
    spoken = {key: str(value).replace("_", " ") for key, value in part.items()}
    return replace(
        field,
        name=field.name.format(**part),
        label=field.label.format(**spoken),
        meaning=field.meaning.format(**spoken),
        point=field.point.format(**spoken),
    )


@functools.cache
def series_field(name: str) -> Field:
    """Return the recorded quantity called `name`, parts of the machine filled in.

    Raises
    ------
    CaseError : no quantity has this name; the nearest one is proposed
    """
    if name in _SERIES and "{" not in name:
        return _SERIES[name]
    for pattern, field in _TEMPLATES:
        if match := pattern.fullmatch(name):
            return _filled(field, **match.groupdict())
    raise CaseError(_unknown(name, expand(mounts=4, sensors=("frame_corner",))))


def snapshot_field(name: str) -> Field:
    """Return the snapshot array called `name`. Raises CaseError as `series_field` does."""
    if name in _SNAPSHOT:
        return _SNAPSHOT[name]
    raise CaseError(_unknown(name, _SNAPSHOT))


def statistics_field(name: str) -> Field:
    """Return the statistics array or axis called `name`. Raises CaseError as `series_field` does."""
    if name in _STATISTICS:
        return _STATISTICS[name]
    raise CaseError(_unknown(name, _STATISTICS))


def _unknown(name: str, known) -> Fault:
    near = difflib.get_close_matches(name, known, 1)
    hint = f'Did you mean "{near[0]}"?' if near else "`nutamill info fields` lists all names."
    return Fault(f"record {name}", "must be a recorded quantity, no such name", hint)


def expand(mounts: int = 0, sensors: Sequence[str] = ()) -> list[str]:
    """Return the names of all series of a machine with `mounts` mounts and the given acceleration sensors,
    `time` first.

    Parameters
    ----------
    mounts : number of mounts [1]; they are counted from 1
    sensors : names of the sensors as in the case file
    """
    joints = [joint for joint in JOINTS if joint != "frame_fix" or not mounts]
    parts = {
        "mount": [str(k) for k in range(1, mounts + 1)],
        "sensor": list(sensors),
        "joint": joints,
        "body": list(TURNING),
    }
    names = []
    for name in _SERIES:
        part = next((part for part in parts if f"{{{part}}}" in name), None)
        names += [name] if part is None else [name.format(**{part: value}) for value in parts[part]]
    return names
