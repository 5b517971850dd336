"""The identification file: a case, its unknown numbers with their ranges, and what was measured."""

from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, model_validator

from nutamill.base.file_kind import FileKind
from nutamill.base.schema import Positive, Seed, Table, refusal
from nutamill.case.toml.layers import Layer
from nutamill.studies.campaign_file import CampaignFile, read_campaign_file
from nutamill.studies.fit_file import Given

MOST_STAGE_MEMBERS = 2000
"""Members of a stage at most [1]: the work of an emulator grows with their cube."""


class UnknownGiven(Table):
    """A number that nobody knows: of the case, or the gain of an instrument."""

    keys: tuple[str, ...] = ()
    """Dotted keys of the case that hold it, all of them the same number."""
    gain_of: tuple[str, ...] = ()
    """Quantities of rows that it multiplies, in place of `keys`: the gain of an instrument."""
    low: Given
    """Lower end of its range."""
    high: Given
    """Upper end of its range. Within the range no value is more probable than another before the rows."""
    reason: Annotated[str, Field(min_length=1)]
    """Why the range is what it is."""
    plus: str = ""
    """Another unknown whose value is added: the keys hold the sum."""
    campaign: str = ""
    """Rows that it belongs to; all of them if empty."""
    stages: tuple[str, ...] = ()
    """Stages in whose rows it acts; all of them if empty."""

    @model_validator(mode="after")
    def _one_place(self) -> "UnknownGiven":
        if bool(self.keys) == bool(self.gain_of):
            raise refusal("must have either keys or gain_of", 'Write e.g. keys = ["drive.speed"]')
        if self.plus and not self.keys:
            raise refusal("plus has no use with gain_of", "Leave it out")
        return self


class RowGiven(Table):
    """A measured number, or one to predict, and the variant of the case that it belongs to."""

    title: str = ""
    """What to call it in tables and figures."""
    quantity: str = ""
    """A series, ``rms`` or ``swing`` and a series, ``natural_frequency 1``, or a quantity of the papers."""
    paper: str = ""
    """Paper that holds the row, in place of `quantity`, `value` and the case; beside a `quantity`, that of
    the same run.
    """
    row: str = ""
    """Its name in that paper."""
    value: Given | None = None
    """What was measured, with its unit; needed where rows are learned from."""
    scatter: Given | None = None
    """Standard uncertainty of the measurement, with its unit."""
    discrepancy: Given | None = None
    """Standard deviation by which the model itself is trusted to be off, with its unit."""
    record: str = ""
    """A file of `nutamill import` beside this one, in place of `value`: its steady mean."""
    case: str = ""
    """A case in place of that of the file."""
    set: dict[str, Any] = Field(default_factory=dict)
    """Changes of the case, by dotted key."""
    campaign: str = ""
    """Name that unknowns of one campaign of measurements share with it."""
    stages: tuple[str, ...] = ()
    """Stages that run it; the first if not given."""
    source: str = ""
    """Where the number comes from."""
    published: str = ""
    """Row of a paper that its interval stands beside, as ``mca2026/table7-empty-force``; that of `paper` and
    `row` if not given.
    """

    @model_validator(mode="after")
    def _one_name(self) -> "RowGiven":
        if not (self.quantity or self.paper) or bool(self.paper) != bool(self.row):
            example = 'Write e.g. quantity = "driveshaft_torque"'
            raise refusal("must have quantity, or paper and row", example)
        if self.value is not None and self.record:
            raise refusal("must have either value or record, got both", "Leave one out")
        return self


class StageGiven(Table):
    """Members that are run together."""

    name: Annotated[str, Field(min_length=1)]
    """Its name."""
    members: Annotated[int, Field(ge=2, le=MOST_STAGE_MEMBERS)]
    """Points of the ranges at which its rows are run."""
    cut: Positive = 3.0
    """Implausibility above which a point of the ranges is ruled out for the stages after it [1]."""
    draws: bool = False
    """Whether its members are draws of the posterior of the stages before it, and its rows are predicted from
    them as they are, without an emulator: for runs of which only a few can be afforded.
    """
    active: tuple[str, ...] = ()
    """Unknowns, and rows of earlier stages, that the emulators of its rows depend on. All unknowns that act
    if empty. What they leave open is part of the emulators' error.
    """


class IdentifyFile(CampaignFile):
    """Content of an identification file."""

    kind_of_file = FileKind.IDENTIFY

    unknown: Annotated[dict[str, UnknownGiven], Field(min_length=1)]
    """Unknown numbers by name."""
    stage: Annotated[tuple[StageGiven, ...], Field(min_length=1)]
    """Stages, in the order in which they are run."""
    learn: Annotated[tuple[RowGiven, ...], Field(min_length=1)]
    """Rows to learn from."""
    predict: tuple[RowGiven, ...] = ()
    """Rows to predict."""
    seed: Seed = 1
    """Seed of the sample and of the posterior."""


def load_identification(name: str | Path) -> tuple[IdentifyFile, Layer]:
    """Return the content of an identification file, and the layer that knows the line of each key.

    Raises
    ------
    CaseError : every fault of form, with file, line and key
    """
    return read_campaign_file(name, IdentifyFile)
