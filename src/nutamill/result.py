"""The result file: `Recorder` writes it, `Result` reads it, and its layout is stated here, once.

One HDF5 file, no pickles, plain enough for any HDF5 reader::

    /                 attributes: format, format_version, state, rate [Hz]
    /case             the case file as text (TOML)
    /provenance       attributes: versions, digest of the kernels, seed, threads, processor, wall_time [s] ...
    /series/<name>    one number per sample; `time` is their common scale; attributes: units, long_name, symbol ...
                      (attribute `names` of the group: their order as recorded)
    /snapshots/<name> one array per snapshot, first axis `time`
    /statistics/<name> cumulative sums over what the charge did, first axis `time`; /statistics/axes/<name>: what they lie along
    /checkpoints/a, b the two newest; attributes: time, rows, snapshots, statistics; <group>/<array> restore a run bit for bit
    /summary          attributes: what was printed at the end

The file is whole at every instant (`nutamill.wholefile`): a commit replaces it by a copy with the new samples added.  Its
cost therefore grows with the file, and so does the pause between two commits.
"""

import time as clock
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, NamedTuple, Self

import h5py
import numpy as np

from nutamill.errors import CaseError, Fault, ResultError
from nutamill.fields import Field, series_field, snapshot_field, statistics_field
from nutamill.wholefile import io_errors, replace_file, tidy

if TYPE_CHECKING:
    import xarray

FORMAT = "nutamill result"
FORMAT_VERSION = 1
CHUNK = 1024
"""Samples in one compressed block of a series; a commit between checkpoints writes whole blocks only."""
CHECKPOINTS = ("a", "b")
BEFORE = ("rows", "snapshots", "statistics")
"""Attributes of a checkpoint: how much had been recorded before it."""
PACKED: dict[str, Any] = {"compression": "gzip", "compression_opts": 4, "shuffle": True}
FIRST_PAUSE = 5.0
"""Shortest time between two commits [s]; with a run's first minutes in mind, when the file is small."""
COMMIT_SHARE = 0.02
"""Largest share of the run's wall time that commits may take."""


class Checkpoint(NamedTuple):
    """A state kept for resuming."""

    time: float
    """Simulated time [s]."""
    groups: dict[str, dict[str, np.ndarray]]
    """Arrays of the state, in groups."""
    attributes: dict[str, Any]
    """Numbers and texts that belong to the state and are no arrays."""


