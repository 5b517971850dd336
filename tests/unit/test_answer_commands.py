"""Commands that answer a designer: a table with its units, a picture, and clear words for what cannot be
answered.
"""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from nutamill import cli
from nutamill.case import load_case
from nutamill.simulation import runs

MECHANISMS = Path(__file__).parents[2] / "examples" / "mechanisms"
RATINGS = """
schema = 1
[bearings.pin_joint]
kind = "roller"
dynamic_rating = "22 kN"
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The empty NuMill of 2025, 0.6 s from rest to 700 rpm and on."""
    place = tmp_path_factory.mktemp("answers")
    case = load_case(
        "numill-2025", ["charge.kind=none", "drive.speed=700 rpm", "drive.ramp=7000 rpm/s", "run.until=0.6 s"]
    )
    runs.run(case, place / "empty.h5").close()
    (place / "ratings.toml").write_text(RATINGS)
    return place


@pytest.fixture
def invoke(folder, monkeypatch):
    """Run a command in the folder with the result."""
    monkeypatch.chdir(folder)
    return lambda *words: CliRunner().invoke(cli.app, words)


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("orders", "empty.h5"), "crank-pin force (N)"),
        (("loads", "empty.h5", "--axes", "crank"), "joint reactions on the second body, crank axes (N, N m)"),
        (("loads", "empty.h5"), "rod forces (N), positive in tension"),
        (
            ("mounts", "empty.h5", "--ring", "80 mm", "330 mm", "--opening", "125 mm"),
            "clearance: 10.5 mm left",
        ),
        (("life", "empty.h5", "ratings.toml"), "L10 (h)"),
        (("modes", "numill-2025"), "torsion of the drive train"),
    ],
    ids=lambda value: value[0] if isinstance(value, tuple) else "",
)
def test_answer_prints_its_table_and_saves_a_picture(invoke, folder, words, expected):
    reply = invoke(*words, "--to", "picture.png")
    assert max(map(len, reply.stdout.splitlines())) <= 80
    assert reply.exit_code == 0, reply.output
    assert expected in reply.stdout and "picture picture.png" in reply.stdout
    assert (folder / "picture.png").stat().st_size > 10_000
    (folder / "picture.png").unlink()


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (
            ("loads", "empty.h5", "--axes", "moon"),
            "axes moon: must be those of a body whose attitude is recorded. Known are ground, frame, crank",
        ),
        (
            ("life", "empty.h5", "ratings.toml", "--bearing", "yoke_pivot"),
            "bearing yoke_pivot: must have a rating, the file has none",
        ),
        (("orders", "empty.h5", "--sensor", "mount_1_travel_x"), "mount_1_travel_x: must be recorded"),
        (("modes", "numill", "--speed", "700"), "--speed: needs a unit"),
        (
            ("balance", "numill", "--plane", "80 mm"),
            '--plane: must be a radius and a depth, got "80 mm". Write e.g.',
        ),
        (("isolation", "numill-2025"), "numill-2025: must stand on bushings, nothing else is between"),
        (
            ("balance", "numill", "--speed", "0 rpm"),
            "--speed: must be positive, got 0 rpm. A machine at rest has no unbalance to take away",
        ),
        (
            ("runup", "numill", "--sensor", "bogus"),
            '--sensor: no series of this machine without its charge is called "bogus". Known: '
            "frame_corner_acceleration_x, frame_corner_acceleration_y, frame_corner_acceleration_z",
        ),
        (("mounts", "empty.h5", "--ring", "nan mm", "330 mm"), "--ring: "),
    ],
    ids=lambda value: value[0] if isinstance(value, tuple) else "",
)
def test_question_without_an_answer_is_refused(invoke, words, expected):
    reply = invoke(*words)
    assert reply.exit_code == 2 and expected.replace(", Known", ". Known") in reply.stderr.replace(
        ", Known", ". Known"
    )


def test_modes_of_a_mechanism_of_listed_parts(invoke, folder):
    pendulum = str(MECHANISMS / "pendulum.toml")
    reply = invoke("modes", pendulum, "--to", "modes.png")
    # an arm of 1 m under 9.81 m/s^2 swings at 0.4985 Hz
    assert reply.exit_code == 0 and "0.498" in reply.stdout and "bob moves" in reply.stdout
    assert (folder / "modes.png").stat().st_size > 10_000
    reply = invoke("modes", pendulum, "--speed", "700 rpm")
    assert reply.exit_code == 2 and reply.stderr.startswith("pendulum: no drive turns this machine")
    reply = invoke("modes", pendulum, "--charge")
    assert reply.exit_code == 2
    assert reply.stderr.startswith("chamber.bars: is missing, so that the mass of the charge has no position")


def test_a_machine_on_joints_has_a_force_on_the_floor_and_no_mounts(invoke, folder):
    crank = MECHANISMS / "slider-crank.toml"
    reply = invoke("balance", str(crank), "--plane", "80 mm, 420 mm")
    assert reply.exit_code == 2 and "must stand on bushings: a fixed joint has no corners" in reply.stderr
    runs.run(load_case(crank, ["run.until=0.3 s"]), folder / "crank.h5").close()
    reply = invoke("mounts", "crank.h5")
    assert reply.exit_code == 0 and reply.stdout.startswith("force on the floor (N)")


def test_picture_of_a_changed_case_or_of_another_option_leaves_the_earlier_one(invoke, folder):
    pendulum, changes = str(MECHANISMS / "pendulum.toml"), ["bodies.bob.mass=7 kg"]
    for words in (
        ("modes", pendulum),
        ("modes", pendulum, "-s", changes[0]),
        *(("orders", "empty.h5", "--sensor", s) for s in SENSORS),
    ):
        reply = invoke(*words)
        assert reply.exit_code == 0, reply.output
    cases = load_case(pendulum), load_case(pendulum, changes)
    assert {file.name for file in (folder / "results").iterdir()} == {
        f"{case.file_in().stem}-modes.png" for case in cases
    }
    assert {file.name for file in folder.glob("empty-orders-*.png")} == {
        f"empty-orders-{sensor}.png" for sensor in SENSORS
    }


SENSORS = ("driveshaft_torque", "crank_pin_force_resultant")
