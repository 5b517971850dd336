"""Draw the machines of the package in three dimensions into docs/pictures, from where the guide takes them.

python tools/machine_pictures.py piston       # or without names: all

Each machine runs for a moment. It takes some minutes in all, and the extra "view".
"""

import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

import nutamill as nm
from nutamill.view.looks import Look
from nutamill.view.scene import draw_scene

PICTURES = Path(__file__).parents[1] / "docs" / "pictures"
SIZE = (1280, 960)
"""Width and height of each picture [px]."""


class Picture(NamedTuple):
    """A machine at a moment."""

    machine: str
    """Its name in the package."""
    time: float
    """The moment [s]."""
    changes: tuple[str, ...] = ()
    """Changes of the case, as after ``-s``."""


DRAWN = {
    "particle_box": Picture("particle-damper", 0.1, ("charge.kind=none",)),
    "particle_damper": Picture("particle-damper", 0.1),
    "piston": Picture("piston", 0.5),
    "tumbling_mill": Picture("tumbling-mill", 1.0),
    "planetary_mill": Picture("planetary-mill", 0.5),
    "vibratory_mill": Picture("vibratory-mill", 0.3),
}
"""The pictures, by the beginning of the name of their file."""


def main(names: list[str]) -> None:
    """Draw these pictures."""
    if unknown := [name for name in names if name not in DRAWN]:
        sys.exit(f"machine_pictures: no picture is called {', '.join(unknown)}. Known: {', '.join(DRAWN)}")
    for name in names or DRAWN:
        picture = DRAWN[name]
        last = f'run.snapshots={{ rate = "10 Hz", last = "{picture.time} s" }}'
        case = nm.load_case(picture.machine, [*picture.changes, f"run.until={picture.time} s", last])
        with tempfile.TemporaryDirectory() as folder, nm.run(case, to=Path(folder) / "run.h5") as result:
            print(draw_scene(result, PICTURES / f"{name}_3d.png", Look(), [], SIZE))


if __name__ == "__main__":
    main(sys.argv[1:])
