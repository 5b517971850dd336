"""The door for units: text with a unit in, an SI number out, and back again.

Inside the package every number is SI; this is the only room that knows another unit.  A unit belongs to one
*kind* of quantity, because kinds are where engineers slip: a torque is no energy although both are newton
times metre, and a frequency is no speed of rotation although both are one over second.

Source of the factors: BIPM, The International System of Units, 9th edition, 2019, sections 2.3 and 4.
"""

import difflib
import math
import re
from collections.abc import Iterable
from decimal import Decimal
from enum import StrEnum
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    import numpy as np

__all__ = ["UNITS", "Kind", "UnitError", "example", "format", "in_unit", "parse", "rpm", "shown", "si_value"]

Number = TypeVar("Number", float, "np.ndarray")
"""A number, or an array of numbers."""


class Kind(StrEnum):
    """What a number measures; the value is the word used in messages."""

    LENGTH = "length"
    VOLUME = "volume"
    MASS = "mass"
    TIME = "time"
    ANGLE = "angle"
    SPEED = "speed of rotation"
    FREQUENCY = "frequency"
    FORCE = "force"
    TORQUE = "torque"
    ENERGY = "energy"
    POWER = "power"
    STIFFNESS = "stiffness"
    ROTATIONAL_STIFFNESS = "rotational stiffness"
    DAMPING = "damping rate"
    ROTATIONAL_DAMPING = "rotational damping rate"
    DENSITY = "density"
    PRESSURE = "pressure"
    VISCOSITY = "viscosity"
    SURFACE_TENSION = "surface tension"
    VELOCITY = "velocity"
    ACCELERATION = "acceleration"
    INERTIA = "moment of inertia"
    RAMP = "ramp of speed"
    UNBALANCE = "unbalance"
    SPECIFIC_ENERGY = "specific energy"


class UnitError(ValueError):
    """Text that is no quantity of the kind asked for: `what` is wrong, and as `hint` what to write
    instead.
    """

    def __init__(self, what: str, hint: str = ""):
        self.what = what
        self.hint = hint
        super().__init__(f"{what}. {hint}" if hint else what)


LONGEST_TEXT = 200
"""Characters of a number with its unit, beyond which it is not read [1]."""

TURN = 2.0 * math.pi
"""One turn [rad]."""

UNITS: dict[Kind, dict[str, float]] = {
    Kind.LENGTH: {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "um": 1e-6, "in": 25.4e-3},
    Kind.VOLUME: {"m^3": 1.0, "L": 1e-3, "cm^3": 1e-6, "mm^3": 1e-9, "nL": 1e-12, "pL": 1e-15},
    Kind.MASS: {"kg": 1.0, "g": 1e-3, "mg": 1e-6, "t": 1e3, "lb": 0.45359237},
    Kind.TIME: {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0},
    Kind.ANGLE: {"rad": 1.0, "deg": TURN / 360.0, "mrad": 1e-3, "rev": TURN},
    Kind.SPEED: {"rad/s": 1.0, "rpm": TURN / 60.0, "rev/s": TURN, "deg/s": TURN / 360.0},
    Kind.FREQUENCY: {"Hz": 1.0, "kHz": 1e3, "MHz": 1e6},
    Kind.FORCE: {"N": 1.0, "kN": 1e3, "mN": 1e-3},
    Kind.TORQUE: {"N m": 1.0, "kN m": 1e3, "N mm": 1e-3},
    Kind.ENERGY: {"J": 1.0, "mJ": 1e-3, "kJ": 1e3},
    Kind.POWER: {"W": 1.0, "kW": 1e3},
    Kind.STIFFNESS: {"N/m": 1.0, "N/mm": 1e3, "kN/m": 1e3, "kN/mm": 1e6, "MN/m": 1e6},
    Kind.ROTATIONAL_STIFFNESS: {"N m/rad": 1.0, "kN m/rad": 1e3, "N m/deg": 360.0 / TURN, "N mm/rad": 1e-3},
    Kind.DAMPING: {"N s/m": 1.0, "N s/mm": 1e3, "kN s/m": 1e3},
    Kind.ROTATIONAL_DAMPING: {"N m s/rad": 1.0, "N mm s/rad": 1e-3, "N m s/deg": 360.0 / TURN},
    Kind.DENSITY: {"kg/m^3": 1.0, "g/cm^3": 1e3, "t/m^3": 1e3},
    Kind.PRESSURE: {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "N/mm^2": 1e6},
    Kind.VISCOSITY: {"Pa s": 1.0, "mPa s": 1e-3},
    Kind.SURFACE_TENSION: {"J/m^2": 1.0, "mN/m": 1e-3, "mJ/m^2": 1e-3},
    Kind.VELOCITY: {"m/s": 1.0, "mm/s": 1e-3},
    Kind.ACCELERATION: {"m/s^2": 1.0, "mm/s^2": 1e-3},
    Kind.INERTIA: {"kg m^2": 1.0, "g m^2": 1e-3, "kg mm^2": 1e-6},
    Kind.RAMP: {"rad/s^2": 1.0, "rpm/s": TURN / 60.0, "rev/s^2": TURN, "deg/s^2": TURN / 360.0},
    Kind.UNBALANCE: {"kg m": 1.0, "g m": 1e-3, "kg mm": 1e-3, "g mm": 1e-6},
    Kind.SPECIFIC_ENERGY: {"J/kg": 1.0, "kJ/kg": 1e3, "kWh/t": 3600.0},
}
"""SI value of one of each unit, by kind."""

