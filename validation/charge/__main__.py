"""Run the comparisons and print their table.

    python -m validation.charge [CASE ...] [--list]

Without a case all are run, and the table is kept in `validation/results/charge.txt`.
"""

import os
import platform
import sys
import time
from pathlib import Path

from nutamill import __version__
from nutamill.base.provenance import processor
from validation.charge import bulk, chung_ooi, hysteretic, mfix, penetration, recorded, rolling
from validation.charge.rows import lines

CASES = {
    **chung_ooi.CASES,
    **rolling.CASES,
    **mfix.CASES,
    **recorded.CASES,
    **hysteretic.CASES,
    **bulk.CASES,
    **penetration.CASES,
}
TABLE = Path(__file__).parent.parent / "results" / "charge.txt"


def main(names: list[str]) -> int:
    """Run the cases of these names, or all; 1 if a row fails."""
    if "--list" in names:
        print("\n".join(CASES))
        return 0
    unknown = [name for name in names if name not in CASES]
    if unknown:
        print(f"no case {', '.join(unknown)}; there are: {', '.join(CASES)}")
        return 2
    date = time.strftime("%Y-%m-%d", time.gmtime())
    text = [
        f"nutamill {__version__}, charge engine beside published references, {date}",
        f"{processor()}, {os.cpu_count()} cores, {platform.system()}",
        "",
    ]
    passed, total = 0, 0
    for name in names or CASES:
        begun = time.monotonic()
        rows = CASES[name]()
        print("\n".join(lines(name, rows)), flush=True)
        print(f"({time.monotonic() - begun:.0f} s)\n", flush=True)
        text += lines(name, rows)
        passed, total = passed + sum(row.passes for row in rows), total + len(rows)
    text.append(f"{passed} of {total} rows pass")
    print(text[-1])
    if not names:
        TABLE.parent.mkdir(exist_ok=True)
        TABLE.write_text("\n".join(text) + "\n", encoding="utf-8")
    return 0 if passed == total else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
