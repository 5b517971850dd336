"""The mapping of a test file: which of its columns is which series, in which unit, from which sensor."""

from pathlib import Path
from typing import Annotated, NamedTuple

from pydantic import AfterValidator, Field

from nutamill.base import units
from nutamill.base.errors import CaseError, Fault, reason
from nutamill.base.file_kind import FileKind, refuse_other_kind
from nutamill.base.files import MOST_CASE_TEXT, exists, read_text
from nutamill.base.schema import Count, Frequency, Number, Quantity, Speed, Table, refusal, spelled
from nutamill.base.units import UNITS, Kind
from nutamill.case import load_case
from nutamill.case.machine import Machine, drive_series
from nutamill.case.series_fields import machine_field
from nutamill.case.toml.layers import Layer
from nutamill.case.toml.merge import merge
from nutamill.case.toml.messages import checked
from nutamill.result.fields import Field as SeriesField
from nutamill.result.fields import series_field


def _one_character(separator: str) -> str:
    """Return a separator of columns. Refuse one that a reader of CSV files does not take."""
    if len(separator) != 1 or separator in '\r\n"':
        raise refusal(f"must be one character, got {spelled(separator)}", 'Write e.g. ";" or "\\t"')
    return separator


class Channel(Table):
    """One column of a test file."""

    column: str
    """Its name in the file."""
    unit: str = ""
    """Unit of its numbers, after `factor`; none for a ratio."""
    factor: Number = 1.0
    """What its numbers are multiplied by: a sensitivity, or -1 where the sensor counts the other way."""
    sensor: str = ""
    """What measured it, for the record."""


class Mapping(Table):
    """How to read a test file; channels are called by the series they measure."""

    case: str | None = None
    """The machine that was tested: a name of the package or a case file; a nutating mill if left out."""
    time: str | None = None
    """Column of the time [s]; none where the file knows its rate."""
    rate: Frequency | None = None
    """Samples per second, where the file holds neither time nor rate [Hz]."""
    offset: Annotated[float, Quantity(Kind.TIME, "any")] = 0.0
    """Added to the file's time, to put the clocks of test and run together [s]."""
    speed: Speed | None = None
    """Speed of the drive whose turns are averaged over (of a mill the driveshaft), where no channel is that
    [rad/s].
    """
    skip: Annotated[Count, Field(ge=0)] = 0
    """Lines of a CSV file before the one with the names of its columns."""
    separator: Annotated[str, AfterValidator(_one_character)] = ","
    """What parts the columns of a CSV file."""
    channel: dict[str, Channel]
    """By the name of the series."""


class MeasuredMachine(NamedTuple):
    """What is known of the machine that was tested."""

    machine: Machine | None
    """The machine, or None for a nutating mill of which only the names of its series are known."""

    def field(self, name: str) -> SeriesField:
        """Return what a series is. Raises CaseError where the machine has none of this name."""
        return series_field(name) if self.machine is None else machine_field(self.machine, name)

    def kind(self, name: str) -> Kind | None:
        """Return the kind of quantity that a series measures, or None for a ratio."""
        unit = self.field(name).unit
        return next((kind for kind, table in UNITS.items() if table.get(unit) == 1.0), None)

    def scale(self, name: str, channel: Channel) -> float:
        """Return the SI value of one in the column of a channel."""
        kind = self.kind(name)
        return channel.factor * (1.0 if kind is None else units.parse(f"1 {channel.unit}", kind))

    @property
    def motion(self) -> tuple[str, str] | None:
        """Series of angle and speed of the drive whose turns are averaged over, None where nothing turns."""
        if self.machine is None:
            return "crank_angle", "driveshaft_speed"
        drive = self.machine.period
        if drive is None:
            return None
        return drive_series(self.machine, drive, "angle"), drive_series(self.machine, drive, "speed")


def load_mapping(path: str | Path) -> tuple[Mapping, MeasuredMachine]:
    """Read a mapping file, and the case of the machine that it names.

    Raises
    ------
    CaseError : all faults at once: no such file, unknown keys, series or units, a unit of another kind, no
        channel; a case that cannot be read
    """
    refuse_other_kind(path, FileKind.MAPPING)
    path = Path(path)
    try:
        text = read_text(path, MOST_CASE_TEXT)
    except (OSError, UnicodeDecodeError) as error:
        raise CaseError(
            Fault(
                str(path),
                f"cannot be read as a mapping file ({reason(error)})",
                "Write one, see docs/guides/measured.md",
            )
        ) from None
    content, positions, faults = merge([Layer.of_text(text, str(path))])
    mapping = checked(Mapping, content, positions, faults)
    machine = None
    if mapping.case is not None:
        beside = path.parent / mapping.case
        machine = load_case(str(beside) if exists(beside) else mapping.case).machine
    tested = MeasuredMachine(machine)
    if faults := _wrong_channels(mapping, tested, str(path)):
        raise CaseError(*faults)
    return mapping, tested


def _wrong_channels(mapping: Mapping, tested: MeasuredMachine, where: str) -> list[Fault]:
    """Return the faults of channels that are no series, or whose unit does not fit what is measured."""
    faults = (
        []
        if mapping.channel
        else [Fault(f"{where}: channel", "at least one must be mapped, got none", "Write [channel.NAME]")]
    )
    for name, channel in mapping.channel.items():
        try:
            kind = tested.kind(name)
        except CaseError as error:
            faults += [Fault(f"{where}: channel.{name}", fault.what, fault.hint) for fault in error.faults]
            continue
        if kind is None:
            if channel.unit not in ("", "1"):
                faults.append(
                    Fault(
                        f"{where}: channel.{name}.unit",
                        f'must be "1", got "{channel.unit}"',
                        "The series is a ratio",
                    )
                )
            continue
        try:
            units.parse(f"1 {channel.unit}", kind)
        except units.UnitError as error:
            faults.append(Fault(f"{where}: channel.{name}.unit", error.what, error.hint))
    return faults