SHOWN: dict[Kind, tuple[str, ...]] = {
    Kind.LENGTH: ("mm",),
    Kind.TIME: ("s", "ms", "us", "ns"),
    Kind.ANGLE: ("deg",),
    Kind.SPEED: ("rpm",),
    Kind.STIFFNESS: ("N/mm",),
    Kind.PRESSURE: ("GPa", "MPa", "kPa", "Pa"),
    Kind.RAMP: ("rpm/s",),
    Kind.SURFACE_TENSION: ("mN/m",),
}
"""Units a value is written with: the first in which it is at least 1, else the last.  Other kinds: their SI
unit.
"""

EXAMPLES: dict[Kind, str] = {
    Kind.LENGTH: "5 mm",
    Kind.VOLUME: "1 L",
    Kind.MASS: "5 kg",
    Kind.TIME: "2 s",
    Kind.ANGLE: "6 deg",
    Kind.SPEED: "700 rpm",
    Kind.FREQUENCY: "200 Hz",
    Kind.FORCE: "100 N",
    Kind.TORQUE: "5 N m",
    Kind.ENERGY: "1 J",
    Kind.POWER: "370 W",
    Kind.STIFFNESS: "72.2 N/mm",
    Kind.ROTATIONAL_STIFFNESS: "50 N m/rad",
    Kind.DAMPING: "34 N s/m",
    Kind.ROTATIONAL_DAMPING: "0.05 N m s/rad",
    Kind.DENSITY: "7850 kg/m^3",
    Kind.PRESSURE: "200 GPa",
    Kind.VISCOSITY: "50 mPa s",
    Kind.SURFACE_TENSION: "72 mN/m",
    Kind.VELOCITY: "2 m/s",
    Kind.ACCELERATION: "9.81 m/s^2",
    Kind.INERTIA: "0.02 kg m^2",
    Kind.RAMP: "70 rpm/s",
    Kind.UNBALANCE: "0.16 kg m",
    Kind.SPECIFIC_ENERGY: "10 kWh/t",
}

_KIND_OF = {unit: kind for kind, table in UNITS.items() for unit in table}
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
_SAME_SIGN = str.maketrans({"µ": "u", "μ": "u", "²": "^2", "³": "^3", "·": " ", "*": " ", "°": "deg"})


def parse(text: str, kind: Kind | str) -> float:
    """Return the SI value of `text`, a number and a unit of the `kind` asked for, such as ``"700 rpm"`` or
    ``"0.05 N m s/rad"``.

    Parameters
    ----------
    text : number with a decimal point, then a unit of `UNITS`
    kind : what is measured

    Raises
    ------
    UnitError : the text has no unit, an unknown one, one of another kind, or no finite number
    """
    kind = Kind(kind)
    if len(text) > LONGEST_TEXT:
        what = f"must be a number with a unit, got {len(text)} characters"
        raise UnitError(what, f'Write e.g. "{EXAMPLES[kind]}"')
    shown = f'"{text}"'
    number, unit = _split(text, kind)
    if not unit:
        raise UnitError(f'needs a unit: write "{_suggest(number, kind)}" (a plain number is ambiguous)')
    unit = _clean(unit)
    if unit not in _KIND_OF:
        other = _same_letters(unit, _KIND_OF)
        if other is None or _same_letters(unit, UNITS[kind]):
            raise UnitError(f'unknown unit "{unit}"', _nearest(unit, kind))
        unit = other
    given = _KIND_OF[unit]
    if given is not kind:
        if kind is Kind.SPEED and given is Kind.FREQUENCY:
            turns = float(number) * UNITS[given][unit]
            raise UnitError(
                f'{shown} is a frequency; write "{turns:g} rev/s" or "{60.0 * turns:g} rpm" (we do '
                "not guess between Hz and rad/s)"
            )
        raise UnitError(
            f'{shown} is {_with_article(given)}, this needs {_with_article(kind)}, e.g. "{EXAMPLES[kind]}"'
        )
    value = _si(number, UNITS[kind][unit])
    if not math.isfinite(value):
        raise UnitError(f"must be a finite number, got {shown}")
    return value


