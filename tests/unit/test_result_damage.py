"""A damaged or hostile result: refused in one sentence, never used without a word, and resumed from what is
whole.
"""

import random
import warnings

import h5py
import numpy as np
import pytest
from typer.testing import CliRunner

from nutamill.base.errors import DamagedError, ResultError
from nutamill.case import load_case
from nutamill.cli import app
from nutamill.result import Recorder, open_result, verify
from nutamill.result.checksums import COPIES, Checksums
from nutamill.result.fields import expand
from nutamill.simulation import runs

NAMES = ["time", "crank_angle", "driveshaft_torque"]
CASE = 'title = "a mill"\nschema = 1\n' + "# every word of the case counts\n" * 40


@pytest.fixture
def path(tmp_path):
    """A result of 3000 samples with snapshots, statistics and two checkpoints."""
    numbers = np.random.default_rng(1)
    file = tmp_path / "a.h5"
    axes = {"energy": 2.0 ** np.arange(8.0), "pair": np.array(["steel-steel", "steel-rubber"])}
    recorder = Recorder.create(file, CASE, {"seed": 7, "versions": {"numpy": "2"}}, NAMES, 1000.0, axes=axes)
    for k in range(3):
        rows = np.arange(1000 * k, 1000 * k + 1000)
        recorder.append(np.stack([rows / 1000.0, 10.0 * rows, numbers.standard_normal(1000)], axis=1))
        recorder.snapshot(k + 0.5, {"positions": numbers.random((50, 3), np.float32)})
        recorder.statistics(k + 1.0, {"impact_number": numbers.random((2, 2, 8))})
        recorder.checkpoint(
            k + 1.0, {"charge": {"x": numbers.random((100, 3)), "ids": np.arange(100)}}, {"windows": k}
        )
    recorder.summary({"power": 663.0, "shares": {"mounts": 0.05}})
    recorder.state("complete")
    recorder.close()
    return file


def content(path):
    """Everything that a reader of a result gets, as comparable values."""
    with open_result(path) as result:
        series, statistics, checkpoint = result.series, result.statistics, result.checkpoint()
        return [
            (result.case_text, result.state, result.rate, result.summary, result.provenance),
            [(str(name), one.values.tobytes(), one.attrs) for name, one in series.variables.items()],
            [(str(name), one.values.tolist(), one.attrs) for name, one in statistics.variables.items()],
            [{name: array.tobytes() for name, array in snapshot.items()} for snapshot in result.snapshots],
            (
                checkpoint.time,
                checkpoint.attributes,
                [array.tobytes() for group in checkpoint.groups.values() for array in group.values()],
            ),
        ]


def places_of(path, name):
    """Where the file holds the numbers of a dataset: first byte and length of each block."""
    with h5py.File(path, "r") as file:
        data = file[name]
        if data.chunks is None:
            return [(data.id.get_offset(), data.id.get_storage_size())]
        blocks = [data.id.get_chunk_info(k) for k in range(data.id.get_num_chunks())]
        return [(block.byte_offset, block.size) for block in blocks]


def flip(path, byte, bit=3):
    """Flip one bit of a file."""
    raw = bytearray(path.read_bytes())
    raw[byte] ^= 1 << bit
    path.write_bytes(raw)


# what HDF5 would read from, or write to, other files


def external(file, victim):
    del file["checkpoints/a/charge/x"]
    file["checkpoints/a/charge"].create_dataset(
        "x", (100, 3), "f8", external=[(str(victim), 0, h5py.h5f.UNLIMITED)]
    )


def linked(file, victim):
    with h5py.File(victim.with_suffix(".h5"), "w") as other:
        other["x"] = np.arange(3.0)
    del file["snapshots"]
    file["snapshots"] = h5py.ExternalLink(str(victim.with_suffix(".h5")), "/")


