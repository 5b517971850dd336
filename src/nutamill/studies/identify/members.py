"""The members of a stage: points, their cases, and what the runs of their rows give."""

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
from nutamill.studies.measurand import rest_frequency, value_in
from nutamill.studies.sweep import Report, run_all
from nutamill.studies.workers import Workers

SHOWN = 3
"""Reasons that are shown of members that are refused or that failed [1]."""

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

    Every run is stored in `folder`, named by its case: what is there is read, the rest is run.

    Raises
    ------
    CaseError : fewer members are left for a row than its unknowns need
    """
    rows = {number: row for number, row in enumerate(problem.rows) if stage in row.stages}
    cases, held = sound_cases(problem, list(rows.values()), points, stage, log)
    planned: dict[str, Member] = {}
    named = [one.name for one in problem.unknowns]
    for point, made in zip(points[held], cases, strict=True):
        values = {name: f"{value:.6g}" for name, value in zip(named, problem.values(point), strict=True)}
        for row, case in zip(rows.values(), made, strict=True):
            if not isinstance(row.measurand.what, int):
                planned.setdefault(case.digest, Member(values | {"row": row.label}, case))
    whats = [row.measurand.what for row in rows.values()]
    readings = tuple(dict.fromkeys(what for what in whats if isinstance(what, Reading)))
    outcomes = run_all(list(planned.values()), folder, workers(), readings, report, log) if planned else []
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
            if isinstance(row.measurand.what, int):
                column.append(rest_frequency(made[place], row.measurand.what))
            elif (outcome := by_case.get(made[place].digest)) is not None:
                column.append(value_in(outcome, row.measurand.what, row.average).mean)
            else:
                column.append(np.nan)
        values_of_rows[number] = np.array(column)
    return Ran(points[held], values_of_rows, int(np.sum(~held)))


def refuse_few(problem: Problem, number: int, values: np.ndarray) -> None:
    """Raise CaseError where too few members of a row have a value."""
    row = problem.rows[number]
    left, unknowns = int(np.sum(np.isfinite(values))), len(problem.columns(row))
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
    for number, point in enumerate(points):
        try:
            cases.append([problem.case_at(row, point) for row in rows])
            held[number] = True
        except CaseError as error:
            reasons.append(str(error.faults[0]))
    _log_reasons(reasons, f"stage {stage}", f"of {len(points)} members refused", log)
    acting = {int(k) for row in rows for k in problem.columns(row)}
    if len(cases) < max(2, FEWEST_PER_UNKNOWN * len(acting)):
        what = (
            f"the drawing cannot hold {len(reasons)} of {len(points)} members, {len(acting)} unknowns need "
            f"{max(2, FEWEST_PER_UNKNOWN * len(acting))}"
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
    """Return a reason without the value that was given, so that equal reasons are counted together."""
    return reason.partition(", got ")[0]