class Recorder:
    """Writes one result file; made by `create` or `reopen`.

    Nothing reaches the file before a `commit`, and a commit that fails loses nothing: it may be repeated.
    """

    def __init__(self, path: Path, names: tuple[str, ...], rows: int, snapshots: int, statistics: int, wall_time: float):
        self.path = path
        self.names = names
        self._rows_in_file, self._snapshots_in_file, self._statistics_in_file = rows, snapshots, statistics
        self._rows: list[np.ndarray] = []
        self._snapshots: list[tuple[float, dict[str, np.ndarray]]] = []
        self._statistics: list[tuple[float, dict[str, np.ndarray]]] = []
        self._checkpoints: list[tuple[Checkpoint, dict[str, int]]] = []
        self._attributes: dict[str, Any] = {}
        self._summary: dict[str, Any] | None = None
        self._started = clock.monotonic() - wall_time
        self._next_commit = clock.monotonic() + FIRST_PAUSE

    @classmethod
    def create(
        cls,
        path: str | Path,
        case_toml: str,
        provenance: Mapping[str, Any],
        names: Sequence[str],
        rate: float,
        overwrite: bool = False,
        axes: Mapping[str, np.ndarray] | None = None,
    ) -> Self:
        """Start a new result file; it is readable, and empty, as soon as this returns.

        Parameters
        ----------
        path : the file; its folder is made if needed
        case_toml : the whole case file
        provenance : texts and numbers, as `nutamill.provenance.run_provenance` collects them
        names : recorded quantities of `nutamill.fields`, the first is ``"time"``
        rate : samples per simulated second [Hz]
        overwrite : replace a file of this name
        axes : what the statistics lie along, by the names of `nutamill.fields.STATISTICS_AXES`; None without statistics

        Raises
        ------
        CaseError : names that are no recorded quantities, or the same name twice
        ResultError : the file exists, or cannot be written
        """
        path = Path(path)
        fields = _checked_fields(names)
        if path.exists() and not overwrite:
            raise ResultError(
                f"{path}: must be a new file, it exists. Choose another name with --to, or continue it with `nutamill resume`."
            )
        with io_errors(path):
            path.parent.mkdir(parents=True, exist_ok=True)
        tidy(path)

        def fill(file: h5py.File) -> None:
            file.attrs.update({"format": FORMAT, "format_version": FORMAT_VERSION, "state": "running", "rate": float(rate)})
            file["case"] = case_toml
            _write_attributes(file.create_group("provenance"), {**provenance, "wall_time": 0.0})
            series = file.create_group("series")
            series.attrs["names"] = list(names)
            for field in fields:
                data = series.create_dataset(field.name, (0,), "f8", maxshape=(None,), chunks=(CHUNK,), **PACKED)
                data.attrs.update(field.attributes())
                if field.name == "time":
                    data.make_scale("time")
                else:
                    data.dims[0].attach_scale(series["time"])
            file.create_group("snapshots")
            file.create_group("checkpoints")
            lines = file.create_group("statistics").create_group("axes")
            for name, array in (axes or {}).items():
                lines[name] = array.astype(h5py.string_dtype()) if array.dtype.kind == "U" else array
                lines[name].attrs.update(statistics_field(name).attributes())

        replace_file(path, _edited(fill), room=len(case_toml) + 2**16 * (len(names) + 2), start=_empty_file())
        return cls(path, tuple(names), 0, 0, 0, 0.0)

    @classmethod
    def reopen(cls, path: str | Path, truncate_after_time: float) -> Self:
        """Continue a file from its checkpoint at `truncate_after_time` [s]; what was recorded after it is dropped.

        The series and snapshots of a resumed run are then those of a run that was never interrupted.

        Raises ResultError if the file cannot be read or holds no checkpoint of that time.
        """
        path = Path(path)
        tidy(path)
        with _opened(path) as file:
            slot = next((slot for slot in file["checkpoints"].values() if slot.attrs["time"] == truncate_after_time), None)
            if slot is None:
                raise ResultError(
                    f"{path}: must hold a checkpoint at t = {truncate_after_time:g} s. Give the time of one of its checkpoints."
                )
            rows, snapshots, statistics = (int(slot.attrs[name]) for name in BEFORE)
            names = tuple(str(name) for name in file["series"].attrs["names"])
            wall_time = float(file["provenance"].attrs["wall_time"])

        def cut(file: h5py.File) -> None:
            for group, length in (("series", rows), ("snapshots", snapshots), ("statistics", statistics)):
                for data in file[group].values():
                    if isinstance(data, h5py.Dataset):
                        data.resize(length, axis=0)
            for name, slot in list(file["checkpoints"].items()):
                if slot.attrs["time"] > truncate_after_time:
                    del file["checkpoints"][name]
            file.attrs["state"] = "running"

        replace_file(path, _edited(cut), room=2**16 * len(names))
        return cls(path, names, rows, snapshots, statistics, wall_time)

    def append(self, rows: np.ndarray) -> None:
        """Add samples: (n, n_names) in SI, columns in the order of `names`."""
        rows = np.array(rows, dtype=np.float64, ndmin=2)
        if rows.shape[1] != len(self.names):
            raise ValueError(f"rows: must have {len(self.names)} columns, one per name, got shape {rows.shape}")
        if len(rows):
            self._rows.append(rows)

    def snapshot(self, time: float, arrays: Mapping[str, np.ndarray]) -> None:
        """Add a snapshot: arrays named in `nutamill.fields`, of the same shapes in every snapshot of a file."""
        for name in arrays:
            snapshot_field(name)
        self._snapshots.append((float(time), {name: np.array(array) for name, array in arrays.items()}))

    def statistics(self, time: float, arrays: Mapping[str, np.ndarray]) -> None:
        """Add what the charge has done by `time` [s]: cumulative arrays named in `nutamill.fields.STATISTICS`."""
        for name in arrays:
            statistics_field(name)
        self._statistics.append((float(time), {name: np.array(array) for name, array in arrays.items()}))

    def checkpoint(self, time: float, groups: Mapping[str, Mapping[str, np.ndarray]], attributes: Mapping[str, Any] | None = None) -> None:
        """Keep the state at `time` [s] for resuming; all samples and snapshots up to it must have been added before.

        The file keeps the two newest.  `attributes` are numbers and texts that belong to the state.
        """
        kept = {name: {key: np.array(array) for key, array in arrays.items()} for name, arrays in groups.items()}
        before = {
            "rows": self._rows_in_file + sum(map(len, self._rows)),
            "snapshots": self._snapshots_in_file + len(self._snapshots),
            "statistics": self._statistics_in_file + len(self._statistics),
        }
        self._checkpoints.append((Checkpoint(float(time), kept, dict(attributes or {})), before))
        del self._checkpoints[: -len(CHECKPOINTS)]

    def summary(self, values: Mapping[str, Any]) -> None:
        """Numbers, texts and (nested) tables of them to be stored under ``/summary``."""
        self._summary = dict(values)

    def state(self, text: str) -> None:
        """State of the run: ``running``, ``interrupted``, ``complete`` or ``failed: ...``."""
        self._attributes["state"] = text

    @property
    def size(self) -> int:
        """Size of the file on the disk [bytes]."""
        return self.path.stat().st_size

    def commit(self, force: bool = False) -> bool:
        """Bring the file up to date if it is time for it, or at once with `force`; tells whether it did.

        Raises
        ------
        ResultError : the disk is full or cannot be written; the file is as it was, and the commit may be repeated
        """
        begun = clock.monotonic()
        if not force and begun < self._next_commit:
            return False
        rows = np.concatenate(self._rows) if self._rows else np.empty((0, len(self.names)))
        taken = len(rows)
        if not force and not self._checkpoints:
            # a block that is rewritten leaves a hole in the file: between checkpoints only whole blocks go out
            taken = max(0, (self._rows_in_file + taken) // CHUNK * CHUNK - self._rows_in_file)
        replace_file(self.path, _edited(lambda file: self._write(file, rows[:taken])), self._room(taken))
        self._rows = [rows[taken:]] if taken < len(rows) else []
        self._rows_in_file += taken
        self._snapshots_in_file += len(self._snapshots)
        self._statistics_in_file += len(self._statistics)
        self._snapshots, self._statistics, self._checkpoints, self._attributes, self._summary = [], [], [], {}, None
        ended = clock.monotonic()
        self._next_commit = ended + max(FIRST_PAUSE, (ended - begun) / COMMIT_SHARE)
        return True

    def close(self) -> None:
        """Commit what is left."""
        self.commit(force=True)

    def _room(self, rows: int) -> int:
        """Upper bound of what a commit adds to the file [bytes]: the numbers unpacked, and the indices of their blocks."""
        arrays = [array for _, arrays in self._snapshots + self._statistics for array in arrays.values()]
        arrays += [array for checkpoint, _ in self._checkpoints for group in checkpoint.groups.values() for array in group.values()]
        numbers = 8 * rows * len(self.names) + sum(array.nbytes for array in arrays)
        return int(1.25 * numbers) + 2**15 * (len(self.names) + len(arrays)) + 2**20

    def _write(self, file: h5py.File, rows: np.ndarray) -> None:
        """Put all that waits into the open copy of the file."""
        end = self._rows_in_file + len(rows)
        for column, name in enumerate(self.names if len(rows) else ()):
            data = file["series"][name]
            data.resize(end, axis=0)
            data[self._rows_in_file :] = rows[:, column]
        if self._snapshots:
            _write_arrays(file["snapshots"], self._snapshots, snapshot_field)
        if self._statistics:
            _write_arrays(file["statistics"], self._statistics, statistics_field)
        for checkpoint in self._checkpoints:
            _write_checkpoint(file["checkpoints"], *checkpoint)
        if self._summary is not None:
            if "summary" in file:
                del file["summary"]
            _write_attributes(file.create_group("summary"), self._summary)
        file.attrs.update(self._attributes)
        file["provenance"].attrs["wall_time"] = clock.monotonic() - self._started


class Snapshots(Sequence):
    """The snapshots of a result; each is read when it is asked for: ``result.snapshots[-1]["positions"]``."""

    def __init__(self, result: "Result"):
        self._result = result

    @property
    def time(self) -> np.ndarray:
        """Simulated times [s], (n_snapshots,)."""
        group = self._result.file["snapshots"]
        return group["time"][:] if "time" in group else np.empty(0)

    def __len__(self) -> int:
        return len(self.time)

    def __getitem__(self, index: int) -> dict[str, Any]:
        """The arrays of one snapshot and its ``time``; names, units and axes as in `nutamill.fields.SNAPSHOT`."""
        if not -len(self) <= index < len(self):
            raise IndexError(f"snapshot {index}: the result holds {len(self)}")
        return {name: data[index % len(self)] for name, data in self._result.file["snapshots"].items()}


class Result:
    """A result file opened for reading; made by `open_result`, closed by ``with`` or `close`."""

    def __init__(self, path: Path, file: h5py.File):
        self.path = path
        self._file = file
        self._series: xarray.Dataset | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        """Let go of the file; a dataset got from `series` stays usable."""
        self._file.close()

    @property
    def file(self) -> h5py.File:
        """The open file; ResultError after `close`."""
        if not self._file:
            raise ResultError(f"{self.path}: must be open, it has been closed. Open it again with open_result.")
        return self._file

    @property
    def case_text(self) -> str:
        """The case file (TOML) that was run."""
        return self.file["case"].asstr()[()]

    @property
    def state(self) -> str:
        """``running``, ``interrupted``, ``complete`` or ``failed: ...``; a killed run still says ``running``."""
        return str(self.file.attrs["state"])

    @property
    def rate(self) -> float:
        """Samples per simulated second [Hz]."""
        return float(self.file.attrs["rate"])

    @property
    def reached(self) -> float:
        """Simulated time of the last sample [s]; 0 before the first."""
        time = self.file["series/time"]
        return float(time[-1]) if len(time) else 0.0

    @property
    def provenance(self) -> dict[str, Any]:
        """What made these numbers: versions, digest of the kernels, seed, threads, processor, wall time [s]."""
        return _read_attributes(self.file["provenance"])

    @property
    def summary(self) -> dict[str, Any]:
        """What was printed at the end of the run; empty if it has not ended."""
        return _read_attributes(self.file["summary"]) if "summary" in self.file else {}

    @property
    def series(self) -> "xarray.Dataset":
        """All series over ``time`` [s], in memory; each variable carries units, long_name, symbol, frame and point."""
        if self._series is None:
            import xarray  # takes half a second: a summary does not need it

            group = self.file["series"]
            hidden = {"CLASS", "NAME", "DIMENSION_LIST", "REFERENCE_LIST"}
            read = {
                name: ("time", group[name][:], {key: text for key, text in group[name].attrs.items() if key not in hidden})
                for name in group.attrs["names"]
            }
            self._series = xarray.Dataset(read, attrs={"source": self.path.name, "state": self.state, "rate": self.rate}).set_coords("time")
        return self._series

    @property
    def statistics(self) -> "xarray.Dataset":
        """What the charge has done, cumulative over ``time`` [s], in memory; names, units and axes as in `nutamill.fields.STATISTICS`.

        The difference of two times belongs to the window between them: `nutamill.charge_flow.window` makes it.
        """
        import xarray

        group = self.file["statistics"]
        if "time" not in group:
            raise ResultError(f"{self.path}: must hold statistics of the charge, it holds none. Run it with run.statistics = true.")
        lines = {}
        for name, data in group["axes"].items():
            values = data.asstr()[:] if h5py.check_string_dtype(data.dtype) else data[:]
            lines[name] = (_dims(name), values, dict(data.attrs))
        sums = {
            name: (("time", *_dims(name)), data[:], dict(data.attrs))
            for name, data in group.items()
            if isinstance(data, h5py.Dataset) and name != "time"
        }
        lines["time"] = ("time", group["time"][:], dict(group["time"].attrs))
        return xarray.Dataset(sums, lines, attrs={"source": self.path.name, "state": self.state})

    @property
    def snapshots(self) -> Snapshots:
        """The snapshots, read one by one."""
        return Snapshots(self)

    def checkpoint(self) -> Checkpoint:
        """The newest state kept for resuming; ResultError if there is none."""
        slots = self.file["checkpoints"].values()
        if not len(slots):
            raise ResultError(f"{self.path}: must hold a checkpoint to be continued, it holds none. Run the case again.")
        slot = max(slots, key=lambda slot: slot.attrs["time"])
        attributes = _read_attributes(slot, inner=False)
        groups = {name: {key: data[()] for key, data in group.items()} for name, group in slot.items()}
        return Checkpoint(attributes.pop("time"), groups, {key: attributes[key] for key in attributes if key not in BEFORE})


def _dims(name: str) -> tuple[str, ...]:
    """Dimensions of a statistics array besides time, as its field names them."""
    inside = statistics_field(name).shape.strip("()")
    return tuple(part.strip() for part in inside.split(",") if part.strip())


def open_result(path: str | Path) -> Result:
    """Open a result file for reading; it may still be growing, and then shows the last commit.

    Raises
    ------
    ResultError : no such file, cut off, no result of this package, or written by a newer one
    """
    return Result(Path(path), _opened(Path(path)))


def _opened(path: Path) -> h5py.File:
    """The file, open for reading, checked to be ours and whole."""
    if not path.is_file():
        raise ResultError(f"{path}: must be a result file, there is none of this name. Look in results/ or run the case first.")
    try:
        file = h5py.File(path, "r")
    except OSError as fault:
        if h5py.is_hdf5(path):
            raise ResultError(
                f"{path}: must be whole, it is cut off or damaged ({fault}). Copy it again, or run the case again."
            ) from fault
        raise ResultError(f"{path}: must be a result file (HDF5), it is not. Give the .h5 file that `nutamill run` has written.") from fault
    if file.attrs.get("format") != FORMAT:
        file.close()
        raise ResultError(
            f"{path}: must be a result of nutamill, it is an HDF5 file of another kind. Give the file that `nutamill run` has written."
        )
    version = int(file.attrs["format_version"])
    if version > FORMAT_VERSION:
        file.close()
        raise ResultError(f"{path}: written by format {version}, this version reads up to {FORMAT_VERSION}. Update the package.")
    return file


def _checked_fields(names: Sequence[str]) -> list[Field]:
    """The registered fields of `names`; all faults at once."""
    faults = [] if names and names[0] == "time" else [Fault("record", "must begin with time", 'Put "time" first.')]
    faults += [
        Fault(f"record {name}", "must be named once, is named twice") for name in sorted({name for name in names if names.count(name) > 1})
    ]
    fields: list[Field] = []
    for name in names:
        try:
            fields.append(series_field(name))
        except CaseError as error:
            faults += error.faults
    if faults:
        raise CaseError(*faults)
    return fields


def _write_attributes(group: h5py.Group, values: Mapping[str, Any]) -> None:
    """Numbers and texts as attributes, nested tables as groups of attributes."""
    for key, value in values.items():
        if isinstance(value, Mapping):
            _write_attributes(group.create_group(key), value)
        else:
            group.attrs[key] = value


def _read_attributes(group: h5py.Group, inner: bool = True) -> dict[str, Any]:
    """What `_write_attributes` wrote, as plain Python numbers and texts; `inner`: with the nested tables."""
    values = {key: value.item() if isinstance(value, np.generic) else value for key, value in group.attrs.items()}
    return values | ({key: _read_attributes(table) for key, table in group.items()} if inner else {})


def _write_arrays(group: h5py.Group, snapshots: list[tuple[float, dict[str, np.ndarray]]], field: Callable[[str], Field]) -> None:
    """Append arrays, one compressed block each, to datasets whose first axis is time."""
    if "time" not in group:
        group.create_dataset("time", (0,), "f8", maxshape=(None,), chunks=(256,)).attrs["units"] = "s"
        for name, array in snapshots[0][1].items():
            longest = (None, *(n or None for n in array.shape))  # a block must fit, and an empty charge has no length
            blocks = (1, *(max(1, n) for n in array.shape))
            data = group.create_dataset(name, (0, *array.shape), array.dtype, maxshape=longest, chunks=blocks, **PACKED)
            data.attrs.update(field(name).attributes())
    first = len(group["time"])
    for data in group.values():
        if isinstance(data, h5py.Dataset):
            data.resize(first + len(snapshots), axis=0)
    for k, (time, arrays) in enumerate(snapshots, start=first):
        group["time"][k] = time
        for name, array in arrays.items():
            group[name][k] = array


def _write_checkpoint(group: h5py.Group, checkpoint: Checkpoint, before: Mapping[str, int]) -> None:
    """Write a checkpoint over the older of the two; arrays of unchanged size keep their place, so that the file does not grow."""
    free = [name for name in CHECKPOINTS if name not in group]
    slot = group.require_group(free[0] if free else min(group, key=lambda name: group[name].attrs["time"]))
    for name in set(slot) - set(checkpoint.groups):
        del slot[name]
    for name, arrays in checkpoint.groups.items():
        place = slot.require_group(name)
        for key in list(place):
            array = arrays.get(key)
            if array is None or place[key].shape != array.shape or place[key].dtype != array.dtype:
                del place[key]
        for key, array in arrays.items():
            if key in place:
                place[key][...] = array
            else:
                place[key] = array
    for key in list(slot.attrs):
        del slot.attrs[key]
    slot.attrs.update({**checkpoint.attributes, "time": checkpoint.time, **before})


def _edited(edit: Callable[[h5py.File], None]) -> Callable[[Path], None]:
    """`edit`, given the path of the copy; HDF5 gives reserved room back when it closes the file."""

    def edit_path(part: Path) -> None:
        with h5py.File(part, "r+") as file:
            edit(file)

    return edit_path


def _empty_file() -> bytes:
    """An empty HDF5 file, made in memory: HDF5 must not be the one to find the disk full."""
    with h5py.File("empty", "w", driver="core", backing_store=False) as file:
        file.flush()
        return file.id.get_file_image()