def virtual(file, victim):
    with h5py.File(victim.with_suffix(".h5"), "w") as other:
        other["x"] = np.arange(3000.0)
    layout = h5py.VirtualLayout((3000,), "f8")
    layout[:] = h5py.VirtualSource(str(victim.with_suffix(".h5")), "x", (3000,))
    del file["series/crank_angle"]
    file["series"].create_virtual_dataset("crank_angle", layout)


def soft(file, victim):
    del file["series/crank_angle"]
    file["series/crank_angle"] = h5py.SoftLink("/series/time")


HOSTILE = [(external, "stores its numbers in another file"), (linked, "is a link to another file")]
HOSTILE += [(virtual, "is a virtual dataset"), (soft, "is a link")]


@pytest.mark.parametrize(("craft", "words"), HOSTILE, ids=[craft.__name__ for craft, _ in HOSTILE])
def test_result_that_refers_to_another_file_is_refused_by_every_reader_and_writer(
    path, tmp_path, craft, words
):
    victim = tmp_path / "victim.txt"
    victim.write_bytes(b"mine " * 1000)
    earlier = Recorder.reopen(path, 3.0)  # a writer at work when the file is put in its place
    with h5py.File(path, "r+") as file:
        craft(file, victim)
    earlier.append(np.array([[3.0, 0.0, 0.0]]))
    acts = [
        open_result,
        verify,
        lambda path: Recorder.reopen(path, 3.0),
        lambda path: earlier.commit(force=True),
    ]
    for act in acts:
        with pytest.raises(ResultError, match=words):
            act(path)
    for command in ("show", "verify", "resume", "view", "report", "orders"):
        done = CliRunner().invoke(app, [command, str(path)])
        assert done.exit_code == 2
        assert isinstance(done.exception, SystemExit)
        assert words in done.output.splitlines()[-1]
    assert victim.read_bytes() == b"mine " * 1000


# damage


@pytest.mark.parametrize("part", ["case", "checkpoints", "statistics", "anywhere"])
def test_no_flipped_bit_is_used_without_a_word(path, tmp_path, part):
    true, whole, draw = content(path), path.read_bytes(), random.Random(1)
    if part == "case":
        places = [(whole.index(CASE.encode()), len(CASE))]
    elif part == "checkpoints":
        places = [
            place
            for slot in "ab"
            for name in ("x", "ids")
            for place in places_of(path, f"checkpoints/{slot}/charge/{name}")
        ]
    elif part == "statistics":
        names = ("impact_number", "time", "axes/energy", "axes/pair")
        places = [place for name in names for place in places_of(path, f"statistics/{name}")]
    else:
        places = [(0, len(whole))]
    damaged = tmp_path / "b.h5"
    for _ in range(40):
        first, length = draw.choice(places)
        damaged.write_bytes(whole)
        flip(damaged, first + draw.randrange(length), draw.randrange(8))
        try:
            read = content(damaged)
        except (ResultError, DamagedError) as error:
            assert "\n" not in str(error)
            continue
        if read != true:  # it may be the older checkpoint, if the file names the damage to the newer one
            assert read[:-1] == true[:-1]
            with open_result(damaged) as result:
                assert result.damaged_checkpoints()


def test_verify_lists_what_is_damaged_and_which_checkpoint_is_whole(path):
    assert verify(path).faults == []
    assert verify(path).continues_from == 3.0
    with h5py.File(path, "r") as file:
        newest = max("ab", key=lambda slot: file[f"checkpoints/{slot}"].attrs["time"])
    flip(path, places_of(path, f"checkpoints/{newest}/charge/x")[0][0] + 800)
    flip(path, places_of(path, "snapshots/positions")[1][0] + 30)
    done = CliRunner().invoke(app, ["verify", str(path)])
    assert done.exit_code == 2
    text = done.output
    assert f"/checkpoints/{newest}/charge/x: its content differs from its checksum" in text
    assert "snapshots     DAMAGED  2 of 3 moments" in text
    assert "series        whole" in text
    assert "the newest whole checkpoint is at t = 2 s" in text


