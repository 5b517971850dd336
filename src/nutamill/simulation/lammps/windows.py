"""The march of a machine whose charge is in LAMMPS: window by window, on all processes alike.

The mechanism is marched on every process. It has the same bits on each, since each gets the same sum of the
impulses.
"""

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from nutamill.base.errors import StepError
from nutamill.base.kernel import entry_of
from nutamill.mechanism.dynamics import body_motion
from nutamill.simulation.coupling import finish_window, start_window
from nutamill.simulation.coupling_model import Outcome
from nutamill.simulation.lammps.overlaps import deepest_pair
from nutamill.simulation.row import charge_row, mechanism_row

if TYPE_CHECKING:
    from nutamill.simulation.setup.model import Model, Scratch, State


def march_grains(
    model: "Model", state: "State", scratch: "Scratch", n_windows: int, rows_out: np.ndarray
) -> tuple[int, StepError | None]:
    """March a machine through `n_windows` windows, called by the first process, and return the number of rows
    written and the fault of LAMMPS that ended the march, if any.

    ``state.coupling.outcome`` is the `Outcome`.  Afterwards ``state.charge`` holds the particles of all
    processes.
    """
    grains = state.grains
    assert grains is not None and state.charge is not None and model.charge is not None
    grains.ranks.order(("march", n_windows))
    try:
        written = march_windows(model, state, scratch, n_windows, rows_out)
    except Exception as error:  # whatever LAMMPS raises, it is in no state to go on
        grains.ranks.leave()
        text = " ".join(str(error).split())
        return 0, StepError(f"t = {state.mechanism.time[0]:.6g} s: LAMMPS stopped: {text}")
    fault = None
    if state.coupling.outcome[0] == Outcome.RUNNING:
        share, text = deepest_pair(model.charge, state.charge)
        state.charge.largest_overlap[0] = share
        if text:
            fault = StepError(f"t = {state.mechanism.time[0]:.6g} s: {text}")
    return written, fault


def march_windows(
    model: "Model", state: "State", scratch: "Scratch", n_windows: int, rows_out: np.ndarray
) -> int:
    """March through `n_windows` windows, called by all processes, and return the number of rows written."""
    grains, coupling, plan = state.grains, state.coupling, model.plan
    assert grains is not None and state.charge is not None
    parts = (model.coupled(), state.coupled(), scratch.coupled(model, state))
    start, finish = (partial(entry_of(kernel, *parts), *parts) for kernel in (start_window, finish_window))
    row = 0
    coupling.outcome[0] = Outcome.RUNNING

    def begin() -> np.ndarray:
        start()
        return coupling.motions

    def end() -> bool:
        nonlocal row
        if grains.halted:
            coupling.outcome[0] = Outcome.CHARGE_FAILED
            return False
        finish()
        if coupling.outcome[0] != Outcome.RUNNING:
            return False
        if coupling.windows[0] % plan.windows_per_row == 0:
            _write_row(model, state, scratch, rows_out[row])
            row += 1
        return True

    grains.march(n_windows, plan.substeps, begin, end)
    if coupling.outcome[0] == Outcome.RUNNING:
        grains.gather()
    return row


def _write_row(model: "Model", state: "State", scratch: "Scratch", row_out: np.ndarray) -> None:
    """Write a row of the record, of the whole charge."""
    assert state.grains is not None and state.charge is not None
    starts = model.readout.table.starts
    reading, ledger = state.grains.read()
    mechanism_row(model.mechanism, state.mechanism, scratch.mechanism, model.sensors, starts, row_out)
    whole = state.charge._replace(ledger=ledger)
    charge_row(whole, reading, state.coupling, model.plan.dt * model.plan.windows_per_row, starts, row_out)
    if model.survey is not None and model.survey.on:
        _sample(model, state)


def _sample(model: "Model", state: "State") -> None:
    """Take a sample of the statistics, of the charge whose row has been written."""
    plan, coupling = model.plan, state.coupling
    assert state.grains is not None and state.statistics is not None and model.survey is not None
    for c, carrier in enumerate(plan.carriers):
        body_motion(state.mechanism, carrier, coupling.row_motions[c])
    if plan.reference_drive >= 0:
        coupling.row_angle[0] = state.mechanism.drive_motion[plan.reference_drive, 0]
    state.statistics.samples[0] += 1
    state.grains.sample(model.survey, coupling.row_motions, float(coupling.row_angle[0]))
