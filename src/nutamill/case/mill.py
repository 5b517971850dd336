"""`Case`: the whole case file as frozen data, SI floats inside."""

import functools
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, model_validator

from nutamill.base.errors import CaseError, Fault
from nutamill.base.file_kind import MECHANISM, FileKind, refuse_other_kind
from nutamill.base.schema import Coordinate, Table, refusal
from nutamill.case import mill_checks
from nutamill.case.case_file import CaseFile, titled, validated
from nutamill.case.charge import ChargeRecipe
from nutamill.case.charge_checks import Vessel
from nutamill.case.drawing import (
    CHAMBER,
    Balance,
    BearingCross,
    Carriage,
    Chamber,
    DrawnMechanism,
    Driveshaft,
    IntermediateShaft,
    MeshedWall,
    Mounts,
    Rod,
    ShaftCoupling,
    TopFrame,
)
from nutamill.case.drive import DriveProgramme
from nutamill.case.expansion import mill_machine
from nutamill.case.fmus import FmuEntry
from nutamill.case.machine import Machine
from nutamill.case.materials import ContactLaws, Material
from nutamill.case.run import RunPlan
from nutamill.case.titles import origin_of
from nutamill.case.toml.layers import Layer, override_layer, read_layers
from nutamill.case.touching import Key, TouchingPair, touching_pairs

SensorBody = Literal["frame", "chamber", "carriage", "driveshaft", "bearing_cross", "intermediate_shaft"]
"""Parts a sensor can sit on."""


class Sensor(Table):
    """An accelerometer."""

    body: SensorBody
    """The part it sits on."""
    at: tuple[Coordinate, Coordinate, Coordinate]
    """Its place in the axes of that part, from the nutation point as assembled [m]."""


class Case(CaseFile):
    """Everything that is needed to repeat a run; made by `load_case`, changed by `Case.with_`."""

    schema_version: Annotated[Literal[1], Field(alias="schema")] = 1
    """Version of the form of this file."""
    title: str = ""
    """What is asked, in one line."""
    changed_from: str | None = None
    """Title of the case that this one was changed from, where its own title was made to say what was
    changed.
    """
    mechanism: DrawnMechanism
    chamber: Chamber
    walls: tuple[MeshedWall, ...] = ()
    """Solids inside the chamber and fixed to it, from mesh files."""
    carriage: Carriage
    driveshaft: Driveshaft
    balance: Balance
    bearing_cross: BearingCross
    rods: dict[str, Rod] = Field(default_factory=dict)
    """Six rods that hold the yoke, by name, where there are any; for their forces only."""
    intermediate_shaft: IntermediateShaft
    frame: TopFrame
    mounts: Mounts
    shaft_coupling: ShaftCoupling
    drive: DriveProgramme
    charge: ChargeRecipe
    materials: dict[str, Material]
    contact: ContactLaws
    sensors: dict[str, Sensor] = Field(default_factory=dict)
    fmus: tuple[FmuEntry, ...] = ()
    """Models of other programs that turn the driveshaft."""
    run: RunPlan

    # meshes and FMUs are identified by their content, wherever the files are
    files: ClassVar[dict[str, Any]] = {
        "chamber": {"mesh": {"file"}},
        "walls": {"__all__": {"file"}},
        "fmus": {"__all__": {"file"}},
    }

    @model_validator(mode="after")
    def _sound(self) -> "Case":
        if contradictions := mill_checks.faults(self):
            raise refusal("parts of the case contradict each other", findings=contradictions)
        return self

    @property
    def frame_mass(self) -> float:
        """Mass of the frame with the fixed parts of the drive [kg]: the total less the other parts."""
        return mill_checks.frame_mass(self)

    @functools.cached_property
    def machine(self) -> Machine:
        """The machine that the drawing describes: its bodies, joints, walls and sensors.

        Raises
        ------
        CaseError : no mass or no possible inertia left for the frame
        """
        return mill_machine(self)

    @property
    def drawing(self) -> "Case":
        """The drawing of the mill, for what needs it: its pictures, mounts, crank and balance."""
        return self

    @property
    def wall_materials(self) -> dict[Key, str]:
        """Material of every wall that the charge can touch, by its key: chamber, ribs, then ``[[walls]]``."""
        materials: dict[Key, str] = {("chamber", "material"): self.chamber.material}
        if self.chamber.ribs and self.chamber.rib:
            materials[("chamber", "rib", "material")] = self.chamber.rib.material
        return materials | {
            ("walls", number, "material"): wall.material for number, wall in enumerate(self.walls)
        }

    @property
    def vessels(self) -> dict[str, Vessel]:
        """What the charge is put into, by name: the chamber."""
        chamber = self.chamber
        label, width = (
            "ribbed chamber" if chamber.ribs else "chamber",
            min(chamber.inner_diameter, chamber.height),
        )
        return {CHAMBER: Vessel(label, chamber.free_volume, width, chamber.mesh is not None)}

    @property
    def touching(self) -> tuple[TouchingPair, ...]:
        """Pairs of materials that can touch: those of the charge, then each of them with every wall."""
        return touching_pairs(self)

    @property
    def warnings(self) -> list[Fault]:
        """What is possible but odd about the case."""
        return mill_checks.warnings(self)


def load_case(name_or_path: str | Path, overrides: list[str] | tuple[str, ...] = ()) -> Case | Machine:
    """Load the case of a file or of a published mill: a `Case`, or a `Machine` where the file lists bodies.

    Parameters
    ----------
    name_or_path : ``"numill"``, ``"numill-2025"``, or a TOML file
    overrides : texts ``key=value``, as after ``--set``; they go through the same parser as the file

    Raises
    ------
    CaseError : every fault, each with its file, line and key
    """
    refuse_other_kind(name_or_path, FileKind.CASE, FileKind.MECHANISM)
    layer, faults = override_layer(list(overrides))
    layers = [*read_layers(name_or_path), layer]
    origin = origin_of(layers)
    case = validated(_kind_of(layers), layers, Path(name_or_path).name.removesuffix(".toml"), faults)
    return case if origin is None else titled(case, origin)


def case_of_text(text: str, name: str = "case") -> Case | Machine:
    """Return the case, a mill or a machine, that a result file stores as TOML text.

    Raises
    ------
    CaseError : every fault
    """
    if not text:
        raise CaseError(
            Fault(
                name,
                "holds measured data, not the result of a run",
                "Use nutamill show, plot and compare",
            )
        )
    layers = [Layer.of_text(text, name)]
    return validated(_kind_of(layers), layers, name, [])


def _kind_of(layers: list[Layer]) -> type[CaseFile]:
    """Return the class that a file describes: a machine given part by part, or a mill."""
    return (
        Machine
        if any(isinstance(layer.content.get(key), list) for layer in layers for key in MECHANISM)
        else Case
    )
