"""The SLURM job script of a run on many processes, and `nutamill submit`."""

import stat

import pytest
from typer.testing import CliRunner

from nutamill import cli

CASE = 'base = "numill"\ncharge.engine = "lammps"\nrun.statistics = false\n'


@pytest.fixture
def invoke(tmp_path, monkeypatch):
    """Run a command in a folder with a case, where no queue is."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", str(tmp_path))
    (tmp_path / "big.toml").write_text(CASE)
    return lambda *words: CliRunner().invoke(cli.app, words)


def test_the_script_shares_the_processes_among_the_nodes_and_goes_on_with_a_result(invoke, tmp_path):
    answer = invoke("submit", "big.toml", "--nodes", "2", "--ranks", "64", "--hours", "1.5")
    assert answer.exit_code == 0, answer.output
    text = (tmp_path / "big.sh").read_text()
    for line in ("--nodes=2", "--ntasks=64", "--ntasks-per-node=32", "--time=01:30:00"):
        assert f"#SBATCH {line}\n" in text
    result = text.split("if [ -e ")[1].split(" ]")[0]
    assert result.startswith("results/big-")
    assert f"srun nutamill resume {result}\n" in text
    assert f"srun nutamill run big.toml --to {result}\n" in text
    assert "there is no sbatch here" in answer.stdout


@pytest.mark.parametrize(
    ("changes", "words", "message"),
    [
        ("", ("--nodes", "3", "--ranks", "64"), "--ranks: must be a multiple of the 3 nodes, got 64"),
        ("", ("--hours", "0.01"), "--hours: must be at least 5 minutes"),
        (
            "none",
            ("--ranks", "4"),
            'charge.engine: a run on many processes needs charge.engine = "lammps"',
        ),
    ],
)
def test_a_job_that_cannot_be_is_refused(invoke, tmp_path, changes, words, message):
    if changes:
        (tmp_path / "big.toml").write_text('base = "numill"\n')
    answer = invoke("submit", "big.toml", *words)
    assert answer.exit_code == 2
    assert message in answer.stderr
    assert not (tmp_path / "big.sh").exists()


@pytest.mark.parametrize(
    ("code", "answered"), [(0, "Submitted batch job 7"), (1, "sbatch refused it: no such")]
)
def test_a_queue_gets_the_script(invoke, tmp_path, code, answered):
    queue = tmp_path / "sbatch"
    queue.write_text(f'#!/bin/sh\necho "Submitted batch job 7"\necho "no such account" >&2\nexit {code}\n')
    queue.chmod(queue.stat().st_mode | stat.S_IXUSR)
    answer = invoke("submit", "big.toml")
    assert answered in answer.output
    assert (answer.exit_code == 0) == (code == 0)
