"""The one time loop: `run` a case to a file, `resume` a file, and `march` in between.

The compiled march is entered for some milliseconds of simulated time at a time; between two entries Python records, keeps
checkpoints, tells the progress and listens for an interrupt.
"""

import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np

from nutamill.advance import (
    bed_from_checkpoint,
    checkpoint_groups,
    enter,
    keep,
    record_first_row,
    restore,
    snapshot,
    statistics,
    statistics_group,
)
from nutamill.build.bed import bed_is_kept, settle_apart, settled_bed
from nutamill.build.chamber_charge import contact_law_of
from nutamill.build.chamber_statistics import statistics_axes
from nutamill.build.clock import run_clock
from nutamill.build.described_mechanism import build_mechanism
from nutamill.build.mill_mechanism import mill_mechanism
from nutamill.build.model import Model, State, build
from nutamill.build.team import team_size
from nutamill.build.wall_mesh import digests, placed_walls
from nutamill.case import Case, MechanismCase, case_of_text
from nutamill.errors import CaseError, Fault, NotSteadyError, ResultError, StepError
from nutamill.kernel import kernel_digest
from nutamill.provenance import run_provenance
from nutamill.record_plan import COLUMNS, Ending, RecordPlan
from nutamill.result import Recorder, Result, open_result
from nutamill.screen import Progress
from nutamill.warm import warm_up, warm_up_mechanism
from nutamill.watch import Watch, requests

ROWS_PER_ENTRY = 48
"""Rows recorded in one entry of the compiled march [1]: 10 ms of simulated time at the default rate."""

ROWS_PER_ENTRY_ALONE = 480
"""The same without charge, where steps are so cheap that entering would cost as much as marching."""

LONGEST_UNSAVED = 600.0
"""Wall time after which a checkpoint is kept before its turn [s]: what a kill may cost where a simulated second takes hours."""


def run(
    case: Case | MechanismCase,
    to: str | Path | None = None,
    progress: Callable[[Progress], None] | None = None,
    tell: Callable[[str], None] | None = None,
) -> Result:
    """Run a case from rest to its end and return the opened result.

    Parameters
    ----------
    case : what is asked, of a mill or of any mechanism
    to : result file, must be new; `Case.result_file` if None
    progress : called about twice a second with where the run stands
    tell : called with a line of text when something takes time before the first step

    Raises
    ------
    CaseError : bad input, before a step is run
    ResultError : the file exists, or cannot be written
    StepError : the run cannot go on; what was recorded is in the file
    NotSteadyError : the run should end when steady, and was not within `run.max`; the file has it all
    KeyboardInterrupt : after an interrupt, with everything saved
    """
    path = Path(case.result_file if to is None else to)
    if path.exists():
        raise ResultError(f"{path}: must be a new file, it exists. Choose another name with --to, or continue it with `nutamill resume`.")
    if isinstance(case, MechanismCase):
        return run_mechanism(case, path, progress, tell)
    run_clock(case)  # refuses a substep that is too long before anything is compiled
    warm_up(tell, None if bed_is_kept(case) else lambda: settle_apart(case), contact_law_of(case))
    watch = Watch(case, progress)
    watch.settling(0.0)
    bed = settled_bed(case, watch.settling)
    watch.settling(1.0)
    model, state = build(case, bed)
    record_first_row(model, state)
    provenance = run_provenance(kernel_digest(), case.run.seed, team_size(case)) | digests(case)
    axes = None if model.charge is None else statistics_axes(case, model.survey)
    names, rate, walls = model.readout.names, case.run.series_rate, placed_walls(case)
    recorder = Recorder.create(path, case.to_toml(), provenance, names, rate, axes=axes, walls=walls)
    ending, first = Ending(case, case.run.end), model.readout.series(state.first_row[None, :], state.first_row)
    recorder.append(first)
    ending.recorded(recorder.names, first)
    record_statistics(model, state, recorder)
    recorder.checkpoint(0.0, checkpoint_groups(model, state))
    march(model, state, recorder, ending, watch)
    return open_result(path)


