"""How long bearings and pins of the empty NuMill last at 700 rpm, with catalogue data of common sizes.

Checked: a turning force of steady size is its own equivalent load.
"""

import tempfile
from pathlib import Path

import nutamill as nm

ratings = nm.load_ratings(Path(__file__).with_name("ratings.toml"))
case = nm.load_case("numill", ["charge.kind=none", "drive.ramp=350 rpm/s", "run.until=8 s"])
with tempfile.TemporaryDirectory() as folder, nm.run(case, to=Path(folder) / "empty.h5") as result:
    bearings = [nm.bearing_life(result, joint, ratings) for joint in ratings.bearings]
    sections = [nm.section_life(result, name, ratings) for name in ratings.sections]
print("\n".join(nm.bearings_lines(bearings) + nm.sections_lines(sections)))
nm.draw_lives(bearings, sections).savefig("life.png")

pin = bearings[1]
assert abs(pin.equivalent - pin.radial) < 0.01 * pin.radial
