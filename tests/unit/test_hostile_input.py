"""Input that no machine has, and files made to break the program, are refused in words and in time."""

import time

import pytest
from typer.testing import CliRunner

from nutamill.analysis.measured_mapping import load_mapping
from nutamill.analysis.mount_test import read_mount_test
from nutamill.base.errors import CaseError, ExitCode, Fault, printable
from nutamill.base.schema import SIZES
from nutamill.base.units import UNITS, Kind
from nutamill.case import load_case
from nutamill.cli import app
from nutamill.simulation.setup.clock import run_clock
from nutamill.studies.axes import axis_values

BASE = 'base = "numill"\n'


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def refusal(act, *arguments):
    """The message of a refusal, and the processor time it takes [s]."""
    began = time.process_time()
    with pytest.raises(CaseError) as error:
        act(*arguments)
    return str(error.value), time.process_time() - began


def refused(text):
    """The message of the refusal of a case file, and the processor time it takes [s]."""
    with open("mill.toml", "w", encoding="utf-8") as file:
        file.write(text)
    return refusal(load_case, "mill.toml")


# magnitudes -------------------------------------------------------------------------------------------------


def test_every_kind_of_quantity_has_a_smallest_and_a_largest_size():
    assert set(SIZES) == set(Kind)
    assert all(0.0 < smallest < largest for smallest, largest in SIZES.values())


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("chamber.inner_diameter=1e300 m", 'chamber.inner_diameter: must be at most 10000 m, got "1e300 m"'),
        ("charge.diameter=1e-320 mm", 'charge.diameter: must be at least 1e-09 m, got "1e-320 mm"'),
        ("run.dt=1e-300 s", 'run.dt: must be at least 1e-12 s, got "1e-300 s"'),
        ("run.until=1e300 s", 'run.until: must be at most 1e+08 s, got "1e300 s"'),
        (
            "mechanism.gravity=1e300 m/s^2",
            'mechanism.gravity: must be at most 100000 m/s^2, got "1e300 m/s^2"',
        ),
        ("drive.speed=1e300 rpm", 'drive.speed: must be at most 100000 rad/s, got "1e300 rpm"'),
        ("balance.mass=1e308 kg", 'balance.mass: must be at most 1e+09 kg, got "1e308 kg"'),
        ("contact.softening=5e-324", "contact.softening: must be at least 1e-09, got 5e-324"),
        (
            "contact.pairs.steel-steel.sliding_friction=1e308",
            "contact.pairs.steel-steel.sliding_friction: must be at most 1e+06, got 1e+308",
        ),
        (
            "run.seed=99999999999999999999",
            "run.seed: must be a whole number of at most 9223372036854775807, got 99999999999999999999",
        ),
        (
            "run.threads=9223372036854775807",
            'run.threads: must be "auto" or a whole number from 1 to 1000, got 9223372036854775807',
        ),
        ("run.window=5000", "run.window: must be at most 1000, got 5000"),
        ("mounts.count=9223372036854775807", "mounts.count: must be at most 1e+09, got 9223372036854775807"),
        ("chamber.ribs=1001", "chamber.ribs: must be at most 1000, got 1001"),
        (
            "run.series_rate=1e8 Hz",
            "run.series_rate: makes 1.8e+11 numbers to record, more than the limit of 1e+10. Lower it, "
            "or end the run sooner",
        ),
        (
            "run.series_rate=1e-3 Hz",
            'run.series_rate: must give at least one row in 13 s, got 0.013. Write e.g. "200 Hz"',
        ),
        (
            "run.checkpoint=1 us",
            "run.checkpoint: makes 1.3e+07 checkpoints, more than the limit of 1e+05. Take a longer time",
        ),
        (
            "run.snapshots={rate='1e8 Hz',last='13 s'}",
            "run.snapshots.rate: makes 1.2e+10 numbers to record, more than the limit of 1e+10. "
            "Lower it, or shorten run.snapshots.last",
        ),
    ],
)
def test_a_size_that_no_machine_has_is_refused_where_it_is_written(change, message):
    text, spent = refusal(load_case, "numill", [change])
    assert text == f"--set {message}"
    assert spent < 2.0


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_coordinate_may_be_as_near_to_zero_as_it_likes(sign):
    sensors = f"sensors={{ x = {{ body = 'frame', at = ['{sign * 1e-30} m', '0 m', '1 m'] }} }}"
    assert load_case("numill", [sensors]).sensors["x"].at[0] == sign * 1e-30


