"""Run-up: how far a reading rises on the way through the resonances, for several rates of the ramp."""

from collections.abc import Sequence
from typing import NamedTuple

from nutamill.analysis.orders import Orders, Waterfall, peaks, spectra, track
from nutamill.base import units
from nutamill.base.errors import CaseError, Fault
from nutamill.base.units import Kind, in_unit, rpm
from nutamill.case import Case, Machine, mill_of
from nutamill.design.empty import empty_series
from nutamill.result.fields import series_field

AFTER = 1.0
"""Time at full speed after the ramp [s]."""


class RunUp(NamedTuple):
    """One ramp through the resonances."""

    ramp: float
    """Rise of the speed [rad/s^2]."""
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
    """Compute the orders of a series of the empty mill on its way to full speed, one run for each ramp.

    Parameters
    ----------
    ramps : rises of the speed [rad/s^2]
    sensor : a recorded series; the x acceleration of the case's first sensor if None
    orders : repetitions per turn [1]
    charge : with the mass of the charge fixed to the chamber's base

    Raises
    ------
    CaseError : a machine given part by part, no ramp, a profile in place of one, no such series
    """
    case = mill_of(case)
    name = sensor or default_sensor(case)
    series_field(name)
    if case.drive.profile is not None:
        raise CaseError(
            Fault(
                "drive.profile",
                "has no use in a run-up, which sets the ramp itself",
                'Write ramp = "70 rpm/s" instead',
            )
        )
    if not ramps or min(ramps) <= 0.0:
        given = ", ".join(units.format(ramp, Kind.RAMP) for ramp in ramps) or "none"
        what = f"must be one or more positive rates, got {given}"
        raise CaseError(Fault("--ramp", what, 'Write e.g. --ramp "70 rpm/s"'))
    runs = []
    for ramp in ramps:
        series = empty_series(
            case.with_(drive__ramp=ramp, run__until=case.drive.speed / ramp + AFTER), charge
        )
        if name not in series:
            raise CaseError(
                Fault(
                    name,
                    "is not a series of this mill",
                    "`nutamill info fields` lists all series",
                )
            )
        time, angle, value = series["time"], series["crank_angle"], series[name]
        runs.append(
            RunUp(
                ramp,
                track(time, angle, value, orders),
                spectra(time, angle, value, min(1.0, 0.25 * time[-1])),
            )
        )
    return runs


def default_sensor(case: Case) -> str:
    """Return the x acceleration of the first sensor, or the crank-pin force of a mill without sensors."""
    return f"{next(iter(case.sensors))}_acceleration_x" if case.sensors else "crank_pin_force_resultant"


def run_up_lines(runs: list[RunUp], name: str) -> list[str]:
    """Format the peaks of the orders for each ramp as a table."""
    unit = series_field(name).unit
    rows = [
        f"{series_field(name).label} ({unit}) on the way to full speed",
        f"{'ramp':>12} {'order':>6} {'peak':>10} {'at rpm':>8} {'Hz':>7}",
    ]
    for run in runs:
        for peak in peaks(run.orders):
            rows.append(
                f"{rpm(run.ramp):6.4g} rpm/s {peak.order:5.3g}x {peak.amplitude:10.4g} "
                f"{rpm(peak.speed):8.1f} {peak.order * in_unit(peak.speed, 'rev/s'):7.3f}"
            )
    return rows
