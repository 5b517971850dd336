"""A first file of each kind is whole, names its schema, and the schema knows what is wrong with a file."""

import json
import re
import shutil
import subprocess

import pytest
from typer.testing import CliRunner

from nutamill import cli
from nutamill.analysis.breakage.ore import load_ore
from nutamill.analysis.measured_mapping import load_mapping
from nutamill.analysis.ratings import load_ratings
from nutamill.base.errors import CaseError, OutputError
from nutamill.base.file_kind import FileKind, file_kind
from nutamill.case import load_case
from nutamill.studies.fit_file import load_fit
from nutamill.studies.identify.problem import read_problem
from nutamill.studies.new_file import KINDS, schema_of, write_new
from nutamill.studies.sweep_file import load_sweep

READ = {
    "mill": load_case,
    "mechanism": load_case,
    "sweep": load_sweep,
    "fit": load_fit,
    "identify": read_problem,
    "ratings": load_ratings,
    "ore": load_ore,
    "mapping": load_mapping,
}


@pytest.mark.parametrize("kind", KINDS)
def test_a_new_file_is_read_by_the_command_that_it_is_for(kind, tmp_path):
    write_new(kind, tmp_path / "first.toml")
    READ[kind](tmp_path / "first.toml")
    expected = {"mill": FileKind.CASE}.get(kind, FileKind[kind.upper()] if kind != "mill" else None)
    assert file_kind(tmp_path / "first.toml") is expected


@pytest.mark.parametrize("kind", KINDS)
def test_a_new_file_names_the_schema_beside_it(kind, tmp_path):
    schema = write_new(kind, tmp_path / "first.toml")
    first = (tmp_path / "first.toml").read_text(encoding="utf-8").splitlines()[0]
    assert first == f"#:schema ./{schema.name}"
    assert json.loads(schema.read_text(encoding="utf-8")) == json.loads(json.dumps(schema_of(kind)))


def test_the_schema_of_a_quantity_takes_a_number_with_a_unit_only():
    drive = schema_of("mill")["$defs"]["DriveProgramme"]["properties"]
    pattern = re.compile(drive["speed"]["pattern"])
    taken = ("700 rpm", "700rpm", "1e3 rad/s", " -5.5 rpm")
    assert [text for text in (*taken, "700", "", "rpm", "7e2") if pattern.fullmatch(text)] == list(taken)
    until = json.dumps(schema_of("mill")["$defs"]["RunPlan"]["properties"]["until"])
    assert "|steady)" in until


def test_a_sweep_may_begin_with_another_case(tmp_path):
    write_new("sweep", tmp_path / "first.toml", "numill-2025")
    assert load_sweep(tmp_path / "first.toml")[0] == "numill-2025"


def test_what_cannot_be_written_is_refused(tmp_path):
    with pytest.raises(CaseError, match=r'must be one of mill, .*, got "swep"\. Did you mean "sweep"\?'):
        write_new("swep", tmp_path / "a.toml")
    with pytest.raises(CaseError, match="--from: has no use for a file of kind ratings"):
        write_new("ratings", tmp_path / "a.toml", "numill")
    (tmp_path / "a.toml").touch()
    with pytest.raises(CaseError, match=r"exists already\. Choose another name"):
        write_new("fit", tmp_path / "a.toml")
    assert not list(tmp_path.glob("*.json"))
    with pytest.raises(OutputError, match="cannot be written"):
        write_new("fit", tmp_path / "a.toml" / "b.toml")


def test_the_command_names_what_it_wrote_and_what_to_type_next(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    reply = CliRunner().invoke(cli.app, ["new", "a.toml", "--kind", "ratings"])
    expected = (
        "a.toml written, with nutamill-ratings.schema.json for editors. Next: nutamill life RESULT.h5 a.toml"
    )
    assert reply.stdout.strip() == expected
    reply = CliRunner().invoke(cli.app, ["schema", "sweep"])
    assert "readings" in json.loads(reply.stdout)["properties"]


@pytest.mark.external
@pytest.mark.skipif(shutil.which("taplo") is None, reason="needs taplo (npm install -g @taplo/cli)")
def test_an_editor_flags_a_wrong_key_and_a_missing_unit_at_their_place(tmp_path):
    def lint(*names):
        return subprocess.run(["taplo", "lint", *names], cwd=tmp_path, capture_output=True, text=True)

    for kind in KINDS:
        write_new(kind, tmp_path / f"{kind}.toml")
    assert lint(*(f"{kind}.toml" for kind in KINDS)).returncode == 0
    file = tmp_path / "mill.toml"
    lines = file.read_text(encoding="utf-8").splitlines()
    number = next(k for k, line in enumerate(lines) if line.startswith("speed "))
    lines[number] = 'speed = "700"\nspeeed = "700 rpm"'
    file.write_text("\n".join(lines), encoding="utf-8")
    reply = lint("mill.toml")
    assert reply.returncode != 0
    assert f"mill.toml:{number + 1}:9" in reply.stderr and "'speeed' was unexpected" in reply.stderr


def test_an_identification_may_begin_with_a_machine_of_parts(tmp_path):
    write_new("identify", tmp_path / "first.toml", "piston")
    problem = read_problem(tmp_path / "first.toml")
    assert problem.unknowns[0].keys == ("springs.spring.stiffness",)
    # 20 % about the 2 N/mm of the piston
    assert (problem.unknowns[0].low, problem.unknowns[0].high) == (1600.0, 2400.0)