def test_older_checkpoint_is_used_when_the_newest_is_damaged_and_the_damage_is_named(path):
    with h5py.File(path, "r") as file:
        newest = max("ab", key=lambda slot: file[f"checkpoints/{slot}"].attrs["time"])
    flip(path, places_of(path, f"checkpoints/{newest}/charge/ids")[0][0] + 8)
    with open_result(path) as result:
        assert result.checkpoint().time == 2.0
        (damage,) = result.damaged_checkpoints()
    assert f"/checkpoints/{newest}/charge/ids is damaged" in damage
    resumed = Recorder.reopen(path, 2.0)
    assert verify(path).faults == []
    with open_result(path) as result:
        assert len(result.series["time"]) == 2000
    resumed.close()
    assert verify(path).faults == []


def test_checkpoint_whose_header_is_damaged_is_passed_over_and_never_used_again(path):
    with h5py.File(path, "r") as file:
        newest = max("ab", key=lambda slot: file[f"checkpoints/{slot}"].attrs["time"])
        headers = [
            h5py.h5o.get_info(file[f"checkpoints/{newest}{name}"].id).addr
            for name in ("", "/charge", "/charge/x")
        ]
    whole = path.read_bytes()
    for header in headers:
        path.write_bytes(whole)
        flip(path, header)
        with open_result(path) as result:
            assert result.checkpoint().time == 2.0
            assert len(result.damaged_checkpoints()) == 1
        resumed = Recorder.reopen(path, 2.0)
        for time in (3.0, 4.0):
            resumed.checkpoint(time, {"charge": {"x": np.full(3, time)}})
            resumed.commit(force=True)
        resumed.close()
        assert verify(path).faults == []
        assert verify(path).continues_from == 4.0


def test_result_with_no_whole_checkpoint_is_not_continued(path):
    for slot in "ab":
        flip(path, places_of(path, f"checkpoints/{slot}/charge/x")[0][0])
    with open_result(path) as result, pytest.raises(ResultError, match="no checkpoint of it is whole"):
        result.checkpoint()


OLDER = "older checkpoint at t = 0.005 s"


def test_run_is_resumed_from_the_older_checkpoint_to_the_bits_it_would_have_had(tmp_path):
    settings = [
        "charge.kind=none",
        "mechanism.mounting=rigid",
        "drive.ramp=7000 rpm/s",
        "run.checkpoint=5 ms",
    ]
    case = load_case("numill", [*settings, "run.until=10 ms"])
    runs.run(case, tmp_path / "whole.h5").close()
    true = (tmp_path / "whole.h5").read_bytes()
    runs.resume(tmp_path / "whole.h5", until=0.015).close()
    broken = tmp_path / "broken.h5"
    broken.write_bytes(true)
    with h5py.File(broken, "r") as file:
        newest = max("ab", key=lambda slot: file[f"checkpoints/{slot}"].attrs["time"])
    flip(broken, places_of(broken, f"checkpoints/{newest}/mechanism/velocity")[0][0] + 3)
    lines = []
    runs.resume(broken, until=0.015, log=lines.append).close()
    assert any("velocity is damaged" in line and OLDER in line for line in lines), lines
    with open_result(broken) as one, open_result(tmp_path / "whole.h5") as other:
        assert one.state == other.state == "complete"
        assert one.series.equals(other.series)
        assert one.checkpoint().groups["mechanism"]["velocity"].tobytes() == (
            other.checkpoint().groups["mechanism"]["velocity"].tobytes()
        )
    broken.write_bytes(true)
    flip(broken, places_of(broken, f"checkpoints/{newest}/mechanism/velocity")[0][0] + 3)
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        runs.resume(broken, until=0.015).close()  # without a listener it is a warning
    assert "older checkpoint" in str(heard[0].message)


def test_damaged_series_are_not_continued(path):
    flip(path, places_of(path, "series/driveshaft_torque")[0][0] + 40)
    with pytest.raises(DamagedError, match="/series/driveshaft_torque is damaged"):
        Recorder.reopen(path, 3.0)


