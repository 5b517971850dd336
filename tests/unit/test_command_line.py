"""What all commands share: one option for output, help in 80 columns, completion of what is typed."""

import re
import types

import pytest
from typer.main import get_command
from typer.testing import CliRunner

from nutamill import cli
from nutamill.cli import completion
from nutamill.view.figures.named import FIGURES, SERIES_FIGURES

COMMANDS = get_command(cli.app).commands
WITHOUT_OUTPUT = {
    "check",
    "show",
    "schema",
    "bench",
    "verify",
    "info",
    "resume",
    "new",
    "doctor",
    "explain",
    "cite",
    "ui",
}
"""Commands that print, or change the file that they are given."""


@pytest.fixture
def invoke(tmp_path, monkeypatch):
    """Run a command in an empty folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    return lambda *words: CliRunner().invoke(cli.app, words)


def test_every_command_that_writes_a_file_takes_its_place_by_one_option():
    written = {name: command for name, command in COMMANDS.items() if name not in WITHOUT_OUTPUT}
    options = {name: {tuple(one.opts) for one in command.params} for name, command in written.items()}
    assert [name for name, known in options.items() if ("--to", "-o") not in known] == []


@pytest.mark.parametrize("words", [(), *((name,) for name in COMMANDS)], ids=lambda words: " ".join(words))
def test_help_fits_80_columns_and_names_no_type_of_python(invoke, words):
    reply = invoke(*words, "-h")
    assert reply.exit_code == 0
    assert max(map(len, reply.stdout.splitlines())) <= 80
    assert not re.search(r"<(bool|str|path|int|float|list)", reply.stdout)


def test_help_lists_every_command_under_a_heading_with_a_whole_sentence(invoke):
    text = invoke("--help").stdout
    assert all(f"  {name} " in text for name in COMMANDS) and "..." not in text.split("Run a case")[1]
    assert text.index("Run a case:") < text.index("  run ") < text.index("Look at results:")


def test_colour_is_spelt_either_way():
    opts = [one.opts for name in ("picture", "movie") for one in COMMANDS[name].params]
    assert opts.count(["--colour", "--color"]) == 2


def test_machines_and_case_files_are_completed(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("numbers.toml", "numbers.h5", "other.toml"):
        (tmp_path / name).touch()
    (tmp_path / "numerics").mkdir()
    mills = ["numill", "numill-2025", "numill-2026", "numill-identified"]
    assert completion.cases("num") == [*mills, "numbers.toml", "numerics/"]
    (tmp_path / "numerics" / "a.toml").touch()
    assert completion.cases("numerics/") == ["numerics/a.toml"]


def test_results_are_completed_also_those_of_the_folder_of_results(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "results").mkdir()
    (tmp_path / "results" / "a.h5").touch()
    assert completion.results("results/") == ["results/a.h5"]
    (tmp_path / "b.h5").touch()
    assert completion.results("") == ["b.h5", "results/"]


def complete(monkeypatch, *words):
    """What the shell gets for these words, the last of them unfinished."""
    line = {"COMP_WORDS": " ".join(["nutamill", *words]), "COMP_CWORD": str(len(words))}
    reply = CliRunner().invoke(
        cli.app, [], env={"_NUTAMILL_COMPLETE": "complete_bash", **line}, prog_name="nutamill"
    )
    return reply.stdout.split()


def test_the_shell_completes_commands_keys_and_figures(monkeypatch):
    assert complete(monkeypatch, "pict") == ["picture"]
    assert "drive.speed=" in complete(monkeypatch, "run", "numill", "-s", "drive.sp")
    assert complete(monkeypatch, "run", "piston", "-s", "drive.sp") == []
    assert complete(monkeypatch, "plot", "a.h5", "imp") == ["impacts"]


def test_figures_and_the_series_of_the_result_are_completed(filmed):
    context = types.SimpleNamespace(params={"file": filmed.path})
    assert completion.figures(context, "") == [*FIGURES, *(f"{name}:" for name in SERIES_FIGURES)]
    assert completion.figures(context, "history:driveshaft_to") == ["history:driveshaft_torque"]
    both = completion.figures(context, "spectrum:driveshaft_torque,crank_pin_force_res")
    assert "spectrum:driveshaft_torque,crank_pin_force_resultant" in both
