"""What all tables of a case file share: a frozen pydantic model, and fields that carry the kind of quantity
they hold.

A field is declared as ``inner_diameter: Length``; its value is an SI float.  Read from a file it must be text
with a unit; given from Python it may be an SI float or such text.  Written to a file it becomes text with a
unit again.
"""

import math
from typing import Annotated, Any, NamedTuple

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, Strict
from pydantic_core import PydanticCustomError, core_schema

from nutamill.base import units
from nutamill.base.errors import printable
from nutamill.base.units import UNITS, Kind

FROM_FILE = "from_file"
"""Key of the validation context that is true while a file is read: plain numbers are then refused for
quantities.
"""


SIZES: dict[Kind, tuple[float, float]] = {
    Kind.LENGTH: (1e-9, 1e4),
    Kind.MASS: (1e-15, 1e9),
    Kind.TIME: (1e-12, 1e8),
    Kind.ANGLE: (1e-9, 1e6),
    Kind.SPEED: (1e-6, 1e5),
    Kind.FREQUENCY: (1e-6, 1e8),
    Kind.FORCE: (1e-12, 1e12),
    Kind.TORQUE: (1e-12, 1e12),
    Kind.ENERGY: (1e-15, 1e15),
    Kind.POWER: (1e-9, 1e12),
    Kind.STIFFNESS: (1e-6, 1e15),
    Kind.ROTATIONAL_STIFFNESS: (1e-9, 1e15),
    Kind.DAMPING: (1e-9, 1e12),
    Kind.ROTATIONAL_DAMPING: (1e-12, 1e12),
    Kind.DENSITY: (1e-2, 1e6),
    Kind.PRESSURE: (1e-3, 1e14),
    Kind.VISCOSITY: (1e-9, 1e9),
    Kind.SURFACE_TENSION: (1e-6, 1e3),
    Kind.VELOCITY: (1e-9, 1e5),
    Kind.ACCELERATION: (1e-9, 1e5),
    Kind.INERTIA: (1e-20, 1e12),
    Kind.RAMP: (1e-6, 1e6),
    Kind.UNBALANCE: (1e-15, 1e9),
    Kind.VOLUME: (1e-18, 1e9),
    Kind.SPECIFIC_ENERGY: (1e-6, 1e9),
}
"""Smallest and largest size of each kind of quantity, SI: what is beyond has been mistyped, for no machine
has it.

The smallest does not hold for numbers that may have either sign: a coordinate may be as near to zero as it
likes.
"""
SMALLEST_SHARE, LARGEST_COEFFICIENT, LARGEST_NUMBER, LARGEST_COUNT = 1e-9, 1e6, 1e12, 10**9
"""Smallest share above zero, largest coefficient, and largest size of a plain number and of a count [1]."""
LONG_INTEGER, MOST_SHOWN = 10**20, 80
"""Whole numbers from which, and characters of a text beyond which, messages give the length only [1]."""


def refusal(what: str, hint: str = "", **details: Any) -> PydanticCustomError:
    """Return the error that a validator raises here. `what` states what must hold and what was given, `hint`
    what to write instead.
    """
    return PydanticCustomError("nutamill", "{what}", {"what": what, "hint": hint, **details})


class Table(BaseModel):
    """One table of a case file: frozen, and an unknown key is an error."""

    model_config = ConfigDict(
        frozen=True,
        extra="forbid",
        allow_inf_nan=False,
        use_attribute_docstrings=True,
        populate_by_name=True,
        validate_default=False,
    )


