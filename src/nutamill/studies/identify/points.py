"""The file of a stage's points: the same call again runs the same members."""

import hashlib
import json
from pathlib import Path

import numpy as np

from nutamill.base.atomic_file import write_whole
from nutamill.base.errors import CaseError, Fault
from nutamill.studies.identify.problem import Problem


def read_points(problem: Problem, stage: int, folder: Path) -> np.ndarray | None:
    """Return the stored points of a stage, (n, n_unknowns), None where there is no file. Unknowns that do not
    decide on them are in the middle of their ranges.

    Raises
    ------
    CaseError : a file that is none of them
    """
    file = _file(problem, stage, folder)
    if not file.exists():
        return None
    places = problem.deciding(stage)
    try:
        stored = np.array(json.loads(file.read_text(encoding="utf-8")), dtype=float)
        points = np.full((problem.stages[stage].members, len(problem.unknowns)), 0.5)
        points[:, places] = stored.reshape(len(points), len(places))
    except (OSError, ValueError, TypeError) as error:
        what = f"holds no points of a stage ({error})"
        raise CaseError(Fault(str(file), what, "Delete it and repeat the command")) from None
    return points


def write_points(problem: Problem, stage: int, folder: Path, points: np.ndarray) -> None:
    """Write the points (n, n_unknowns) of a stage."""
    write_whole(_file(problem, stage, folder), json.dumps(points[:, problem.deciding(stage)].tolist()))


def _file(problem: Problem, stage: int, folder: Path) -> Path:
    """Return the file of a stage, with a word in its name that changes when its points may be others."""
    before = [one.name for one in problem.stages[:stage]]
    cutting = [row for row in problem.rows if row.learned and not set(before).isdisjoint(row.stages)]
    deciding = [problem.unknowns[k] for k in problem.deciding(stage)]
    asked = [
        [one.name for one in deciding],
        [one._replace(reason="", stages=(), plus=None) for one in deciding if cutting],
        [(row.case.digest, row.quantity, row.value, row.doubt) for row in cutting],
        [(one.name, one.members, one.cut, one.draws, *one.active) for one in problem.stages[: stage + 1]],
        problem.seed,
    ]
    word = hashlib.sha256(json.dumps(asked).encode()).hexdigest()[:12]
    return folder / f"points-{stage + 1}-{word}.json"
