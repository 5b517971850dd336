"""Runs of the empty machine in memory: its series, without a file."""

import numpy as np

from nutamill.case import Machine
from nutamill.simulation.entry import enter, record_first_row
from nutamill.simulation.setup.altered import angle_series, driven, supports, without_charge
from nutamill.simulation.setup.model import build

RAMP_TIME, TAKEN = 0.5, 1.0
"""Time to reach a speed, and the end of a steady run from which readings are taken [s]."""
ON_SUPPORTS, BOLTED = 5.0, 1.2
"""Time to let vibrations die out at speed [s], on bushings to the ground and without any: there only the
drive train vibrates.
"""


def empty_series(machine: Machine) -> dict[str, np.ndarray]:
    """Simulate a machine without its charge to the end of its run and return every series, (n,) each, by
    name.

    Raises
    ------
    StepError : the run cannot go on
    """
    empty = without_charge(machine)
    model, state, scratch = build(empty, None)
    record_first_row(model, state, scratch)
    _, rows, fault = enter(model, state, scratch, round(empty.run.end * empty.run.series_rate))
    if fault is not None:
        raise fault
    rows = np.vstack([state.first_row, rows])
    return dict(zip(model.readout.names, model.readout.series(rows, state.first_row).T, strict=True))


def steady_series(machine: Machine, speed: float) -> dict[str, np.ndarray]:
    """Simulate the empty machine at a steady `speed` [rad/s] of its drive and return the series of the last
    whole periods, about `TAKEN` seconds.

    Raises
    ------
    CaseError : a machine without a drive that turns
    """
    settle = ON_SUPPORTS if supports(machine) else BOLTED
    series = empty_series(driven(machine, RAMP_TIME + settle, speed, speed / RAMP_TIME))
    angle = series[angle_series(machine)]
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