def run_mechanism(
    case: MechanismCase,
    path: Path,
    progress: Callable[[Progress], None] | None = None,
    tell: Callable[[str], None] | None = None,
) -> Result:
    """Run a mechanism to a new file at `path`; the other arguments and the errors are those of `run`."""
    warm_up_mechanism(tell)
    model, state = build_mechanism(case)
    record_first_row(model, state)
    recorder = Recorder.create(path, case.to_toml(), run_provenance(kernel_digest(), 0, 1), model.readout.names, case.run.series_rate)
    recorder.append(model.readout.series(state.first_row[None, :], state.first_row))
    recorder.checkpoint(0.0, checkpoint_groups(model, state))
    march(model, state, recorder, Ending(case, case.run.end), Watch(case, progress))
    return open_result(path)


def resume(
    path: str | Path,
    until: float | None = None,
    progress: Callable[[Progress], None] | None = None,
    tell: Callable[[str], None] | None = None,
) -> Result:
    """Continue the run of a result file from its newest checkpoint, bit for bit as if it had never stopped.

    Parameters
    ----------
    path : result file
    until : simulated time at the end [s]; as the case says if None.  Of a run that ends when steady: the longest time; if it has been
        found steady already, the end
    progress, tell : as for `run`

    Raises
    ------
    CaseError : an end before the checkpoint
    ResultError : no such file, no checkpoint, or written by other kernels
    StepError, NotSteadyError, KeyboardInterrupt : as for `run`
    """
    with open_result(path) as result:
        case = case_of_text(result.case_text, Path(path).stem)
        kept, digest = result.checkpoint(), result.provenance.get("kernel_digest")
        for damage in result.damaged_checkpoints():
            (tell or warnings.warn)(f"{damage} Continuing from the older checkpoint at t = {kept.time:.6g} s.")
        end = case.run.end if until is None else until
        ending = Ending(case, end)
        if case.run.until == "steady":
            rows = round(kept.time * case.run.series_rate) + 1
            ending.replay(np.column_stack([result.series[name].values[:rows] for name in COLUMNS]))
    if until is not None and ending.found:
        ending = Ending(case, end).fixed()
    if end < kept.time:
        raise CaseError(
            Fault("--until", f"must be later than the checkpoint at {kept.time:.6g} s, got {end:.6g} s", "The file has what came before")
        )
    if digest != kernel_digest():
        raise ResultError(
            f"{path}: must go on with the kernels it was begun with, this version has others. Install the version named under"
            " /provenance, or run the case again."
        )
    if isinstance(case, MechanismCase):
        model, state = build_mechanism(case)
    else:
        warm_up(tell, law=contact_law_of(case))
        bed = bed_from_checkpoint(case, [body.name for body in mill_mechanism(case).bodies], kept.groups)
        model, state = build(case, bed)
    model = restore(model, state, kept.groups)
    recorder = Recorder.reopen(path, kept.time)
    march(model, state, recorder, ending, Watch(case, progress))
    return open_result(path)


