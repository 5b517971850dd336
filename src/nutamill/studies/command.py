"""What the commands of a campaign do between the typed words and the calls of the package."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from nutamill.analysis.values import DEFAULT, default_readings, reading_of
from nutamill.base.errors import CaseError, Fault
from nutamill.case import Case, Machine, load_case
from nutamill.result import is_finished
from nutamill.simulation.setup.quick import banner
from nutamill.simulation.setup.quick import quick as quickened
from nutamill.studies.axes import axis_values, members
from nutamill.studies.board import Board, ended, total
from nutamill.studies.figures import draw_sweep
from nutamill.studies.fit import fit
from nutamill.studies.identify.identify import identify
from nutamill.studies.measurand import refuse_unrecorded
from nutamill.studies.sweep import run_all
from nutamill.studies.sweep_file import is_sweep_file, load_sweep
from nutamill.studies.table import dataset
from nutamill.studies.workers import ClusterWorkers, LocalProcesses, Workers, cluster_client
from nutamill.view.figures.saving import save_figure


def workers_of(jobs: int | None, cluster: str | None) -> Callable[[], Workers]:
    """Return a function that makes processes of this machine, or takes the workers of a cluster, for one
    batch of runs.
    """
    if cluster is None:
        return lambda: LocalProcesses(jobs)
    client = cluster_client(cluster, jobs)
    return lambda: ClusterWorkers(client)


def run_sweep(
    name: str,
    changes: list[str],
    jobs: int | None,
    cluster: str | None,
    to: Path | None,
    quick: bool,
    log: Callable[[str], None],
) -> bool:
    """Run a sweep and print its table, and return whether all of its runs are finished.

    Parameters
    ----------
    name : a case or a sweep file
    changes : ``key=values``; a key with one value is changed in all runs
    jobs, cluster, to, quick : as typed
    log : prints a line

    Raises
    ------
    CaseError : no key has several values; it and KeyboardInterrupt also as `nutamill.studies.sweep.sweep`
    """
    fixed: list[str] = []
    axes: dict[str, list[Any]] = {}
    named: tuple[str, ...] = ()
    if is_sweep_file(name):
        stem = Path(name).stem
        name, fixed, swept, named = load_sweep(name)
        axes = {
            key: value if isinstance(value, list) else axis_values(key, value) for key, value in swept.items()
        }
    else:
        stem = Path(name).name.removesuffix(".toml")
    for change in changes:
        key, equals, text = change.partition("=")
        values = axis_values(key.strip(), text) if equals else []
        if len(values) > 1:
            axes[key.strip()] = values
        else:
            axes.pop(key.strip(), None)
            fixed.append(change)

    if not axes:
        hint = 'Write e.g. -s drive.speed="500,600,700 rpm"; a single case is for nutamill run'
        raise CaseError(Fault("sweep", "needs a key with several values, got none", hint))

    notices: list[str] = []

    def made(values: dict[str, Any]) -> Case | Machine:
        settings = [*fixed, *(f"{key}={value}" for key, value in values.items())]
        if not quick:
            return load_case(name, settings)
        case = load_case(name, settings)
        if not notices:
            notices.append(banner(case))
        return quickened(case)

    planned = members(axes, made)
    first = planned[0].case
    readings = tuple(reading_of(text, "readings", first.machine) for text in named)
    if readings:
        refuse_unrecorded(readings, (member.case.machine for member in planned), "readings")
    readings = readings or default_readings(first)
    folder = to or Path("sweeps") / stem
    for notice in notices:
        log(notice)
    workers = workers_of(jobs, cluster)()
    with Board(readings) as board:
        board.message(f"{len(planned)} runs into {folder}")
        outcomes = run_all(planned, folder, workers, readings, board, board.message)
        board(outcomes)
    picture = draw_sweep(dataset(outcomes, axes, readings), readings)
    if picture is not None:
        save_figure(picture, folder / "table.png")
    bad = [outcome for outcome in outcomes if ended(outcome) and not is_finished(outcome.state)]
    drawn = f"   picture {folder / 'table.png'}" if picture is not None else ""
    log(
        f"{total(outcomes)}   {folder / 'table.csv'}{drawn}"
        + ("   the same command again does what is left" if bad else "")
    )
    return not bad


def run_fit(file: Path, jobs: int | None, cluster: str | None, to: Path | None) -> list[str]:
    """Fit, and return the lines to print. Parameters are as typed, errors those of
    `nutamill.studies.fit.fit`.
    """
    folder = to or Path("fits") / file.stem
    client = None if cluster is None else cluster_client(cluster, jobs)
    with Board(DEFAULT) as board:
        board.message(f"runs into {folder}")
        return fit(file, folder, jobs, client, board, board.message).lines()


def run_identification(
    file: Path,
    until: str | None,
    jobs: int | None,
    cluster: str | None,
    to: Path | None,
    steps: int | None,
    learned: Sequence[str],
) -> list[str]:
    """Identify, and return the lines to print. Parameters are as typed, errors those of
    `nutamill.studies.identify.identify.identify`.
    """
    folder = to or Path("identified") / file.stem
    client = None if cluster is None else cluster_client(cluster, jobs)
    with Board(DEFAULT) as board:
        board.message(f"runs into {folder}")
        done = identify(file, folder, until, jobs, client, board, board.message, steps, learned)
    return [*done.lines(), "", ", ".join(map(str, done.files))]
