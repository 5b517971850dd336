"""The fit file: a case, the keys that are free, and the measured values they are to meet."""

from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from nutamill.base.file_kind import FileKind
from nutamill.base.schema import Share, Table
from nutamill.case.toml.addresses import placed
from nutamill.case.toml.layers import Layer
from nutamill.studies.campaign_file import CampaignFile, read_campaign_file

Given = str | int | float


class FreeKey(Table):
    """A key that is fitted, with its first guess and bounds."""

    start: Given
    """First guess."""
    low: Given
    """Lower bound."""
    high: Given
    """Upper bound."""
    step: Share = 0.01
    """Difference by which its influence is computed, share of the range [1]; larger where the readings
    scatter.
    """


class Measured(Table):
    """A measured or published value."""

    quantity: str
    """A series, ``rms`` or ``swing`` and a series, or ``natural_frequency 1`` for the first of the modes
    about rest.
    """
    value: str
    """What was measured, with its unit."""
    uncertainty: str
    """Its standard uncertainty, with its unit."""
    set: dict[str, Any] = Field(default_factory=dict)
    """Changes of the case under which it was measured, by dotted key."""
    source: str = ""
    """Where it comes from."""


class FitFile(CampaignFile):
    """Content of a fit file."""

    kind_of_file = FileKind.FIT

    free: Annotated[dict[str, FreeKey], Field(min_length=1)]
    """The keys that are fitted."""
    target: Annotated[tuple[Measured, ...], Field(min_length=1)]
    """The values to be met."""


def load_fit(name: str | Path) -> tuple[FitFile, Layer]:
    """Return the content of a fit file, and the layer that knows the line of each key.

    Raises
    ------
    CaseError : every fault of form, with file, line and key
    """
    return read_campaign_file(name, FitFile)


def position_of(layer: Layer, *key: str | int) -> str:
    """Return the position of a key in its file, for messages."""
    return placed(layer.places, key)
