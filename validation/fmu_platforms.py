"""Libraries of exported machines for every platform: what was linked, what it asks for, what was run.

    python -m validation.fmu_platforms       the table, and write it

Needs the extras fmu and cross.  Emission for five platforms takes some minutes the first time.
"""

import sys
import tempfile
import zipfile
from datetime import date
from pathlib import Path

import numpy as np

from nutamill import __version__
from nutamill.base.provenance import processor
from nutamill.case import Case, load_case
from nutamill.export.fmu.linking import PLATFORMS, this_platform
from nutamill.export.fmu.write import export_machine

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "cross"))
from fmu_session import marched, opened, recorded_rows
from library_symbols import of_python, symbols

TABLE = Path(__file__).parent / "results" / "fmu-platforms.txt"
CASES = {
    "mechanism": ("numill", ["charge.kind=none", 'run.until="0.06 s"', "run.series_rate=1000 Hz"]),
    "whole": (
        "piston",
        ["charge.count=150", 'run.until="0.06 s"', "run.series_rate=1000 Hz", "run.threads=1"],
    ),
}
"""Machine and changes of what is exported."""
HEAD = f"{'content':10} {'platform':15} {'bytes':>8}  {'C library':12} asked offered Python  run"


def rows_apart(path: Path, case: Case, folder: Path) -> str:
    """Compare what an FMU gives with what a run records, row by row."""
    names, values = recorded_rows(case, folder / f"{path.stem}.h5")
    unit, places = opened(path)
    got = marched(unit, [places[name] for name in names], len(values) - 1, 1e-3)
    if np.array_equal(got, values[1:]):
        return f"bits of a run in {len(names)} series of {len(got)} rows"
    name = next(name for name in names if name.endswith("charge_force_z"))
    one, two = (np.mean(rows[:, names.index(name)]) for rows in (got, values[1:]))
    return f"mean {name} {100 * (one / two - 1):+.2g} % of a run's"


def main() -> None:
    """Print the table and write it."""
    folder, here = Path(tempfile.mkdtemp()), this_platform()
    lines = [f"nutamill {__version__}, libraries of FMUs, {date.today()}", processor(), "", HEAD]
    for content, (machine, changes) in CASES.items():
        case = load_case(machine, changes)
        path = export_machine(case.machine, folder / f"{content}.fmu", content, platforms="all")
        run = rows_apart(path, case, folder)
        with zipfile.ZipFile(path) as archive:
            for target in PLATFORMS:
                library = archive.read(f"binaries/{target.folder}/nutamill{target.ending}")
                looked = symbols(library)
                needs = f"glibc {looked.glibc}" if looked.glibc else {".dll": "UCRT"}.get(target.ending, "")
                python = len(of_python(looked.asked + looked.offered))
                ran = run if target == here else "not run"
                lines.append(
                    f"{content:10} {target.tuple:15} {len(library):8}  {needs or 'libSystem':12} "
                    f"{len(looked.asked):5} {len(looked.offered):7} {python:6}  {ran}"
                )
                print(lines[-1], flush=True)
        here_path = export_machine(case.machine, folder / f"{content}-here.fmu", content)
        lines.append(f"{content:10} {here.tuple}, this computer only: {rows_apart(here_path, case, folder)}")
        print(lines[-1], flush=True)
    lines += [
        "",
        "asked: functions of libraries of the system; offered: functions of FMI and data; Python: names of",
        "Python among both.  Means of the short run of the whole machine scatter by its chaos.",
    ]
    TABLE.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
