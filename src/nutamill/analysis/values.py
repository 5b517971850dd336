"""What a campaign reads from its results: steady means, root mean squares or swings of series."""

import contextlib
from collections.abc import Collection, Sequence
from typing import NamedTuple, cast, get_args

from nutamill.analysis.windows import How, steady_mean
from nutamill.base.errors import CaseError, Fault, ResultError
from nutamill.base.steady import NO_ESTIMATE, Estimate
from nutamill.case import Case, Machine
from nutamill.result import Result
from nutamill.result.fields import Field, series_field


class Reading(NamedTuple):
    """A series and the number taken of each of its turns, whose steady mean is read."""

    series: str
    """Name of the series."""
    by: How = "mean"
    """Number taken of each turn."""

    @property
    def name(self) -> str:
        """``driveshaft_torque``, ``mount_1_travel_x_swing``."""
        return self.series if self.by == "mean" else f"{self.series}_{self.by}"

    @property
    def field(self) -> Field:
        """The series, as declared, or a quantity of its machine by its name."""
        try:
            return series_field(self.series)
        except CaseError:
            label = self.series.replace("_", " ")
            return Field(self.series, label, "SI", label, "a quantity that the file of the machine names")


DEFAULT = (
    Reading("crank_pin_force_resultant"),
    Reading("driveshaft_torque"),
    Reading("driveshaft_power"),
    Reading("mount_1_travel_x", "swing"),
    Reading("mount_1_travel_z", "swing"),
)
"""Readings of a campaign that names none."""


def default_readings(case: Case | Machine) -> tuple[Reading, ...]:
    """Return the readings of a campaign that names none: those of a mill, of another machine the quantities
    that its file names, else the torques of its drives, the forces of its charge, or the reactions of its
    joints.
    """
    if isinstance(case, Case):
        return DEFAULT
    named = [entry.name for entry in case.quantities]
    named = named or [f"drive_{drive.name}_torque" for drive in case.drives]
    if not named and case.charge.parts:
        carriers = dict.fromkeys(wall.body for wall in case.walls)
        named = [f"{carrier}_charge_force_{axis}" for carrier in carriers for axis in "zxy"]
    named = named or [f"joint_{joint.name}_force_{axis}" for joint in case.joints for axis in "xyz"]
    return tuple(Reading(name, "mean" if case.quantities else "rms") for name in named[: len(DEFAULT)])


def reading_of(text: str, where: str = "reading", quantities: Collection[str] = ()) -> Reading:
    """Return the reading that a text names: a series, or ``rms`` or ``swing`` and a series.

    Parameters
    ----------
    quantities : names of series that the file of a machine gives its own

    Raises
    ------
    CaseError : no such series, or no such way to read it
    """
    *ways, series = text.split()
    if len(ways) > 1 or any(way not in get_args(How) for way in ways):
        raise CaseError(
            Fault(
                where,
                f'must be a series, or "rms" or "swing" and a series, got "{text}"',
                'Write e.g. "rms driveshaft_torque"',
            )
        )
    try:
        if series not in quantities:
            series_field(series)
    except CaseError as error:
        raise CaseError(
            *(Fault(where, f"{fault.where}: {fault.what}", fault.hint) for fault in error.faults)
        ) from None
    return Reading(series, *(cast(How, way) for way in ways))


def read(result: Result, readings: Sequence[Reading]) -> dict[Reading, Estimate]:
    """Return the steady mean of each reading, `NO_ESTIMATE` where the result holds no such series or no whole
    turn at its last speed.
    """
    values = dict.fromkeys(readings, NO_ESTIMATE)
    for reading in readings:
        if reading.series in result.series:
            with contextlib.suppress(ResultError):
                values[reading] = steady_mean(result, reading.series, reading.by)
    return values
