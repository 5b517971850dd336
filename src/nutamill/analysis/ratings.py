"""Catalogue data of bearings and sections for estimates of life: a TOML file beside the case, checked as a
case is.
"""

from pathlib import Path
from typing import Annotated, Literal

from pydantic import AfterValidator, Field, model_validator

from nutamill.base.errors import CaseError, Fault
from nutamill.base.file_kind import FileKind, refuse_other_kind
from nutamill.base.schema import (
    Angle,
    Coefficient,
    Coordinate,
    Force,
    Length,
    Number,
    Positive,
    Pressure,
    Quantity,
    Table,
    refusal,
)
from nutamill.base.units import Kind, shown
from nutamill.case.toml.layers import read_layers
from nutamill.case.toml.merge import merge
from nutamill.case.toml.messages import checked
from nutamill.result.fields import JOINTS, known_joints

Bore = Annotated[float, Quantity(Kind.LENGTH, "zero or more")]


class Bearing(Table):
    """A rolling bearing at a joint, as its catalogue describes it."""

    kind: Literal["ball", "roller"]
    """What rolls: exponent 3 or 10/3."""
    dynamic_rating: Force
    """Basic dynamic load rating C [N]."""
    static_rating: Force | None = None
    """Basic static load rating C0 [N]."""
    radial_factor: Coefficient = 1.0
    """Share X of the radial load in the equivalent one where the axial load counts."""
    axial_factor: Coefficient = 0.0
    """Share Y of the axial load in the equivalent one where it counts."""
    axial_limit: Coefficient = 0.0
    """Ratio e of axial to radial load above which it counts."""
    swing: Angle | None = None
    """Half of the angle it swings through, once to and fro per turn of the driveshaft [rad]; a bearing that
    turns if left out.
    """
    life_factor: Positive = 1.0
    """Factor on the basic life for reliability, lubricant and dirt, a1 times aISO [1]."""


def _joint(name: str) -> str:
    if name not in JOINTS:
        raise refusal(f"no such joint of the mill, got {name!r}", known_joints(name))
    return name


class Section(Table):
    """A round section of a shaft or pin, and the strength of its material."""

    joint: Annotated[str, AfterValidator(_joint)]
    """The joint whose reaction it carries."""
    axes: Literal["ground", "frame", "crank", "chamber"] = "crank"
    """Axes that are fixed to it."""
    axis: Literal["x", "y", "z"] = "z"
    """Its axis in those."""
    arm: tuple[Coordinate, Coordinate, Coordinate]
    """From the joint's point to the middle of the section, in those axes [m]."""
    diameter: Length
    """Outer diameter [m]."""
    bore: Bore = 0.0
    """Inner diameter [m]."""
    ultimate_strength: Pressure
    """Ultimate tensile strength [Pa]."""
    fatigue_strength: Pressure
    """Amplitude of stress it bears `fatigue_cycles` times, fully reversed; surface and size included [Pa]."""
    fatigue_cycles: Positive = 1e6
    """Cycles that belong to it [1]."""
    exponent: Positive
    """Slope of the S-N line: life goes with stress to the power minus this [1]."""
    stress_concentration: Annotated[Number, Field(ge=1.0)] = 1.0
    """Fatigue notch factor [1]."""

    @model_validator(mode="after")
    def _possible(self) -> "Section":
        if self.bore >= self.diameter:
            raise refusal(
                f"bore must be less than the diameter, got {shown(self.bore, 'mm', 'g')} in "
                f"{shown(self.diameter, 'mm', 'g')}"
            )
        if self.fatigue_strength >= self.ultimate_strength:
            raise refusal("fatigue_strength must be less than ultimate_strength")
        return self


class Ratings(Table):
    """Bearings and sections of a mill."""

    schema_version: Annotated[Literal[1], Field(alias="schema")] = 1
    """Version of the form of this file."""
    bearings: dict[str, Bearing] = Field(default_factory=dict)
    """Bearings by the name of their joint."""
    sections: dict[str, Section] = Field(default_factory=dict)
    """Sections by any name."""


def load_ratings(path: str | Path) -> Ratings:
    """Read the ratings of a TOML file.

    Raises
    ------
    CaseError : all faults at once, each with its file, line and key
    """
    refuse_other_kind(path, FileKind.RATINGS)
    content, positions, faults = merge(read_layers(path))
    ratings = checked(Ratings, content, positions, faults)
    for joint in ratings.bearings:
        if joint not in JOINTS:
            faults.append(
                Fault(
                    f"{path}: bearings.{joint}",
                    "no such joint of the mill",
                    known_joints(joint),
                )
            )
    if not ratings.bearings and not ratings.sections:
        faults.append(Fault(str(path), "must have a bearing or a section", "Write e.g. [bearings.pin_joint]"))
    if faults:
        raise CaseError(*faults)
    return ratings
