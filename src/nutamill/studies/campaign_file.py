"""What the files of campaigns have in common: a case, and what is changed in all of its runs."""

from pathlib import Path
from typing import Any, ClassVar, TypeVar

from pydantic import Field

from nutamill.base.file_kind import FileKind, refuse_other_kind
from nutamill.base.library import library_file
from nutamill.base.schema import Table
from nutamill.case.toml.layers import Layer, read_layer
from nutamill.case.toml.messages import checked
from nutamill.case.toml.write import toml_value


class CampaignFile(Table):
    """A case and changes of it."""

    kind_of_file: ClassVar[FileKind]

    case: str
    """A published mill, or a case file beside this one."""
    set: dict[str, Any] = Field(default_factory=dict)
    """Changes in all runs, by dotted key."""


Kind = TypeVar("Kind", bound=CampaignFile)


def read_campaign_file(name: str | Path, kind: type[Kind]) -> tuple[Kind, Layer]:
    """Return the content of a file of this kind, and the layer that knows the line of each key.

    Raises
    ------
    CaseError : every fault of form, with file, line and key
    """
    refuse_other_kind(name, kind.kind_of_file)
    layer = read_layer(name)
    return checked(kind, layer.content, layer.places), layer


def case_of(file: CampaignFile, layer: Layer) -> tuple[str, list[str]]:
    """Return the name of the case, and the changes of all runs as ``key=value``."""
    return file.case if library_file(file.case) else str(layer.folder / file.case), overrides(file.set)


def overrides(changes: dict[str, Any]) -> list[str]:
    """Return changes by dotted key as ``key=value``, as after ``--set``."""
    return [f"{key}={toml_value(value)}" for key, value in changes.items()]
