"""One entry of the compiled march: rows out, lists that grow, and the message of a failure."""

import dataclasses

import numpy as np

from nutamill.base.errors import StepError
from nutamill.charge.arrays import grow
from nutamill.charge.kernels.team import run_team
from nutamill.charge.measures.observe import charge_reading, observe
from nutamill.charge.messages import status_text, status_time
from nutamill.charge.model import ChargeState
from nutamill.charge.model import Clock as ChargeClock
from nutamill.simulation.coupling import march_coupled, march_mechanism
from nutamill.simulation.coupling_model import Outcome
from nutamill.simulation.fmus.windows import march_exchanged
from nutamill.simulation.lammps.windows import march_grains
from nutamill.simulation.row import charge_row, mechanism_row
from nutamill.simulation.setup.model import Model, Scratch, State
from nutamill.simulation.setup.threads import team_size
from nutamill.simulation.setup.walls import wall_surfaces


def enter(
    model: Model, state: State, scratch: Scratch, n_rows: int
) -> tuple[Model, np.ndarray, StepError | None]:
    """March `state` in place through `n_rows` rows, unless a fault stops it.

    Returns
    -------
    the model (with larger lists if they had to grow, as in `state` and `scratch`), rows (n, n_columns), and
    the fault that stopped the march, if any
    """
    rows = np.empty((n_rows, model.readout.n_columns))
    done, coupling, per_row = 0, state.coupling, model.plan.windows_per_row
    while True:
        before = int(coupling.windows[0])
        left = (n_rows - done) * per_row - before % per_row
        if state.grains is not None:
            written, fault = march_grains(model, state, scratch, left, rows[done:])
            done += written
            if fault is not None:
                return model, rows[:done], fault
        elif state.exchange is not None:
            written, fault = march_exchanged(model, state, scratch, left, rows[done:])
            done += written
            if fault is not None:
                return model, rows[:done], fault
        elif model.charge is None:
            march_mechanism(
                model.mechanism,
                state.mechanism,
                scratch.mechanism,
                coupling,
                model.sensors,
                model.plan,
                model.readout.table.starts,
                left,
                rows[done:],
            )
        else:
            parts = (model.coupled(), state.coupled(), scratch.coupled(model, state))
            run_team(march_coupled, (*parts, left, rows[done:]), team_size(model.machine))
        if state.exchange is None and state.grains is None:
            done += int(coupling.windows[0]) // per_row - before // per_row
        full = coupling.outcome[0] == Outcome.LISTS_FULL
        if full or (state.charge is not None and state.charge.clock[ChargeClock.CROWDED]):
            model = grown(model, state, scratch)
        if not full:
            break
    fault = None if coupling.outcome[0] == Outcome.RUNNING else StepError(failure(model, state))
    return model, rows[:done], fault


def grown(model: Model, state: State, scratch: Scratch) -> Model:
    """Return the model with larger neighbour lists. `state` and `scratch` get them too."""
    assert model.charge is not None and state.charge is not None and scratch.charge is not None
    charge, state.charge, scratch.charge = grow(model.charge, state.charge, scratch.charge)
    return dataclasses.replace(model, charge=charge)


def record_first_row(model: Model, state: State, scratch: Scratch) -> None:
    """Read the state at rest into `state.first_row`, from which ledgers count."""
    starts = model.readout.table.starts
    mechanism_row(model.mechanism, state.mechanism, scratch.mechanism, model.sensors, starts, state.first_row)
    if model.charge is not None:
        interval = model.plan.dt * model.plan.windows_per_row
        reading = charge_reading()
        observe(model.charge, state.charge, scratch.charge, reading, 0, 1)
        charge_row(state.charge, reading, state.coupling, interval, starts, state.first_row)


def failure(model: Model, state: State) -> str:
    """Return the message of a failed march: when, which particle or part, and what to do."""
    if state.charge is not None and state.coupling.outcome[0] == Outcome.CHARGE_FAILED:
        time = status_time(state.charge, model.clock.substep)
        return f"t = {time:.9g} s: {charge_fault(model, state.charge)}"
    when = f"t = {state.mechanism.time[0]:.6g} s"
    if state.coupling.outcome[0] == Outcome.NOT_CONVERGED:
        return (
            f"{when}: the passes over a window did not converge. Shorten the window (run.window), or use "
            'run.coupling = "staggered".'
        )
    return (
        f"{when}: the motion of the mechanism is not finite. Shorten the window (run.window) and look at "
        "stiffnesses and small inertias."
    )


def charge_fault(model: Model, charge: ChargeState) -> str:
    """Return the message of the charge's status, and what to do."""
    surfaces = [surface.name for surface in wall_surfaces(model.machine)]
    return (
        f"{status_text(charge, surfaces)}. The charge substep is "
        f'{model.clock.substep:.3g} s; try run.dt = "auto" or a shorter one, stiffer contacts, or, where so '
        "soft a contact is meant, a larger overlap_stop of the pair."
    )
