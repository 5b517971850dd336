"""Catalogue data of bearings and sections for estimates of life: a TOML file beside the case, checked as a
case is.
"""

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, model_validator

from nutamill.analysis.load_paths import CALLED, axes_of, joints_of
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
from nutamill.case.toml.addresses import Key, placed
from nutamill.case.toml.layers import read_layers
from nutamill.case.toml.merge import merge
from nutamill.case.toml.messages import checked
from nutamill.result import Result
from nutamill.result.fields import JOINTS, TURNING, known_joints

TURNING_AXES = tuple(CALLED.get(body, body) for body in TURNING)
"""Axes of a mill that turn, by name."""
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
    static_radial_factor: Coefficient | None = None
    """Share X0 of the radial load in the static equivalent one; of ball bearings 0.6, of roller bearings 1 if
    left out.
    """
    static_axial_factor: Coefficient | None = None
    """Share Y0 of the axial load in it; of ball bearings 0.5, of roller bearings 0 if left out."""
    swing: Angle | None = None
    """Half of the angle it swings through, once to and fro per turn of the drive [rad]; a bearing that
    turns if left out.
    """
    life_factor: Positive = 1.0
    """Factor on the basic life for reliability, lubricant and dirt, a1 times aISO [1]."""


class Section(Table):
    """A round section of a shaft or pin, and the strength of its material."""

    joint: str
    """The joint whose reaction it carries."""
    axes: str = "crank"
    """Axes that are fixed to it: "ground", or a body whose attitude is recorded; of a mill "frame", "crank"
    or "chamber".
    """
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
    """Bearings and sections of a machine."""

    schema_version: Annotated[Literal[1], Field(alias="schema")] = 1
    """Version of the form of this file."""
    bearings: dict[str, Bearing] = Field(default_factory=dict)
    """Bearings by the name of their joint."""
    sections: dict[str, Section] = Field(default_factory=dict)
    """Sections by any name."""


def load_ratings(path: str | Path, result: Result | None = None) -> Ratings:
    """Read the ratings of a TOML file.

    Parameters
    ----------
    result : the run whose joints and axes they name; a mill if not given

    Raises
    ------
    CaseError : all faults at once, each with its file, line and key
    """
    joints = list(JOINTS) if result is None else joints_of(result)
    axes = ["ground", *TURNING_AXES] if result is None else list(axes_of(result))
    refuse_other_kind(path, FileKind.RATINGS)
    content, positions, faults = merge(read_layers(path))
    ratings = checked(Ratings, content, positions, faults)
    named: list[tuple[Key, str]] = [(("bearings", joint), joint) for joint in ratings.bearings]
    named += [(("sections", name, "joint"), section.joint) for name, section in ratings.sections.items()]
    for key, joint in named:
        if joint not in joints:
            what = f"no such joint of the machine, got {joint!r}"
            faults.append(Fault(placed(positions, key, content), what, known_joints(joint, joints)))
    for name, section in ratings.sections.items():
        if section.axes not in axes:
            what, where = f"no such axes of the machine, got {section.axes!r}", ("sections", name, "axes")
            faults.append(Fault(placed(positions, where, content), what, f"Known are {', '.join(axes)}"))
    if not ratings.bearings and not ratings.sections:
        faults.append(Fault(str(path), "must have a bearing or a section", "Write e.g. [bearings.pin_joint]"))
    if faults:
        raise CaseError(*faults)
    return ratings
