"""Feed the program damaged and hostile inputs of one kind and count what becomes of them.

``python -m validation.robustness results --cases 20000`` reads damaged result files.  The exit code is 1 if
an input was neither used nor refused in words and in time, or if the program took more memory than it may.
"""

import argparse
import importlib
import os
import resource
import sys
import time
from collections import Counter
from contextlib import suppress
from pathlib import Path

from nutamill import __version__
from nutamill.base.provenance import processor
from validation.robustness.outcome import KINDS, outcome

PLACE = Path(__file__).resolve().parent.parent / "results"
MOST_MEMORY = 1.5e9
"""Memory that reading damaged inputs may take [bytes]."""
SHOWN = 20
"""Bad outcomes that are printed in full [1]."""


def main(words: list[str]) -> int:
    """Run the attempts of one kind and write their table."""
    parser = argparse.ArgumentParser(
        prog="python -m validation.robustness", description="Damaged and hostile inputs."
    )
    parser.add_argument("kind", choices=sorted(path.stem for path in Path(__file__).parent.glob("*s.py")))
    parser.add_argument("--cases", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--longest", type=float, default=30.0, help="processor time an answer may take, in seconds"
    )
    given = parser.parse_args(words)
    module = importlib.import_module(f"validation.robustness.{given.kind}")
    counts: dict[str, Counter] = {}
    bad: list[str] = []
    began = time.monotonic()
    with suppress(KeyboardInterrupt):  # the table then has what was tried so far
        for group, name, act in module.attempts(given.cases, given.seed):
            found = outcome(act, given.longest)
            counts.setdefault(group, Counter())[found.kind] += 1
            if not found.good:
                bad.append(f"{name}: {found.kind}: {found.detail}")
                print(bad[-1], flush=True)
    tried = sum(one.total() for one in counts.values())
    memory = 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    lines = [
        f"python -m validation.robustness {given.kind} --cases {given.cases} --seed {given.seed}",
        f"nutamill {__version__}, {time.strftime('%Y-%m-%d', time.gmtime())}, {processor()}, "
        f"{os.cpu_count()} cores",
        "",
        f"{'damage':24}" + "".join(f"{kind:>10}" for kind in KINDS),
        *(
            f"{group:24}" + "".join(f"{counts[group][kind]:10d}" for kind in KINDS)
            for group in sorted(counts)
        ),
        f"{'all':24}" + "".join(f"{sum(one[kind] for one in counts.values()):10d}" for kind in KINDS),
        *([] if tried == given.cases else [f"stopped after {tried} of {given.cases}"]),
        "",
        f"largest memory {memory / 1e6:.0f} MB of {MOST_MEMORY / 1e6:.0f} MB allowed, "
        f"{time.monotonic() - began:.0f} s",
        *bad[:SHOWN],
    ]
    print("\n".join(lines))
    PLACE.mkdir(exist_ok=True)
    (PLACE / f"robustness-{given.kind}.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return 1 if bad or memory > MOST_MEMORY else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