def march(model: Model, state: State, recorder: Recorder, ending: Ending, watch: Watch) -> None:
    """March `model` and `state` in place to their `ending` and record; commits the file also when it fails or is interrupted.

    Cadences are counted in rows of the record, which are whole numbers of windows.  When a step fails, the state at the last entry of
    the compiled march, at most `ROWS_PER_ENTRY` rows earlier, is kept as snapshot and checkpoint.
    """
    plan = ending.plan
    row = int(state.coupling.windows[0]) // model.plan.windows_per_row
    fault: StepError | None = None
    kept: State | None = None
    with requests() as asked, saved_whatever_happens(recorder):
        while row < plan.rows and not asked.stop.is_set() and fault is None:
            count = min(ROWS_PER_ENTRY_ALONE if model.charge is None else ROWS_PER_ENTRY, plan.next_stop(row) - row)
            kept = keep(state, kept)
            kept_sums = {} if kept is None else statistics_group(model, state)
            model, rows, fault = enter(model, state, count)
            if fault is not None:
                fault = keep_what_was_sound(model, kept, kept_sums, recorder, plan, row, fault)
            row += len(rows)
            if len(rows):
                series = model.readout.series(rows, state.first_row)
                recorder.append(series)
                ending.recorded(recorder.names, series)
                watch.marched(model, recorder.names, series, plan.rows / model.case.run.series_rate, recorder)
            if fault is None:
                ending.look(row)
                plan = ending.plan
                if row in plan.snapshots:
                    recorder.snapshot(state.mechanism.time[0], snapshot(model, state))
                wanted = asked.take_checkpoint()
                if wanted or row % plan.rows_per_checkpoint == 0 or row == plan.rows:
                    record_statistics(model, state, recorder)
                    recorder.checkpoint(state.mechanism.time[0], checkpoint_groups(model, state))
                elif recorder.unsaved >= LONGEST_UNSAVED:
                    wanted = True
                    recorder.checkpoint(state.mechanism.time[0], checkpoint_groups(model, state))
                recorder.commit(force=wanted)
    if fault is None and row < plan.rows:
        recorder.checkpoint(state.mechanism.time[0], checkpoint_groups(model, state))
    recorder.summary(run_facts(model, state))
    if fault is not None:
        recorder.state(f"failed: {fault}")
    elif row < plan.rows:
        recorder.state("interrupted")
    else:
        recorder.state(f"not steady: {ending.missed}" if ending.missed else "complete")
    recorder.close()
    if fault is not None:
        raise fault
    if row < plan.rows:
        raise KeyboardInterrupt
    if ending.missed:
        end = f"{plan.rows / model.case.run.series_rate:g} s"
        what = f"must be steady, it is not after {end}: {ending.missed}"
        raise NotSteadyError(f"{recorder.path}: {what}. Go on with: nutamill resume {recorder.path} --until ...")


def record_statistics(model: Model, state: State, recorder: Recorder) -> None:
    """Record what the charge has done so far, if it is summed."""
    if (sums := statistics(model, state)) is not None:
        recorder.statistics(state.mechanism.time[0], sums)


def keep_what_was_sound(
    model: Model, kept: State | None, kept_sums: dict, recorder: Recorder, plan: "RecordPlan", row: int, fault: StepError
) -> StepError:
    """Put the state before a failed entry, at `row`, and its statistics into the file; returns the fault with words about it."""
    if kept is None:
        return fault
    time = float(kept.mechanism.time[0])
    if row not in plan.snapshots:
        recorder.snapshot(time, snapshot(model, kept))
    if row % plan.rows_per_checkpoint:
        recorder.checkpoint(time, kept.arrays() | kept_sums)
    return StepError(f"{fault} The file keeps the state at t = {time:.6g} s, before that, as its last snapshot and checkpoint.")


@contextmanager
def saved_whatever_happens(recorder: Recorder) -> Iterator[None]:
    """Commit what has been recorded when something unforeseen ends a march: a callback that raises, a terminal that is gone."""
    try:
        yield
    except Exception as trouble:
        recorder.state(f"failed: {trouble}")
        with suppress(ResultError):  # a full disk: the file is as the last commit left it
            recorder.close()
        raise


def run_facts(model: Model, state: State) -> dict[str, float]:
    """How a run stepped, for the file's summary: what its series do not say."""
    return {
        "substep": model.clock.substep,
        "mechanism_step": model.clock.window,
        "windows": int(state.coupling.windows[0]),
        "passes": int(state.coupling.passes[0]),
        "particles": 0 if model.charge is None else model.charge.n_particles,
    }
