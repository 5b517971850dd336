"""The one time loop: from entry to entry of the compiled march to the end of a run.

The compiled march is entered for some milliseconds of simulated time at a time; between two entries Python
records, saves checkpoints, reports the progress and handles requests to stop.
"""

from collections.abc import Iterator
from contextlib import contextmanager, suppress

import numpy as np

from nutamill.base.errors import (
    Interrupted,
    ResultError,
    StepError,
)
from nutamill.result import NOT_STEADY, Recorder
from nutamill.simulation.checkpoint import (
    backup,
    checkpoint_groups,
    sum_groups,
)
from nutamill.simulation.entry import enter
from nutamill.simulation.progress import Watch
from nutamill.simulation.record import Ending, RecordPlan
from nutamill.simulation.setup.model import Model, Scratch, State
from nutamill.simulation.setup.solid_walls import solids_met
from nutamill.simulation.signals import Requests
from nutamill.simulation.snapshot import snapshot, statistics

ROWS_PER_ENTRY = 48
"""Rows recorded in one entry of the compiled march [1]: 10 ms of simulated time at the default rate."""

ROWS_PER_ENTRY_ALONE = 480
"""The same without charge, where steps are so cheap that entering would cost as much as marching."""

LONGEST_UNSAVED = 600.0
"""Wall time after which a checkpoint is saved before it is due [s], so that a kill costs no more of a slow
run.
"""


def march(
    model: Model,
    state: State,
    scratch: Scratch,
    recorder: Recorder,
    ending: Ending,
    watch: Watch,
    asked: Requests,
) -> None:
    """March `state` in place to its `ending` and record. The file is committed also after a fault or an
    interrupt.

    Cadences are counted in rows of the record, which are whole numbers of windows.  After a fault the state
    at the last entry of the compiled march, at most `ROWS_PER_ENTRY` rows earlier, is recorded as snapshot
    and checkpoint.

    Raises
    ------
    StepError : the fault that stopped the march
    Interrupted : after a request to stop
    """
    most = ROWS_PER_ENTRY_ALONE if model.charge is None else ROWS_PER_ENTRY
    row = int(state.coupling.windows[0]) // model.plan.windows_per_row
    fault: StepError | None = None
    before: State | None = None
    with commit_on_error(recorder):
        while row < ending.plan.rows and not asked.stop.is_set() and fault is None:
            before = backup(state, before)
            sums = {} if before is None else sum_groups(model, state)
            count = min(most, ending.plan.next_stop(row) - row)
            model, rows, fault = enter(model, state, scratch, count)
            if fault is None and model.charge is not None:
                moved = state.mechanism
                fault = solids_met(model.machine, moved.position, moved.quaternion, float(moved.time[0]))
            if fault is not None:
                fault = record_state_before(model, before, sums, recorder, ending.plan, row, fault)
            row += len(rows)
            if len(rows):
                record_rows(model, state, rows, recorder, ending, watch)
            if fault is None:
                ending.look(row)
                record_state(model, state, recorder, ending.plan, row, watch, asked)
    complete = row >= ending.plan.rows
    if fault is None and not complete:
        recorder.checkpoint(state.mechanism.time[0], checkpoint_groups(model, state))
    recorder.summary(run_facts(model, state))
    recorder.state(state_of_run(fault, complete, ending.missed))
    recorder.close()
    if fault is not None:
        raise fault
    if not complete:
        raise Interrupted(recorder.path)


def record_rows(
    model: Model, state: State, rows: np.ndarray, recorder: Recorder, ending: Ending, watch: Watch
) -> None:
    """Record the series of `rows`, and hand them to the ending and to the progress."""
    series = model.readout.series(rows, state.first_row)
    recorder.append(series)
    ending.recorded(recorder.names, series)
    end = ending.plan.rows / model.machine.run.series_rate
    watch.marched(model, recorder.names, series, end, recorder)


def record_state(
    model: Model,
    state: State,
    recorder: Recorder,
    plan: RecordPlan,
    row: int,
    watch: Watch,
    asked: Requests,
) -> None:
    """Record the snapshot and the checkpoint that are due at `row`, requested, or late, and commit."""
    time = state.mechanism.time[0]
    if row in plan.snapshots:
        recorder.snapshot(time, snapshot(model, state))
    requested, late = asked.take_checkpoint(), recorder.unsaved >= LONGEST_UNSAVED
    due = row % plan.rows_per_checkpoint == 0 or row == plan.rows
    if requested or due:
        record_statistics(model, state, recorder)
    if requested or due or late:
        recorder.checkpoint(time, checkpoint_groups(model, state))
    recorder.commit(force=requested or late)
    if requested:
        watch.checkpoint_saved(time)


def record_statistics(model: Model, state: State, recorder: Recorder) -> None:
    """Record the statistics of the charge so far, if there are any."""
    if (sums := statistics(model, state)) is not None:
        recorder.statistics(state.mechanism.time[0], sums)


def record_state_before(
    model: Model,
    before: State | None,
    sums: dict,
    recorder: Recorder,
    plan: RecordPlan,
    row: int,
    fault: StepError,
) -> StepError:
    """Record the state and the statistics before an entry that failed, at `row`, and return the fault with a
    sentence about it.
    """
    if before is None:
        return fault
    time = float(before.mechanism.time[0])
    if row not in plan.snapshots:
        recorder.snapshot(time, snapshot(model, before))
    if row % plan.rows_per_checkpoint:
        recorder.checkpoint(time, checkpoint_groups(model, before, sums))
    return StepError(
        f"{fault} The last snapshot and checkpoint of the file are the state before it, at t = {time:.6g} s."
    )


def state_of_run(fault: StepError | None, complete: bool, missed: str) -> str:
    """Return the state of a run that has ended, for its file. `missed` is why it is not steady."""
    if fault is not None:
        return f"failed: {fault}"
    if not complete:
        return "interrupted"
    return f"{NOT_STEADY}: {missed}" if missed else "complete"


@contextmanager
def commit_on_error(recorder: Recorder) -> Iterator[None]:
    """Commit the record if an unforeseen error ends a march: a callback that raises, a closed terminal."""
    try:
        yield
    except Exception as error:
        recorder.state(f"failed: {error}")
        with suppress(ResultError):  # a full disk: the file is as the last commit left it
            recorder.close()
        raise


def run_facts(model: Model, state: State) -> dict[str, float]:
    """Return the facts about the steps of a run for the summary of its file."""
    return {
        "substep": model.clock.substep,
        "mechanism_step": model.clock.window,
        "windows": int(state.coupling.windows[0]),
        "passes": int(state.coupling.passes[0]),
        "particles": 0 if model.charge is None else model.charge.n_particles,
    }
