"""Forecast of a run by its trial, beside the time that the run took, for six cases.

    python benchmarks/forecasts.py               all six, some minutes with compiled kernels
    python benchmarks/forecasts.py pellets       some of them

Both are processor time of this process on one thread, so that other programs on the machine do not count: a
trial is `nutamill.simulation.trial.trial_rate`, a run is measured from its first row to the end of its
recording. Settling is in neither; the large charge begins in a loose bed, which is quicker to make.
"""

import datetime
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import nutamill as nm
from nutamill.base.provenance import git_commit, processor
from nutamill.simulation import runs
from nutamill.simulation.setup.bed import loose_bed
from nutamill.simulation.trial import trial_rate

SHORT = {"run.threads": 1, "drive.ramp": "7000 rpm/s", "run.snapshots.last": "10 ms"}
"""Settings that all share: at full speed after a tenth of a second."""

SOME = {"charge.mass": "150 g", "run.until": "0.3 s"}

CASES = {
    "empty": ("numill", {"charge.kind": "none", "run.until": "10 s"}),
    "pellets": ("numill", SOME),
    "mixed sizes": ("numill", SOME | {"charge.sizes": [["4 mm", 0.3], ["6 mm", 0.7]]}),
    "clumps": ("numill-2025", {"charge.set": "coarse-sand", "charge.count": 400, "run.until": "0.05 s"}),
    "mesh": ("numill", SOME | {"chamber.mesh": "chamber"}),
    "large": ("numill", {"charge.diameter": "3 mm", "charge.count": 8000, "run.until": "0.03 s"}),
}
"""Name of a case: its base and what is set."""

LOOSE = ("large",)
"""Cases that begin in a loose bed."""


def write_tube(path: Path, facets: int = 48) -> Path:
    """Write the inside of the published chamber as a closed prism to a text STL file [mm]."""
    angle = 2.0 * np.pi * np.arange(facets) / facets
    ring = 70.0 * np.column_stack([np.cos(angle), np.sin(angle)])
    low, high = (np.column_stack([ring, np.full(facets, z)]) for z in (-350.0, -122.0))
    middle = np.array([0.0, 0.0, 1.0])
    lines = ["solid chamber"]
    for i in range(facets):
        j = (i + 1) % facets
        ends = [(-350.0 * middle, low[j], low[i]), (-122.0 * middle, high[i], high[j])]
        for corners in [(low[i], low[j], high[j]), (low[i], high[j], high[i]), *ends]:
            vertices = [f"vertex {x!r} {y!r} {z!r}" for x, y, z in np.array(corners).tolist()]
            lines += ["facet normal 0 0 0", "outer loop", *vertices, "endloop", "endfacet"]
    path.write_text("\n".join([*lines, "endsolid chamber", ""]))
    return path


def case_of(name: str, folder: Path) -> nm.Case:
    """Return a case of `CASES`. Its mesh is written to `folder`."""
    base, settings = CASES[name]
    case = nm.load_case(base)
    for key, value in (SHORT | settings).items():
        given = (
            {"file": str(write_tube(folder / "chamber.stl")), "unit": "mm"} if value == "chamber" else value
        )
        case = case.with_(key, given)
    return case


def measured(case: nm.Case, path: Path) -> float:
    """Run a case and return the processor time from its first row to its end [s]."""
    begun = []
    record_first_row = runs.record_first_row

    def first_row(*arguments):
        record_first_row(*arguments)
        begun.append(time.process_time())

    runs.record_first_row = first_row
    try:
        runs.run(case, path).close()
    finally:
        runs.record_first_row = record_first_row
    return time.process_time() - begun[0]


def main(names: list[str]) -> None:
    """Run the cases `names` and print a line for each."""
    print(f"{datetime.date.today()}, {processor()}, commit {git_commit()}")
    print(f"{'case':12} {'simulated':>9} {'forecast':>9} {'measured':>9} {'forecast/measured':>18}")
    settled_bed = runs.settled_bed
    for name in names or CASES:
        with tempfile.TemporaryDirectory() as folder:
            case = case_of(name, Path(folder))
            runs.settled_bed = (lambda machine, _: loose_bed(machine)) if name in LOOSE else settled_bed
            settled_bed(case.machine) if name not in LOOSE else None
            rate = trial_rate(case.machine, time.process_time)
            took = measured(case, Path(folder) / "run.h5")
        forecast = float("nan") if rate is None else rate * case.run.end
        print(
            f"{name:12} {case.run.end:7.2f} s {forecast:7.1f} s {took:7.1f} s {forecast / took:18.2f}",
            flush=True,
        )


if __name__ == "__main__":
    main(sys.argv[1:])
