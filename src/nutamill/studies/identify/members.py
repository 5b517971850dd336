"""The members of a stage: points, their cases, and what the runs of their rows give."""

import re
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from nutamill.analysis.values import Reading
from nutamill.base.errors import CaseError, Fault
from nutamill.case import Case, Machine
from nutamill.result import is_finished
from nutamill.studies.axes import Member
from nutamill.studies.identify.problem import FEWEST_PER_UNKNOWN, Problem, Row
from nutamill.studies.identify.values import read_values
from nutamill.studies.measurand import rest_frequency, value_in
from nutamill.studies.sweep import Report, run_all
from nutamill.studies.table import Outcome
from nutamill.studies.workers import Workers

SHOWN = 3
"""Reasons that are shown of members that are refused or that failed [1]."""

NUMBER = re.compile(r"(?<![\w^])-?\d+(\.\d+)?(e[+-]?\d+)?\b")
"""A number in a message."""

Log = Callable[[str], None]


class Ran(NamedTuple):
    """What the members of a stage gave."""

    points: np.ndarray
    """Shares of the ranges, of the members that the drawing holds, (n, n_unknowns)."""
    values: dict[int, np.ndarray]
    """Values (n,) of each row that the stage runs, by its number, SI; NaN where a run failed."""
    refused: int
    """Members that the drawing cannot hold [1]."""


def run_members(
    problem: Problem,
    stage: str,
    points: np.ndarray,
    folder: Path,
    workers: Callable[[], Workers],
    report: Report | None = None,
    log: Log | None = None,
) -> Ran:
    """Run all rows of a stage at all points that the drawing can hold.

    Every run is stored in `folder`/runs, named by its case, and its values in `folder`: what is there is
    read, the rest is run.

    Raises
    ------
    CaseError : fewer members are left for a row than its unknowns need
    """
    rows = {number: row for number, row in enumerate(problem.rows) if stage in row.stages}
    cases, held = sound_cases(problem, list(rows.values()), points, stage, log)
    known = read_values(folder)
    planned: dict[str, Member] = {}
    for member, made in zip(np.flatnonzero(held), cases, strict=True):
        for row, case in zip(rows.values(), made, strict=True):
            if not isinstance(row.measurand.what, int) and not known.has(case.digest, row.reading):
                planned.setdefault(case.digest, Member({"member": str(member + 1), "row": row.label}, case))
    whats = [row.measurand.what for row in rows.values()]
    readings = tuple(dict.fromkeys(what for what in whats if isinstance(what, Reading)))
    if known.others() and log is not None:
        log(f"made by the kernels of another version, and read as they are: {known.others()} runs")
    outcomes: list[Outcome] = []
    if planned:
        outcomes = run_all(list(planned.values()), folder / "runs", workers(), readings, report, log)
    _log_reasons(
        [outcome.state for outcome in outcomes if not is_finished(outcome.state)],
        f"stage {stage}",
        f"of {len(outcomes)} runs failed",
        log,
    )
    by_case = {outcome.member.case.digest: outcome for outcome in outcomes if is_finished(outcome.state)}
    values_of_rows: dict[int, np.ndarray] = {}
    for place, (number, row) in enumerate(rows.items()):
        column = []
        for made in cases:
            case = made[place]
            if known.has(case.digest, row.reading):
                pass
            elif isinstance(row.measurand.what, int):
                known.add(case.digest, row.reading, rest_frequency(case, row.measurand.what))
            elif (outcome := by_case.get(case.digest)) is not None:
                value = value_in(outcome, row.measurand.what, row.average).mean
                known.add(case.digest, row.reading, float(value))
            column.append(known.value(case.digest, row.reading))
        values_of_rows[number] = np.array(column)
    known.write()
    return Ran(points[held], values_of_rows, int(np.sum(~held)))


def refuse_few(problem: Problem, number: int, values: np.ndarray) -> None:
    """Raise CaseError where too few members of a row have a value."""
    row = problem.rows[number]
    left, unknowns = int(np.sum(np.isfinite(values))), problem.count_inputs([row])
    unknowns = 0 if problem.drawn(row) else unknowns
    if left < max(2, FEWEST_PER_UNKNOWN * unknowns):
        what = (
            f"only {left} of its members have a steady value, {unknowns} unknowns need "
            f"{FEWEST_PER_UNKNOWN * unknowns}"
        )
        raise CaseError(Fault(row.label, what, "Narrow the ranges, run longer, or take more members"))


def sound_cases(
    problem: Problem, rows: Sequence[Row], points: np.ndarray, stage: str, log: Log | None
) -> tuple[list[list[Case | Machine]], np.ndarray]:
    """Make the cases of rows at all points. Return those of each point that the drawing can hold, and which
    points these are, (n,).

    Raises
    ------
    CaseError : too few are left
    """
    cases: list[list[Case | Machine]] = []
    held = np.zeros(len(points), dtype=bool)
    reasons: list[str] = []
    kinds = [(row.case.digest, *problem.columns(row)) for row in rows]
    for number, point in enumerate(points):
        made: dict[tuple, Case | Machine] = {}  # several rows are read from one run
        try:
            for row, kind in zip(rows, kinds, strict=True):
                if kind not in made:
                    made[kind] = problem.case_at(row, point)
            cases.append([made[kind] for kind in kinds])
            held[number] = True
        except CaseError as error:
            reasons.append(str(error.faults[0]))
    _log_reasons(reasons, f"stage {stage}", f"of {len(points)} members refused", log)
    acting = problem.count_inputs(rows)
    acting = 0 if any(problem.drawn(row) for row in rows) else acting
    least = max(2, FEWEST_PER_UNKNOWN * acting)
    if len(cases) < least:
        what = (
            f"the drawing cannot hold {len(reasons)} of {len(points)} members, {acting} unknowns need {least}"
        )
        raise CaseError(Fault(f"stage {stage}", what, f"Narrow the ranges. {reasons[0]}"))
    return cases, held


def _log_reasons(reasons: Sequence[str], where: str, what: str, log: Log | None) -> None:
    """Log how many there are, and the most frequent reasons."""
    if reasons and log is not None:
        log(f"{where}: {len(reasons)} {what}")
        for reason, count in Counter(_without_numbers(reason) for reason in reasons).most_common(SHOWN):
            log(f"  {count} x {reason}")


def _without_numbers(reason: str) -> str:
    """Return a reason without the value that was given, and with dots for the other numbers, so that equal
    reasons are counted together.
    """
    return NUMBER.sub("...", reason.partition(", got ")[0])
