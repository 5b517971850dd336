"""Runs of the empty mill in memory: its series, without a file."""

import numpy as np

from nutamill.base.errors import CaseError, Fault
from nutamill.case import Case
from nutamill.simulation.entry import enter, record_first_row
from nutamill.simulation.setup.model import build
from nutamill.simulation.setup.particles import charge_mass

RAMP_TIME, TAKEN = 0.5, 1.0
"""Time to reach a speed, and the end of a steady run from which readings are taken [s]."""
SETTLE_TIME = {"flexible": 5.0, "rigid": 1.2}
"""Time to let vibrations die out at speed, by the mounting [s]: on rigid mounts only the drive train
vibrates.
"""


def with_charge_mass(case: Case) -> Case:
    """Return the case with the mass of its charge fixed to the chamber's base, where the rigid bars are.

    Raises
    ------
    CaseError : a case without a ring for the bars
    """
    if case.chamber.bars is None:
        what = "is missing, so that the mass of the charge has no position"
        raise CaseError(Fault("chamber.bars", what, "Give radius and depth of a ring"))
    return case.with_("chamber.bars.mass", case.chamber.bars_mass + charge_mass(case.machine))


def empty_series(case: Case, charge: bool = False) -> dict[str, np.ndarray]:
    """Simulate the mill without its charge from rest to the end of the case and return its series, (n,) each,
    by name.

    Parameters
    ----------
    charge : with the mass of the charge fixed to the chamber's base

    Raises
    ------
    StepError : the run cannot go on
    """
    loaded = (with_charge_mass(case) if charge else case).with_("charge.kind", "none")
    model, state, scratch = build(loaded.machine, None)
    record_first_row(model, state, scratch)
    _, rows, fault = enter(model, state, scratch, round(loaded.run.end * loaded.run.series_rate))
    if fault is not None:
        raise fault
    rows = np.vstack([state.first_row, rows])
    return dict(zip(model.readout.names, model.readout.series(rows, state.first_row).T, strict=True))


def steady_series(case: Case, speed: float, charge: bool = False) -> dict[str, np.ndarray]:
    """Simulate the empty mill at a steady `speed` [rad/s] and return the series of the last whole periods,
    about `TAKEN` seconds.
    """
    settled = case.with_(
        drive__speed=speed,
        drive__ramp=speed / RAMP_TIME,
        run__until=RAMP_TIME + SETTLE_TIME[case.mechanism.mounting],
    )
    series = empty_series(settled, charge)
    angle = series["crank_angle"]
    turns = max(1, int(TAKEN * speed / (2.0 * np.pi)))
    inside = angle > angle[-1] - 2.0 * np.pi * turns * (1.0 + 1e-9)
    return {name: values[inside] for name, values in series.items()}


def once_per_turn(angle: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Compute complex amplitudes c of signals (n, m) over whole periods of `angle` (n,): ``Re(c exp(i
    angle))``.

    By least squares with the mean and the second order, so that the ends of the turns need not be samples.
    """
    basis = np.column_stack([np.exp(1j * order * angle) for order in (0, 1, -1, 2, -2)])
    return 2.0 * np.linalg.lstsq(basis, values.astype(complex), rcond=None)[0][1]
