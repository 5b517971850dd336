"""The one time loop: `run` a case to a file, `resume` a file, and `march` in between.

The compiled march is entered for some milliseconds of simulated time at a time; between two entries Python
records, keeps checkpoints, tells the progress and listens for an interrupt.
"""

import math
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np

from nutamill.base.atomic_file import check_room, put_in_place
from nutamill.base.errors import (
    CaseError,
    DamagedError,
    Fault,
    Interrupted,
    MillError,
    NotSteadyError,
    ResultError,
    StepError,
)
from nutamill.base.files import exists
from nutamill.base.kernel import kernel_digest
from nutamill.base.provenance import run_provenance
from nutamill.base.units import Kind, UnitError, parse
from nutamill.case import Case, MechanismCase, case_of_text, load_case
from nutamill.result import NOT_STEADY, Recorder, Result, is_finished, open_result
from nutamill.result.one_writer import one_writer
from nutamill.simulation.checkpoint import (
    backup,
    bed_from_checkpoint,
    checkpoint_groups,
    restore,
    statistics_group,
)
from nutamill.simulation.earlier import earlier_result, place_beside
from nutamill.simulation.entry import enter, record_first_row
from nutamill.simulation.progress import Watch
from nutamill.simulation.progress_report import Progress
from nutamill.simulation.record import COLUMNS, Ending, RecordPlan, room_at_start
from nutamill.simulation.setup.bed import bed_is_kept, settle_apart, settled_bed
from nutamill.simulation.setup.charge import contact_law_of
from nutamill.simulation.setup.clock import run_clock
from nutamill.simulation.setup.mechanism import build_mechanism
from nutamill.simulation.setup.mill import mill_mechanism
from nutamill.simulation.setup.model import Model, Scratch, State, build
from nutamill.simulation.setup.statistics import statistics_axes
from nutamill.simulation.setup.threads import team_size
from nutamill.simulation.setup.walls import digests, placed_walls
from nutamill.simulation.signals import Requests, requests, stop_at_once
from nutamill.simulation.snapshot import snapshot, statistics
from nutamill.simulation.warm_up import warm_up, warm_up_mechanism

ROWS_PER_ENTRY = 48
"""Rows recorded in one entry of the compiled march [1]: 10 ms of simulated time at the default rate."""

ROWS_PER_ENTRY_ALONE = 480
"""The same without charge, where steps are so cheap that entering would cost as much as marching."""

LONGEST_UNSAVED = 600.0
"""Wall time after which a checkpoint is kept before its turn [s]: what a kill may cost where a simulated
second takes hours.
"""


def run(
    case: Case | MechanismCase | str | Path,
    to: str | Path | None = None,
    progress: Callable[[Progress], None] | None = None,
    tell: Callable[[str], None] | None = None,
    again: bool = False,
) -> Result:
    """Run a case from rest to its end and return the opened result; a result that is complete already is
    returned as it is.

    Parameters
    ----------
    case : what is asked, of a mill or of any mechanism; or the name of a mill, or a case file
    to : result file; in the folder `results`, as `Case.file_in` names it, if None
    progress : called about twice a second with where the run stands
    tell : called with a line of text when something takes time before the first step, or a checkpoint that
        was asked for is saved
    again : run the case even if the file exists; the file there stays until the new run has ended

    Raises
    ------
    CaseError : bad input, before a step is run
    ResultError : the file holds another case or an incomplete run, another run writes it now, or it cannot be
        written
    DamagedError : a result in the file is damaged
    StepError : the run cannot go on; what was recorded is in the file
    NotSteadyError : the run should end when steady, and was not within `run.max`; the file has it all
    KeyboardInterrupt : after an interrupt before the first step
    Interrupted : after an interrupt of the march, with everything saved
    """
    case = asked_case(case)
    path = Path(case.file_in() if to is None else to)
    if isinstance(case, Case):
        run_clock(case)  # refuses a substep that is too long before a file is touched
    with stop_at_once():
        if not again:
            earlier = None
            with suppress(
                ResultError, DamagedError
            ):  # reported below, where it is known that no other run writes the file
                earlier = earlier_result(path, case)
            if earlier is not None:
                return complete_already(earlier, tell)
        with one_writer(path):
            if not again and (earlier := earlier_result(path, case)) is not None:
                return complete_already(earlier, tell)
            place = place_beside(path) if again else path
            if place == path:
                run_to(case, path, progress, tell)
            else:
                run_beside(case, place, path, progress, tell)
    return ended_result(path)


def asked_case(case: Case | MechanismCase | str | Path) -> Case | MechanismCase:
    """The case itself, or that of a name or file. Raises CaseError for anything else."""
    if isinstance(case, (str, Path)):
        return load_case(case)
    if not isinstance(case, (Case, MechanismCase)):
        what = f"must be a case, the name of a mill, or a case file, got {type(case).__name__}"
        raise CaseError(Fault("case", what, "Make a case with load_case"))
    return case


