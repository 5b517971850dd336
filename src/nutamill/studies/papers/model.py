"""What a paper's file holds: configurations that were run, rows of numbers to compare, figures; frozen, and
refused when wrong.
"""

import math
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field, model_validator

from nutamill.base import units
from nutamill.base.schema import Coefficient, Count, Number, Speed, Table, Time, refusal
from nutamill.base.units import Kind
from nutamill.studies.papers.quantities import MODES, QUANTITIES

SAME_SPEED = 1e-6
"""Share by which two speeds may differ and still be the same."""

if TYPE_CHECKING:
    QuantityName = str
else:
    QuantityName = Literal[tuple(QUANTITIES)]
"""Name of a quantity of `nutamill.studies.papers.quantities`."""

NUMBERS = ("experiment", "simulation")
"""Published numbers of a row."""


def same_speed(a: float, b: float) -> bool:
    """Return whether two speeds [rad/s] are the same but for round-off."""
    return math.isclose(a, b, rel_tol=SAME_SPEED)


class Configuration(Table):
    """One way the mill was set up, at several speeds."""

    title: str
    """What it is, in a few words."""
    base: str = "numill"
    """The case it starts from."""
    set: tuple[str, ...] = ()
    """What it changes, as after ``--set``."""
    speed_key: str = "drive.speed"
    """Dotted key of the case that its speed is given to; not used at speed zero."""
    speeds: Annotated[tuple[Speed, ...], Field(min_length=1)] = (0.0,)
    """Steady speeds at which it is run [rad/s]; zero for a machine that the paper gives no speed of."""
    quick: tuple[Speed, ...] = ()
    """Those that decide, taken with ``--quick`` [rad/s]."""
    hold: Time = 3.0
    """Time at the steady speed, after the ramp of a mill [s]; of another machine the whole run."""
    average: Time = 3.0
    """Length of the averaging window at the end [s]; 3 s in both papers."""
    seeds: Annotated[tuple[Count, ...], Field(min_length=1)] = (1,)
    """Seeds of the placement of the charge."""
    repeated: tuple[Speed, ...] = ()
    """Speeds that are run with all seeds [rad/s]; the others with the first."""
    sensitivity: str = ""
    """What is changed of the mill, where this is a sensitivity run: shown, not counted as a prediction."""
    note: str = ""
    """What differs from the paper's own run, and why."""

    @model_validator(mode="after")
    def _among_its_speeds(self) -> "Configuration":
        for key in ("quick", "repeated"):
            if lost := [speed for speed in getattr(self, key) if not self.has(speed)]:
                known = ", ".join(units.format(speed, Kind.SPEED) for speed in self.speeds)
                raise refusal(
                    f"{key} must be among speeds, got {units.format(lost[0], Kind.SPEED)}", f"Speeds: {known}"
                )
        return self

    def has(self, speed: float) -> bool:
        """Return whether it is run at a speed [rad/s]."""
        return any(same_speed(speed, own) for own in self.speeds)

    def seeds_at(self, speed: float) -> tuple[int, ...]:
        """Return the seeds with which it is run at a speed [rad/s]."""
        return self.seeds if any(same_speed(speed, own) for own in self.repeated) else self.seeds[:1]


class Against(Table):
    """The other run that a row compares with."""

    configuration: str | None = None
    """Its configuration; the row's own if not given."""
    speed: Speed | None = None
    """Its speed [rad/s]; the row's own if not given."""
    quantity: QuantityName | None = None
    """Its quantity; the row's own if not given."""
    how: Literal["difference", "change", "ratio"]
    """Row minus other; row over other less one; row over other."""


