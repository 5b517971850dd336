"""From keys and lists of values to cases: the members of a campaign."""

import itertools
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from decimal import Decimal
from typing import Any, NamedTuple

from nutamill.base import units
from nutamill.base.errors import CaseError, Fault
from nutamill.base.schema import LARGEST_NUMBER, spelled
from nutamill.case import Case, Machine
from nutamill.case.toml.keys import quantity_at

MOST_FAULTS = 10
"""Faults of the members of a sweep that are listed; of the others only the number is given."""
MOST_MEMBERS = 10_000
"""Members above which a campaign is refused as a slip of the pen [1]."""

_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_QUANTITY = rf"\s*({_NUMBER})\s*((?!step\b)[^\d\s./][^.]*?)?\s*"
_RANGE = re.compile(rf"{_QUANTITY}\.\.{_QUANTITY}(?:step{_QUANTITY}|/\s*(\d+)\s*)?")
_LIKE_A_RANGE = re.compile(r"""[^/\\"',]*\.\.[^/\\"',]*(/\s*\d+\s*)?""")
"""Two dots outside a path and a quoted text."""


class Member(NamedTuple):
    """One case of a campaign."""

    values: dict[str, Any]
    """What it differs in: value by dotted key, as it was asked for."""
    case: Case | Machine
    """The case, on one thread."""

    @property
    def label(self) -> str:
        """``drive.speed=160 rpm chamber.ribs=12``."""
        return " ".join(f"{key}={value}" for key, value in self.values.items())


def members(
    axes: Mapping[str, Sequence[Any]], make: Callable[[dict[str, Any]], Case | Machine]
) -> list[Member]:
    """Make all combinations of the values of each key, the last key changing fastest, each into a case.

    Parameters
    ----------
    axes : values by dotted key
    make : the case with these values by key

    Raises
    ------
    CaseError : the faults of all members, each once, the first ten and the number of the rest; too many
        members, or the same one twice
    """
    count = 1
    for values_of_key in axes.values():
        count *= len(values_of_key)
    if not 0 < count <= MOST_MEMBERS:
        what = f"must be 1 to {MOST_MEMBERS} cases, got {count}"
        raise CaseError(Fault("sweep", what, "Give fewer values"))
    combinations: list[Member] = []
    faults: list[Fault] = []
    for chosen in itertools.product(*axes.values()):
        values = dict(zip(axes, chosen, strict=True))
        try:
            combinations.append(Member(values, make(values).with_("run.threads", 1)))
        except CaseError as error:
            faults += error.faults
    if faults:
        each = list(dict.fromkeys(faults))
        left = (
            [Fault("sweep", f"{len(each) - MOST_FAULTS} more faults like these")]
            if len(each) > MOST_FAULTS
            else []
        )
        raise CaseError(*each[:MOST_FAULTS], *left)
    for one, other in _twins(combinations):
        faults.append(
            Fault("sweep", f"{one.label} and {other.label} are the same case", "Give each value once")
        )
    if faults:
        raise CaseError(*faults)
    return combinations


def _twins(combinations: list[Member]) -> Iterator[tuple[Member, Member]]:
    """Return the faults of members that are the same case as one before them."""
    seen: dict[str, Member] = {}
    for member in combinations:
        if (before := seen.setdefault(member.case.digest, member)) is not member:
            yield before, member


def changed(case: Case | Machine, values: Mapping[str, Any]) -> Case | Machine:
    """Return the case with other values by dotted key: SI floats or text with a unit."""
    return case.with_(values) if values else case


def axis_values(key: str, text: str) -> list[str]:
    """Return the values a text stands for, each as it would stand after ``--set``.

    ``"100..700 rpm step 60 rpm"`` counts up from the first in steps as far as the last;
    ``"250..750 rpm / 11"`` are eleven evenly spaced; ``"1..5"`` are whole numbers; ``"0, 12"`` is a list; all
    else is one value.  A unit that stands last holds for all.

    Raises
    ------
    CaseError : a range without a step, with two units, or that runs backwards
    """
    if text.lstrip().startswith(("[", "{")):
        return [text]
    if match := _RANGE.fullmatch(text):
        return _range(key, text, match)
    if _LIKE_A_RANGE.fullmatch(text):
        what = f"must be a range of numbers with their unit, got {spelled(text)}"
        raise CaseError(
            Fault(f"sweep {key}", what, 'Write e.g. "100..700 rpm step 60 rpm" or "250..750 rpm / 11"')
        )
    values = [part.strip() for part in re.findall(r"""(?:"[^"]*"|'[^']*'|[^,])+""", text)]
    last = re.fullmatch(_QUANTITY, values[-1]) if values else None
    if len(values) > 1 and last and last[2]:
        values = [f"{value} {last[2]}" if re.fullmatch(_NUMBER, value) else value for value in values]
    return values or [text]


def _range(key: str, text: str, match: re.Match[str]) -> list[str]:
    """Return the values of a range. Decimals are counted as decimals, so that 0.1..0.3 step 0.1 ends with
    0.3.
    """
    first, first_unit, last, unit, step, step_unit, count = match.groups()
    unit = unit or ""
    where = f"sweep {key}"
    if any(abs(float(number)) > LARGEST_NUMBER for number in (first, last, step or "1")):
        raise CaseError(Fault(where, f'must have numbers of at most {LARGEST_NUMBER:g}, got "{text}"'))
    begin, end = Decimal(first), Decimal(last)
    if any(other not in (None, unit) for other in (first_unit, step_unit)):
        raise CaseError(Fault(where, f'must have one unit, got "{text}"', "Write all three in the same unit"))
    if end <= begin:
        cure = (
            f"{first} {unit}".strip()
            if end == begin
            else f"{last}..{first} {unit}".strip() + _division(step, step_unit, count)
        )
        raise CaseError(Fault(where, f'must rise, got "{text}"', f'Write "{cure}"'))
    if not unit and (quantity := quantity_at(key)):
        example = units.example(quantity.kind).split(" ", 1)[1]
        hint = f'Write e.g. "{first}..{last} {example} / 5"'
        raise CaseError(Fault(where, f'must have a unit, got "{text}"', hint))
    if count is not None:
        if not 2 <= float(count) <= MOST_MEMBERS:
            raise CaseError(Fault(where, f'must have 2 to {MOST_MEMBERS} values, got "{text}"'))
        numbers = [begin + (end - begin) * k / (int(count) - 1) for k in range(int(count))]
    else:
        if step is None and (unit or begin != int(begin)):
            hint = (
                f'Write e.g. "{first}..{last} {unit} / 11" or "{first}..{last} {unit} step '
                f'{_shown((end - begin) / 10)} {unit}"'
            )
            raise CaseError(Fault(where, f'needs a step or a number of values, got "{text}"', hint))
        stride = Decimal(step or "1")
        if float(stride) <= 0.0:
            raise CaseError(Fault(where, f'must have a step above zero, got "{text}"'))
        if (end - begin) / stride > MOST_MEMBERS:
            raise CaseError(
                Fault(where, f'makes more than {MOST_MEMBERS} values: "{text}"', "Take a larger step")
            )
        numbers = [begin + stride * k for k in range(int((end - begin) / stride) + 1)]
    return [f"{_shown(number)} {unit}".strip() for number in numbers]


def _division(step: str | None, step_unit: str | None, count: str | None) -> str:
    """Return how a range is divided, as it was typed."""
    if count:
        return f" / {count}"
    return f" step {step} {step_unit or ''}".rstrip() if step else ""


def _shown(number: Decimal) -> str:
    """Format a decimal number as one would type it, to twelve digits."""
    return f"{float(number):.12g}"
