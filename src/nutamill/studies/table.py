"""The result table of a campaign: one row a run, as a dataset over the swept keys and as CSV."""

import csv
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray

from nutamill.analysis.values import Reading
from nutamill.base.atomic_file import write_whole
from nutamill.base.steady import NO_ESTIMATE, Estimate
from nutamill.case.toml.keys import held as held_at
from nutamill.case.toml.keys import unit_at
from nutamill.studies.axes import Member

PARTS = {"": "mean", "_half_width": "half_width", "_window": "plain_mean"}
"""Variables of a reading in the dataset, by what is added to its name."""


class Outcome(NamedTuple):
    """What became of a member."""

    member: Member
    """What was asked."""
    file: Path
    """Its result file."""
    state: str
    """``waiting``, ``running``, ``complete``, ``not steady: ...``, or what went wrong."""
    values: Mapping[Reading, Estimate]
    """What was read from it; empty before it has ended."""


def dataset(
    outcomes: Sequence[Outcome], axes: Mapping[str, Sequence[Any]], readings: Sequence[Reading]
) -> xarray.Dataset:
    """Collect all readings over the swept keys, in SI, with the ``_half_width`` (95 %) and the ``_window``
    (last seconds, as in the papers) of each.

    Coordinates are SI numbers with their unit where the key holds a quantity, else text.  ``state`` and
    ``file`` are given for each run.
    """
    shape = tuple(len(values) for values in axes.values())
    dims = tuple(axes)

    def over_axes(column: list[Any]) -> tuple[tuple[str, ...], np.ndarray]:
        return dims, np.array(column).reshape(shape)

    variables: dict[str, Any] = {}
    for reading in readings:
        for suffix, part in PARTS.items():
            column = [getattr(outcome.values.get(reading, NO_ESTIMATE), part) for outcome in outcomes]
            label = {"": reading.field.label, "_half_width": f"{reading.field.label}, 95 % half width"}.get(
                suffix, f"{reading.field.label}, last seconds"
            )
            attributes = {
                "units": reading.field.unit,
                "long_name": f"{label}{'' if reading.by == 'mean' else f' ({reading.by})'}",
            }
            variables[f"{reading.name}{suffix}"] = (*over_axes(column), attributes)
    variables["state"] = over_axes([outcome.state for outcome in outcomes])
    variables["file"] = over_axes([outcome.file.name for outcome in outcomes])
    return xarray.Dataset(variables, {key: _coordinate(key, outcomes) for key in dims})


def _coordinate(key: str, outcomes: Sequence[Outcome]) -> tuple[Any, ...]:
    """Return the values of a swept key along its axis, and their unit."""
    asked = dict.fromkeys(map(str, (outcome.member.values[key] for outcome in outcomes)))
    held = {str(outcome.member.values[key]): held_at(outcome.member.case, key) for outcome in outcomes}
    values = [held[text] for text in asked]
    if not all(isinstance(value, (int, float)) and not isinstance(value, bool) for value in values):
        return key, list(asked)
    return key, values, {"units": unit_at(key)}


def write_csv(path: Path, outcomes: Sequence[Outcome], readings: Sequence[Reading]) -> None:
    """Write the table as CSV: swept keys as they were asked for, state, file, and each reading with its 95 %
    half width. The file is replaced whole.
    """
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    keys = list(outcomes[0].member.values)
    heads = [
        f"{reading.name}{ending} [{reading.field.unit}]"
        for reading in readings
        for ending in ("", " half width 95 %", " last seconds")
    ]
    writer.writerow([*keys, "state", "file", *heads])
    for outcome in outcomes:
        values = [outcome.values.get(reading, NO_ESTIMATE) for reading in readings]
        numbers = [
            f"{number:.6g}" for value in values for number in (value.mean, value.half_width, value.plain_mean)
        ]
        writer.writerow([*outcome.member.values.values(), outcome.state, outcome.file.name, *numbers])
    write_whole(path, out.getvalue())
