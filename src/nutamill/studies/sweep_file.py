"""The sweep file: a case, what is changed in all runs, and what is swept."""

from pathlib import Path
from typing import Any

from pydantic import Field

from nutamill.base.file_kind import FileKind, file_kind
from nutamill.case.toml.write import toml_value
from nutamill.studies.campaign_file import CampaignFile, case_of, read_campaign_file


class SweepFile(CampaignFile):
    """Content of a sweep file."""

    kind_of_file = FileKind.SWEEP

    sweep: dict[str, str | int | float | list[Any]] = Field(default_factory=dict)
    """Values by dotted key: a list, or text as after ``-s``."""
    readings: tuple[str, ...] = ()
    """What is put into the table; force, torque, power and mount travel unless given."""


def is_sweep_file(name: str) -> bool:
    """Return whether a name is that of a sweep file."""
    return file_kind(name) is FileKind.SWEEP


def load_sweep(name: str | Path) -> tuple[str, list[str], dict[str, str | list[str]], tuple[str, ...]]:
    """Return the case, changes in all runs (``key=value``), values or text by swept key, and readings.

    Raises
    ------
    CaseError : every fault, with file, line and key
    """
    file, layer = read_campaign_file(name, SweepFile)
    case, fixed = case_of(file, layer)
    swept = {
        key: [toml_value(one) for one in value] if isinstance(value, list) else str(value)
        for key, value in file.sweep.items()
    }
    return case, fixed, swept, file.readings