class Quantity(NamedTuple):
    """Marks a float field as a quantity: the kind of its unit, and its sign."""

    kind: Kind
    """What is measured."""
    sign: str = "positive"
    """``"positive"``, ``"zero or more"`` or ``"any"``."""
    word: str = ""
    """A word that may stand in place of a quantity, such as ``"auto"``."""

    def read(self, value: Any, info: core_schema.ValidationInfo) -> float | str:
        """Return the SI value of what a file or a caller gave."""
        if self.word and value == self.word:
            return value
        instead = f'Write e.g. "{units.example(self.kind)}"' + (f' or "{self.word}"' if self.word else "")
        if isinstance(value, str):
            try:
                si = units.parse(value, self.kind)
            except units.UnitError as error:
                word = f' or "{self.word}"' if self.word and error.hint.startswith("Write") else ""
                raise refusal(error.what, error.hint + word) from None
        elif isinstance(value, bool) or not isinstance(value, (int, float)):
            raise refusal(f"must be text with a unit, got {spelled(value)}", instead)
        elif (info.context or {}).get(FROM_FILE) and math.isfinite(value):
            unit = units.example(self.kind).split(" ", 1)[1]
            raise refusal(f'needs a unit: write "{value:g} {unit}" (a plain number is ambiguous)')
        else:
            si = float(value)
        if not math.isfinite(si):
            raise refusal(f"must be a finite number with a unit, got {spelled(value)}", instead)
        if fault := self._beyond(si):
            raise refusal(f"{fault}, got {spelled(value)}")
        if (si < 0.0 and self.sign != "any") or (si == 0.0 and self.sign == "positive"):
            raise refusal(f"must be {self.sign}, got {spelled(value)}")
        return si

    def _beyond(self, si: float) -> str:
        """Return what a value of this size has to be, empty if it is neither too small nor too large."""
        (smallest, largest), unit = SIZES[self.kind], next(iter(UNITS[self.kind]))
        if abs(si) > largest:
            return f"must be at most {largest:g} {unit}"
        if self.sign != "any" and 0.0 < si < smallest:
            return f"must be at least {smallest:g} {unit}"
        return ""

    def write(self, value: float | str | None) -> Any:
        """Return text with a unit for the file."""
        return value if value is None or isinstance(value, str) else units.format(value, self.kind)

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> core_schema.CoreSchema:
        return core_schema.with_info_plain_validator_function(
            self.read,
            serialization=core_schema.plain_serializer_function_ser_schema(self.write, when_used="json"),
        )

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        example = [units.example(self.kind)] + ([self.word] if self.word else [])
        word = f"|{self.word}" if self.word else ""
        return {
            "type": "string",
            "pattern": rf"^\s*([+-]?[0-9.]+([eE][+-]?[0-9]+)?\s*[^0-9\s.+eE-].*{word})$",
            "examples": example,
            "description": f"{self.kind} with its unit, e.g. {example[0]}",
        }


