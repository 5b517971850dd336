"""The result file: what is put in comes out, and files that cannot be used are refused with the way out."""

import h5py
import numpy as np
import pytest
import xarray

from nutamill.base.errors import CaseError, ResultError
from nutamill.result import Recorder, open_result
from nutamill.result.recorder import CHUNK

NAMES = ["time", "crank_angle", "crank_pin_force_radial"]
CASE = 'title = "a mill with μ and °"\n'


def samples(first: int, end: int) -> np.ndarray:
    """Rows `first` to `end` of a record at 1000 Hz; each number encodes its position."""
    k = np.arange(first, end)
    return np.stack([k / 1000.0, 10.0 * k, np.sin(k)], axis=1)


def new(path, **options) -> Recorder:
    return Recorder.create(path, CASE, {"seed": 7, "package_version": "0.1"}, NAMES, 1000.0, **options)


def test_series_come_back_with_their_values_units_and_axes(tmp_path):
    recorder = new(tmp_path / "sub" / "a.h5")
    recorder.append(samples(0, 5))
    recorder.append(samples(5, 2500))
    recorder.close()
    with open_result(tmp_path / "sub" / "a.h5") as result:
        series = result.series
        assert result.rate == 1000.0
    assert set(series.variables) == set(NAMES)
    assert np.array_equal(series["crank_pin_force_radial"], np.sin(np.arange(2500)))
    assert np.array_equal(series["time"], np.arange(2500) / 1000.0)
    stored = series["crank_pin_force_radial"].attrs
    assert stored["units"] == "N"
    assert stored["symbol"] == "F_r"
    assert "crank_pin_load_cell" in stored["point"]
    assert "towards its axis" in stored["frame"]
    assert series["time"].attrs["units"] == "s"


def test_xarray_opens_the_series_without_this_package(tmp_path):
    recorder = new(tmp_path / "a.h5")
    recorder.append(samples(0, 100))
    recorder.close()
    with (
        xarray.open_dataset(tmp_path / "a.h5", group="series", engine="h5netcdf") as series,
        open_result(tmp_path / "a.h5") as result,
    ):
        assert "time" in series.coords
        assert series["time"].dtype == np.float64
        assert series["crank_angle"].attrs["long_name"] == "crank angle"
        assert series.equals(result.series)


def test_case_provenance_summary_and_state_come_back(tmp_path):
    recorder = new(tmp_path / "a.h5")
    with open_result(tmp_path / "a.h5") as result:
        assert result.state == "running"
        assert result.summary == {}
        assert len(result.series["time"]) == 0
    recorder.summary({"power": 663.0, "shares": {"mounts": 0.05, "note": "as run"}})
    recorder.state("complete")
    recorder.close()
    with open_result(tmp_path / "a.h5") as result:
        assert result.case_text == CASE
        assert result.provenance["seed"] == 7
        assert result.provenance["wall_time"] >= 0.0
        assert result.summary == {"power": 663.0, "shares": {"mounts": 0.05, "note": "as run"}}
        assert result.state == "complete"


def test_snapshots_are_read_one_by_one(tmp_path):
    recorder = new(tmp_path / "a.h5")
    for k in range(3):
        positions = np.full((4, 3), float(k))
        recorder.snapshot(0.1 * k, {"positions": positions, "velocities": np.empty((0, 3))})
        positions[:] = np.nan  # the recorder must have taken a copy
        recorder.commit(force=True)
    with open_result(tmp_path / "a.h5") as result:
        assert np.array_equal(result.snapshots.time, [0.0, 0.1, 0.2])
        assert [snapshot["positions"][2, 1] for snapshot in result.snapshots] == [0.0, 1.0, 2.0]
        assert result.snapshots[-1]["time"] == 0.2
        assert result.snapshots[0]["velocities"].shape == (0, 3)
        with pytest.raises(IndexError):
            result.snapshots[3]


def test_checkpoint_restores_every_bit(tmp_path):
    random = np.random.default_rng(1)
    groups = {
        "charge": {
            "x": random.standard_normal((5, 3)),
            "list": np.arange(4, dtype=np.int32),
            "rows": random.random((2, 8), dtype=np.float32),
        },
        "mechanism": {
            "time": np.array([0.1 + 0.2]),
            "odd": np.array([np.nan, -0.0, 5e-324]),
            "none": np.empty((0, 2)),
        },
    }
    recorder = new(tmp_path / "a.h5")
    recorder.checkpoint(0.1 + 0.2, groups, {"windows": 12})
    recorder.close()
    with open_result(tmp_path / "a.h5") as result:
        checkpoint = result.checkpoint()
    assert checkpoint.time == 0.1 + 0.2
    assert checkpoint.attributes == {"windows": 12}
    for group, arrays in groups.items():
        for name, array in arrays.items():
            read = checkpoint.groups[group][name]
            assert read.dtype == array.dtype
            assert read.shape == array.shape
            assert read.tobytes() == array.tobytes()


def test_newest_checkpoint_is_read_and_the_file_does_not_grow_with_their_number(tmp_path):
    recorder = new(tmp_path / "a.h5")
    sizes = []
    for k in range(6):
        recorder.checkpoint(float(k), {"charge": {"x": np.full(5000 + 10 * (k == 5), float(k))}})
        recorder.commit(force=True)
        sizes.append(recorder.size)
        with open_result(tmp_path / "a.h5") as result:
            checkpoint = result.checkpoint()
        assert checkpoint.time == k
        assert np.all(checkpoint.groups["charge"]["x"] == k)
    assert sizes[4] == sizes[1]


