"""What a campaign reads from its results: steady means, root mean squares or swings of series."""

import contextlib
from collections.abc import Sequence
from typing import NamedTuple, cast, get_args

from nutamill.analysis.windows import How, steady_mean
from nutamill.base.errors import CaseError, Fault, ResultError
from nutamill.base.steady import NO_ESTIMATE, Estimate
from nutamill.case import Case, Machine
from nutamill.case.series_fields import machine_field
from nutamill.result import Result
from nutamill.result.fields import Field, series_field


class Reading(NamedTuple):
    """A series and the number taken of each of its turns, whose steady mean is read."""

    series: str
    """Name of the series."""
    by: How = "mean"
    """Number taken of each turn."""
    quantity: Field | None = None
    """What the series is, where the file of the machine names it."""

    @property
    def name(self) -> str:
        """``driveshaft_torque``, ``mount_1_travel_x_swing``."""
        return self.series if self.by == "mean" else f"{self.series}_{self.by}"

    @property
    def field(self) -> Field:
        """What the series is."""
        return self.quantity or series_field(self.series)


DEFAULT = (
    Reading("crank_pin_force_resultant"),
    Reading("driveshaft_torque"),
    Reading("driveshaft_power"),
    Reading("mount_1_travel_x", "swing"),
    Reading("mount_1_travel_z", "swing"),
)
"""Readings of a campaign that names none."""


def default_readings(case: Case | Machine) -> tuple[Reading, ...]:
    """Return the readings of a campaign that names none: those of a crank and its mounts where the machine
    has the series of a crank pin, else the quantities that its file names, else the torques of its drives,
    the forces of its charge, or the reactions of its joints.
    """
    machine = case.machine
    named = [entry.name for entry in machine.quantities]
    if DEFAULT[0].series in named:
        return DEFAULT
    named = named or [f"drive_{drive.name}_torque" for drive in machine.drives]
    if not named and machine.charge.parts:
        carriers = dict.fromkeys(wall.body for wall in machine.walls)
        named = [f"{carrier}_charge_force_{axis}" for carrier in carriers for axis in "zxy"]
    named = named or [f"joint_{joint.name}_force_{axis}" for joint in machine.joints for axis in "xyz"]
    by: How = "mean" if machine.quantities else "rms"
    return tuple(_reading(machine, name, by) for name in named[: len(DEFAULT)])


def reading_of(text: str, where: str = "reading", machine: Machine | None = None) -> Reading:
    """Return the reading that a text names: a series, or ``rms`` or ``swing`` and a series.

    Parameters
    ----------
    machine : the machine whose file may name quantities of its own

    Raises
    ------
    CaseError : no such series, or no such way to read it
    """
    *ways, series = text.split() or [""]
    if not series or len(ways) > 1 or any(way not in get_args(How) for way in ways):
        raise CaseError(
            Fault(
                where,
                f'must be a series, or "rms" or "swing" and a series, got "{text}"',
                'Write e.g. "rms driveshaft_torque"',
            )
        )
    try:
        return _reading(machine, series, *(cast(How, way) for way in ways))
    except CaseError as error:
        raise CaseError(
            *(Fault(where, f"{fault.where}: {fault.what}", fault.hint) for fault in error.faults)
        ) from None


def _reading(machine: Machine | None, series: str, by: How = "mean") -> Reading:
    """Return the reading of a series. Raises CaseError where there is none of this name."""
    try:
        series_field(series)
    except CaseError:
        if machine is None:
            raise
        return Reading(series, by, machine_field(machine, series))
    return Reading(series, by)


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
