"""`sweep`: a case with other values of some keys, all combinations, each run once; and `run_all` for any
cases.
"""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from pathlib import Path
from threading import Event
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from nutamill.analysis.values import DEFAULT, Reading, read
from nutamill.base.atomic_file import make_folder
from nutamill.base.errors import CaseError, Fault, MillError
from nutamill.base.kernel import kernel_digest
from nutamill.base.notebook_hook import notebook_html
from nutamill.case import Case, Machine
from nutamill.result import is_finished, open_result, state_of
from nutamill.simulation.setup.bed import bed_is_cached, bed_key
from nutamill.simulation.setup.charge import contact_law_of
from nutamill.simulation.setup.clock import run_clock
from nutamill.simulation.signals import requests
from nutamill.simulation.warm_up import warm_up, warm_up_mechanism
from nutamill.studies.axes import Member, changed, members
from nutamill.studies.member import Task
from nutamill.studies.table import Outcome, dataset, write_csv
from nutamill.studies.workers import ClusterWorkers, LocalProcesses, Workers

if TYPE_CHECKING:
    import distributed
    import xarray

NAMED = 3
"""Files that a line names before it counts the rest [1]."""
TABLE = "table.csv"
"""File of a campaign's folder that holds the table of its results."""
POLL = 1.0
"""Wall time between two looks at how the runs stand [s]."""

Report = Callable[[Sequence[Outcome]], None]


class Campaign(NamedTuple):
    """The result of a sweep."""

    table: "xarray.Dataset"
    """Readings over the swept keys."""
    outcomes: list[Outcome]
    """What became of each run."""
    folder: Path
    """Where the result files and ``table.csv`` are."""

    def _repr_html_(self) -> str:
        return notebook_html("campaigns.campaign_html", self)


def sweep(
    case: Case | Machine,
    axes: Mapping[str, Sequence[Any]],
    folder: str | Path | None = None,
    jobs: int | None = None,
    client: "distributed.Client | None" = None,
    readings: Sequence[Reading] = DEFAULT,
    report: Report | None = None,
    log: Callable[[str], None] | None = None,
) -> Campaign:
    """Run a case with all combinations of other values, one process a run, and collect the steady means in a
    table.

    A run whose result is in the folder is read, one that was begun goes on from its last checkpoint, the rest
    are run: after an interrupt or a kill, the same call does what is left.

    Parameters
    ----------
    case : what is varied
    axes : values by dotted key; SI floats or text with a unit
    folder : for result files and the table; ``sweeps/<case>`` if None
    jobs : runs at once on this machine, the physical cores if None
    client : a Dask client, whose workers run instead
    readings : what is put into the table
    report : called about once a second with how all runs stand
    log : called with a line of text when something takes time before the first run

    Raises
    ------
    CaseError : every fault of every case, before anything is run
    KeyboardInterrupt : after an interrupt, with everything saved
    """
    planned = members(axes, lambda values: changed(case, values))
    directory = Path("sweeps") / case.name if folder is None else Path(folder)
    outcomes = run_all(
        planned, directory, ClusterWorkers(client) if client else LocalProcesses(jobs), readings, report, log
    )
    return Campaign(dataset(outcomes, axes, readings), outcomes, directory)


def run_all(
    planned: Sequence[Member],
    folder: Path,
    workers: Workers,
    readings: Sequence[Reading] = DEFAULT,
    report: Report | None = None,
    log: Callable[[str], None] | None = None,
) -> list[Outcome]:
    """Run members that are not run yet, into `folder`, and read all. Beds that several share are settled
    once, before.

    A run that fails, or whose worker is killed, is named in its outcome, and the others go on.  ``table.csv``
    in the folder is updated after every run.  Parameters and errors as of `sweep`.
    """
    _refuse(planned)
    make_folder(folder / TABLE)
    board = {member.case.digest: _outcome(member, folder, "waiting", readings) for member in planned}
    left = [outcome for outcome in board.values() if not is_finished(outcome.state)]
    log_other_kernels((outcome.file for outcome in board.values() if is_finished(outcome.state)), log)

    def keep(outcome: Outcome) -> None:
        board[outcome.member.case.digest] = outcome
        write_csv(folder / TABLE, list(board.values()), readings)

    try:
        if left:
            _warm_up([outcome.member.case for outcome in left], log)
            with requests() as asked:
                _settle([outcome.member.case for outcome in left], workers, log, asked.stop)
                tasks = {
                    workers.submit(_task("run", outcome.member.case, outcome.file)): outcome.member
                    for outcome in left
                }
                for done in _as_they_end(tasks, asked.stop):
                    for future in done:
                        keep(_outcome(tasks[future], folder, _trouble(future), readings))
                    if report is not None:
                        report(
                            [outcome if outcome.values else _glance(outcome) for outcome in board.values()]
                        )
    finally:
        workers.stop()
        write_csv(folder / TABLE, list(board.values()), readings)
    return list(board.values())


