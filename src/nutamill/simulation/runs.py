"""Run a case to a file, and go on with a file: `run` and `resume`.

Both end in `nutamill.simulation.march.march`.
"""

import math
import warnings
from collections.abc import Callable
from contextlib import suppress
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
)
from nutamill.base.files import exists
from nutamill.base.kernel import kernel_digest
from nutamill.base.provenance import run_provenance
from nutamill.base.units import Kind, UnitError, parse
from nutamill.case import Case, Machine, case_of_text, load_case
from nutamill.result import NOT_STEADY, Recorder, Result, is_finished, open_result
from nutamill.result.one_writer import one_writer
from nutamill.simulation.checkpoint import (
    checkpoint_groups,
    placed_by_checkpoint,
    restore,
)
from nutamill.simulation.earlier import earlier_result, path_beside
from nutamill.simulation.entry import record_first_row
from nutamill.simulation.fmus.exchange import refuse_resume, started
from nutamill.simulation.fmus.mapping import fmu_plans
from nutamill.simulation.fmus.trust import identities, refuse_untrusted
from nutamill.simulation.lammps.lead import in_lammps, led
from nutamill.simulation.march import march, record_statistics
from nutamill.simulation.progress import Watch
from nutamill.simulation.progress_report import Progress
from nutamill.simulation.record import Ending, room_at_start
from nutamill.simulation.setup.bed import bed_is_cached, settle_apart, settled_bed
from nutamill.simulation.setup.charge import contact_law_of
from nutamill.simulation.setup.clock import run_clock
from nutamill.simulation.setup.light_carriers import refuse_light_carriers
from nutamill.simulation.setup.model import Model, Scratch, State, build
from nutamill.simulation.setup.statistics import statistics_axes
from nutamill.simulation.setup.threads import team_size
from nutamill.simulation.setup.wall_checks import refuse_walls
from nutamill.simulation.setup.walls import digests, placed_walls
from nutamill.simulation.signals import requests, stop_at_once
from nutamill.simulation.warm_up import warm_up, warm_up_mechanism


def run(
    case: Case | Machine | str | Path,
    to: str | Path | None = None,
    progress: Callable[[Progress], None] | None = None,
    log: Callable[[str], None] | None = None,
    again: bool = False,
    trust_fmu: bool = False,
) -> Result:
    """Run a case from rest to its end and return the opened result, with no display of its own.

    Arguments and errors are those of `nutamill.notebook.runs.run`, the public face.
    """
    case = asked_case(case)
    path = Path(case.file_in() if to is None else to)
    refuse_untrusted(case.machine, trust_fmu)
    if case.charge.parts:
        run_clock(case.machine)  # refuses a substep that is too long before a file is touched
        refuse_light_carriers(case.machine)
        refuse_walls(case.machine)
    with led(case.machine), stop_at_once():
        if not again:
            earlier = None
            with suppress(
                ResultError, DamagedError
            ):  # reported below, where it is known that no other run writes the file
                earlier = earlier_result(path, case)
            if earlier is not None:
                return complete_already(earlier, log)
        with one_writer(path):
            if not again and (earlier := earlier_result(path, case)) is not None:
                return complete_already(earlier, log)
            beside = path_beside(path) if again else path
            if beside == path:
                run_to(case, path, progress, log)
            else:
                run_beside(case, beside, path, progress, log)
    return ended_result(path)


def asked_case(case: Case | Machine | str | Path) -> Case | Machine:
    """Return the case itself, or that of a name or file. Raise CaseError for anything else."""
    if isinstance(case, (str, Path)):
        return load_case(case)
    if not isinstance(case, (Case, Machine)):
        what = f"not a case, the name of a mill, or a case file, got {type(case).__name__}"
        raise CaseError(Fault("case", what, "Make a case with load_case"))
    return case


def complete_already(earlier: Result, log: Callable[[str], None] | None) -> Result:
    """Return the finished result of a case that is run again, and log how to make it anew. Raise as
    `ended_result`.
    """
    with earlier:
        made = (
            ""
            if earlier.provenance.get("kernel_digest") == kernel_digest()
            else ", made by other kernels than this version has"
        )
    if log is not None:
        log(f"{earlier.path} is complete already{made}. Make it anew with --again.")
    return ended_result(earlier.path)


def ended_result(path: Path) -> Result:
    """Return the result of a run that has ended. Raise NotSteadyError if it should have ended steady and did
    not.
    """
    result = open_result(path)
    kind, _, why = result.state.partition(": ")
    if kind != NOT_STEADY:
        return result
    with result:
        what = f"not steady after {result.reached:g} s: {why}"
    raise NotSteadyError(f"{path}: {what}. Go on with: nutamill resume {path} --until ...")


def run_beside(
    case: Case | Machine,
    beside: Path,
    path: Path,
    progress: Callable[[Progress], None] | None,
    log: Callable[[str], None] | None,
) -> None:
    """Run a case to the file `beside`, which replaces `path` if the run ends. Otherwise both remain."""
    with one_writer(beside):
        beside.unlink(missing_ok=True)  # of a run like this one that was stopped
        try:
            run_to(case, beside, progress, log)
        except (Interrupted, MillError):
            if log is not None and exists(beside):
                log(f"{path} is unchanged, the new run so far is in {beside}")
            raise
        put_in_place(beside, path)