def complete_already(earlier: Result, tell: Callable[[str], None] | None) -> Result:
    """The finished result of a case that was asked for again; `tell` gets to know how to make it anew. Raises
    as `ended_result`.
    """
    with earlier:
        made = (
            ""
            if earlier.provenance.get("kernel_digest") == kernel_digest()
            else ", made by other kernels than this version has"
        )
    if tell is not None:
        tell(f"{earlier.path} is complete already{made}. Make it anew with --again.")
    return ended_result(earlier.path)


def ended_result(path: Path) -> Result:
    """The result of a run that has ended. Raises NotSteadyError if it should have ended steady and did
    not.
    """
    result = open_result(path)
    kind, _, why = result.state.partition(": ")
    if kind != NOT_STEADY:
        return result
    with result:
        what = f"must be steady, it is not after {result.reached:g} s: {why}"
    raise NotSteadyError(f"{path}: {what}. Go on with: nutamill resume {path} --until ...")


def run_beside(
    case: Case | MechanismCase,
    place: Path,
    path: Path,
    progress: Callable[[Progress], None] | None,
    tell: Callable[[str], None] | None,
) -> None:
    """Run a case to the file `place`, which replaces `path` when the run has ended; otherwise both stay."""
    with one_writer(place):
        place.unlink(missing_ok=True)  # of a run like this one that was stopped
        try:
            run_to(case, place, progress, tell)
        except (Interrupted, MillError):
            if tell is not None and exists(place):
                tell(f"{path} is unchanged, the new run so far is in {place}")
            raise
        put_in_place(place, path)


def run_to(
    case: Case | MechanismCase,
    path: Path,
    progress: Callable[[Progress], None] | None,
    tell: Callable[[str], None] | None,
) -> None:
    """Run a case to a new file, or to one that holds nothing yet; the other arguments and the errors are
    those of `run`.
    """
    watch = Watch(case, progress, tell)
    if isinstance(case, MechanismCase):
        warm_up_mechanism(tell)
        model, state, scratch = build_mechanism(case)
        threads, meshes, axes, walls = 1, {}, None, {}
    else:
        check_room(path, room_at_start(case))
        warm_up(tell, None if bed_is_kept(case) else lambda: settle_apart(case), contact_law_of(case))
        watch.settling(0.0)
        bed = settled_bed(case, watch.settling)
        watch.settling(1.0)
        model, state, scratch = build(case, bed)
        threads, meshes, walls = team_size(case), digests(case), placed_walls(case)
        axes = None if model.charge is None else statistics_axes(case, model.survey)
    record_first_row(model, state, scratch)
    seed = 0 if isinstance(case, MechanismCase) else case.run.seed
    provenance = run_provenance(kernel_digest(), seed, threads) | meshes
    names, rate = model.readout.names, case.run.series_rate
    with requests() as asked:
        recorder = Recorder.create(
            path, case.to_toml(), provenance, names, rate, overwrite=True, axes=axes, walls=walls
        )
        ending, first = (
            Ending(case, case.run.end),
            model.readout.series(state.first_row[None, :], state.first_row),
        )
        recorder.append(first)
        ending.recorded(recorder.names, first)
        record_statistics(model, state, recorder)
        recorder.checkpoint(0.0, checkpoint_groups(model, state))
        march(model, state, scratch, recorder, ending, watch, asked)


def resume(
    path: str | Path,
    until: float | str | None = None,
    progress: Callable[[Progress], None] | None = None,
    tell: Callable[[str], None] | None = None,
) -> Result:
    """Continue the run of a result file from its newest checkpoint, bit for bit as if it had never stopped.

    A run that is complete is returned as it is, unless `until` asks for a later end.

    Parameters
    ----------
    path : result file
    until : simulated time at the end, in seconds or as text with a unit; as the case says if None.  Of a run
        that ends when steady: the longest time; if it has been steady already, the end
    progress, tell : as for `run`

    Raises
    ------
    CaseError : an end before the checkpoint
    ResultError : no such file, no checkpoint, written by other kernels, or another run writes it now
    StepError, NotSteadyError, KeyboardInterrupt, Interrupted : as for `run`
    """
    path, asked_end = Path(path), None if until is None else end_time(until)
    with stop_at_once():
        with open_result(path) as result:
            state, reached = result.state, result.reached
        if asked_end is None and is_finished(state):
            if tell is not None:
                tell(
                    f"{path} has ended, at {reached:g} s. For a later end: nutamill resume {path} "
                    "--until TIME"
                )
            return ended_result(path)
        with one_writer(path):
            resume_to(path, asked_end, progress, tell)
    return ended_result(path)


def end_time(until: float | str) -> float:
    """The end [s] that is asked for in seconds or as text with a unit. Raises CaseError unless it is a finite
    time.
    """
    try:
        end = parse(until, Kind.TIME) if isinstance(until, str) else float(until)
    except UnitError as error:
        raise CaseError(Fault("--until", error.what, error.hint)) from None
    if not math.isfinite(end):
        raise CaseError(Fault("--until", f"must be a finite time, got {end}", 'Write e.g. "20 s"'))
    return end