def test_between_checkpoints_only_whole_blocks_are_written(tmp_path):
    recorder = new(tmp_path / "a.h5")
    recorder.append(samples(0, CHUNK + 10))
    assert not recorder.commit()
    recorder._next_commit = 0.0
    assert recorder.commit()
    with open_result(tmp_path / "a.h5") as result:
        assert len(result.series["time"]) == CHUNK
    recorder.close()
    with open_result(tmp_path / "a.h5") as result:
        assert np.array_equal(result.series["crank_angle"], 10.0 * np.arange(CHUNK + 10))


def test_resumed_file_equals_an_uninterrupted_one(tmp_path):
    whole = new(tmp_path / "whole.h5")
    broken = new(tmp_path / "broken.h5")
    for recorder in (whole, broken):
        recorder.append(samples(0, 1500))
        recorder.snapshot(1.0, {"positions": np.ones((2, 3))})
        recorder.checkpoint(1.5, {"charge": {"x": np.ones(3)}})
        recorder.append(samples(1500, 1600))
        recorder.snapshot(1.55, {"positions": np.full((2, 3), 1.55)})
        recorder.checkpoint(1.6, {"charge": {"x": np.full(3, 1.6)}})
        recorder.commit(force=True)
    resumed = Recorder.reopen(tmp_path / "broken.h5", 1.5)
    assert resumed.names == tuple(NAMES)
    with open_result(tmp_path / "broken.h5") as result:
        assert result.checkpoint().time == 1.5
        assert len(result.series["time"]) == 1500
    resumed.append(samples(1500, 1600))
    resumed.snapshot(1.55, {"positions": np.full((2, 3), 1.55)})
    for recorder in (whole, resumed):
        recorder.append(samples(1600, 3000))
        recorder.close()
    with open_result(tmp_path / "whole.h5") as one, open_result(tmp_path / "broken.h5") as other:
        assert one.series.equals(other.series)
        assert np.array_equal(one.snapshots.time, other.snapshots.time)
        assert np.array_equal(one.snapshots[-1]["positions"], other.snapshots[-1]["positions"])


def test_wall_time_of_a_resumed_run_counts_on(tmp_path):
    recorder = new(tmp_path / "b.h5")
    recorder.checkpoint(0.0, {})
    recorder._started -= 1000.0  # as if it had run so long
    recorder.close()
    Recorder.reopen(tmp_path / "b.h5", 0.0).close()
    with open_result(tmp_path / "b.h5") as result:
        assert result.provenance["wall_time"] >= 1000.0


def test_resume_from_a_time_without_checkpoint_is_refused(tmp_path):
    new(tmp_path / "a.h5").close()
    with pytest.raises(ResultError, match="must hold a whole checkpoint at t = 1 s"):
        Recorder.reopen(tmp_path / "a.h5", 1.0)
    with open_result(tmp_path / "a.h5") as result, pytest.raises(ResultError, match="Run the case again"):
        result.checkpoint()


def test_names_that_are_no_quantities_are_refused_all_at_once(tmp_path):
    with pytest.raises(CaseError) as caught:
        Recorder.create(
            tmp_path / "a.h5", CASE, {}, ["crank_angle", "crank_angle", "crank_pin_force_radiall"], 1000.0
        )
    text = str(caught.value)
    assert len(caught.value.faults) == 3
    assert 'Did you mean "crank_pin_force_radial"?' in text
    assert "named twice" in text
    assert 'Put "time" first.' in text
    assert not (tmp_path / "a.h5").exists()


def test_row_of_the_wrong_width_is_refused(tmp_path):
    with pytest.raises(ValueError, match="3 columns"):
        new(tmp_path / "a.h5").append(np.zeros((2, 4)))


def test_an_existing_file_is_overwritten_only_on_request(tmp_path):
    new(tmp_path / "a.h5").close()
    with pytest.raises(ResultError, match="exists already"):
        new(tmp_path / "a.h5")
    new(tmp_path / "a.h5", overwrite=True).close()


def test_missing_file_is_named(tmp_path):
    with pytest.raises(ResultError, match=r"b\.h5: must be a result file, there is none"):
        open_result(tmp_path / "b.h5")


def test_a_truncated_file_and_a_foreign_one_have_different_messages(tmp_path):
    recorder = new(tmp_path / "a.h5")
    recorder.append(samples(0, 3000))
    recorder.close()
    content = (tmp_path / "a.h5").read_bytes()
    (tmp_path / "cut.h5").write_bytes(content[: len(content) * 2 // 3])
    with pytest.raises(ResultError, match="cut off"):
        open_result(tmp_path / "cut.h5")
    (tmp_path / "case.toml").write_text(CASE)
    with pytest.raises(ResultError, match=r"is no result file \(HDF5\)"):
        open_result(tmp_path / "case.toml")


def test_hdf5_file_of_another_program_is_refused(tmp_path):
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["a"] = 1.0
    with pytest.raises(ResultError, match="no result of nutamill"):
        open_result(tmp_path / "other.h5")


def test_file_of_a_newer_version_asks_for_an_update(tmp_path):
    new(tmp_path / "a.h5").close()
    with h5py.File(tmp_path / "a.h5", "r+") as file:
        file.attrs["format_version"] = 99
    with pytest.raises(
        ResultError, match=r"written by format 99, this version reads up to 2\. Update the package"
    ):
        open_result(tmp_path / "a.h5")


def test_closed_result_says_so_and_its_dataset_stays_usable(tmp_path):
    recorder = new(tmp_path / "a.h5")
    recorder.append(samples(0, 10))
    recorder.close()
    with open_result(tmp_path / "a.h5") as result:
        series = result.series
    assert float(series["crank_angle"][3]) == 30.0
    with pytest.raises(ResultError, match="has been closed"):
        print(result.state)
