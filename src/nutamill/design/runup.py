"""Run-up: how far a reading rises on the way through the resonances, for several rates of the ramp."""

from collections.abc import Sequence
from typing import NamedTuple

from nutamill.analysis.orders import Orders, Waterfall, peaks, spectra, track
from nutamill.base import units
from nutamill.base.errors import CaseError, Fault
from nutamill.base.library import similar
from nutamill.base.units import Kind, in_unit, rpm
from nutamill.case import Case, Machine
from nutamill.case.series_fields import machine_field
from nutamill.design.empty import empty_series
from nutamill.design.weights import with_charge_mass
from nutamill.result.fields import Field
from nutamill.simulation.setup.altered import angle_series, driven, turning_drive, without_charge
from nutamill.simulation.setup.model import recorded_fields

AFTER = 1.0
"""Time at full speed after the ramp [s]."""


class RunUp(NamedTuple):
    """One ramp through the resonances."""

    ramp: float
    """Rise of the speed [rad/s^2]."""
    field: Field
    """What is read."""
    orders: Orders
    """Orders of the reading on the way."""
    waterfall: Waterfall
    """Its spectra."""


def run_up(
    case: Case | Machine,
    ramps: Sequence[float],
    sensor: str | None = None,
    orders: Sequence[float] = (1.0, 2.0),
    charge: bool = False,
) -> list[RunUp]:
    """Compute the orders of a series of the empty machine on its way to full speed, one run for each ramp.

    Parameters
    ----------
    ramps : rises of the speed [rad/s^2]
    sensor : a series of the machine; that of `default_sensor` if None
    orders : repetitions per turn [1]
    charge : with the mass of the charge fixed to the chamber's base

    Raises
    ------
    CaseError : a machine without a drive that turns, no ramp, a profile in place of one, no such series
    """
    machine = (with_charge_mass(case) if charge else case).machine
    drive, name = turning_drive(machine), sensor or default_sensor(machine)
    field = _field_of(machine, name)
    if drive.profile is not None:
        where = "drive.profile" if case.drawing is not None else f"{drive.name}.profile"
        what = "has no use in a run-up, which sets the ramp itself"
        raise CaseError(Fault(where, what, 'Write ramp = "70 rpm/s" instead'))
    if not ramps or not min(ramps) > 0.0:
        given = ", ".join(units.format(ramp, Kind.RAMP) for ramp in ramps) or "none"
        what = f"must be one or more positive rates, got {given}"
        raise CaseError(Fault("--ramp", what, 'Write e.g. --ramp "70 rpm/s"'))
    runs = []
    for ramp in ramps:
        series = empty_series(driven(machine, drive.speed / ramp + AFTER, ramp=ramp))
        time, angle, value = series["time"], series[angle_series(machine)], series[name]
        runs.append(
            RunUp(
                ramp,
                field,
                track(time, angle, value, orders),
                spectra(time, angle, value, min(1.0, 0.25 * time[-1])),
            )
        )
    return runs


def default_sensor(case: Case | Machine) -> str:
    """Return the x acceleration of the first accelerometer, else the crank-pin force of a mill, else the
    x force of the first support or joint.
    """
    machine = case.machine
    named = {entry.name for entry in machine.quantities}
    first = [f"{entry.name}_acceleration_x" for entry in machine.sensors if entry.kind == "acceleration"]
    first += [name for name in ("crank_pin_force_resultant",) if name in named]
    first += [f"bushing_{entry.name}_force_x" for entry in machine.bushings]
    first += [f"joint_{entry.name}_force_x" for entry in machine.joints]
    return first[0]


def _field_of(machine: Machine, name: str) -> Field:
    """Return what a series of the empty machine is. Raises CaseError with its accelerometers where there is
    none of this name.
    """
    empty = without_charge(machine)
    known = [field.name for field in recorded_fields(empty)]
    if name in known:
        return machine_field(empty, name)
    sensors = [entry.name for entry in empty.sensors if entry.kind == "acceleration"]
    series = [f"{sensor}_acceleration_{axis}" for sensor in sensors for axis in "xyz"]
    what = f'no series of this machine without its charge is called "{name}"'
    raise CaseError(Fault("--sensor", what, similar(name, series or known, cutoff=0.9)))


def run_up_lines(runs: list[RunUp]) -> list[str]:
    """Format the peaks of the orders for each ramp as a table."""
    field = runs[0].field
    rows = [
        f"{field.label} ({field.unit}) on the way to full speed",
        f"{'ramp':>12} {'order':>6} {'peak':>10} {'at rpm':>8} {'Hz':>7}",
    ]
    for run in runs:
        for peak in peaks(run.orders):
            rows.append(
                f"{rpm(run.ramp):6.4g} rpm/s {peak.order:5.3g}x {peak.amplitude:10.4g} "
                f"{rpm(peak.speed):8.1f} {peak.order * in_unit(peak.speed, 'rev/s'):7.3f}"
            )
    return rows