def spelled(value: Any) -> str:
    """Return a value as the file spells it, shortened where it is long."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, (list, tuple)):
        return "a list"
    if isinstance(value, int) and abs(value) >= LONG_INTEGER:
        return f"a number of about {round(value.bit_length() * math.log10(2.0))} digits"
    if isinstance(value, str) and len(value) > MOST_SHOWN:
        return f'"{printable(value[:MOST_SHOWN])}..." of {len(value)} characters'
    return f'"{printable(value)}"' if isinstance(value, str) else f"{value}"


def _no_text_or_bool(value: Any) -> Any:
    if isinstance(value, (str, bool, dict, list, tuple)):
        raise refusal(f"must be a plain number, got {spelled(value)}")
    return value


def _not_tiny(value: float) -> float:
    if 0.0 < value < SMALLEST_SHARE:
        raise refusal(f"must be at least {SMALLEST_SHARE:g}, got {spelled(value)}")
    return value


Length = Annotated[float, Quantity(Kind.LENGTH)]
Coordinate = Annotated[float, Quantity(Kind.LENGTH, "any")]
Volume = Annotated[float, Quantity(Kind.VOLUME)]
Mass = Annotated[float, Quantity(Kind.MASS)]
AddedMass = Annotated[float, Quantity(Kind.MASS, "zero or more")]
Time = Annotated[float, Quantity(Kind.TIME)]
StartTime = Annotated[float, Quantity(Kind.TIME, "zero or more")]
EndTime = Annotated[float | str, Quantity(Kind.TIME, word="steady")]
AutoTime = Annotated[float | str, Quantity(Kind.TIME, word="auto")]
Angle = Annotated[float, Quantity(Kind.ANGLE)]
AnyAngle = Annotated[float, Quantity(Kind.ANGLE, "any")]
Speed = Annotated[float, Quantity(Kind.SPEED)]
AnySpeed = Annotated[float, Quantity(Kind.SPEED, "any")]
ProfileSpeed = Annotated[float, Quantity(Kind.SPEED, "zero or more")]
Ramp = Annotated[float, Quantity(Kind.RAMP)]
Frequency = Annotated[float, Quantity(Kind.FREQUENCY)]
Force = Annotated[float, Quantity(Kind.FORCE)]
PassiveForce = Annotated[float, Quantity(Kind.FORCE, "zero or more")]
AnyForce = Annotated[float, Quantity(Kind.FORCE, "any")]
Power = Annotated[float, Quantity(Kind.POWER)]
MotorTorque = Annotated[float, Quantity(Kind.TORQUE)]
RotationalGain = Annotated[float, Quantity(Kind.ROTATIONAL_DAMPING)]
Torque = Annotated[float, Quantity(Kind.TORQUE, "zero or more")]
Moment = Annotated[float, Quantity(Kind.TORQUE, "any")]
Stiffness = Annotated[float, Quantity(Kind.STIFFNESS)]
BushingStiffness = Annotated[float, Quantity(Kind.STIFFNESS, "zero or more")]
RollingStiffness = Annotated[float, Quantity(Kind.ROTATIONAL_STIFFNESS)]
RotationalStiffness = Annotated[float, Quantity(Kind.ROTATIONAL_STIFFNESS, "zero or more")]
Damping = Annotated[float, Quantity(Kind.DAMPING, "zero or more")]
RotationalDamping = Annotated[float, Quantity(Kind.ROTATIONAL_DAMPING, "zero or more")]
Density = Annotated[float, Quantity(Kind.DENSITY)]
Pressure = Annotated[float, Quantity(Kind.PRESSURE)]
AddedPressure = Annotated[float, Quantity(Kind.PRESSURE, "zero or more")]
Viscosity = Annotated[float, Quantity(Kind.VISCOSITY, "zero or more")]
SurfaceTension = Annotated[float, Quantity(Kind.SURFACE_TENSION)]
BridgeVolume = Annotated[float, Quantity(Kind.VOLUME, "zero or more")]
ContactAngle = Annotated[float, Quantity(Kind.ANGLE, "zero or more")]
Acceleration = Annotated[float, Quantity(Kind.ACCELERATION, "zero or more")]
AnyAcceleration = Annotated[float, Quantity(Kind.ACCELERATION, "any")]
Velocity = Annotated[float, Quantity(Kind.VELOCITY, "any")]
Inertia = Annotated[float, Quantity(Kind.INERTIA)]
SpecificEnergy = Annotated[float, Quantity(Kind.SPECIFIC_ENERGY)]
LeastSpecificEnergy = Annotated[float, Quantity(Kind.SPECIFIC_ENERGY, "zero or more")]
LinearGain = Annotated[float, Quantity(Kind.DAMPING)]
AnyInertia = Annotated[float, Quantity(Kind.INERTIA, "any")]
Number = Annotated[
    float, BeforeValidator(_no_text_or_bool), Strict(), Field(ge=-LARGEST_NUMBER, le=LARGEST_NUMBER)
]
Positive = Annotated[Number, Field(gt=0.0), AfterValidator(_not_tiny)]
Share = Annotated[Number, Field(gt=0.0, le=1.0), AfterValidator(_not_tiny)]
Coefficient = Annotated[
    float, BeforeValidator(_no_text_or_bool), Strict(), Field(ge=0.0, le=LARGEST_COEFFICIENT)
]
Count = Annotated[int, BeforeValidator(_no_text_or_bool), Strict(), Field(le=LARGEST_COUNT)]
Seed = Annotated[int, BeforeValidator(_no_text_or_bool), Strict(), Field(ge=0, lt=2**63)]
