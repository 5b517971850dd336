"""The mill as bodies, joints and walls answers every command as its drawing does."""

import shlex

import numpy as np
import pytest
from typer.testing import CliRunner

import nutamill as nm
from nutamill import cli
from nutamill.analysis.replay import replay
from nutamill.case import load_case
from nutamill.result import open_result
from nutamill.simulation import runs
from nutamill.simulation.setup.quick import quick
from nutamill.view.drawn import drawn

BRIEF = [
    "charge.mass=20 g",
    "drive.ramp=9000 rpm/s",
    "run.until=0.4 s",
    'run.snapshots={ rate = "50 Hz", last = "60 ms" }',
    "run.threads=1",
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A brief run of the NuMill, and one of the file that its drawing expands into."""
    place = tmp_path_factory.mktemp("expanded")
    drawn = load_case("numill", BRIEF)
    (place / "drawn.toml").write_text(drawn.to_toml())
    (place / "parts.toml").write_text(drawn.machine.to_toml())
    for name in ("drawn", "parts"):
        runs.run(load_case(place / f"{name}.toml"), place / f"{name}.h5").close()
    return place


@pytest.fixture
def invoke(folder, monkeypatch):
    """Run a command in that folder."""
    monkeypatch.chdir(folder)
    return lambda *words: CliRunner().invoke(cli.app, words)


SAME = [
    ("modes", "{}.toml"),
    ("modes", "{}.toml", "--speed", "700 rpm"),
    ("runup", "{}.toml", "--ramp", "2000 rpm/s"),
    ("isolation", "{}.toml"),
    ("mounts", "{}.h5", "--last", "0.1 s"),
    ("mounts", "{}.h5", "--ring", "80 mm", "330 mm", "--opening", "125 mm", "--fixed-to", "ground"),
    ("loads", "{}.h5"),
    ("orders", "{}.h5"),
    ("wear", "{}.h5", "--hardness", "6 GPa", "--coefficient", "1e-4"),
]
"""Commands whose answers are the same."""


@pytest.mark.parametrize("words", SAME, ids=lambda words: "-".join(words[::2]))
def test_the_parts_of_a_mill_answer_as_its_drawing_does(invoke, words):
    answers = [invoke(*(word.format(name) for word in words)) for name in ("drawn", "parts")]
    for answer in answers:
        assert answer.exit_code == 0, answer.output
    drawn, parts = (
        [line for line in one.stdout.splitlines() if ".h5" not in line and ".png" not in line]
        for one in answers
    )
    assert drawn == parts and len(drawn) > 2


def test_the_sheet_of_the_parts_of_a_mill_has_the_numbers_of_its_drawing(folder):
    drawn, parts = (nm.check(load_case(folder / f"{name}.toml")) for name in ("drawn", "parts"))
    assert drawn.clock == parts.clock and list(drawn.parts.values()) == list(parts.masses.values())
    charge = drawn.charge.lines(drawn.case.machine)
    assert charge == parts.charge.lines(parts.case) and len(charge) > 2
    # the numbers of the file have 17 digits, and modes are taken from central differences
    assert np.array(parts.modes)[:, 0] == pytest.approx(np.array(drawn.empty_modes)[:, 0], rel=1e-8)
    # the drawing alone knows where the mass of the charge sits, which lowers its modes by a per cent
    speeds = [[one.speed for one in sheet.crossings] for sheet in (drawn, parts)]
    assert speeds[1] == pytest.approx(speeds[0], rel=0.01)


def test_the_charge_is_shown_in_axes_of_the_chamber_of_either(folder):
    depths = []
    for name in ("drawn", "parts"):
        with open_result(folder / f"{name}.h5") as result:
            (frame,) = replay(result, [0])
            floor = drawn(load_case(folder / f"{name}.toml")).floor
        assert frame.home == "chamber" and len(frame.positions) > 10
        depths.append(frame.at_home()[:, 2] - floor)
    # the drawing counts from the nutation point, the parts from the mass centre: heights over the floor agree
    assert depths[0] == pytest.approx(depths[1], abs=1e-9)
    assert 0.0 < depths[0].min() < 0.01


def test_the_demonstration_of_the_parts_of_a_mill_is_that_of_its_drawing(folder):
    drawn, parts = (quick(load_case(folder / f"{name}.toml")).machine for name in ("drawn", "parts"))
    assert drawn.run.until == pytest.approx(parts.run.until) and drawn.drives == parts.drives
    assert drawn.contact == parts.contact
    assert [joint.name for joint in drawn.joints] == [joint.name for joint in parts.joints]
    assert set(parts.run.series) == set(drawn.run.series) - {
        name for name in drawn.run.series if name.startswith("frame_fix_")
    }


def test_balance_masses_of_the_parts_of_a_mill_are_those_of_its_drawing(invoke, folder):
    drawn, parts = (
        invoke("balance", f"{name}.toml", "--plane", "80 mm, 300 mm").stdout.splitlines()
        for name in ("drawn", "parts")
    )
    assert drawn[:-2] == parts[:-2] and len(drawn) == 7
    # the keys that each prints put the same mass on the driveshaft
    of_drawing, of_parts = (
        load_case(folder / f"{name}.toml", shlex.split(lines[-2])[4::2]).machine
        for name, lines in (("drawn", drawn), ("parts", parts))
    )
    for ours, theirs in zip(of_drawing.bodies, of_parts.bodies, strict=True):
        assert ours.mass == pytest.approx(theirs.mass, rel=1e-5)
        assert ours.position == pytest.approx(theirs.position, abs=1e-6)
        assert ours.inertia == pytest.approx(theirs.inertia, abs=1e-6)
