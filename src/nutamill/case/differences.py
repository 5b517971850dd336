"""In what cases differ: values by dotted key, and the one number in which runs of a sweep differ."""

from collections.abc import Sequence
from typing import Any, NamedTuple

from nutamill.base import units
from nutamill.case.case_file import CaseFile
from nutamill.case.titles import leaves
from nutamill.case.toml.keys import quantity_at

ASIDE = ("title", "changed_from", "schema", "drive.ramp", "run.")
"""Beginnings of keys that steady means do not depend on: the words of a case, and how it is brought to speed
and run.
"""


class SweptAxis(NamedTuple):
    """The one number in which cases differ."""

    label: str
    """Its key and unit, for an axis."""
    values: list[float]
    """Its value in each case, in that unit."""


def values_by_key(case: CaseFile) -> dict[str, Any]:
    """Return every value of a case by its dotted key, SI. Entries of lists of tables by name or number."""
    return dict(leaves(case.model_dump(by_alias=True, exclude_none=True, exclude=case.files)))


def swept_axis(cases: Sequence[CaseFile]) -> SweptAxis | None:
    """Return the number in which all cases differ, if they differ in that number only.

    Else None.

    What steady means do not depend on, as the seed or the length of a run, does not count.
    """
    all_values = [values_by_key(case) for case in cases]
    keys = {key for values in all_values for key in values if not key.startswith(ASIDE)}
    differing = [
        key for key in keys if any(values.get(key) != all_values[0].get(key) for values in all_values)
    ]
    if len(differing) != 1:
        return None
    key = differing[0]
    values_of_key = [values.get(key) for values in all_values]
    numbers = [n for n in values_of_key if isinstance(n, (int, float)) and not isinstance(n, bool)]
    if len(numbers) < len(all_values) or len(set(numbers)) < len(numbers):
        return None
    if (quantity := quantity_at(key)) is None:
        return SweptAxis(key, [float(number) for number in numbers])
    unit = units.EXAMPLES[quantity.kind].split(" ", 1)[1]
    return SweptAxis(f"{key} ({unit})", [number / units.UNITS[quantity.kind][unit] for number in numbers])
