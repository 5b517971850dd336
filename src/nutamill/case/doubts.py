"""Plain numbers of a call in Python that are possible in SI, but look as if another unit was meant."""

import math
import warnings
from collections.abc import Mapping
from typing import Any

from nutamill.base import units
from nutamill.base.errors import Fault
from nutamill.base.units import Kind
from nutamill.case.toml.keys import quantity_at

USUAL: dict[Kind, tuple[str, str, str]] = {
    Kind.SPEED: ("0 rpm", "3000 rpm", "rpm"),
    Kind.LENGTH: ("0 mm", "10 m", "mm"),
    Kind.ANGLE: ("0 deg", "360 deg", "deg"),
    Kind.DENSITY: ("50 kg/m^3", "50000 kg/m^3", "g/cm^3"),
    Kind.PRESSURE: ("1 kPa", "10000 GPa", "GPa"),
}
"""Smallest and largest size of a plain number without doubt, and the unit that a user may have meant."""


def doubt(key: str, value: Any) -> Fault | None:
    """Return what is doubtful about a plain number for a dotted key, or None.

    Parameters
    ----------
    key : dotted key, as ``"drive.speed"``
    value : what a caller gave; text states its unit and is never doubtful
    """
    plain = isinstance(value, (int, float)) and not isinstance(value, bool)
    quantity = quantity_at(key) if plain else None
    if quantity is None or quantity.kind not in USUAL or value == 0 or not math.isfinite(value):
        return None
    *limits, other = USUAL[quantity.kind]
    low, high = (units.parse(limit, quantity.kind) for limit in limits)
    if low <= abs(value) <= high:
        return None
    home = next(iter(units.UNITS[quantity.kind]))
    return Fault(
        key,
        f"a plain number is SI, and {value:g} {home} is {units.shown(value, other)}",
        f'Write "{value:g} {other}" if that is meant, or "{value:g} {home}"',
    )


def warn_of_doubts(changes: Mapping[str, Any], stacklevel: int) -> None:
    """Report, as a Python warning, every doubtful plain number among changes by dotted key.

    Parameters
    ----------
    stacklevel : how many calls above this one the warning points to [1]
    """
    for key, value in changes.items():
        if (fault := doubt(key, value)) is not None:
            warnings.warn(str(fault), UserWarning, stacklevel=stacklevel + 1)
