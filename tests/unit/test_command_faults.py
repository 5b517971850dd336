"""Every command, given a missing file, a wrong file, an unwritable place or an unknown suffix: one sentence
and its exit code.
"""

import math
from pathlib import Path

import pytest
from typer.main import get_command
from typer.testing import CliRunner

from nutamill import cli
from nutamill.analysis.measured_import import import_test
from nutamill.base.errors import ExitCode
from nutamill.case import load_case
from nutamill.simulation import runs

PENDULUM = Path(__file__).parents[2] / "examples/mechanisms/pendulum.toml"
EMPTY = (
    "-s",
    "charge.kind=none",
    "-s",
    "mechanism.mounting=rigid",
    "-s",
    "run.until=2 ms",
    "-s",
    "drive.ramp=7000 rpm/s",
)
FILES = {
    "fit.toml": """
case = "numill"
[set]
"charge.kind" = "none"
[free]
"mounts.shear_stiffness" = { start = "70 N/mm", low = "50 N/mm", high = "90 N/mm" }
[[target]]
quantity = "crank_pin_force_resultant"
value = "900 N"
uncertainty = "5 N"
""",
    "test.csv": "time [s],displacement [mm],force [N]\n"
    + "".join(f"{k / 100},{math.sin(k / 2):.6f},{70 * math.sin(k / 2 + 0.1):.6f}\n" for k in range(200)),
    "map.toml": """
time = "time [s]"
speed = "60 rpm"
[channel.driveshaft_torque]
column = "force [N]"
unit = "N m"
""",
    "ratings.toml": """
schema = 1
[bearings.pin_joint]
kind = "roller"
dynamic_rating = "22 kN"
""",
    "paper.toml": """
schema = 1
short = "Nobody 2026"
citation = "Nobody, 2026"
[configurations.empty]
title = "empty"
set = ["charge.kind=none"]
speeds = ["700 rpm"]
[[rows]]
id = "force"
quantity = "force"
configuration = "empty"
speed = "700 rpm"
experiment = "600 N"
source = "page 1"
""",
    "many.toml": 'base = "numill"\ncharge.engine = "lammps"\nrun.statistics = false\n',
    "words.txt": "These are words, no data.\n",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory, film):
    """A file of each kind that commands take, results of a mill with and without charge, and files that are
    wrong.
    """
    place = tmp_path_factory.mktemp("commands")
    for name, text in FILES.items():
        (place / name).write_text(text)
    (place / "junk.h5").write_bytes(bytes(range(256)) * 8)
    film(place / "film.h5", 2, 5)
    case = load_case(
        "numill-2025",
        ["charge.kind=none", "drive.speed=700 rpm", "drive.ramp=70000 rpm/s", "run.until=0.2 s"],
    )
    runs.run(case, place / "empty.h5").close()
    runs.run(load_case(PENDULUM, ["run.until=50 ms"]), place / "pendulum.h5").close()
    import_test(place / "test.csv", place / "map.toml", place / "measured.h5")
    (place / "a_folder.png").mkdir()
    return place


@pytest.fixture
def invoke(folder, monkeypatch):
    """Run a command in that folder."""
    monkeypatch.chdir(folder)
    monkeypatch.setenv("COLUMNS", "1000")
    return lambda *words: CliRunner().invoke(cli.app, words)


