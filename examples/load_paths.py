"""Where the forces of the empty NuMill of 2025 go: every joint, in crank axes, and the six rods that hold the
yoke.

Checked: the rods together carry what the yoke pivot passes on.
"""

import tempfile
from pathlib import Path

import numpy as np

import nutamill as nm

case = nm.load_case("numill-2025", ["charge.kind=none", "run.until=2.5 s"])
with tempfile.TemporaryDirectory() as folder, nm.run(case, to=Path(folder) / "empty.h5") as result:
    print("\n".join(nm.loads_lines(nm.load_paths(result, "1 s"), "crank")))
    rods = nm.yoke_rods(result, "1 s")
    print("\n".join(nm.rods_lines(rods)))
    nm.draw_loads(result, "crank", "1 s").savefig("load_paths.png")
    pivot = nm.hodograph(result, "yoke_pivot", "frame", "1 s").reaction[:, :3]

carried = np.column_stack(
    [rods.tension[:, 5], rods.tension[:, 3:5].sum(axis=1), rods.tension[:, :3].sum(axis=1)]
)
assert np.abs(carried - pivot).max() < 1e-9 * np.abs(pivot).max()
