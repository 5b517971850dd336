"""The charge's force on soft mounts as MCA 2026 infers it, over the posterior of the NuMill: force and torque
less those of the empty mill.

    python -m validation.superposition FOLDER [--learn TITLE]

FOLDER is that of ``nutamill identify validation/identify/numill.toml --until "pellets, soft"`` with the same
titles.
"""

import argparse
import json
from pathlib import Path

import numpy as np

from nutamill.studies.identify.identification import LEVELS
from nutamill.studies.identify.identify import learn
from nutamill.studies.identify.problem import read_problem
from nutamill.studies.workers import LocalProcesses

FILE = Path(__file__).parent / "identify" / "numill.toml"
SPEEDS = (723.0 / 700.0) ** 2
"""Force of the empty mill at 723 rpm over that at 700 rpm, as the paper scales it [1]."""
CRANK_RADIUS = 0.039
"""Crank radius of the paper [m]."""
ROWS = {
    "radial": "radial force, pellets, 723 rpm, as the authors superpose",
    "torque": "torque, pellets, 723 rpm",
    "empty": "force, empty, 700 rpm",
    "friction": "torque, empty, 700 rpm",
}
"""Rows of the identification by what they are here."""
MEASURED = {
    "radial force of the charge (N)": 254.0,
    "tangential force of the charge (N)": 230.0,
    "lag of the charge's force (deg)": 42.0,
}
"""What the authors infer."""


def main() -> None:
    """Print the intervals of the three numbers."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--learn", action="append", default=[])
    given = parser.parse_args()
    problem = read_problem(FILE, "pellets, soft", given.learn)
    emulators, _ = learn(problem, given.folder, lambda: LocalProcesses(1))
    stored = json.loads((given.folder / "identify.json").read_text(encoding="utf-8"))
    low, high = (np.array([getattr(one, end) for one in problem.unknowns]) for end in ("low", "high"))
    points = (np.array(stored["posterior"]["points"]) - low) / (high - low)
    rng = np.random.default_rng(problem.seed)
    drawn = {}
    for name, label in ROWS.items():
        number = next(k for k, row in enumerate(problem.rows) if row.label == label)
        mean, error = emulators[number].predict(points)
        off = np.hypot(error, problem.rows[number].doubt)
        drawn[name] = mean + off * rng.standard_normal(len(points))
    radial = drawn["radial"] - SPEEDS * drawn["empty"]
    tangential = (drawn["torque"] - drawn["friction"]) / CRANK_RADIUS
    computed = (radial, tangential, np.degrees(np.arctan2(tangential, radial)))
    print(f"{'':36} {'measured':>9} {'5 %':>7} {'50 %':>7} {'95 %':>7}")
    for (name, measured), values in zip(MEASURED.items(), computed, strict=True):
        print(f"{name:36} {measured:9.0f} " + " ".join(f"{one:7.0f}" for one in np.quantile(values, LEVELS)))


if __name__ == "__main__":
    main()
