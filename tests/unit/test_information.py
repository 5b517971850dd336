"""The installation, the keys of a case, how to cite, and lines that a terminal can hold."""

import sys

import pytest
from typer.testing import CliRunner

from nutamill import cli
from nutamill.base.citation import PAPERS, citation_lines
from nutamill.base.errors import CaseError, ExitCode, StepError
from nutamill.case.toml.explain import explained
from nutamill.cli.paragraphs import broken
from nutamill.design import doctor as room
from nutamill.design.doctor import Check, doctor, lacking_packages


@pytest.fixture
def quiet(monkeypatch):
    """No window and no film are tried."""
    monkeypatch.setattr(room, "opengl_trouble", lambda: "pictures need OpenGL")
    monkeypatch.setattr(room, "ffmpeg_trouble", str)


def test_doctor_runs_the_empty_mill_and_finds_its_ledger_closed(quiet):
    checks = {check.what: check for check in doctor()}
    assert {"nutamill", "processor", "memory", "libraries", "kernels", 'extra "view"'} <= set(checks)
    assert checks["self-test"].state == "ok" and "the energy ledger closes to" in checks["self-test"].text
    assert checks["OpenGL"].line == "missing OpenGL           pictures need OpenGL"
    assert "numba " in checks["libraries"].text


def test_doctor_reports_what_is_missing_and_how_to_install_it(quiet, monkeypatch):
    monkeypatch.setattr(room, "lacking_packages", lambda: {"view": ["pyvista"], "dev": ["ruff"]})
    monkeypatch.setattr(room, "run", lambda case, to: (_ for _ in ()).throw(StepError("t = 0 s: blow-up.")))
    monkeypatch.setattr(room, "cache_trouble", lambda: "compiled kernels are not stored")
    checks = {check.what: check for check in doctor()}
    assert checks['extra "view"'].text.startswith('pyvista: pip install ".[view]" in your clone')
    assert 'extra "dev"' not in checks
    assert checks["self-test"] == Check("self-test", "FAULT", "t = 0 s: blow-up.")
    assert checks["kernels"].line == "FAULT   kernels          compiled kernels are not stored"
    assert CliRunner().invoke(cli.app, ["doctor"]).exit_code == ExitCode.FAILED


def test_lacking_packages_are_those_of_the_extras(monkeypatch):
    asked = ['pyvista>=0.46; extra == "view"', 'no-such-thing>=1; extra == "view"', "numpy>=1"]
    monkeypatch.setattr(room.importlib.metadata, "requires", lambda name: asked)
    monkeypatch.setattr(room, "_version", lambda name: "" if name == "no-such-thing" else "1")
    assert lacking_packages() == {"view": ["no-such-thing"]}


def test_explain_gives_quantity_units_value_source_and_note():
    lines = explained("chamber.height")
    assert lines[0] == "chamber.height: Free height between floor and ceiling [m]."
    assert lines[1] == '  takes   length, e.g. "5 mm"; units: m, mm, cm, um, in'
    assert lines[2] == "  value   228 mm in numill"
    assert lines[3] == "  source  fitted to a published number"
    assert "bulk fractions" in lines[4]


def test_explain_lists_the_choices_of_a_key_and_the_keys_of_a_table():
    assert '  takes   "prescribed", "staggered", "iterated"' in explained("run.coupling")
    assert "  takes   a whole number" in explained("chamber.ribs")
    table = explained("chamber")
    assert table[0] == "chamber: a table" and any("chamber.ribs" in line for line in table)


def test_explain_reads_the_note_where_the_value_was_set(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text('base = "numill"\n[drive]\nspeed = "500 rpm"  # A the old motor\n', encoding="utf-8")
    lines = explained("drive.speed", str(file))
    assert f"  value   500 rpm in {file}" in lines
    assert lines[-2:] == ["  source  assumed", "  note    the old motor"]
    assert "  value   2 N/mm" not in explained("springs", "piston")


def test_explain_refuses_an_unknown_key_with_the_keys_that_were_meant():
    with pytest.raises(CaseError, match=r'"ribs": is no key of this case\. Did you mean chamber\.ribs\?'):
        explained("ribs")
    with pytest.raises(CaseError, match=r"is no key of this case\. Tables: .*chamber, "):
        explained("zzzzqqq")


def test_cite_names_the_package_and_both_papers():
    text = "\n".join(citation_lines())
    assert all(paper.title in text and str(paper.year) in text for paper in PAPERS)
    entries = citation_lines(bibtex=True)
    assert entries[0].startswith("@software{nutamill,") and entries[1].count("{") == entries[1].count("}")
    assert "author = {Janse van Vuuren, H. C. and Bredell, J. R. and Coetzee, C. J.}" in entries[1]
    assert CliRunner().invoke(cli.app, ["cite"]).stdout.strip() == text


LINE = "machine   6 bodies, 4 mounts, 84.54 kg in all; loop closes within 0.001 um; nutation 6.08 deg"


def test_a_line_too_wide_for_the_terminal_is_broken_between_words_under_its_text():
    lines = broken(LINE, 60).split("\n")
    assert max(map(len, lines)) <= 60 and lines[1].startswith(" " * 10) and lines[1][10] != " "
    assert " ".join(" ".join(lines).split()) == " ".join(LINE.split())


def test_a_line_for_a_file_or_another_program_is_left_whole(capsys):
    from nutamill.cli.paragraphs import echo_lines

    assert not sys.stdout.isatty()
    echo_lines([LINE, "x" * 300])
    assert capsys.readouterr().out == f"{LINE}\n{'x' * 300}\n"


def test_a_list_of_parts_names_them_and_the_keys_of_each():
    bodies = explained("bodies", "planetary-mill")
    assert bodies[1] == "  3 in planetary-mill: sun, jar_1, jar_2"
    assert any(line.startswith("  bodies.sun.mass ") and "Mass [kg]" in line for line in bodies)
    assert explained("gears", "piston")[1] == "  none in piston"
    assert explained("charge.part", "planetary-mill")[1] == "  2 in planetary-mill: 0, 1"
    assert "  value   0.2 kg in piston" in explained("bodies.0.mass", "piston")
    guide = explained("joints.guide", "piston")
    assert guide[0] == "joints.guide: an entry of joints"
    assert any(line.startswith("  joints.guide.axis ") for line in guide)
    with pytest.raises(CaseError, match="is no key of this case"):
        explained("joints.gide", "piston")
