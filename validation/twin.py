"""Synthetic twins of an identification with a charge: how often its intervals hold the values drawn.

    python -m validation.twin [--twins 40] [--folder FOLDER]

Each twin is two runs with stiffness, mass and placement of the balls drawn at random, and with the stated
scatter added to what is read.  The emulators are those of the members of ``identify/piston.toml``, all with
another placement.
"""

import argparse
from pathlib import Path

import numpy as np
from scipy import stats

from nutamill.studies.axes import Member
from nutamill.studies.identify.emulator import Emulator
from nutamill.studies.identify.identify import learn
from nutamill.studies.identify.posterior import Evidence, sample_posterior
from nutamill.studies.identify.problem import Problem, read_problem
from nutamill.studies.measurand import value_in
from nutamill.studies.sweep import run_all
from nutamill.studies.workers import LocalProcesses

FILE = Path(__file__).parent / "identify" / "piston.toml"
STEPS = 400
"""Steps of the chain of each twin [1]."""


def twins(problem: Problem, emulators: list[Emulator], count: int, folder: Path) -> np.ndarray:
    """Return the rank of each drawn value among the points of its posterior, (count, n_unknowns)."""
    rng = np.random.default_rng(1)
    truths = rng.random((count, len(problem.unknowns)))
    members = [
        Member({"twin": str(k), "row": row.label}, problem.case_at(row, truth).with_("run.seed", 100 + k))
        for k, truth in enumerate(truths)
        for row in problem.rows
    ]
    readings = [row.measurand.what for row in problem.rows]
    outcomes = iter(run_all(members, folder / "twins", LocalProcesses(1), readings))
    ranks = []
    for number, truth in enumerate(truths):
        evidence = []
        for row, emulator in zip(problem.rows, emulators, strict=True):
            measured = value_in(next(outcomes), row.measurand.what).mean + row.scatter * rng.standard_normal()
            evidence.append(Evidence(emulator, measured, row.doubt))
        points = sample_posterior(evidence, len(truth), number, most_steps=STEPS).points
        ranks.append(np.mean(points < truth, axis=0))
    return np.array(ranks)


def main() -> None:
    """Run the twins and print what the intervals hold."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--twins", type=int, default=40)
    parser.add_argument("--folder", type=Path, default=Path("identified") / "piston")
    given = parser.parse_args()
    problem = read_problem(FILE)
    given.folder.mkdir(parents=True, exist_ok=True)
    emulators, _ = learn(problem, given.folder, lambda: LocalProcesses(1), log=print)
    ranks = twins(problem, emulators, given.twins, given.folder)
    low, high = stats.binom.interval(0.99, given.twins, 0.9)
    print(f"{given.twins} twins with 20 and 150 balls, intervals of 90 %; 99 % band of the binomial:")
    for unknown, column in zip(problem.unknowns, ranks.T, strict=True):
        inside = int(np.sum((column >= 0.05) & (column <= 0.95)))
        histogram = np.histogram(column, bins=5, range=(0.0, 1.0))[0]
        print(f"{unknown.name:10} inside {inside} (band {low:.0f} to {high:.0f}), ranks {histogram.tolist()}")
    for row, emulator in zip(problem.rows, emulators, strict=True):
        print(
            f"{row.label}: emulator's error {emulator.check.error:.2g}, members spread by "
            f"{emulator.check.spread:.2g} {row.measurand.unit}"
        )


if __name__ == "__main__":
    main()
