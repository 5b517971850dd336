"""`nutamill validate`: run, resume or read what a paper needs, compare row by row, store and draw it."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from nutamill.base.atomic_file import io_errors, write_whole
from nutamill.base.durations import duration
from nutamill.base.errors import CaseError, DamagedError, Fault, ResultError
from nutamill.base.notebook_hook import notebook_html
from nutamill.design.modes import machine_modes
from nutamill.design.preflight import preflight, wall_time
from nutamill.result import MISSING, is_finished, open_result
from nutamill.studies.axes import Member
from nutamill.studies.board import Board
from nutamill.studies.papers.cells import HEADINGS, Interval
from nutamill.studies.papers.compare import Finding, Key, Measured, compare, keys_of, measure
from nutamill.studies.papers.figures import draw_figure
from nutamill.studies.papers.library import read_paper
from nutamill.studies.papers.model import Paper
from nutamill.studies.papers.runs import (
    COMPLETE,
    PlannedRun,
    chosen,
    planned_runs,
    read_modes,
    run_state,
    wants_modes,
    write_modes,
)
from nutamill.studies.papers.table import SHORT, csv_text, json_text, markdown
from nutamill.studies.sweep import log_other_kernels, run_all
from nutamill.studies.workers import ClusterWorkers, LocalProcesses, Workers
from nutamill.view.figures.saving import save_figure

if TYPE_CHECKING:
    import distributed

FOLDER = Path("results") / "validation"
"""Where results go unless another folder is given, each paper's in a folder of its name."""


@dataclass(frozen=True, slots=True)
class Comparison:
    """A paper compared, and where it is stored."""

    paper: Paper
    """What was published."""
    findings: list[Finding]
    """The rows asked for, compared; the files hold all rows."""
    files: list[Path]
    """Tables and pictures written."""
    failures: list[str]
    """Runs that could not go on, with the reason."""
    undrawn: list[str]
    """Figures that lack results, with the reason."""

    def _repr_html_(self) -> str:
        return notebook_html("campaigns.comparison_html", self)


def validate(
    name: str | Path,
    quick: bool = False,
    only: Sequence[str] = (),
    folder: str | Path | None = None,
    start: bool = True,
    jobs: int | None = None,
    client: "distributed.Client | None" = None,
    log: Callable[[str], None] = print,
) -> Comparison:
    """Compare a paper with our own runs of all its configurations, row by row.

    Results that are complete are read, begun ones resumed, missing ones run; each is a result file of its
    own, so that an interrupt or a failure costs nothing that was done.

    Parameters
    ----------
    name : ``"saimm2025"``, ``"mca2026"``, or a file of the same form
    quick : start the few decisive runs only
    only : names of rows, configurations or runs to restrict it to
    folder : where results are and go; ``results/validation/<paper>`` if None
    start : False: start no run, evaluate what is there
    jobs : runs at once on this machine, the physical cores if None
    client : a Dask client, whose workers run instead
    log : called with each line of what goes on

    Raises
    ------
    CaseError : no such paper, a fault in its file, or a name in `only` that is none
    ResultError : a table or picture cannot be written
    KeyboardInterrupt : after an interrupt, with everything saved
    """
    paper, stem = read_paper(name), Path(name).stem
    directory = Path(folder) if folder is not None else FOLDER / stem
    runs = planned_runs(paper, directory)
    rows, taken = chosen(paper, runs, only, quick)
    failures: list[str] = []
    if start:
        find_modes([run for run in runs if wants_modes(rows, run)])
        if waiting := in_order(taken, log):
            failures = run_campaign(
                waiting, directory, ClusterWorkers(client) if client else LocalProcesses(jobs)
            )
    complete = [run.path for run in runs if run_state(run) == COMPLETE]
    log_other_kernels(complete, log)
    if complete:
        log(
            f"{len(complete)} of {len(runs)} runs are complete; they took "
            f"{duration(wall_time_of(complete))} in all, one after the other"
        )
    measured = measure(paper, runs, keys_of(paper), f"nutamill validate {name} --only")
    files, undrawn = store(paper, runs, compare(paper.rows, measured), measured, directory)
    return Comparison(paper, compare(rows, measured), files, failures, undrawn)


def wall_time_of(files: Sequence[Path]) -> float:
    """Return the wall time that the runs of these results took together [s], without beds from the cache."""
    total = 0.0
    for file in files:
        with open_result(file) as result:
            total += result.provenance["wall_time"]
    return total


def find_modes(runs: Sequence[PlannedRun]) -> None:
    """Compute and store the natural frequencies of machines, the charge counted as a rigid mass, where they
    are not stored yet.
    """
    for run in runs:
        if read_modes(run) is not None:
            continue
        if (mill := run.case.drawing) is None:
            rest = machine_modes(run.case)
            write_modes(run, rest.frequency.tolist(), rest.damping_ratio.tolist())
        else:
            crossings = preflight(mill).crossings
            write_modes(
                run, [mode.frequency for mode in crossings], [mode.damping_ratio for mode in crossings]
            )


