"""`Case`: the whole case file as frozen data, SI floats inside."""

from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, Field, model_validator

from nutamill.base.errors import CaseError, Fault
from nutamill.base.file_kind import MECHANISM, FileKind, refuse_other_kind
from nutamill.base.schema import (
    AutoTime,
    Coordinate,
    Count,
    EndTime,
    Frequency,
    Seed,
    Share,
    Table,
    Time,
    refusal,
    spelled,
)
from nutamill.case import mill_checks
from nutamill.case.case_file import CaseFile, SnapshotPlan, titled, validated
from nutamill.case.charge import ChargeRecipe
from nutamill.case.drawing import (
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
from nutamill.case.machine import Machine
from nutamill.case.materials import ContactLaws, Material
from nutamill.case.titles import origin_of
from nutamill.case.toml.layers import Layer, override_layer, read_layers
from nutamill.case.touching import TouchingPair, touching_pairs

MOST_THREADS = 1000
"""Threads that a case may ask for [1]; no computer of today has more cores for one process."""


def _threads(given: Any) -> Any:
    whole = isinstance(given, int) and not isinstance(given, bool)
    if given != "auto" and not (whole and 1 <= given <= MOST_THREADS):
        raise refusal(f'must be "auto" or a whole number from 1 to {MOST_THREADS}, got {spelled(given)}')
    return given


class Sensor(Table):
    """An accelerometer."""

    body: Literal[mill_checks.SENSOR_BODIES]
    """The part it sits on."""
    at: tuple[Coordinate, Coordinate, Coordinate]
    """Its place in the axes of that part, from the nutation point as assembled [m]."""


STEADY_DEFAULTS = {"max": "30 s", "precision": 0.01}
"""Keys of a run that ends when steady, unless given."""


class RunPlan(Table):
    """How long, how finely, and what is recorded."""

    until: EndTime
    """Simulated time at the end [s]; ``"steady"``: when crank-pin force and torque are steady, looked at
    after each `run.checkpoint`.
    """
    max: Time | None = None
    """With until = "steady": simulated time at the end at the latest [s]."""
    precision: Share | None = None
    """With until = "steady": 95 % half width, and drift, of both means at which they count as known and
    steady, share of their size [1].
    """
    dt: AutoTime = "auto"
    """Charge substep [s]; ``"auto"``: contact time of the stiffest, lightest pair over 20."""
    window: Annotated[Count, Field(ge=1, le=1000)] = 10
    """Charge substeps in one mechanism step [1]."""
    coupling: Literal["prescribed", "staggered", "iterated"] = "staggered"
    """Whether the charge moves the mechanism, and how often a window is repeated."""
    threads: Annotated[int | str, BeforeValidator(_threads)] = "auto"
    """Threads of the charge; ``"auto"``: the physical cores."""
    seed: Seed = 1
    """Seed of the placement of the charge."""
    series_rate: Frequency = 4800.0
    """Rate of the recorded series [Hz]."""
    snapshots: SnapshotPlan = SnapshotPlan(rate=200.0, last=0.5)
    """Snapshots of the charge."""
    checkpoint: Time = 1.0
    """Simulated time between checkpoints [s]; where that takes longer than ten minutes, more are saved
    between.
    """
    statistics: bool = True
    """Whether spectra, wall work and fields of the charge are summed, and recorded after every
    `run.checkpoint`.
    """

    @model_validator(mode="before")
    @classmethod
    def _bounded(cls, given: Any) -> Any:
        """A run that ends when steady has a longest time and a precision, whether given or not."""
        return (
            STEADY_DEFAULTS | given if isinstance(given, dict) and given.get("until") == "steady" else given
        )

    @property
    def end(self) -> float:
        """Simulated time at the end at the latest [s]."""
        return self.max if self.until == "steady" else self.until


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
    run: RunPlan

    # a mesh is known by its content, wherever the file is
    files: ClassVar[dict[str, Any]] = {"chamber": {"mesh": {"file"}}, "walls": {"__all__": {"file"}}}

    @model_validator(mode="after")
    def _sound(self) -> "Case":
        if contradictions := mill_checks.faults(self):
            raise refusal("parts of the case contradict each other", findings=contradictions)
        return self

    @property
    def frame_mass(self) -> float:
        """Mass of the frame with the fixed parts of the drive [kg]: the total less the other parts."""
        return mill_checks.frame_mass(self)

    @property
    def touching(self) -> tuple[TouchingPair, ...]:
        """Pairs of materials that can touch: those of the charge, then each of them with every wall."""
        return touching_pairs(self)

    @property
    def warnings(self) -> list[Fault]:
        """What is possible but odd about the case."""
        return mill_checks.warnings(self)


def load_case(name_or_path: str | Path, overrides: list[str] | tuple[str, ...] = ()) -> Case | Machine:
    """The case of a file or of a published mill: a `Case`, or a `Machine` where the file lists bodies.

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


def load_mill(name_or_path: str | Path, overrides: list[str] | tuple[str, ...] = ()) -> Case:
    """`load_case` for what only a mill can do; raises CaseError for a file that describes a mechanism part by
    part.
    """
    case = load_case(name_or_path, overrides)
    if isinstance(case, Machine):
        raise CaseError(
            Fault(
                str(name_or_path),
                "describes a mechanism part by part ([[bodies]]), not a mill",
                "Use nutamill check, run, show and resume",
            )
        )
    return case


def case_of_text(text: str, name: str = "case") -> Case | Machine:
    """The case that a result file keeps as TOML text, of either kind.

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
    """What a file describes: parts one by one, or a mill."""
    return (
        Machine
        if any(isinstance(layer.content.get(key), list) for layer in layers for key in MECHANISM)
        else Case
    )