class Row(Table):
    """One published number, or one that follows from published ones, and what to set against it."""

    id: str
    """Short name, for ``--only`` and messages."""
    quantity: QuantityName
    """What is compared."""
    configuration: str
    """With which set-up."""
    speed: Speed = 0.0
    """At which speed, of the experiment where there is one [rad/s]; zero for a machine without one."""
    at: float | None = None
    """Place or time at which the quantity is taken, SI; in the file text with a unit."""
    factor: Number = 1.0
    """What ours is multiplied by: where a slice of the machine is run, or another density [1]."""
    against: Against | None = None
    """If the number is a difference, change or ratio of two runs."""
    experiment: float | None = None
    """What ours is compared with, SI; in the file text with a unit. None where there is only a picture."""
    experiment_is: Literal["measured", "computed"] = "measured"
    """How that value came about: by a measurement, or by a closed form or another model."""
    simulation: float | None = None
    """The authors' simulated value, SI; in the file text with a unit."""
    simulation_speed: Speed | None = None
    """Speed of that simulation, where it differs from the experiment's [rad/s]."""
    simulation_error: Number | None = None
    """Printed error of that simulation [1], where its value is not printed or was run at another speed."""
    source: str
    """Table or figure of the paper."""
    relative: Coefficient | None = None
    """Target: largest share of the published value by which we may be off [1]."""
    absolute: Coefficient | None = None
    """Target: largest difference from the published value, in its SI unit."""
    same_sign: bool = False
    """Target: the sign must be right."""
    calibrated: str = ""
    """Which assumed number was fitted to this row; empty for a prediction."""
    derived: str = ""
    """How the value follows from printed ones, where it is not printed itself."""
    note: str = ""
    """What a reader must know to judge the row."""
    headline: bool = False
    """Whether it stands in the short table."""

    @model_validator(mode="after")
    def _sound(self) -> "Row":
        if self.relative is not None and self.absolute is not None:
            raise refusal("must have one target, relative or absolute, got both", "Leave one out")
        if self.reference is None and (self.relative, self.absolute, self.same_sign) != (None, None, False):
            raise refusal(
                "has a target but no published value",
                "Add experiment or simulation, or leave it out",
            )
        if self.quantity == MODES and self.against is not None:
            raise refusal("against has no use with a natural frequency", "Leave it out")
        return self

    @model_validator(mode="before")
    @classmethod
    def _in_si(cls, given: Any) -> Any:
        if not isinstance(given, dict):
            return given
        if given.get("quantity") not in QUANTITIES:  # numbers cannot be read: the one fault is the quantity
            return {key: value for key, value in given.items() if key not in NUMBERS}
        against = given.get("against")
        plain = isinstance(against, dict) and against.get("how") != "difference"
        kind = None if plain else QUANTITIES[given["quantity"]].kind
        values = {key: _si(key, given[key], kind) for key in NUMBERS if key in given}
        place = QUANTITIES[given["quantity"]].at
        if place is None and "at" in given:
            raise refusal(f"at has no use with {given['quantity']}", "Leave it out")
        if place is not None:
            if "at" not in given:
                raise refusal(f"{given['quantity']} needs at", f'Write e.g. at = "{units.example(place)}"')
            values["at"] = _si("at", given["at"], place)
        return given | values

    @property
    def kind(self) -> Kind | None:
        """Kind of the row's unit, or None for a plain number."""
        return (
            None
            if self.against is not None and self.against.how != "difference"
            else QUANTITIES[self.quantity].kind
        )

    @property
    def reference(self) -> float | None:
        """What we are measured by: the experiment, or the authors' simulation where that has no number."""
        return self.simulation if self.experiment is None else self.experiment

    @property
    def needs(self) -> list[tuple[str, float, str]]:
        """Configuration, speed [rad/s] and quantity of the one or two numbers the row is made of."""
        own = (self.configuration, self.speed, self.quantity)
        if (other := self.against) is None:
            return [own]
        configuration = self.configuration if other.configuration is None else other.configuration
        speed = self.speed if other.speed is None else other.speed
        return [own, (configuration, speed, other.quantity or self.quantity)]


def _si(key: str, given: Any, kind: Kind | None) -> float:
    """Return the SI value of a published number: text with a unit, or a plain number where the row has no
    unit.
    """
    if kind is None:
        if isinstance(given, bool) or not isinstance(given, (int, float)):
            raise refusal(f'{key} must be a plain number, got "{given}"', "Write a share, e.g. 0.05 for 5 %")
        return float(given)
    if not isinstance(given, str):
        raise refusal(f"{key} must be text with a unit, got {given}", f'Write e.g. "{units.example(kind)}"')
    try:
        return units.parse(given, kind)
    except units.UnitError as error:
        raise refusal(f"{key}: {error.what}", error.hint) from None


