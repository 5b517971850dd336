"""Compare the first start of a mill, with nothing compiled, with the second, which loads what was compiled.

    python -m validation.first_start              a few pellets: compiles for minutes
    python -m validation.first_start empty        without a charge
    python -m validation.first_start both         one after the other, and write the table

Each start is a process of its own, as a user makes it.  The cache folder is empty before the first.  The exit
code is 1 if a bit of a series, of a snapshot or of a statistic differs.
"""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import nutamill as nm
from nutamill import __version__
from nutamill.base.cache_folder import VARIABLE
from nutamill.base.provenance import processor

TABLE = Path(__file__).parent / "results" / "first-start.txt"
SHORT = ["drive.ramp=7000 rpm/s", "run.until=20 ms", "run.checkpoint=10 ms", "run.snapshots.last=10 ms"]
CASES = {
    "empty": ["charge.kind=none", *SHORT],
    "pellets": ["charge.kind=spheres", "charge.mass=50 g", *SHORT],
}
"""Changes of the published mill."""


def start(changes: list[str], file: Path, cache: Path) -> float:
    """Run the mill in a process of its own and return the time it took [s]."""
    words = [word for change in changes for word in ("-s", change)]
    program = "import sys; from nutamill.cli import app; app(sys.argv[1:])"
    command = [sys.executable, "-P", "-c", program, "run", "numill", *words, "--to", str(file)]
    paths = os.pathsep.join([str(Path(nm.__file__).parents[1]), os.environ.get("PYTHONPATH", "")])
    began = time.monotonic()
    subprocess.run(
        command,
        env=os.environ | {VARIABLE: str(cache), "PYTHONPATH": paths},
        check=True,
        stdout=subprocess.DEVNULL,
    )
    return time.monotonic() - began


def arrays(file: Path) -> dict[str, np.ndarray]:
    """Return every series, statistic and array of a snapshot by its name."""
    with nm.open_result(file) as result:
        read = {f"series {name}": one.values for name, one in result.series.variables.items()}
        for number, moment in enumerate(result.snapshots):
            read |= {f"snapshot {number} {name}": array for name, array in moment.items()}
        if result.summary.get("particles"):
            read |= {f"statistic {name}": one.values for name, one in result.statistics.variables.items()}
    return read


def compared(name: str) -> tuple[str, bool]:
    """Return a line on a case, and whether both starts have the same bits."""
    with tempfile.TemporaryDirectory() as folder:
        first, second, cache = (Path(folder) / part for part in ("first.h5", "second.h5", "cache/kernels"))
        cache.mkdir(parents=True)
        times = [start(CASES[name], file, cache) for file in (first, second)]
        one, other = arrays(first), arrays(second)
    wrong = [key for key in one.keys() | other.keys() if not _same(one.get(key), other.get(key))]
    verdict = "the same bits" if not wrong else f"{len(wrong)} differ, first {min(wrong)}"
    line = f"{name:10} {times[0]:8.0f} s {times[1]:8.0f} s   {len(one):4d} arrays: {verdict}"
    return line, not wrong


def _same(one: np.ndarray | None, other: np.ndarray | None) -> bool:
    if one is None or other is None or one.dtype != other.dtype or one.shape != other.shape:
        return False
    return one.tolist() == other.tolist() if one.dtype == object else one.tobytes() == other.tobytes()


def main(words: list[str]) -> int:
    """Compare the cases that are asked for and print a line for each."""
    asked = words[0] if words else "pellets"
    lines, good = [f"{'mill':10} {'first':>10} {'second':>10}"], True
    for name in CASES if asked == "both" else [asked]:
        line, same = compared(name)
        good &= same
        lines.append(line)
    print("\n".join(lines), flush=True)
    if asked == "both":
        head = [
            "python -m validation.first_start both",
            f"nutamill {__version__}, {time.strftime('%Y-%m-%d', time.gmtime())}, {processor()}, "
            f"{os.cpu_count()} cores",
            "",
        ]
        TABLE.write_text("\n".join([*head, *lines]) + "\n", encoding="utf-8")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
