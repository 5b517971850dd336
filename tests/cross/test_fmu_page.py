"""The ten lines of docs/fmi.md, as they are printed there; runs are shorter and without a charge."""

import re
import shutil
from pathlib import Path

import pytest
from box_and_ball import BALL, BOX
from fmu_bench import compiled, write_fmu
from packaged_fmu import packaged
from typer.testing import CliRunner

from nutamill import cli
from nutamill.case import load_case
from nutamill.result import open_result
from nutamill.simulation.fmus.mapping import fmu_plans

pytest.importorskip("fmpy", reason="needs the extra fmu")
pytestmark = [
    pytest.mark.external,
    pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler"),
]

PAGE = (Path(__file__).parents[2] / "docs" / "fmi.md").read_text(encoding="utf-8")
SHORT = ["-s", "charge.kind=none", "-s", "run.until=10 ms"]


def blocks(heading, language=""):
    """The blocks of a language under a heading, commands if it is empty."""
    text = PAGE.partition(f"## {heading}")[2].partition("\n## ")[0]
    return [
        code for kind, code in re.findall(r"^```(\w*)\n(.*?)^```$", text, re.S | re.M) if kind == language
    ]


def commands(heading):
    """The commands under a heading as words, without their comments."""
    return [line.partition("#")[0].split()[1:] for line in "".join(blocks(heading)).splitlines()]


def typed(*words):
    """What a command prints."""
    done = CliRunner().invoke(cli.app, words)
    assert done.exit_code == 0, done.output
    return done.output


def test_our_machine_in_fmpy(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (export,) = commands("Our machine in FMPy, in ten lines")
    assert export == ["export", "fmu", "numill", "--to", "mill.fmu"]
    typed(*export)
    (code,) = blocks("Our machine in FMPy, in ten lines", "python")
    assert len(code.splitlines()) <= 10
    space = {}
    exec(code.replace("stop_time=1.0", "stop_time=0.02"), space)
    result = space["result"]
    assert len(result) == 0.02 * 4800 + 1
    assert result["driveshaft_speed"][-1] > 0.0


def test_their_motor_on_our_shaft(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    heading = "Their motor on our shaft, in ten lines"
    (text,) = blocks(heading, "toml")
    assert len([line for line in text.splitlines() if line]) <= 10
    (tmp_path / "motor.toml").write_text(text, encoding="utf-8")
    write_fmu(tmp_path / "motor.fmu", compiled(tmp_path))
    check, run = commands(heading)
    assert "gets w; gives M" in typed(*check, *SHORT)
    typed(*run, *SHORT, "-o", "a.h5")
    with open_result("a.h5") as result:
        assert result.series.driveshaft_speed.values[-1] > 0.0
        assert result.series.motor_work.values[-1] > 0.0


def test_their_machine_around_our_charge(tmp_path):
    """Its names are those of an oscillator that a package carries."""
    packaged("crane-fmu", "HarmonicOscillator6D.fmu", tmp_path)
    (text,) = blocks("Their machine around our charge", "toml")
    (tmp_path / "box.toml").write_text(BOX + BALL, encoding="utf-8")
    changed = text.replace("machine.fmu", "HarmonicOscillator6D.fmu")
    (tmp_path / "case.toml").write_text(changed, encoding="utf-8")
    (plan,) = fmu_plans(load_case(tmp_path / "case.toml"))
    assert len(plan.inputs) == 6
    assert len(plan.outputs) == 9