class Curve(Table):
    """One line of a figure."""

    label: str
    """Its label in the legend."""
    configurations: Annotated[tuple[str, ...], Field(min_length=1)]
    """Set-ups whose speeds make up the line."""
    quantity: QuantityName | None = None
    """Quantity instead of the panel's: superposed beside coupled."""


class Panel(Table):
    """One set of axes of a figure."""

    quantity: QuantityName
    """What is drawn over the speed."""
    curves: Annotated[tuple[Curve, ...], Field(min_length=1)]
    """Its lines."""


class FigurePlan(Table):
    """A figure in the paper's form."""

    number: str
    """Number of the figure in the paper, for the file name."""
    title: str
    """What it shows."""
    form: Literal["speed", "lambda", "place", "particles", "transient"]
    """Over speed, over the centrifugal number, over place or time of rows, particles at several arm
    positions, or the run over time.
    """
    panels: tuple[Panel, ...] = ()
    """Panels of the forms ``speed``, ``lambda`` and ``place``."""
    configuration: str | None = None
    """Run drawn by the forms ``particles`` and ``transient``."""
    speed: Speed | None = None
    """Its speed [rad/s]."""

    @model_validator(mode="after")
    def _of_its_form(self) -> "FigurePlan":
        if self.form in ("speed", "lambda", "place"):
            if not self.panels or self.configuration is not None or self.speed is not None:
                raise refusal(f'needs panels, and neither configuration nor speed, with form = "{self.form}"')
        elif self.panels or self.configuration is None or self.speed is None:
            raise refusal(f'needs a configuration and a speed, and no panels, with form = "{self.form}"')
        return self


class Paper(Table):
    """A paper: where its numbers come from, and what of it can be compared."""

    schema_version: Annotated[Literal[1], Field(alias="schema")]
    """Version of the form of this file."""
    citation: str
    """Authors, title, journal."""
    short: str
    """How tables and figures name it."""
    configurations: dict[str, Configuration]
    """Set-ups by name."""
    rows: tuple[Row, ...]
    """Numbers to compare."""
    figures: tuple[FigurePlan, ...] = ()
    """Figures to draw."""

    @model_validator(mode="after")
    def _refers_to_what_is_there(self) -> "Paper":
        findings = self._row_findings() + self._figure_findings()
        if findings:
            raise refusal("parts of the paper's file contradict each other", findings=findings)
        return self

    def _row_findings(self) -> list[tuple[tuple[Any, ...], str, str]]:
        findings = []
        first: dict[str, int] = {}
        for number, row in enumerate(self.rows):
            if first.setdefault(row.id, number) != number:
                findings.append(
                    (
                        ("rows", number, "id"),
                        f'is the id of two rows, got "{row.id}"',
                        "Give each row its own",
                    )
                )
            for configuration, speed, _ in row.needs:
                findings += self._missing(("rows", number), configuration, speed)
        return findings

    def _figure_findings(self) -> list[tuple[tuple[Any, ...], str, str]]:
        findings = []
        for number, figure in enumerate(self.figures):
            named = [
                name for panel in figure.panels for curve in panel.curves for name in curve.configurations
            ]
            for name in dict.fromkeys(named):
                findings += self._missing(("figures", number), name, None)
            if figure.configuration is not None:
                findings += self._missing(("figures", number), figure.configuration, figure.speed)
        return findings

    def _missing(
        self, key: tuple[Any, ...], name: str, speed: float | None
    ) -> list[tuple[tuple[Any, ...], str, str]]:
        """Return the finding that there is no such configuration, or not at that speed."""
        if name not in self.configurations:
            return [
                (
                    (*key, "configuration"),
                    f'no configuration is called "{name}"',
                    f"Known: {', '.join(self.configurations)}",
                )
            ]
        if speed is not None and not self.configurations[name].has(speed):
            text = f"must be a speed of {name}, got {units.format(speed, Kind.SPEED)}"
            return [((*key, "speed"), text, f"Add it to [configurations.{name}]")]
        return []
