"""The command line: what it prints, where, and with which exit code; the runs behind it are tested
elsewhere.
"""

import json
import subprocess
import sys
import types
from pathlib import Path

import pytest
from typer.testing import CliRunner

from nutamill import cli
from nutamill.base.errors import Interrupted, StepError
from nutamill.case import load_case


@pytest.fixture
def invoke(tmp_path, monkeypatch):
    """Run a command in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return lambda *words: CliRunner().invoke(cli.app, words)


class OneResult:
    """Stands for a result file."""

    state, summary, provenance, case_text = "complete", {"substep": 3e-06}, {"seed": 1}, ""
    verifiable = True

    def __enter__(self):
        return self

    def __exit__(self, *error):
        pass


@pytest.fixture
def engine(monkeypatch):
    """The march, replaced by a record of what it was asked."""
    asked = {}

    def run(case, to=None, progress=None, log=None, again=False, trust_fmu=False):
        asked.update(case=case, to=to, again=again)
        if "fault" in asked:
            raise asked["fault"]
        return OneResult()

    def resume(path, until=None, progress=None, log=None, trust_fmu=False):
        asked.update(path=path, until=until)
        return OneResult()

    def save_figure(figure, path):
        asked[figure] = path
        return path

    monkeypatch.setitem(
        sys.modules, "nutamill.simulation.runs", types.SimpleNamespace(run=run, resume=resume)
    )
    monkeypatch.setattr("nutamill.simulation.runs", sys.modules["nutamill.simulation.runs"], raising=False)
    figures = {"run": "picture", "power": "power"}
    drawn = types.SimpleNamespace(figure_of=lambda result, what: figures[what])
    monkeypatch.setitem(sys.modules, "nutamill.view.figures.named", drawn)
    monkeypatch.setitem(
        sys.modules, "nutamill.view.figures.saving", types.SimpleNamespace(save_figure=save_figure)
    )
    monkeypatch.setitem(
        sys.modules,
        "nutamill.analysis.summary",
        types.SimpleNamespace(
            summary_lines=lambda result: ["crank-pin force 981 N"], warning_lines=lambda result: []
        ),
    )
    return asked


def test_help_is_answered_without_any_heavy_import():
    heavy = [
        "numba",
        "numpy",
        "scipy",
        "scipy.signal",
        "xarray",
        "matplotlib",
        "h5py",
        "pydantic",
        "llvmlite",
    ]
    program = f"import sys, nutamill, nutamill.cli; print([name for name in {heavy} if name in sys.modules])"
    reply = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert reply.stdout.strip() == "[]"


def test_the_package_itself_is_the_command():
    reply = subprocess.run(
        [sys.executable, "-m", "nutamill", "--version"], capture_output=True, text=True, check=True
    )
    assert reply.stdout.startswith("nutamill ")


def test_new_writes_a_file_that_loads_and_never_over_another(invoke, tmp_path):
    assert invoke("new", "mymill.toml", "--from", "numill-2025").exit_code == 0
    text = (tmp_path / "mymill.toml").read_text()
    assert load_case(tmp_path / "mymill.toml").drive == load_case("numill-2025").drive
    again = invoke("new", "mymill.toml")
    assert (again.exit_code, again.stderr) == (
        2,
        "mymill.toml: exists already. Choose another name\n",
    )
    assert (tmp_path / "mymill.toml").read_text() == text


def test_show_prints_a_case_that_is_the_case(invoke):
    from nutamill.case import Case

    reply = invoke("show", "numill", "-s", "drive.speed=500 rpm")
    assert reply.exit_code == 0
    assert Case.from_toml(reply.stdout) == load_case("numill").with_(drive__speed="500 rpm")


def test_check_says_the_contacts_in_other_programs_when_asked(invoke, monkeypatch):
    sheet = types.SimpleNamespace(lines=lambda: ["the sheet"])
    monkeypatch.setattr("nutamill.simulation.warm_up.warm_up", lambda log, law: None)
    monkeypatch.setattr("nutamill.design.check.check", lambda case, trial: sheet)
    assert invoke("check", "numill").stdout == "the sheet\n"
    reply = invoke("check", "numill", "--dialects").stdout
    assert reply.startswith("the sheet\nsteel-steel: linear x displacement x type_c x none")
    assert "pair_coeff i j hooke 500000 0.5" in reply


@pytest.mark.parametrize(
    ("command", "held"), [("mount-test", ("time [s]", "displacement [mm]")), ("mounts", ("RADIUS DEPTH",))]
)
def test_help_swallows_no_brackets(invoke, command, held):
    reply = " ".join(invoke(command, "--help").stdout.replace("│", " ").split())
    assert all(text in reply for text in held)


def test_bad_input_prints_a_line_for_each_fault_on_stderr_and_exits_with_2(invoke):
    reply = invoke("show", "numill", "--set", "drive.sped=3", "--set", "charge.mass=20 kg")
    assert (reply.exit_code, reply.stdout) == (2, "")
    assert reply.stderr == '--set drive.sped: unknown key. Did you mean "speed"?\n'


def test_a_run_goes_to_a_file_named_by_the_case_and_its_digest(invoke, engine):
    reply = invoke("run", "numill", "-s", "chamber.ribs=12", "--threads", "2")
    assert reply.exit_code == 0, reply.output
    case = load_case("numill", ["chamber.ribs=12", "run.threads=2"])
    assert engine["case"] == case
    assert str(engine["to"]) == f"results/numill-{case.digest[:12]}.h5"
    assert engine["picture"] == engine["to"].with_suffix(".png")
    assert "crank-pin force 981 N" in reply.stdout


def test_a_quick_run_is_rigid_and_says_that_it_is_a_demonstration(invoke, engine):
    reply = invoke("run", "numill", "--quick", "--to", "a.h5")
    assert engine["case"].mechanism.mounting == "rigid"
    assert str(engine["to"]) == "a.h5"
    assert reply.stdout.startswith("demonstration: rigid mounts")


def test_a_run_that_fails_exits_with_1(invoke, engine):
    engine["fault"] = StepError("t=0.4 s: particle 812 overlaps. Take a smaller step.")
    reply = invoke("run", "numill")
    assert (reply.exit_code, reply.stderr.splitlines()[-1]) == (
        1,
        "t=0.4 s: particle 812 overlaps. Take a smaller step.",
    )


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        (Interrupted(Path("a.again.h5")), "interrupted, saved. Go on with: nutamill resume a.again.h5"),
        (KeyboardInterrupt(), "interrupted before the first step, there was nothing to save"),
    ],
)
def test_an_interrupted_run_says_how_to_go_on_and_exits_with_130(invoke, engine, fault, message):
    engine["fault"] = fault
    reply = invoke("run", "numill", "--to", "a.h5", "--again")
    assert (reply.exit_code, reply.stderr.splitlines()[-1], engine["again"]) == (130, message, True)


def test_resume_takes_a_new_end_with_its_unit(invoke, engine):
    assert invoke("resume", "a.h5", "--until", "20 s").exit_code == 0
    assert (str(engine["path"]), engine["until"]) == ("a.h5", "20 s")


def test_resume_refuses_an_end_without_unit(invoke):
    wrong = invoke("resume", "a.h5", "--until", "20")
    assert (wrong.exit_code, wrong.stderr) == (
        2,
        '--until: needs a unit: write "20 s" (a plain number is ambiguous)\n',
    )


def test_show_of_a_result_says_its_means_its_state_and_where_it_comes_from(invoke, engine, monkeypatch):
    monkeypatch.setitem(
        sys.modules, "nutamill.result", types.SimpleNamespace(open_result=lambda path: OneResult())
    )
    assert invoke("show", "a.h5").stdout.split() == [
        "crank-pin",
        "force",
        "981",
        "N",
        "state",
        "complete",
        "substep",
        "3",
        "us",
        "seed",
        "1",
    ]


def test_info_fields_names_each_recorded_quantity_with_its_unit(invoke):
    reply = invoke("info", "fields")
    assert any(line.split()[:3] == ["driveshaft_torque", "N", "m"] for line in reply.stdout.splitlines())


def test_the_schema_knows_every_key_of_a_published_mill(invoke):
    schema = json.loads(invoke("schema").stdout)
    written = load_case("numill").model_dump(mode="json", by_alias=True, exclude_none=True)
    assert set(written) | {"base", "changed_from"} == set(schema["properties"])
    assert set(written["chamber"]) <= set(schema["$defs"]["Chamber"]["properties"])
    assert "required" not in schema["$defs"]["Chamber"]


def test_an_unknown_command_exits_with_2(invoke):
    assert invoke("runn", "numill").exit_code == 2
