"""How long bearings and pins of the empty NuMill last at 700 rpm, with catalogue data of common sizes.

Checked: a turning force of steady size is its own equivalent load.
"""

import tempfile
from pathlib import Path

import nutamill as nm
from nutamill.analysis.bearings import bearing_life, bearings_lines
from nutamill.analysis.fatigue import section_life, sections_lines
from nutamill.analysis.ratings import load_ratings
from nutamill.view.figures.reading import draw_lives

ratings = load_ratings(Path(__file__).with_name("ratings.toml"))
case = nm.load_case("numill", ["charge.kind=none", "drive.ramp=350 rpm/s", "run.until=8 s"])
with tempfile.TemporaryDirectory() as folder, nm.run(case, to=Path(folder) / "empty.h5") as result:
    bearings = [bearing_life(result, joint, ratings) for joint in ratings.bearings]
    sections = [section_life(result, name, ratings) for name in ratings.sections]
print("\n".join(bearings_lines(bearings) + sections_lines(sections)))
draw_lives(bearings, sections).savefig("life.png")

pin = bearings[1]
assert abs(pin.equivalent - pin.radial) < 0.01 * pin.radial