def test_more_steps_than_can_be_meant_are_refused():
    text, _ = refusal(run_clock, load_case("numill", ["run.dt=1e-12 s", "charge.count=10"]).machine)
    assert text.startswith("run.until: makes 1.3e+13 steps of 1e-12 s, at most 1e+12 can be meant")


@pytest.mark.parametrize(
    "text", ["1..2 rpm / 1000000000", "1e1000000..2e1000000 step 1", "1..2 rpm / " + "9" * 5000]
)
def test_a_sweep_of_more_values_than_can_be_meant_is_refused(text):
    message, spent = refusal(axis_values, "drive.speed", text)
    assert message.startswith("sweep drive.speed: must have ")
    assert spent < 2.0


def test_a_sweep_from_what_is_no_number_is_refused_as_a_range():
    message, _ = refusal(axis_values, "drive.speed", "nan..700 rpm step 10 rpm")
    assert message.startswith("sweep drive.speed: must be a range of numbers with their unit, got ")
    # two dots in a path are none
    assert axis_values("charge.shapes", "../shapes.toml") == ["../shapes.toml"]


# text -------------------------------------------------------------------------------------------------------

DEEP = 600


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (f"x = {'[' * DEEP}{']' * DEEP}", "nested"),
        (f"x = {'{a=' * DEEP}1{'}' * DEEP}", "nested"),
        (f"{'.'.join('a' * DEEP)} = 1", "nested"),
        (f"[run]\nseed = {'9' * 5000}", "mill.toml:3: holds a whole number of more than 4300 digits"),
        (f"[run]\nseed = 0x{'f' * 5000}", "got a number of about 6021 digits"),
        ("[[charge.part]]\n" * 20_000, "charge.part: must hold at most 1000 keys or tables, got 20000"),
        ("".join(f"key{n} = 1\n" for n in range(20_000)), "must hold at most 1000 keys or tables, got 20001"),
        ("".join(f"[table{n}]\n" for n in range(20_000)), "must hold at most 1000 keys or tables, got 20001"),
        (f'title = "{"a" * 10_000_000}"', "cannot be read: it is longer than 5 MB"),
        (f'title = "{"a" * 4_000_000}"', 'got "' + "a" * 80 + '..." of 4000000 characters'),
        ("until = 5" + " " * 60_000 + "=", "mill.toml:2"),
        (
            f"[sensors.{'s' * 200}]\nbody = 'frame'\nat = ['0 m', '0 m', '0 m']",
            "a key must be one line of at most 100 characters",
        ),
        (f"base = '{'b' * 300}'", "appears twice"),
    ],
)
def test_an_endless_file_is_refused_in_two_seconds(text, message):
    error, spent = refused(BASE + text)
    assert message in error
    assert len(error) < 10_000
    assert spent < 2.0


@pytest.mark.parametrize(
    "change", [f"{'.'.join('a' * DEEP)}=1", f"run.seed={'[' * DEEP}{']' * DEEP}", f"run.seed={'9' * 5000}"]
)
def test_an_endless_change_on_the_command_line_is_refused(change):
    error, spent = refusal(load_case, "numill", [change])
    assert error.startswith("--set")
    assert spent < 2.0


def test_faults_beyond_the_first_fifty_are_counted():
    error, _ = refused(BASE + "".join(f"[t{n}]\nx = 1\n" for n in range(900)))
    assert error.splitlines()[-1] == "mill.toml: 850 more faults"


LONG = "n" * 300