def in_order(runs: Sequence[PlannedRun], log: Callable[[str], None]) -> list[PlannedRun]:
    """Return the runs that are not complete, the quickest first, and log the forecast of each."""
    waiting = []
    for run in runs:
        state = run_state(run)
        if state == COMPLETE:
            continue
        if state.startswith("failed"):
            log(f"{run.name}: {state} The file stays as it is; delete {run.path} to run it again")
            continue
        waiting.append((wall_time(run.case) * _share_left(run, state), run, state))
    waiting.sort(key=lambda entry: entry[0])
    forecast = duration(sum(seconds for seconds, _, _ in waiting))
    log(f"{len(waiting)} of {len(runs)} runs to do, forecast {forecast}")
    for seconds, run, state in waiting:
        left = "" if state == MISSING else "   to resume"
        log(f"  {run.name:32} {run.case.run.end:6.2f} s simulated   forecast {duration(seconds)}{left}")
    return [run for _, run, _ in waiting]


def _share_left(run: PlannedRun, state: str) -> float:
    """Return the share of a run that is still to do [1]."""
    if state == MISSING:
        return 1.0
    try:
        with open_result(run.path) as result:
            return max(0.0, 1.0 - result.checkpoint().time / run.case.run.end)
    except (ResultError, DamagedError):
        return 1.0


def run_campaign(runs: Sequence[PlannedRun], directory: Path, workers: Workers) -> list[str]:
    """Run or resume each in a process of its own, and return what failed, in words."""
    members = [Member({"run": run.name}, run.case) for run in runs]
    with Board(()) as board:
        outcomes = run_all(members, directory, workers, (), board, board.message)
        board(outcomes)
    return [
        f"{outcome.member.case.name}: {outcome.state}"
        for outcome in outcomes
        if not is_finished(outcome.state)
    ]


def store(
    paper: Paper,
    runs: Sequence[PlannedRun],
    findings: Sequence[Finding],
    measured: dict[Key, Measured],
    directory: Path,
) -> tuple[list[Path], list[str]]:
    """Write the table as CSV, JSON and Markdown, and the figures. Return the files, and in words the figures
    that lack results.
    """
    files = []
    for suffix, text in ((".csv", csv_text), (".json", json_text), (".md", markdown)):
        files.append(directory / f"comparison{suffix}")
        write_whole(files[-1], text(findings, paper))
    undrawn = []
    for plan in paper.figures:
        try:
            figure = draw_figure(plan, paper, runs, measured)
        except (ResultError, DamagedError) as error:
            undrawn.append(f"figure {plan.number} not drawn: {error}")
            continue
        files.append(save_figure(figure, directory / f"figure-{plan.number}.png"))
    return files, undrawn


def write_tables(
    file: Path, done: Comparison, name: str, identified: Mapping[str, Interval] | None = None
) -> None:
    """Write the tables of a paper into a file of Markdown: headline rows, all rows, or both.

    What stands between the lines ``<!-- validate NAME -->`` and ``<!-- end NAME -->`` is replaced by the
    headline rows, marked so in the paper's file; between ``<!-- validate NAME all -->`` and
    ``<!-- end NAME all -->`` by all rows.  A file without these lines is replaced whole by the headline rows.
    Rows without a result are counted below the table.

    Parameters
    ----------
    name : what the paper is called on the command line
    identified : predictive intervals by the name of the row, for a column of their own

    Raises
    ------
    CaseError : a first line without its last
    ResultError : the file cannot be written
    """
    short = [finding for finding in done.findings if finding.row.headline]
    headline = _table(short, done.paper, name, SHORT, identified)
    tables = {name: headline, f"{name} all": _table(done.findings, done.paper, name, HEADINGS, identified)}
    with io_errors(file):
        try:
            text = file.read_text(encoding="utf-8") if file.exists() else ""
        except UnicodeDecodeError:
            raise CaseError(Fault(str(file), "is not a text file", "Choose another name")) from None
    marked = False
    for mark, table in tables.items():
        begin, end = f"<!-- validate {mark} -->\n", f"<!-- end {mark} -->"
        if begin not in text:
            continue
        marked = True
        before, _, rest = text.partition(begin)
        if end not in rest:
            raise CaseError(Fault(str(file), f'has no line "{end}" after "{begin.strip()}"', "Add that line"))
        text = f"{before}{begin}{table}{end}{rest.partition(end)[2]}"
    write_whole(file, text if marked else headline)


def _table(
    findings: Sequence[Finding],
    paper: Paper,
    name: str,
    columns: Sequence[str],
    identified: Mapping[str, Interval] | None = None,
) -> str:
    """Return the rows that have a result as Markdown, and how many have none."""
    present = [finding for finding in findings if not math.isnan(finding.value)]
    text = markdown(present, paper, columns, identified)
    if lacking := len(findings) - len(present):
        text += f"\n{lacking} more rows have no result yet; `nutamill validate {name}` makes them.\n"
    return text
