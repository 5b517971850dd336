"""`identify`: from a file of unknowns and rows to a posterior, and to what it predicts."""

import importlib.util
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from nutamill.base.atomic_file import make_folder, write_whole
from nutamill.base.errors import CaseError, Fault, missing_extra
from nutamill.case import Case, Machine
from nutamill.studies.axes import changed
from nutamill.studies.identify.draws import drawn_points
from nutamill.studies.identify.emulator import Emulator, emulator_of_draws, fit_emulator
from nutamill.studies.identify.figures import draw_corner, draw_rows
from nutamill.studies.identify.identification import Identification, identification_of
from nutamill.studies.identify.inputs import Inputs
from nutamill.studies.identify.members import Log, refuse_few, run_members
from nutamill.studies.identify.points import read_points, write_points
from nutamill.studies.identify.posterior import MOST_STEPS, Evidence, implausibility
from nutamill.studies.identify.problem import Problem, Row, read_problem
from nutamill.studies.identify.sample import filling_points, points_left
from nutamill.studies.identify.table import json_text, lines, members_csv
from nutamill.studies.sweep import Report
from nutamill.studies.workers import ClusterWorkers, LocalProcesses, Workers
from nutamill.view.figures.saving import save_figure

if TYPE_CHECKING:
    import distributed

NEEDED = {"sklearn": "scikit-learn", "emcee": "emcee"}
"""Modules of the extra ``study``, and their packages."""


def identify(
    file: str | Path,
    folder: str | Path | None = None,
    until: str | None = None,
    jobs: int | None = None,
    client: "distributed.Client | None" = None,
    report: Report | None = None,
    log: Log | None = None,
    steps: int | None = None,
    learned: Sequence[str] = (),
) -> Identification:
    """Identify the unknowns of a file from its rows, and predict its other rows.

    Every run is stored in `folder`, named by its case, with its values and the points of each stage beside
    them: the same call again reads what has been run.

    Parameters
    ----------
    file : the identification file (TOML)
    folder : for results, tables and figures; ``identified/<file>`` if None
    until : the last stage to take, with its rows and unknowns; all if None
    jobs, client, report, log : as for `nutamill.studies.sweep.sweep`
    steps : steps of the chain of the posterior at most [1]; 20 000 if None
    learned : titles of rows to predict that are learned from instead

    Raises
    ------
    CaseError : every fault of the file, before anything is run; ranges that the drawing cannot hold, a row
        that depends on no unknown, an emulator that fails its check
    NotInstalledError : the extra ``study`` is missing
    """
    for module, name in NEEDED.items():
        if importlib.util.find_spec(module) is None:
            raise missing_extra("nutamill identify", name, "study")
    problem = read_problem(file, until, learned)
    directory = Path("identified") / Path(file).stem if folder is None else Path(folder)
    make_folder(directory / "identify.md")

    def workers() -> Workers:
        return ClusterWorkers(client) if client else LocalProcesses(jobs)

    emulators, refused = learn(problem, directory, workers, report, log)
    done = identification_of(problem, emulators, refused, steps or MOST_STEPS)
    files = store(done, directory)
    return done._replace(files=files)


def learn(
    problem: Problem,
    folder: Path,
    workers: Callable[[], Workers],
    report: Report | None = None,
    log: Log | None = None,
) -> tuple[list[Emulator], int]:
    """Run all stages, each at points that the stages before it have not ruled out.

    Returns
    -------
    the emulator of each row, and how many members the drawing could not hold
    """
    unknowns, refused = len(problem.unknowns), 0
    points: dict[int, list[np.ndarray]] = {number: [] for number in range(len(problem.rows))}
    values: dict[int, list[np.ndarray]] = {number: [] for number in range(len(problem.rows))}
    emulators: dict[int, Emulator] = {}
    cuts: list[tuple[list[Evidence], float]] = []

    def plausible(candidates: np.ndarray) -> np.ndarray:
        left = np.ones(len(candidates), dtype=bool)
        for rows, cut in cuts:
            left[left] = implausibility(rows, candidates[left]).max(axis=1) <= cut
        return left

    for number, stage in enumerate(problem.stages):
        seed, deciding = problem.seed + number, problem.deciding(number)
        chosen = read_points(problem, number, folder)
        if chosen is not None:
            pass
        elif stage.draws:
            chosen = drawn_points(problem, [one for rows, _ in cuts for one in rows], number)
        elif not cuts:
            chosen = np.full((stage.members, unknowns), 0.5)
            chosen[:, deciding] = filling_points(len(deciding), stage.members, seed)
        else:
            inputs = inputs_of(problem, problem.rows_of(stage.name), emulators)
            chosen = points_left(unknowns, deciding, stage.members, seed, plausible, stage.name, inputs)
        write_points(problem, number, folder, chosen)
        if log is not None:
            log(f"stage {stage.name}: {stage.members} members")
        ran = run_members(problem, stage.name, chosen, folder, workers, report, log)
        refused += ran.refused
        write_whole(folder / f"members-{number + 1}.csv", members_csv(problem, ran))
        for row, column in ran.values.items():
            points[row].append(ran.points)
            values[row].append(column)
        new = emulators_of(problem, {row: (points[row], values[row]) for row in ran.values}, emulators)
        emulators |= new
        if evidence := evidence_of(problem, new):
            cuts.append((evidence, stage.cut))
    return [emulators[row] for row in range(len(problem.rows))], refused