def format(value: float, kind: Kind | str) -> str:
    """Return text with a unit that `parse` reads back to exactly the same float, as short as that allows.

    Parameters
    ----------
    value : SI value
    kind : what is measured

    Raises
    ------
    ValueError : the value is not finite
    """
    kind = Kind(kind)
    if not math.isfinite(value):
        raise ValueError(f"{value} has no text: it is not finite")
    table = UNITS[kind]
    home = next(iter(table))
    choice = SHOWN.get(kind, (home,))
    unit = (
        choice[0]
        if value == 0.0
        else next((name for name in choice if abs(value) >= table[name]), choice[-1])
    )
    for name in (unit, home):
        for digits in range(1, 18):
            number = _plain(f"{value / table[name]:.{digits}g}")
            if _si(number, table[name]) == value:
                return f"{number} {name}"
    raise AssertionError(f"{value!r} is written exactly in the SI unit")


def example(kind: Kind | str) -> str:
    """Return a typical value of this kind, as a user would type it."""
    return EXAMPLES[Kind(kind)]


def in_unit(value: Number, unit: str) -> Number:
    """Return an SI value, or an array of them, as a number of `unit`: for tables and figures."""
    return value / UNITS[_KIND_OF[unit]][unit]


def si_value(number: Number, unit: str) -> Number:
    """Return the SI value of a number of `unit`, or of an array of them."""
    return number * UNITS[_KIND_OF[unit]][unit]


def shown(value: float, unit: str, form: str = ".4g") -> str:
    """Return an SI value as text in `unit`, rounded by a format specification: ``shown(2e-6, "us")`` is
    ``"2 us"``.  `format` gives text that is read back exactly.
    """
    return f"{in_unit(value, unit):{form}} {unit}"


def rpm(speed: Number) -> Number:
    """Return a speed [rad/s] in turns per minute, or a ramp [rad/s^2] in turns per minute and second."""
    return speed / UNITS[Kind.SPEED]["rpm"]


def _si(number: str, factor: float) -> float:
    """Return the number in SI, multiplied as decimals: 700 mm is 0.7 m, while 700 x 1e-3 in floats is not
    quite.
    """
    value = float(number)
    return float(Decimal(number) * Decimal(repr(factor))) if math.isfinite(value) else value


def _split(text: str, kind: Kind) -> tuple[str, str]:
    """Split text into number and unit, both as text."""
    stripped = text.strip()
    if match := _NUMBER.match(stripped):
        number, unit = match.group(), stripped[match.end() :].strip()
        if re.match(r",\d", unit):
            raise UnitError(f'"{text}" has a decimal comma', f'Write "{number}.{unit[1:]}"')
        return number, unit
    raise UnitError(f'must be a finite number with a unit, got "{text}"', f'Write e.g. "{EXAMPLES[kind]}"')


def _clean(unit: str) -> str:
    """Return the unit as the table spells it: one space between factors, none around "/" and "^"."""
    unit = " ".join(unit.translate(_SAME_SIGN).split())
    return re.sub(r"\s*([/^])\s*", r"\1", unit).replace("Nm", "N m")


def _nearest(unit: str, kind: Kind) -> str:
    """Return a hint for an unknown unit: same letters in another case, then a similar unit of the kind, then
    an example.
    """
    if known := _same_letters(unit, UNITS[kind]):
        return f'Did you mean "{known}"?'
    if close := difflib.get_close_matches(unit, UNITS[kind], n=1, cutoff=0.5):
        return f'Did you mean "{close[0]}"?'
    return f'Units of {_with_article(kind)}: {", ".join(UNITS[kind])}; e.g. "{EXAMPLES[kind]}"'


def _same_letters(unit: str, known: Iterable[str]) -> str | None:
    """Return the known unit of the same letters, large or small, or None if there is none."""
    return next((name for name in known if name.lower() == unit.lower()), None)


def _suggest(number: str, kind: Kind) -> str:
    """Return the given number with the unit of the kind's example."""
    return f"{number} {EXAMPLES[kind].split(' ', 1)[1]}"


def _with_article(kind: Kind) -> str:
    return f"{'an' if kind[0] in 'aeiou' else 'a'} {kind}"


def _plain(number: str) -> str:
    """Write 1e+03 as 1000: exponents only where the digits would run long."""
    if "e" not in number:
        return number
    written = repr(float(number))
    return written.removesuffix(".0")