def run_to(
    case: Case | Machine,
    path: Path,
    progress: Callable[[Progress], None] | None,
    log: Callable[[str], None] | None,
) -> None:
    """Run a case to a new or empty file. The other arguments and the errors are those of `run`."""
    machine, watch = case.machine, Watch(case, progress, log)
    check_room(path, room_at_start(machine))
    if machine.charge.parts and machine.charge.engine is None:
        cached = bed_is_cached(machine)
        warm_up(log, None if cached else lambda: settle_apart(machine), contact_law_of(machine))
    else:
        warm_up_mechanism(log)
    bed = settled_bed(machine, watch.settling)
    with started(machine) as exchange:
        model, state, scratch = build(machine, bed, exchange)
        with in_lammps(model, state, scratch, bed):
            record_run(case, model, state, scratch, path, watch)


def record_run(
    case: Case | Machine, model: Model, state: State, scratch: Scratch, path: Path, watch: Watch
) -> None:
    """Create the file of a run, record its start, and march to its end. The errors are those of `run`."""
    machine = case.machine
    axes = None if model.survey is None else statistics_axes(machine, model.survey)
    record_first_row(model, state, scratch)
    threads = 1 if model.charge is None else team_size(machine)
    files = digests(machine) | identities(machine)
    provenance = run_provenance(kernel_digest(), machine.run.seed, threads) | files
    fields, rate = model.readout.fields, case.run.series_rate
    with requests() as asked:
        recorder = Recorder.create(
            path,
            case.to_toml(),
            provenance,
            fields,
            rate,
            overwrite=True,
            axes=axes,
            walls=placed_walls(machine),
        )
        ending, first = (
            Ending(machine, case.run.end),
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
    log: Callable[[str], None] | None = None,
    trust_fmu: bool = False,
) -> Result:
    """Continue the run of a result file from its newest checkpoint, bit for bit as if it had never stopped.

    A run that is complete is returned as it is, unless `until` asks for a later end.

    Parameters
    ----------
    path : result file
    until : simulated time at the end, in seconds or as text with a unit; the end of the case if None.  For a
        run that ends when steady this is the longest time, or the end if it has been steady already
    progress, log, trust_fmu : as for `run`

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
            if log is not None:
                log(
                    f"{path} has ended, at {reached:g} s. For a later end: nutamill resume {path} "
                    "--until TIME"
                )
            return ended_result(path)
        with led(machine_of(path)), one_writer(path):
            resume_to(path, asked_end, progress, log, trust_fmu)
    return ended_result(path)


def machine_of(path: Path) -> Machine:
    """Return the machine of a result file."""
    with open_result(path) as result:
        return case_of_text(result.case_text, path.stem).machine


def end_time(until: float | str) -> float:
    """Return the end [s] given in seconds or as text with a unit. Raise CaseError unless it is finite."""
    try:
        end = parse(until, Kind.TIME) if isinstance(until, str) else float(until)
    except UnitError as error:
        raise CaseError(Fault("--until", error.what, error.hint)) from None
    if not math.isfinite(end):
        raise CaseError(Fault("--until", f"not a finite time, got {end}", 'Write e.g. "20 s"'))
    return end


def resume_to(
    path: Path,
    until: float | None,
    progress: Callable[[Progress], None] | None,
    log: Callable[[str], None] | None,
    trust_fmu: bool,
) -> None:
    """Continue the run of a file to `until` [s]. Other arguments and errors are those of `resume`."""
    with open_result(path) as result:
        case = case_of_text(result.case_text, path.stem)
        checkpoint, digest = result.checkpoint(), result.provenance.get("kernel_digest")
        for damage in result.damaged_checkpoints():
            (log or warnings.warn)(
                f"{damage} Continuing from the older checkpoint at t = {checkpoint.time:.6g} s."
            )
        end = case.run.end if until is None else until
        ending = Ending(case.machine, end)
        if case.run.until == "steady":
            rows = round(checkpoint.time * case.run.series_rate) + 1
            ending.replay(np.column_stack([result.series[name].values[:rows] for name in ending.columns]))
    if until is not None and ending.steady:
        ending = Ending(case.machine, end).fixed()
    if end < checkpoint.time - 0.5 / case.run.series_rate:
        raise CaseError(
            Fault(
                "--until",
                f"not later than the checkpoint at {checkpoint.time:.6g} s, got {end:.6g} s",
                "The file has the earlier part",
            )
        )
    if digest != kernel_digest():
        raise ResultError(
            f"{path}: the run was begun with other kernels than those of this version. Install the version "
            "named under /provenance, or run the case again."
        )
    machine = case.machine
    if machine.charge.parts and machine.charge.engine is None:
        warm_up(log, law=contact_law_of(machine))
    refuse_untrusted(machine, trust_fmu)
    if machine.fmus:
        refuse_resume(fmu_plans(machine))
    with started(machine) as exchange, requests() as asked:
        bed, poses = placed_by_checkpoint(machine, checkpoint.groups)
        model, state, scratch = build(machine, bed, exchange, poses)
        model = restore(model, state, scratch, checkpoint.groups)
        with in_lammps(model, state, scratch, bed, poses, checkpoint.groups):
            recorder = Recorder.reopen(path, checkpoint.time)
            march(model, state, scratch, recorder, ending, Watch(case, progress, log), asked)
