"""The march of a machine with FMUs: window by window from Python, the windows themselves compiled.

Without an FMU nothing of this runs.  A drive's FMU is stepped before the mechanism, with the motion of the
window as predicted; a foreign machine after the charge, with the mean wrench of the window.
"""

from collections.abc import Callable
from functools import partial

import numpy as np

from nutamill.base.errors import StepError
from nutamill.base.kernel import entry_of
from nutamill.charge.kernels.copying import copied
from nutamill.charge.kernels.team import run_team
from nutamill.charge.measures.observe import observe
from nutamill.charge.measures.sampling import sample
from nutamill.simulation.coupling import (
    MAX_PASSES,
    PASS_TOLERANCE,
    march_coupled,
    march_mechanism,
    write_row,
)
from nutamill.simulation.coupling_model import Outcome, Scheme
from nutamill.simulation.fmus.exchange import Exchange
from nutamill.simulation.fmus.pose import MOTION, product
from nutamill.simulation.row import mechanism_row
from nutamill.simulation.setup.model import Model, Scratch, State
from nutamill.simulation.setup.threads import team_size

NO_ROWS = 2**62
"""Windows per row of a march that writes no rows [1]: rows are written after the exchange."""
Window = Callable[[], None]


def march_exchanged(
    model: Model, state: State, scratch: Scratch, n_windows: int, rows_out: np.ndarray
) -> tuple[int, StepError | None]:
    """March a machine with FMUs through `n_windows` windows, and return the number of rows written and the
    fault of an FMU that ended the march, if any.

    ``state.coupling.outcome`` is the `Outcome` and the meaning of a second call after `LISTS_FULL` is that of
    `nutamill.simulation.coupling.march_coupled`.
    """
    exchange, coupling = state.exchange, state.coupling
    assert exchange is not None
    scheme = Scheme(model.plan.scheme)
    iterated = bool(exchange.moves) and scheme == Scheme.ITERATED
    march, write = _windows(model, state, scratch, Scheme.STAGGERED if iterated else scheme)
    row = 0
    for _ in range(n_windows):
        try:
            if coupling.outcome[0] != Outcome.LISTS_FULL:
                exchange.drive(model.mechanism, state.mechanism, model.plan.dt)
            (_iterate if iterated else _stagger)(model, state, exchange, march)
        except StepError as fault:
            return row, fault
        if coupling.outcome[0] != Outcome.RUNNING:
            break
        if coupling.windows[0] % model.plan.windows_per_row == 0:
            write(rows_out[row])
            row += 1
    return row, None


def _windows(
    model: Model, state: State, scratch: Scratch, scheme: Scheme
) -> tuple[Window, Callable[[np.ndarray], None]]:
    """Return what marches one window without a row, and what writes a row of the state after it."""
    starts, n_threads = model.readout.table.starts, team_size(model.machine)
    quiet = model.plan._replace(windows_per_row=NO_ROWS, scheme=int(scheme))
    no_rows = np.empty((0, model.readout.n_columns))
    if model.charge is None:
        parts = (model.mechanism, state.mechanism, scratch.mechanism)
        given = (*parts, state.coupling, model.sensors, quiet, starts, 1, no_rows)
        march_one = entry_of(march_mechanism, *given)
        return partial(march_one, *given), partial(mechanism_row, *parts, model.sensors, starts)
    whole = model.coupled()
    inside, now, work = whole._replace(plan=quiet), state.coupled(), scratch.coupled(model, state)
    both = (inside, now, work, 1, no_rows)
    march_team = entry_of(march_coupled, *both, 0, 1)

    def march_both() -> None:
        run_team(march_team, both, n_threads)

    def write_both(row_out: np.ndarray) -> None:
        run_team(observe, (model.charge, state.charge, work.charge, work.reading), n_threads)
        write_row(whole, now, work, row_out)
        if model.survey is not None and model.survey.on == 1:
            angle = float(state.coupling.row_angle[0])
            parts = (model.charge, state.charge, work.charge, model.survey, state.coupling.row_motions, angle)
            run_team(sample, (*parts, state.statistics), n_threads)

    return march_both, write_both


def _stagger(model: Model, state: State, exchange: Exchange, march: Window) -> None:
    """March one window with extrapolated walls, then step the FMU that moves them."""
    time, resumed = float(state.mechanism.time[0]), state.coupling.outcome[0] == Outcome.LISTS_FULL
    if not resumed:
        exchange.window_start = exchange.motions(state.mechanism)
    march()
    if state.coupling.outcome[0] == Outcome.RUNNING and exchange.moves:
        exchange.move(state.mechanism, exchange.window_start, time, model.plan.dt)


def _iterate(model: Model, state: State, exchange: Exchange, march: Window) -> None:
    """March one window again and again until the walls end where the FMU moves them.

    The FMU goes back to the start of the window before each of its steps, the first included: a solver that
    starts anew does so in every pass.
    """
    mechanism, coupling, dt = state.mechanism, state.coupling, model.plan.dt
    time, start = float(mechanism.time[0]), exchange.motions(mechanism)
    coupling.outcome[0] = Outcome.RUNNING
    before = (
        copied(mechanism),
        None if state.charge is None else copied(state.charge),
        copied(coupling),
    )
    exchange.mark(time)
    guess = mechanism.acceleration[exchange.moves].copy()
    for _ in range(MAX_PASSES):
        mechanism.acceleration[exchange.moves] = guess
        march()
        if coupling.outcome[0] != Outcome.RUNNING:
            break
        walls = mechanism.position[exchange.moves].copy()
        exchange.back(time)
        exchange.move(mechanism, start, time, dt)
        end = exchange.motions(mechanism)
        if np.abs(end[:, MOTION["position"]] - walls).max() <= PASS_TOLERANCE:
            return
        guess = _accelerations(start, end, dt)
        _copy(before, (mechanism, state.charge, coupling))
        coupling.passes[0] += 1
        before[2].passes[0] = coupling.passes[0]
    outcome = coupling.outcome[0] if coupling.outcome[0] != Outcome.RUNNING else Outcome.NOT_CONVERGED
    if outcome != Outcome.CHARGE_FAILED:
        _copy(before, (mechanism, state.charge, coupling))
    coupling.outcome[0] = outcome


def _accelerations(start: np.ndarray, end: np.ndarray, dt: float) -> np.ndarray:
    """Return the constant accelerations (n, 6) that take bodies from one motion (n, 19) to the other."""
    out = np.empty((len(start), 6))
    back = np.array([1.0, -1.0, -1.0, -1.0])
    for k, (first, last) in enumerate(zip(start, end, strict=True)):
        moved = last[MOTION["position"]] - first[MOTION["position"]]
        turn = product(last[MOTION["quaternion"]], first[MOTION["quaternion"]] * back)
        turned = 2.0 * np.copysign(1.0, turn[0]) * turn[1:]
        turned *= 1.0 + turned @ turned / 24.0  # the rotation vector, to the fifth order of the angle
        out[k, :3] = 2.0 * (moved / dt - first[MOTION["velocity"]]) / dt
        out[k, 3:] = 2.0 * (turned / dt - first[MOTION["angular_velocity"]]) / dt
    return out


def _copy(sources: tuple, targets_out: tuple) -> None:
    """Copy all arrays of nested tuples to those of others of the same shape."""
    for source, target in zip(sources, targets_out, strict=True):
        if isinstance(source, tuple):
            _copy(source, target)
        elif source is not None:
            np.copyto(target, source)
