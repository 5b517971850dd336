"""A file of another kind than a command takes is recognised, called what it is, and sent to the command that
takes it.
"""

from pathlib import Path

import h5py
import pytest

from nutamill.analysis.breakage.ore import load_ore
from nutamill.analysis.measured_mapping import load_mapping
from nutamill.analysis.mount_test import read_mount_test
from nutamill.analysis.ratings import load_ratings
from nutamill.base.errors import CaseError, ResultError
from nutamill.base.file_kind import FileKind, file_kind
from nutamill.case import load_case
from nutamill.result import open_result
from nutamill.studies.fit_file import load_fit
from nutamill.studies.identify.identify_file import load_identification
from nutamill.studies.papers.library import read_paper
from nutamill.studies.sweep_file import is_sweep_file, load_sweep

ROOT = Path(__file__).parents[2]
TEXTS = {
    FileKind.CASE: 'base = "numill"\n[drive]\nspeed = "500 rpm"\n',
    FileKind.MECHANISM: '[[bodies]]\nname = "arm"\n',
    FileKind.SWEEP: 'case = "numill"\n[sweep]\n"drive.speed" = "1..2 rpm / 2"\n',
    FileKind.FIT: 'case = "numill"\n[free]\n"drive.speed" = { start = "1 rpm", low = "1 rpm", high = "2 '
    'rpm" }\n',
    FileKind.IDENTIFY: 'case = "numill"\n[unknown.friction]\nlow = 0.0\n',
    FileKind.RATINGS: '[bearings.crank_pin]\nkind = "ball"\n',
    FileKind.ORE: "[drop_weight]\nA = 50.0\n",
    FileKind.MAPPING: '[channel.driveshaft_torque]\ncolumn = "Mz"\n',
    FileKind.PAPER: '[configurations.empty]\ntitle = "empty"\n',
    FileKind.RECORD: "Time,Mz\n0,1\n",
    FileKind.MOUNT_TEST: "time [s],displacement [mm],force [N]\n",
    FileKind.MESH: "solid a\nendsolid a\n",
    FileKind.PICTURE: "",
    FileKind.DOCUMENT: "<!DOCTYPE html>",
    FileKind.RESULT: "",
}
SUFFIX = {
    FileKind.RECORD: ".csv",
    FileKind.MOUNT_TEST: ".csv",
    FileKind.MESH: ".stl",
    FileKind.PICTURE: ".png",
    FileKind.RESULT: ".h5",
}
READERS = {
    load_case: (FileKind.CASE, FileKind.MECHANISM),
    load_sweep: (FileKind.SWEEP,),
    load_fit: (FileKind.FIT,),
    load_identification: (FileKind.IDENTIFY,),
    load_ratings: (FileKind.RATINGS,),
    load_ore: (FileKind.ORE,),
    load_mapping: (FileKind.MAPPING,),
    read_paper: (FileKind.PAPER,),
    read_mount_test: (FileKind.MOUNT_TEST, FileKind.RECORD),
    open_result: (FileKind.RESULT,),
}


def write(folder, kind):
    """A file of this kind, as small as its kind can be recognised."""
    path = folder / f"given{SUFFIX.get(kind, '.toml')}"
    if kind is FileKind.FOLDER:
        path.mkdir()
    elif kind is FileKind.RESULT:
        h5py.File(path, "w").close()
    elif kind is FileKind.PICTURE:
        path.write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(64))
    else:
        path.write_text(TEXTS[kind])
    return path


@pytest.mark.parametrize("kind", FileKind)
def test_a_file_is_recognised_by_its_content(tmp_path, kind):
    assert file_kind(write(tmp_path, kind)) is kind


@pytest.mark.parametrize(
    ("reader", "kind"),
    [
        pytest.param(reader, kind, id=f"{reader.__name__}-{kind.name}")
        for reader, wanted in READERS.items()
        for kind in FileKind
        if kind not in wanted
    ],
)
def test_a_reader_refuses_every_other_kind_by_name_and_says_which_command_takes_it(tmp_path, reader, kind):
    path = write(tmp_path, kind)
    with pytest.raises((CaseError, ResultError)) as raised:
        reader(path)
    message = str(raised.value)
    assert f"must be {READERS[reader][0].label}, got {kind.label}" in message
    assert (f"It is for: {kind.command.format(path)}" in message) == bool(kind.command)


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("schema = 1\n[sweep]\nx = 1\n[chamber]\nribs = 2\n", FileKind.CASE),
        ("", None),
        ("a = 1\n", None),
        ("not = toml = at all", None),
        ("\xff\x00", None),
        ("x = " + "[" * 5000, None),
        ("x = " + "9" * 5000, None),
    ],
)
def test_a_file_of_no_known_kind_is_left_to_the_reader_and_a_mill_stays_a_mill(tmp_path, text, kind):
    path = tmp_path / "a.toml"
    path.write_bytes(text.encode("latin-1"))
    assert file_kind(path) is kind
    assert not is_sweep_file(str(path))


def test_a_name_of_the_library_and_a_missing_file(tmp_path):
    assert file_kind("numill") is FileKind.CASE
    assert file_kind(tmp_path / "nothing.toml") is None
    with pytest.raises(
        CaseError, match=r"numill: must be a fit file, got a case of a mill\. It is for: nutamill run numill"
    ):
        load_fit("numill")


@pytest.mark.parametrize("path", sorted((ROOT / "examples").rglob("*.toml")), ids=lambda path: path.stem)
def test_every_file_among_the_examples_is_recognised(path):
    wanted = {
        "ratings": FileKind.RATINGS,
        "friction-law": FileKind.FIT,
        "joint-friction": FileKind.FIT,
        "empty-mill-identified": FileKind.IDENTIFY,
        "spring-identified": FileKind.IDENTIFY,
        "trough-identified": FileKind.IDENTIFY,
        "trough-channels": FileKind.MAPPING,
        "wet-pellets": FileKind.SWEEP,
    }
    assert file_kind(path) is wanted.get(path.stem, FileKind.MECHANISM)