@pytest.mark.parametrize(
    "text",
    [f'base = "{LONG}"', f'base = "{LONG}.toml"', f'{BASE}[charge]\nkind = "clumps"\nshapes = "{LONG}"',
     f'{BASE}[chamber.mesh]\nfile = "{LONG}.stl"\nunit = "mm"', f'{BASE}[drive]\nprofile = "{LONG}.csv"'],
)  # fmt: skip
def test_a_name_that_no_file_can_have_names_no_file(text):
    error, _ = refused(text)
    assert LONG in error


@pytest.mark.parametrize("name", [LONG, f"{LONG}.toml", f"{LONG}/{LONG}.toml", "a\0b.toml"])
def test_a_case_of_a_name_that_no_file_can_have_is_refused(name):
    assert refusal(load_case, name)[0].startswith(printable(name))


def test_a_case_of_a_long_name_has_a_result_file_that_can_be_made(tmp_path):
    with open(f"{'n' * 250}.toml", "w") as file:
        file.write(BASE)
    path = load_case(f"{'n' * 250}.toml").file_in()
    path.parent.mkdir()
    path.touch()


def test_a_chain_of_bases_is_refused():
    for n in range(1500):
        with open(f"b{n}.toml", "w") as file:
            file.write(f'base = "b{n + 1}.toml"\n')
    assert "the chain of bases is longer than 20 files" in refusal(load_case, "b0.toml")[0]


def test_a_device_that_never_ends_is_no_test_of_a_mount():
    error, _ = refusal(read_mount_test, "/dev/zero")
    assert error == "/dev/zero: cannot be read as a CSV file (it is longer than 200 MB)"
    assert "it is longer than 5 MB" in refusal(load_mapping, "/dev/zero")[0]


# what a terminal obeys --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "text",
    ['title = "a\\u001b]0;pwn\\u0007"', 'title = "a\\nok: everything fine"', '[materials."a\\u001b[2J"]',
     '[charge]\nmaterial = "\\u202eleets"', '"\\u009b31m" = 1'],
)  # fmt: skip
def test_text_that_a_terminal_would_obey_is_refused_and_shown_escaped(text):
    error, _ = refused(BASE + text)
    assert "without control characters" in error or "a key must be one line" in error
    assert error == printable(error)


def test_a_fault_is_one_printable_line():
    assert (
        str(Fault("mill\x1b[2J.toml", "must\nbe", "Write\r\x9b31m"))
        == r"mill\x1b[2J.toml: must\nbe. Write\r\x9b31m"
    )
    assert printable("two µm, ü and 中\t½") == "two µm, ü and 中\t½"


def test_nothing_in_a_case_is_evaluated(tmp_path):
    """Text that Python, a shell or a template would run stays text."""
    bait = tmp_path / "pwned"
    for text in (
        f"__import__('os').system('touch {bait}')",
        f"$(touch {bait})",
        f"{{{{ open('{bait}', 'w') }}}}",
    ):
        assert load_case("numill", [f'title="{text}"']).title == text
        for key in ("charge.mass", "charge.shapes", "base", "mounts.set", "drive.profile"):
            refusal(load_case, "numill", [f'{key}="{text}"'])
    assert not bait.exists()


def test_units_are_read_with_bounds_that_their_own_example_keeps():
    for kind, (smallest, largest) in SIZES.items():
        assert all(smallest <= factor <= largest for factor in UNITS[kind].values())


@pytest.mark.parametrize(
    "words",
    [
        ["check", LONG],
        ["show", f"{LONG}.h5"],
        ["resume", f"{LONG}.h5"],
        ["report", f"{LONG}.h5"],
        ["new", f"{LONG}.toml"],
        ["import", f"{LONG}.csv", "--map", f"{LONG}.toml"],
        ["mount-test", f"{LONG}.csv"],
        ["run", "numill", "--to", f"{LONG}.h5"],
    ],
    ids=lambda words: words[0],
)
def test_a_command_with_a_name_that_no_file_can_have_says_so(words):
    done = CliRunner().invoke(app, words)
    assert isinstance(done.exception, SystemExit)
    assert done.exit_code in (ExitCode.BAD_INPUT, ExitCode.NOT_WRITTEN)
    assert LONG in done.output
