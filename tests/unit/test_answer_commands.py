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
        (("isolation", "numill-2025"), 'mechanism.mounting: must be "flexible", got "rigid"'),
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
    for question in (("--charge",), ("--speed", "700 rpm")):
        reply = invoke("modes", pendulum, *question)
        assert reply.exit_code == 2
        what = "has no use for a machine given part by part: its modes are those about rest"
        assert reply.stderr == f"{question[0][2:]}: {what}. Leave it out\n"


def test_mechanism_of_listed_parts_is_no_mill(invoke, folder):
    crank = MECHANISMS / "slider-crank.toml"
    reply = invoke("balance", str(crank))
    assert (
        reply.exit_code == 2 and "describes a mechanism part by part ([[bodies]]), not a mill" in reply.stderr
    )
    runs.run(load_case(crank, ["run.until=5 ms"]), folder / "crank.h5").close()
    reply = invoke("mounts", "crank.h5")
    assert reply.exit_code == 2 and "crank.h5: the run of a machine given part by part" in reply.stderr


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