@pytest.mark.parametrize("group", ["snapshots", "statistics"])
def test_a_length_that_the_file_cannot_hold_is_not_cut_off_number_by_number(path, group):
    """HDF5 looks for each of the claimed numbers, for hours, where no checksum has noticed the length."""
    with h5py.File(path, "r+") as file:
        name, data = next(
            (n, d) for n, d in file[group].items() if isinstance(d, h5py.Dataset) and d.ndim > 1
        )
        data.resize(10**6, axis=0)
    with pytest.raises(DamagedError, match=f"{group}/{name} is damaged: the numbers of its shape"):
        Recorder.reopen(path, 3.0)


@pytest.mark.parametrize("group", ["", "series"])
def test_a_name_that_is_no_text_is_damage(path, group):
    """HDF5 stores names as bytes; these are no UTF-8."""
    with h5py.File(path, "r+") as file:
        h5py.h5g.create(file[group or "/"].id, b"ti\xffme")
    (fault,) = {fault for part in verify(path).parts for fault in part.faults}
    assert fault.endswith(f"/{group}: it holds a name that is no text, b'ti\\xffme'")


def test_a_group_with_a_damaged_header_is_refused_in_a_sentence(path):
    """HDF5 cannot even say what such a group holds."""
    with h5py.File(path, "r") as file:
        header = h5py.h5o.get_info(file["series"].id).addr
    flip(path, header + 16)
    with open_result(path) as result, pytest.raises(DamagedError, match=r"/series/time is damaged: .*object"):
        _ = result.reached


def test_one_damaged_copy_of_the_checksums_does_no_harm_and_two_are_refused(path):
    true = content(path)
    for count, name in enumerate(COPIES):
        flip(path, places_of(path, name)[0][0] + 200)
        if count == 0:
            assert content(path) == true
    with pytest.raises(ResultError, match="its checksums are damaged, nothing in it can be verified"):
        open_result(path)


def test_checksums_of_a_result_that_grew_by_commits_are_those_of_one_written_at_once(path):
    """The running digests of the writer and digests of the finished content are the same."""
    with h5py.File(path, "r") as file:
        written, again = Checksums.read(file), Checksums({}, {})
        again.take(file, "")
    assert again.entries == written.entries


def test_commits_between_damage_elsewhere_do_not_hide_it(path):
    recorder = Recorder.reopen(path, 3.0)
    flip(path, places_of(path, "snapshots/positions")[0][0] + 30)
    recorder.append(np.array([[3.0, 0.0, 0.0]]))
    recorder.close()
    assert [fault.split(":")[0] for fault in verify(path).faults] == ["/snapshots"]


# files of format 1


@pytest.fixture
def early(path):
    """The same as format 1 has it: without checksums."""
    with h5py.File(path, "r+") as file:
        for name in COPIES:
            del file[name]
        file.attrs["format_version"] = 1
    return path


def test_file_of_format_1_is_read_and_shown_as_not_verifiable(early):
    with open_result(early) as result:
        assert not result.verifiable
        assert len(result.series["time"]) == 3000
        assert len(result.snapshots) == 3
    done = CliRunner().invoke(app, ["verify", str(early)])
    assert done.exit_code == 0
    assert "nothing in it can be verified" in done.output


def test_file_of_format_1_is_not_resumed(early):
    before = early.read_bytes()
    with pytest.raises(ResultError, match="its checkpoint cannot be verified and is not continued"):
        Recorder.reopen(early, 3.0)
    assert early.read_bytes() == before


def test_a_file_does_not_lose_its_checksums_by_naming_the_earlier_format(path):
    with h5py.File(path, "r+") as file:
        file.attrs["format_version"] = 1
    with pytest.raises(DamagedError, match="has no checksums, and holds some"):
        open_result(path)


def test_result_without_a_sample_is_shown(tmp_path):
    case = load_case("numill")
    Recorder.create(tmp_path / "a.h5", case.to_toml(), {}, expand(), 4800.0).close()
    done = CliRunner().invoke(app, ["show", str(tmp_path / "a.h5")])
    assert done.exit_code == 0
    assert "no steady means" in done.output