def _warm_up(cases: Sequence[Case | Machine], log: Callable[[str], None] | None) -> None:
    """Compile what these cases run once, before their processes start: no charge where none has one."""
    laws = {contact_law_of(case.machine) for case in cases if case.charge.parts}
    for law in laws:
        warm_up(log, law=law)
    if not laws:
        warm_up_mechanism(log)


def _as_they_end(futures: Iterable[Future], interrupted: Event) -> Iterator[set[Future]]:
    """Yield those that have ended since the last look, about once a second, until all have. Raises
    KeyboardInterrupt when it is interrupted.
    """
    left = set(futures)
    while left:
        done, left = wait(left, POLL, FIRST_COMPLETED)
        if interrupted.is_set():
            raise KeyboardInterrupt
        yield done


def _refuse(planned: Sequence[Member]) -> None:
    """Raise every fault that shows before the first step, each once."""
    faults: list[Fault] = []
    for member in planned:
        try:
            run_clock(member.case.machine)
        except CaseError as error:
            faults += [
                Fault(f"{member.label}: {fault.where}", fault.what, fault.hint) for fault in error.faults
            ]
    if faults:
        raise CaseError(*dict.fromkeys(faults))


def log_other_kernels(files: Iterable[Path], log: Callable[[str], None] | None) -> None:
    """Log which of these finished results another version has made. They are read all the same."""
    others = []
    for file in files:
        with open_result(file) as result:
            others += [file.name] if result.provenance.get("kernel_digest") != kernel_digest() else []
    if others and log is not None:
        named = ", ".join(others[:NAMED]) + (
            f" and {len(others) - NAMED} more" if len(others) > NAMED else ""
        )
        log(f"made by the kernels of another version, and read as it is: {named}")


def _task(work: Literal["settle", "run"], case: Case | Machine, file: Path) -> Task:
    return Task(work, case.to_toml(), case.name, str(file.absolute()))


def _settle(
    cases: Sequence[Case | Machine], workers: Workers, log: Callable[[str], None] | None, interrupted: Event
) -> None:
    """Settle each bed that several runs share and that is not in the cache yet. A fault shows again in the
    runs that need it.
    """
    needed = [(bed_key(case.machine), case) for case in cases if not bed_is_cached(case.machine)]
    runs = Counter(key for key, _ in needed)
    beds = {key: case for key, case in needed if runs[key] > 1}
    if beds and log is not None:
        log(
            f"settling {len(beds)} bed{'s' if len(beds) > 1 else ''} that "
            f"{sum(runs[key] for key in beds)} runs share"
        )
    for _ in _as_they_end(
        [workers.submit(_task("settle", case, Path())) for case in beds.values()], interrupted
    ):
        pass


def _trouble(future: Future) -> str:
    """Return what went wrong with a task, empty if nothing did."""
    try:
        future.result()
    except MillError as error:
        return str(error)
    except (Exception, CancelledError) as error:  # a cluster hands on whatever its worker met
        return f"{type(error).__name__}: {error}"
    return ""


def _outcome(member: Member, folder: Path, state: str, readings: Sequence[Reading]) -> Outcome:
    """Return how a member stands by its file: finished, with its readings, or else in the given `state`."""
    file = member.case.file_in(folder)
    try:
        held = state_of(file)
        if is_finished(held):
            with open_result(file) as result:
                return Outcome(member, file, held, read(result, readings))
    except MillError as error:
        state = str(error)
    return Outcome(member, file, state, {})


def _glance(outcome: Outcome) -> Outcome:
    """Return how far a run has come, by its file."""
    if outcome.state != "waiting" or not outcome.file.exists():
        return outcome
    try:
        with open_result(outcome.file) as result:
            return outcome._replace(
                state=f"running, t = {result.reached:.2f} of {outcome.member.case.run.end:g} s"
            )
    except MillError:
        return outcome
