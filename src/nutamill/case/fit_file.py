"""The fit file: a case, the keys that are free, and the measured values they are to meet."""

from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, ValidationError

from nutamill.case.layers import Layer, placed, read_layer
from nutamill.case.library import library_file
from nutamill.case.wording import worded
from nutamill.case.write import toml_value
from nutamill.errors import CaseError
from nutamill.tables import FROM_FILE, Share, Table

Given = str | int | float


class FreeKey(Table):
    """A key that is to be found, and where to look for it."""

    start: Given
    """First guess."""
    low: Given
    """Lower bound."""
    high: Given
    """Upper bound."""
    step: Share = 0.01
    """Difference by which its influence is found, share of the range [1]; larger where the readings scatter."""


class Measured(Table):
    """A measured or published value."""

    quantity: str
    """A series, ``rms`` or ``swing`` and a series, or ``natural_frequency 1`` for the first of the modes below twice the full speed."""
    value: str
    """What was measured, with its unit."""
    uncertainty: str
    """Its standard uncertainty, with its unit."""
    set: dict[str, Any] = Field(default_factory=dict)
    """Changes of the case under which it was measured, by dotted key."""
    source: str = ""
    """Where it comes from."""


class FitFile(Table):
    """What a fit file says."""

    case: str
    """A published mill, or a case file beside this one."""
    set: dict[str, Any] = Field(default_factory=dict)
    """Changes in all runs, by dotted key."""
    free: Annotated[dict[str, FreeKey], Field(min_length=1)]
    """The keys to be found."""
    target: Annotated[tuple[Measured, ...], Field(min_length=1)]
    """The values to be met."""


def load_fit(name: str | Path) -> tuple[FitFile, Layer]:
    """What a fit file says, and the layer that knows the line of each key.

    Raises
    ------
    CaseError : every fault of form, with file, line and key
    """
    layer = read_layer(name)
    try:
        return FitFile.model_validate(layer.content, context={FROM_FILE: True}), layer
    except ValidationError as error:
        raise CaseError(*worded(error, FitFile, layer.content, layer.places)) from None


def case_of(file: FitFile, layer: Layer) -> tuple[str, list[str]]:
    """Name of the case, and the changes of all runs as ``key=value``."""
    return file.case if library_file(file.case) else str(layer.folder / file.case), overrides(file.set)


def overrides(changes: dict[str, Any]) -> list[str]:
    """Changes by dotted key as ``key=value``, as after ``--set``."""
    return [f"{key}={toml_value(value)}" for key, value in changes.items()]


def place_of(layer: Layer, *key: str | int) -> str:
    """Where a key stands, for messages."""
    return placed(layer.places, key)
