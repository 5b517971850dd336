"""`Case`: the whole case file as frozen data, SI floats inside."""

import functools
import hashlib
import json
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, PrivateAttr, ValidationError, model_validator

from nutamill.case import checks
from nutamill.case.drive import DriveProgramme
from nutamill.case.layers import Layer, merge, override_layer, python_layer, read_layers
from nutamill.case.recipe import ChargeRecipe
from nutamill.case.wording import worded
from nutamill.case.write import written
from nutamill.errors import CaseError, Fault
from nutamill.machine import (
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
from nutamill.materials import ContactLaws, Material
from nutamill.tables import FROM_FILE, AutoTime, Coordinate, Count, Frequency, Table, Time, refusal


def _threads(given: Any) -> Any:
    if given != "auto" and (isinstance(given, bool) or not isinstance(given, int) or given < 1):
        raise refusal(f'must be "auto" or a whole number from 1, got {json.dumps(given, default=str)}')
    return given


class Sensor(Table):
    """An accelerometer."""

    body: Literal[checks.SENSOR_BODIES]
    """The part it sits on."""
    at: tuple[Coordinate, Coordinate, Coordinate]
    """Its place in the axes of that part, from the nutation point as assembled [m]."""


class SnapshotPlan(Table):
    """When the whole state is kept for looking."""

    rate: Frequency
    """How often [Hz]."""
    last: Time
    """How long before the end of the run [s]."""


class RunPlan(Table):
    """How long, how finely, and what is kept."""

    until: Time
    """Simulated time at the end [s]."""
    dt: AutoTime = "auto"
    """Charge substep [s]; ``"auto"``: contact time of the stiffest, lightest pair over 20."""
    window: Annotated[Count, Field(ge=1)] = 10
    """Charge substeps in one mechanism step [1]."""
    coupling: Literal["prescribed", "staggered", "iterated"] = "staggered"
    """Whether the charge moves the mechanism, and how often a window is repeated."""
    threads: Annotated[int | str, BeforeValidator(_threads)] = "auto"
    """Threads of the charge; ``"auto"``: the physical cores."""
    seed: Annotated[Count, Field(ge=0)] = 1
    """Seed of the placement of the charge."""
    series_rate: Frequency = 4800.0
    """Rate of the recorded series [Hz]."""
    snapshots: SnapshotPlan = SnapshotPlan(rate=200.0, last=0.5)
    """Snapshots of the charge."""
    checkpoint: Time = 1.0
    """Simulated time between checkpoints [s]."""
    statistics: bool = True
    """Whether spectra, wall work and fields of the charge are summed, and recorded at every checkpoint."""


class Case(Table):
    """Everything that is needed to repeat a run; made by `load_case`, changed by `Case.with_`."""

    schema_version: Annotated[Literal[1], Field(alias="schema")] = 1
    """Version of the form of this file."""
    title: str = ""
    """One line that says what is asked."""
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

    _name: str = PrivateAttr("case")

    @model_validator(mode="after")
    def _sound(self) -> "Case":
        if found := checks.faults(self):
            raise refusal("parts of the case contradict each other", findings=found)
        return self

    @property
    def name(self) -> str:
        """Short name for file names: the stem of the case file, or the library name."""
        return self._name

    @property
    def result_file(self) -> Path:
        """Where the result goes unless told otherwise: ``results/<case>-<hash>.h5``."""
        return Path("results") / f"{self.name}-{self.digest[:6]}.h5"

    @property
    def frame_mass(self) -> float:
        """Mass of the frame with the fixed parts of the drive [kg]: the total less the other parts."""
        return checks.frame_mass(self)

    @property
    def warnings(self) -> list[Fault]:
        """What is possible but odd about the case."""
        return checks.warnings(self)

    @functools.cached_property
    def digest(self) -> str:
        """SHA-256 of the content, in hexadecimal: the identity of the case, whatever units or base it was written with."""
        # a mesh is known by its content, wherever the file is
        files = {"chamber": {"mesh": {"file"}}, "walls": {"__all__": {"file"}}}
        content = json.dumps(_rounded(self.model_dump(by_alias=True, exclude_none=True, exclude=files)), sort_keys=True)
        return hashlib.sha256(content.encode()).hexdigest()

    def with_(self, key: str | None = None, value: Any = None, /, **changes: Any) -> "Case":
        """The case with other values: ``case.with_("drive.speed", "500 rpm")`` or ``case.with_(drive__speed=52.36)``.

        Parameters
        ----------
        key, value : dotted key as in the file, and its new value
        changes : more of them, with ``__`` in place of the dot
        Values are SI floats or text with a unit.

        Raises
        ------
        CaseError : every fault of the changed case
        """
        given = {name.replace("__", "."): new for name, new in changes.items()}
        if key is not None:
            given[key] = value
        now = Layer(self.model_dump(by_alias=True, exclude_none=True), {}, Path.cwd())
        return _validated([now, python_layer(given)], self.name, [], from_file=False)

    def to_toml(self) -> str:
        """The complete case file, every default written out; `Case.from_toml` reads back an equal case."""
        return written(self)

    @classmethod
    def from_toml(cls, text: str, name: str = "case") -> "Case":
        """The case that complete TOML text describes, as `to_toml` writes it and a result file keeps it.

        Raises
        ------
        CaseError : every fault found
        """
        return _validated([Layer.of_text(text, name)], name, [])

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Case) and self.digest == other.digest

    def __hash__(self) -> int:
        return hash(self.digest)


def load_case(name_or_path: str | Path, overrides: list[str] | tuple[str, ...] = ()) -> Case:
    """The case of a file or of a published mill.

    Parameters
    ----------
    name_or_path : ``"numill"``, ``"numill-2025"``, or a TOML file
    overrides : texts ``key=value``, as after ``--set``; they go through the same parser as the file

    Raises
    ------
    CaseError : every fault found, each with its file, line and key
    """
    layer, faults = override_layer(list(overrides))
    return _validated([*read_layers(name_or_path), layer], Path(name_or_path).name.removesuffix(".toml"), faults)


def _validated(layers: list[Layer], name: str, faults: list[Fault], *, from_file: bool = True) -> Case:
    """Merge the layers and make the case, or raise the faults found so far with all others."""
    content, places, more = merge(layers)
    faults = [*faults, *more]
    try:
        case = Case.model_validate(content, context={FROM_FILE: from_file})
    except ValidationError as error:
        faults += worded(error, Case, content, places)
    if faults:
        raise CaseError(*faults)
    case._name = name
    return case


def _rounded(value: Any) -> Any:
    """Floats to 12 digits, so that a value given in another unit has the same digest."""
    if isinstance(value, float):
        return f"{value:.12g}"
    if isinstance(value, dict):
        return {key: _rounded(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [_rounded(inner) for inner in value]
    return value
