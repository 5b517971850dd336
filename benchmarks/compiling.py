"""Processor time that compiling takes, from an empty cache: the mechanism, the charge, and more laws.

    python benchmarks/compiling.py

Each row is a process of its own, all with one cache that is empty at first.  It compiles what a run of that
kind calls, as `nutamill.simulation.warm_up` does.
"""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from nutamill import __version__
from nutamill.base.cache_folder import VARIABLE
from nutamill.base.provenance import processor

TABLE = Path(__file__).parent / "results" / "compiling.txt"
ROWS = {
    "mechanism": (),
    "charge, standard law": ("linear", "displacement", "type_c", "none", "none"),
    "charge, Hertz, incremental, type A": ("hertz", "incremental", "type_a", "none", "none"),
    "charge, standard law, viscous film": ("linear", "displacement", "type_c", "none", "viscous"),
}
"""What is compiled: the names of the law, or nothing for a mechanism without a charge."""


def compile_here(names: list[str]) -> None:
    """Compile the kernels of runs with a law, or without a charge, and print the time it took [s]."""
    from nutamill.simulation import warm_up

    began = time.process_time()
    if names:
        warm_up.march_ball(names)
        warm_up.read_ball(names)
        warm_up.march_both(names)
    else:
        warm_up.march_turntable()
    print(time.process_time() - began)


def main() -> None:
    """Compile row after row, and write the table."""
    lines = [
        "python benchmarks/compiling.py",
        f"nutamill {__version__}, {time.strftime('%Y-%m-%d', time.gmtime())}, {processor()}, "
        f"{os.cpu_count()} cores",
        "",
        f"{'compiled, one after another':36} {'processor':>10}",
    ]
    with tempfile.TemporaryDirectory() as cache:
        for name, law in ROWS.items():
            command = [sys.executable, __file__, "here", *law]
            run = subprocess.run(
                command, env=os.environ | {VARIABLE: cache}, check=True, capture_output=True, text=True
            )
            lines.append(f"{name:36} {float(run.stdout):8.1f} s")
            print(lines[-1], flush=True)
    TABLE.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    if sys.argv[1:2] == ["here"]:
        compile_here(sys.argv[2:])
    else:
        main()
