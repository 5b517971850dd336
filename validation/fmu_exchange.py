"""Error of the exchange with a foreign machine over the window: the table of docs/fmi.md.

Needs the extra fmu and a C compiler.  Type in the clone: ``python -m validation.fmu_exchange``.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np

from nutamill.case import load_case

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "cross"))
from box_and_ball import BALL, BOX, FOREIGN, OWN, rows_of
from fmu_bench import compiled, description, write_fmu

ACCELERATION = 'acceleration = ["ax", "ay", "az"]\n'
VELOCITY = 'velocity     = ["vx", "vy", "vz"]\n'
AT_ONCE = FOREIGN.replace("mass = 2.0", "mass = 2.0, at_once = 1.0")
NO_ACCELERATION = FOREIGN.replace(ACCELERATION, "")
HELD = FOREIGN.replace("mass = 2.0", "mass = 2.0, held = 1.0")
WINDOWS = (40, 20, 10)
END = 0.02


def iterated(text: str) -> str:
    """The case with passes over each window."""
    return text.replace("[run]", '[run]\ncoupling = "iterated"')


ROWS = {
    "our own body, no FMU": BOX + OWN + BALL,
    "pose, velocity, acceleration": BOX + FOREIGN + BALL,
    "the same, force held from the exchange before": BOX + HELD + BALL,
    "pose, velocity": BOX + NO_ACCELERATION + BALL,
    "pose only": BOX + NO_ACCELERATION.replace(VELOCITY, "") + BALL,
    "body that answers within the window": BOX + AT_ONCE + BALL,
    "such a body, `iterated`": iterated(BOX + AT_ONCE + BALL),
}


def main() -> None:
    """Print the table."""
    folder = Path(tempfile.mkdtemp())
    library = compiled(folder)

    def rows(text: str, window: int) -> dict[str, np.ndarray]:
        # the frame test would refuse a body that answers a force one step late
        write_fmu(folder / "bench.fmu", library, description(states="held" not in text))
        (folder / "case.toml").write_text(text, encoding="utf-8")
        return rows_of(load_case(folder / "case.toml").with_("run.window", window), END)

    fine = rows(iterated(BOX + AT_ONCE + BALL), 1)
    print("| what the FMU gives | 200 us | 100 us | 50 us |\n|---|---|---|---|")
    for name, text in ROWS.items():
        cells = []
        for window in WINDOWS:
            got = rows(text, window)
            errors = (np.abs(got[k] - fine[k]).max() for k in ("box_position_z", "charge_mass_centre_z"))
            cells.append(" / ".join(f"{error:.2e}" for error in errors))
        print(f"| {name} | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
