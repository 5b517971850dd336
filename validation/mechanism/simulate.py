"""March a mechanism file and measure what the march costs and how well it keeps constraints and energy."""

import time as clock
from pathlib import Path
from typing import NamedTuple

import numpy as np

from nutamill.case import load_case
from nutamill.mechanism.equations import row_residuals, update_kinematics
from nutamill.simulation.entry import enter, record_first_row
from nutamill.simulation.setup.model import build

EXAMPLES = Path(__file__).parents[2] / "examples" / "mechanisms"


class Run(NamedTuple):
    """What one march came to."""

    series: dict[str, np.ndarray]
    """Series by name, (n,), the first sample included."""
    dt: float
    """Step [s]."""
    steps: int
    """Steps [1]."""
    seconds: float
    """Wall time [s], compilation left out."""
    gap: float
    """Largest gap of a constraint at the end [m or rad]."""
    gap_rate: float
    """Largest rate of a gap at the end [m/s or rad/s]."""
    energy_drift: float
    """Largest residual of the energy ledger [J]."""


def simulate(name: str, halvings: int = 0, until: float | None = None) -> Run:
    """March ``examples/mechanisms/<name>.toml`` with its step halved so many times, to the end of the file or
    `until` [s].
    """
    case = load_case(EXAMPLES / f"{name}.toml")
    case = case.with_(
        **{"run.step": case.run.step / 2**halvings, "run.until": case.run.until if until is None else until}
    )
    model, state, scratch = build(case, None)
    record_first_row(model, state, scratch)
    rows = round(case.run.until * case.run.series_rate)
    begun = clock.perf_counter()
    _, rows, fault = enter(model, state, scratch, rows)
    seconds = clock.perf_counter() - begun
    if fault is not None:
        raise fault
    table = model.readout.series(np.vstack([state.first_row, rows]), state.first_row)
    series = dict(zip(model.readout.names, table.T, strict=True))
    mechanism, mstate, scratch = model.mechanism, state.mechanism, scratch.mechanism
    update_kinematics(mechanism, mstate, scratch)
    rate, twist = np.zeros(len(mechanism.rows)), np.hstack([mstate.velocity, mstate.angular_velocity])
    row_residuals(mechanism.rows, mechanism.gears, scratch.jacobian, twist, -scratch.gap_rate, rate)
    return Run(
        series,
        model.clock.window,
        len(rows) * model.clock.windows_per_row,
        seconds,
        float(np.abs(scratch.gap).max(initial=0.0)),
        float(np.abs(rate).max(initial=0.0)),
        float(np.abs(series["ledger_residual"]).max()),
    )
