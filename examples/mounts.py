"""What the mounts of the empty NuMill do at 700 rpm, what they pass on over speed, and whether the chamber
clears its opening.

Checked: the force on the floor at speed, from a run, is the one of the slow run-up.
"""

import tempfile
from pathlib import Path

import nutamill as nm

case = nm.load_case("numill", ["charge.kind=none", "drive.ramp=350 rpm/s", "run.until=8 s"])
with tempfile.TemporaryDirectory() as folder, nm.run(case, to=Path(folder) / "empty.h5") as result:
    print("\n".join(nm.mounts_lines(result)))
    for body in ("frame", "ground"):
        print(
            f"opening of 125 mm in the {body}: "
            f"{nm.clearance_line(nm.chamber_clearance(result, (0.08, 0.33), 0.125, body))}"
        )
    floor = nm.floor_force(result)
    nm.draw_floor(result).savefig("mounts.png")
isolation = nm.isolation(case)
print("\n".join(nm.isolation_lines(isolation)))
nm.draw_isolation(isolation).savefig("isolation.png")

assert abs(floor.once[0] - isolation.transmitted[-1]) < 0.05 * floor.once[0]