INPUTS = {
    "check": ("{}",),
    "run": ("{}",),
    "resume": ("{}",),
    "show": ("{}",),
    "verify": ("{}",),
    "sweep": ("{}", "-s", "run.seed=1..2"),
    "submit": ("{}",),
    "fit": ("{}",),
    "identify": ("{}",),
    "mount-test": ("{}",),
    "validate": ("{}", "--stored"),
    "modes": ("{}",),
    "campbell": ("{}",),
    "runup": ("{}",),
    "isolation": ("{}",),
    "balance": ("{}",),
    "orders": ("{}",),
    "loads": ("{}",),
    "mounts": ("{}",),
    "life": ("{}", "ratings.toml"),
    "breakage": ("{}", "--ore", "smc-sample-a"),
    "wear": ("{}", "--hardness", "6 GPa", "--coefficient", "1e-4"),
    "plot": ("{}", "run"),
    "picture": ("{}",),
    "movie": ("{}",),
    "view": ("{}",),
    "export": ("vtkhdf", "{}"),
    "report": ("{}",),
    "import": ("{}", "--map", "map.toml"),
    "compare": ("film.h5", "{}"),
    "new": ("a.toml", "--from", "{}"),
}
"""A call of each command that reads a file, with the file left open."""
OUTPUTS = {
    "new": ("{}.toml",),
    "run": ("numill", *EMPTY, "--to", "{}.h5"),
    "sweep": ("numill", *EMPTY, "-s", "run.seed=1..2", "--to", "{}"),
    "submit": ("many.toml", "--ranks", "8", "--to", "{}"),
    "fit": ("fit.toml", "--to", "{}"),
    "mount-test": ("test.csv", "--to", "{}.png"),
    "validate": ("paper.toml", "--stored", "--to", "{}"),
    "modes": ("numill-2025", "--to", "{}.png"),
    "campbell": ("numill", "--to", "{}.png"),
    "isolation": ("numill", "--to", "{}.png"),
    "balance": ("numill", "--to", "{}.png"),
    "orders": ("empty.h5", "--to", "{}.png"),
    "loads": ("empty.h5", "--to", "{}.png"),
    "mounts": ("empty.h5", "--to", "{}.png"),
    "life": ("empty.h5", "ratings.toml", "--to", "{}.png"),
    "breakage": ("empty.h5", "--ore", "smc-sample-a", "--to", "{}.png"),
    "wear": ("empty.h5", "--hardness", "6 GPa", "--coefficient", "1e-4", "--to", "{}.png"),
    "plot": ("empty.h5", "history:driveshaft_torque", "--to", "{}"),
    "picture": ("film.h5", "-o", "{}.png"),
    "movie": ("film.h5", "-o", "{}.mp4"),
    "view": ("film.h5", "-o", "{}.html"),
    "export": ("csv", "empty.h5", "-o", "{}.csv"),
    "report": ("empty.h5", "--to", "{}.html"),
    "import": ("test.csv", "--map", "map.toml", "--to", "{}.h5"),
    "compare": ("empty.h5", "measured.h5", "--to", "{}.png"),
}
"""A call of each command that writes a file, with its place left open."""
WRONG = (
    "missing.toml",
    "missing.h5",
    "junk.h5",
    "words.txt",
    "a_folder.png",
    "fit.toml",
    "measured.h5",
    "pendulum.h5",
)
"""Files that no command can use, but those of `RIGHT`."""
RIGHT = {
    "measured.h5": ("show", "verify", "plot", "compare", "orders", "life"),
    "pendulum.h5": (
        "show",
        "verify",
        "resume",
        "picture",
        "movie",
        "view",
        "export",
        "plot",
        "report",
        "life",
    ),
    "fit.toml": ("fit",),
}
"""Commands that can do something with such a file."""
WITHOUT_FILES = {"schema", "bench", "info", "cite", "doctor", "explain", "ui"}


def refused(reply, code):
    """Whether a command ended with this code and with a few plain lines, none of them of a traceback or of
    another program.
    """
    assert reply.exception is None or isinstance(reply.exception, SystemExit), repr(reply.exception)
    assert reply.exit_code == code, reply.output
    lines = reply.stderr.strip().splitlines()
    assert 1 <= len(lines) <= 10, reply.stderr
    assert not any(word in reply.stderr for word in ("Traceback", "Errno", "<HDF5", "FFMPEG", "object at 0x"))
    return lines[-1]


def test_every_command_that_reads_or_writes_a_file_is_walked():
    known = set(get_command(cli.app).commands)
    assert known - WITHOUT_FILES <= set(INPUTS) | set(OUTPUTS)


def commands(calls):
    known = get_command(cli.app).commands
    return [name for name in calls if name in known]


@pytest.mark.parametrize("wrong", WRONG)
@pytest.mark.parametrize("command", commands(INPUTS))
def test_a_missing_or_wrong_file_is_bad_input(invoke, command, wrong):
    if command in RIGHT.get(wrong, ()):
        return
    message = refused(invoke(command, *(word.format(wrong) for word in INPUTS[command])), ExitCode.BAD_INPUT)
    assert Path(wrong).stem in message


@pytest.mark.parametrize("command", OUTPUTS)
def test_a_place_that_cannot_be_written_is_named(invoke, command):
    reply = invoke(command, *(word.format("words.txt/x") for word in OUTPUTS[command]))
    assert "words.txt/x" in refused(reply, ExitCode.NOT_WRITTEN)


@pytest.mark.parametrize(
    "command", [name for name, words in OUTPUTS.items() if any("{}." in word for word in words)]
)
def test_a_file_to_be_written_with_the_suffix_of_nothing_is_bad_input(invoke, folder, command):
    reply = invoke(command, *("a.xyz" if "{}." in word else word for word in OUTPUTS[command]))
    assert refused(reply, ExitCode.BAD_INPUT).startswith("a.xyz: must end with ")
    assert not (folder / "a.xyz").exists()


def test_a_folder_in_the_place_of_a_picture_is_named(invoke):
    for command, file in (("picture", "film.h5"), ("mounts", "empty.h5")):
        reply = invoke(command, file, "--to", "a_folder.png")
        assert refused(reply, ExitCode.NOT_WRITTEN).startswith("a_folder.png: cannot be written")