def resume_to(
    path: Path,
    until: float | None,
    progress: Callable[[Progress], None] | None,
    tell: Callable[[str], None] | None,
) -> None:
    """Continue the run of a file to `until` [s]; the other arguments and the errors are those of `resume`."""
    with open_result(path) as result:
        case = case_of_text(result.case_text, path.stem)
        kept, digest = result.checkpoint(), result.provenance.get("kernel_digest")
        for damage in result.damaged_checkpoints():
            (tell or warnings.warn)(
                f"{damage} Continuing from the older checkpoint at t = {kept.time:.6g} s."
            )
        end = case.run.end if until is None else until
        ending = Ending(case, end)
        if case.run.until == "steady":
            rows = round(kept.time * case.run.series_rate) + 1
            ending.replay(np.column_stack([result.series[name].values[:rows] for name in COLUMNS]))
    if until is not None and ending.found:
        ending = Ending(case, end).fixed()
    if end < kept.time - 0.5 / case.run.series_rate:
        raise CaseError(
            Fault(
                "--until",
                f"must be later than the checkpoint at {kept.time:.6g} s, got {end:.6g} s",
                "The file has what came before",
            )
        )
    if digest != kernel_digest():
        raise ResultError(
            f"{path}: must go on with the kernels it was begun with, this version has others. "
            "Install the version named under"
            " /provenance, or run the case again."
        )
    if isinstance(case, MechanismCase):
        model, state, scratch = build_mechanism(case)
    else:
        warm_up(tell, law=contact_law_of(case))
        bed = bed_from_checkpoint(case, [body.name for body in mill_mechanism(case).bodies], kept.groups)
        model, state, scratch = build(case, bed)
    model = restore(model, state, scratch, kept.groups)
    with requests() as asked:
        recorder = Recorder.reopen(path, kept.time)
        march(model, state, scratch, recorder, ending, Watch(case, progress, tell), asked)


def march(
    model: Model,
    state: State,
    scratch: Scratch,
    recorder: Recorder,
    ending: Ending,
    watch: Watch,
    asked: Requests,
) -> None:
    """March `model` and `state` in place to their `ending` and record; commits the file also when it fails or
    is interrupted.

    Cadences are counted in rows of the record, which are whole numbers of windows.  When a step fails, the
    state at the last entry of the compiled march, at most `ROWS_PER_ENTRY` rows earlier, is kept as snapshot
    and checkpoint.
    """
    plan = ending.plan
    row = int(state.coupling.windows[0]) // model.plan.windows_per_row
    fault: StepError | None = None
    kept: State | None = None
    with saved_whatever_happens(recorder):
        while row < plan.rows and not asked.stop.is_set() and fault is None:
            count = min(
                ROWS_PER_ENTRY_ALONE if model.charge is None else ROWS_PER_ENTRY, plan.next_stop(row) - row
            )
            kept = backup(state, kept)
            kept_sums = {} if kept is None else statistics_group(model, state)
            model, rows, fault = enter(model, state, scratch, count)
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
                now = asked.take_checkpoint()
                early = recorder.unsaved >= LONGEST_UNSAVED
                if now or row % plan.rows_per_checkpoint == 0 or row == plan.rows:
                    record_statistics(model, state, recorder)
                    recorder.checkpoint(state.mechanism.time[0], checkpoint_groups(model, state))
                elif early:
                    recorder.checkpoint(state.mechanism.time[0], checkpoint_groups(model, state))
                recorder.commit(force=now or early)
                if now:
                    watch.checkpoint_saved(state.mechanism.time[0])
    if fault is None and row < plan.rows:
        recorder.checkpoint(state.mechanism.time[0], checkpoint_groups(model, state))
    recorder.summary(run_facts(model, state))
    if fault is not None:
        recorder.state(f"failed: {fault}")
    elif row < plan.rows:
        recorder.state("interrupted")
    else:
        recorder.state(f"{NOT_STEADY}: {ending.missed}" if ending.missed else "complete")
    recorder.close()
    if fault is not None:
        raise fault
    if row < plan.rows:
        raise Interrupted(recorder.path)


def record_statistics(model: Model, state: State, recorder: Recorder) -> None:
    """Record what the charge has done so far, if it is summed."""
    if (sums := statistics(model, state)) is not None:
        recorder.statistics(state.mechanism.time[0], sums)


def keep_what_was_sound(
    model: Model,
    kept: State | None,
    kept_sums: dict,
    recorder: Recorder,
    plan: "RecordPlan",
    row: int,
    fault: StepError,
) -> StepError:
    """Put the state before a failed entry, at `row`, and its statistics into the file; returns the fault with
    words about it.
    """
    if kept is None:
        return fault
    time = float(kept.mechanism.time[0])
    if row not in plan.snapshots:
        recorder.snapshot(time, snapshot(model, kept))
    if row % plan.rows_per_checkpoint:
        recorder.checkpoint(time, kept.arrays() | kept_sums)
    return StepError(
        f"{fault} The file keeps the state at t = {time:.6g} s, before that, as its last snapshot "
        "and checkpoint."
    )


@contextmanager
def saved_whatever_happens(recorder: Recorder) -> Iterator[None]:
    """Commit what has been recorded when something unforeseen ends a march: a callback that raises, a
    terminal that is gone.
    """
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
