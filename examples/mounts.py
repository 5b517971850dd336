"""What the mounts of the empty NuMill do at 700 rpm, what they pass on over speed, and whether the chamber
clears its opening.

Checked: the force on the floor at speed, from a run, is the one of the slow run-up.
"""

import tempfile
from pathlib import Path

import nutamill as nm
from nutamill.analysis.mounts import chamber_clearance, clearance_line, floor_force, mounts_lines
from nutamill.design.figures import draw_isolation
from nutamill.design.isolation import isolation, isolation_lines
from nutamill.view.figures.reading import draw_floor

case = nm.load_case("numill", ["charge.kind=none", "drive.ramp=350 rpm/s", "run.until=8 s"])
with tempfile.TemporaryDirectory() as folder, nm.run(case, to=Path(folder) / "empty.h5") as result:
    print("\n".join(mounts_lines(result)))
    for body in ("frame", "ground"):
        print(
            f"opening of 125 mm in the {body}: "
            f"{clearance_line(chamber_clearance(result, (0.08, 0.33), 0.125, body))}"
        )
    floor = floor_force(result)
    draw_floor(result).savefig("mounts.png")
found = isolation(case)
print("\n".join(isolation_lines(found)))
draw_isolation(found).savefig("isolation.png")

assert abs(floor.once[0] - found.transmitted[-1]) < 0.05 * floor.once[0]
