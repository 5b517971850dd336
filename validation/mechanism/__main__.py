"""Run the problems and print their table.

    python -m validation.mechanism [PROBLEM ...] [--list]

Without a problem all are run, and the table is kept in `validation/results/mechanism.txt`.
"""

import math
import os
import platform
import sys
import time
from pathlib import Path

from nutamill import __version__
from nutamill.base.provenance import processor
from nutamill.simulation.warm_up import warm_up_mechanism
from validation.mechanism.problems import PROBLEMS, Problem
from validation.mechanism.simulate import Run, simulate

TABLE = Path(__file__).parents[1] / "results" / "mechanism.txt"
HEAD = (
    f"{'problem':17} {'compared':41} {'step':>7} {'error':>9} {'limit':>8} {'energy':>9} {'limit':>8} {'gaps':>8} {'rates':>8}"
    f" {'order':>5} {'steps':>7} {'us/step':>7} {'s':>6}  ok"
)
NOTE = """\
error: largest against the reference, in the unit named; energy: largest residual of the energy ledger [J]; gaps, rates: of the
constraints at the end [m or rad, and per second]; order: from the errors at this step and half of it (Bricard: from three steps);
s: wall time of the run on one core, compiled."""


def order(problem: Problem, runs: list[Run]) -> float:
    """Observed order of accuracy, from halvings of the step."""
    if problem.error is not None:
        first, second = (problem.error(run) for run in runs[:2])
        return math.log2(first / second) if second > 1e-11 else math.nan
    values = [problem.probe(run) for run in runs]
    return math.log2(abs((values[0] - values[1]) / (values[1] - values[2])))


def row(problem: Problem) -> tuple[str, bool]:
    """One line of the table, and whether the problem is solved well enough."""
    runs = [simulate(problem.file, halvings) for halvings in range(2 if problem.error else 3)]
    run = runs[0]
    error = problem.error(run) if problem.error else math.nan
    passes = (problem.error is None or error <= problem.limit) and run.energy_drift <= problem.energy_limit
    found = order(problem, runs)
    shown = [
        f"{problem.file:17}",
        f"{problem.quantity + f' [{problem.unit}]':41}",
        f"{1e6 * run.step:4.0f} us",
        f"{error:9.1e}" if problem.error else f"{'-':>9}",
        f"{problem.limit:8.0e}" if math.isfinite(problem.limit) else f"{'-':>8}",
        f"{run.energy_drift:9.1e}",
        f"{problem.energy_limit:8.0e}" if math.isfinite(problem.energy_limit) else f"{'-':>8}",
        f"{run.gap:8.0e}",
        f"{run.gap_rate:8.0e}",
        f"{found:5.2f}" if math.isfinite(found) else f"{'exact':>5}",
        f"{run.steps:7d}",
        f"{1e6 * run.seconds / run.steps:7.2f}",
        f"{run.seconds:6.2f}",
    ]
    return " ".join(shown) + ("  yes" if passes else "  NO"), passes


def main(names: list[str]) -> int:
    """Run the problems of these names, or all; 1 if a limit is missed."""
    known = [problem.file for problem in PROBLEMS]
    if "--list" in names:
        print("\n".join(known))
        return 0
    if unknown := [name for name in names if name not in known]:
        print(f"no problem {', '.join(unknown)}; there are: {', '.join(known)}")
        return 2
    warm_up_mechanism()
    simulate("universal-joint")
    date = time.strftime("%Y-%m-%d", time.gmtime())
    text = [f"nutamill {__version__}, mechanism engine beside published problems, {date}"]
    text += [f"{processor()}, {os.cpu_count()} cores, {platform.system()}", "", HEAD]
    print("\n".join(text))
    solved = 0
    chosen = [problem for problem in PROBLEMS if not names or problem.file in names]
    for problem in chosen:
        line, passes = row(problem)
        print(line, flush=True)
        text.append(line)
        solved += passes
    text += ["", NOTE, f"{solved} of {len(chosen)} problems within their limits"]
    print("\n".join(text[-3:]))
    if not names:
        TABLE.parent.mkdir(exist_ok=True)
        TABLE.write_text("\n".join(text) + "\n", encoding="utf-8")
    return 0 if solved == len(chosen) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