def emulators_of(
    problem: Problem,
    members: dict[int, tuple[Sequence[np.ndarray], Sequence[np.ndarray]]],
    known: dict[int, Emulator],
) -> dict[int, Emulator]:
    """Fit the emulator of each row to its members, through those of earlier stages, `known`, where it depends
    on these. Raises CaseError with the faults of all rows.
    """
    emulators: dict[int, Emulator] = {}
    faults: list[Fault] = []
    ends = np.array([[one.low, one.high] for one in problem.unknowns])
    for number, (points, values) in members.items():
        row, gains = problem.rows[number], problem.gains(problem.rows[number])
        together = np.concatenate(values)
        try:
            refuse_few(problem, number, together)
            if problem.drawn(row):
                shares = np.concatenate(points)[:, gains]
                together = together * np.prod(ends[gains, 0] + shares * np.ptp(ends[gains], axis=1), axis=1)
                emulators[number] = emulator_of_draws(together, len(problem.unknowns))
                continue
            emulators[number] = fit_emulator(
                np.concatenate(points),
                together,
                inputs_of(problem, [row], known),
                gains,
                ends[gains].reshape(-1, 2),
                row.label,
                row.doubt,
                bool(problem.active(row)),
            )
        except CaseError as error:
            faults += error.faults
    if faults:
        raise CaseError(*faults)
    return emulators


def inputs_of(problem: Problem, rows: Sequence[Row], known: dict[int, Emulator]) -> Inputs:
    """Return what the emulators of some rows depend on, of which rows of earlier stages have emulators."""
    return Inputs(problem.inputs(rows), tuple(known[number].score for number in problem.through(rows)))


def evidence_of(problem: Problem, emulators: dict[int, Emulator]) -> list[Evidence]:
    """Return the rows among these that are learned from."""
    return [
        Evidence(emulator, problem.rows[number].value, problem.rows[number].doubt)
        for number, emulator in emulators.items()
        if problem.rows[number].learned
    ]


def store(done: Identification, folder: Path) -> list[Path]:
    """Write table, numbers, figures, and a machine file with the most probable values for each campaign.
    Return the files.
    """
    files = [folder / "identify.md", folder / "identify.json"]
    write_whole(files[0], "\n".join(lines(done)) + "\n")
    write_whole(files[1], json_text(done))
    files.append(save_figure(draw_corner(done), folder / "corner.png"))
    files.append(save_figure(draw_rows(done), folder / "rows.png"))
    for campaign in dict.fromkeys(one.campaign for one in done.problem.rows):
        file = folder / f"{'-'.join(filter(None, (done.problem.base.name, campaign)))}.toml"
        try:
            write_whole(file, machine_at_mode(done, campaign).to_toml())
        except CaseError:  # the case without the changes of any row need not hold them
            continue
        files.append(file)
    return files


def machine_at_mode(done: Identification, campaign: str = "") -> Case | Machine:
    """Return the case with the most probable values of the unknowns that act in a campaign."""
    acting = [
        number
        for number, one in enumerate(done.problem.unknowns)
        if one.keys and one.campaign in ("", campaign)
    ]
    changes = done.problem.changes(np.array(acting, dtype=int), done.posterior.mode)
    return changed(done.problem.base, changes)
