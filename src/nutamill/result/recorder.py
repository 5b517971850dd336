"""`Recorder` writes a result file: what waits, and when it reaches the disk."""

import contextlib
import os
import time as clock
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, BinaryIO, Self

import h5py
import numpy as np

from nutamill.base.atomic_file import make_folder, replace_file, tidy
from nutamill.base.errors import CaseError, DamagedError, Fault, MillError, ResultError
from nutamill.base.files import exists
from nutamill.result.archive import Archive, all_stored
from nutamill.result.checkpoints import WholeCheckpoint, whole_at, whole_until
from nutamill.result.checksums import GROWING, Checksums, array_bytes, new_hash
from nutamill.result.fields import Field, series_field, snapshot_field, statistics_field
from nutamill.result.layout import FORMAT, FORMAT_VERSION, Checkpoint, WallMesh, fixed_texts, write_attributes
from nutamill.result.parts import CHECKPOINTS, PACKED, edited, empty_file, write_arrays, write_checkpoint
from nutamill.result.reader import series_names, series_values

CHUNK = 1024
"""Samples in one compressed block of a series; a commit between checkpoints writes whole blocks only."""
FIRST_PAUSE = 5.0
"""Shortest time between two commits [s]; with a run's first minutes in mind, when the file is small."""
COMMIT_SHARE = 0.02
"""Largest share of the run's wall time that commits may take."""
SERIES_ROOM = 2**16
"""Room that an empty series may take in a file [bytes]."""
DELETED_STAYS = os.name == "posix"
"""Whether the content of a deleted file stays as long as the file is open, and an open file can be
replaced.
"""


class Recorder:
    """Writes one result file; made by `create` or `reopen`.

    Nothing reaches the file before a `commit`, and a commit that fails loses nothing: it may be repeated.
    """

    def __init__(self, path: Path, checksums: Checksums, digests: dict[str, Any], wall_time: float):
        self.path = path
        self.names = tuple(digests)
        self._checksums = checksums
        self._digests = digests
        """Running digest of the numbers of each series in the file."""
        self._rows_in_file = checksums.entries["series/time"].shape[0]
        self._snapshots_in_file, self._statistics_in_file = (
            len(checksums.moments[group]) for group in GROWING
        )
        self._rows: list[np.ndarray] = []
        self._snapshots: list[tuple[float, dict[str, np.ndarray]]] = []
        self._statistics: list[tuple[float, dict[str, np.ndarray]]] = []
        self._checkpoints: list[tuple[Checkpoint, dict[str, int]]] = []
        self._attributes: dict[str, Any] = {}
        self._summary: dict[str, Any] | None = None
        self._started = clock.monotonic() - wall_time
        self._next_commit = clock.monotonic() + FIRST_PAUSE
        self._saved_at = clock.monotonic()
        self._size = 0
        self._last_commit: BinaryIO | None = None
        self._hold_commit()

    @classmethod
    def create(
        cls,
        path: str | Path,
        case_toml: str,
        provenance: Mapping[str, Any],
        series: Sequence[str | Field],
        rate: float,
        overwrite: bool = False,
        axes: Mapping[str, np.ndarray] | None = None,
        walls: Mapping[str, WallMesh] | None = None,
    ) -> Self:
        """Start a new result file. It is readable, and empty, as soon as this returns.

        Parameters
        ----------
        path : the file; its folder is made if needed
        case_toml : the whole case file
        provenance : texts and numbers, as `nutamill.base.provenance.run_provenance` collects them
        series : recorded quantities, or their names in `nutamill.result.fields`; the first is ``"time"``
        rate : samples per simulated second [Hz]
        overwrite : replace a file of this name
        axes : what the statistics lie along, by the names of `nutamill.result.fields.STATISTICS_AXES`; None
            without statistics
        walls : vertices, triangles and carrier of meshed walls, as in `WallMesh`, by their key in the
            case; so pictures need no other file

        Raises
        ------
        CaseError : names that are no recorded quantities, or the same name twice
        ResultError : the file exists, or cannot be written
        """
        path = Path(path)
        fields = _checked_fields(series)
        names = [field.name for field in fields]
        if exists(path) and not overwrite:
            raise ResultError(f"{path}: exists already. Choose another name.")
        make_folder(path)
        tidy(path)

        def fill(file: h5py.File) -> None:
            began = {"format": FORMAT, "format_version": FORMAT_VERSION, "state": "running"}
            write_attributes(file, {**began, "rate": float(rate)})
            file["case"] = fixed_texts(case_toml)
            write_attributes(file.create_group("provenance"), {**provenance, "wall_time": 0.0})
            series = file.create_group("series")
            write_attributes(series, {"names": names})
            for field in fields:
                data = series.create_dataset(
                    field.name, (0,), "f8", maxshape=(None,), chunks=(CHUNK,), **PACKED
                )
                write_attributes(data, field.attributes())
                if field.name == "time":
                    data.make_scale("time")
                else:
                    data.dims[0].attach_scale(series["time"])
            file.create_group("snapshots")
            file.create_group("checkpoints")
            lines = file.create_group("statistics").create_group("axes")
            for name, array in (axes or {}).items():
                lines[name] = fixed_texts(array) if array.dtype.kind == "U" else array
                write_attributes(lines[name], statistics_field(name).attributes())
            for name, wall in (walls or {}).items():
                mesh = file.create_group(f"walls/{name}")
                corners = mesh.create_dataset("vertices", data=wall.vertices, **PACKED)
                write_attributes(corners, {"units": "m", "carrier": wall.carrier})
                mesh.create_dataset("triangles", data=wall.triangles, **PACKED)
            Checksums.of_new(file).write(file)

        meshed = sum(wall.vertices.nbytes + wall.triangles.nbytes for wall in (walls or {}).values())
        replace_file(
            path,
            edited(fill),
            room=len(case_toml) + meshed + SERIES_ROOM * (len(names) + 2),
            start=empty_file(),
        )
        with Archive(path) as archive:
            return cls(path, archive.required_checksums, {name: new_hash() for name in names}, 0.0)

    @classmethod
    def reopen(cls, path: str | Path, truncate_after_time: float) -> Self:
        """Continue a file from its checkpoint at `truncate_after_time` [s]. What was recorded after it is
        dropped.

        The series and snapshots of a resumed run are then those of a run that was never interrupted.

        Raises ResultError if the file cannot be read or holds no checkpoint of that time.
        """
        path = Path(path)
        tidy(path)
        with Archive(path) as archive:
            if archive.checksums is None:
                raise ResultError(
                    f"{path}: was written by format {archive.version}, which has no checksums: its "
                    "checkpoint cannot be"
                    " verified and is not continued. Run the case again."
                )
            last = whole_at(archive, truncate_after_time)
            if last is None:
                raise ResultError(
                    f"{path}: must hold a whole checkpoint at t = {truncate_after_time:g} s."
                    f" `nutamill verify {path}` lists those it holds."
                )
            archive.attributes("")
            wall_time = archive.attributes("provenance").get("wall_time", 0.0)
            digests = {name: new_hash() for name in series_names(archive)}
            count = archive.shape("series/time")[0]
            for name, digest in digests.items():
                digest.update(array_bytes(series_values(archive, name, count)[: last.before[0]]))
            checksums = _cut_off(archive, last, digests)
        slots_left = checksums.members("checkpoints")

        def cut(file: h5py.File) -> None:
            try:
                cut_off(file)
            except (
                Exception
            ) as fault:  # HDF5 raises many kinds on a damaged file; errors of the system have a number
                if isinstance(fault, MillError) or getattr(fault, "errno", None):
                    raise
                raise DamagedError(path, "/", str(fault)) from fault

        def cut_off(file: h5py.File) -> None:
            for group, length in zip(("series", "snapshots", "statistics"), last.before, strict=True):
                for name, data in file[group].items():
                    if not isinstance(data, h5py.Dataset):
                        continue
                    if not all_stored(data):  # HDF5 would look for every number that is claimed
                        what = f"the numbers of its shape {data.shape} are not all in the file"
                        raise DamagedError(path, f"/{group}/{name}", what)
                    data.resize(length, axis=0)
            for slot in set(file["checkpoints"]) - slots_left:
                with contextlib.suppress(
                    Exception
                ):  # too damaged even for that: it stays, and is never used again
                    del file["checkpoints"][slot]
            write_attributes(file, {"state": "running"})
            checksums.take_one(file, "")
            checksums.write(file)

        replace_file(path, edited(cut), room=SERIES_ROOM * len(digests) + checksums.room)
        return cls(path, checksums, digests, wall_time)

    def append(self, rows: np.ndarray) -> None:
        """Add samples: (n, n_names) in SI, columns in the order of `names`."""
        rows = np.array(rows, dtype=np.float64, ndmin=2)
        if rows.shape[1] != len(self.names):
            raise ValueError(
                f"rows: must have {len(self.names)} columns, one per name, got shape {rows.shape}"
            )
        if len(rows):
            self._rows.append(rows)

    def snapshot(self, time: float, arrays: Mapping[str, np.ndarray]) -> None:
        """Add a snapshot: arrays named in `nutamill.result.fields`, of the same shapes in every snapshot of a
        file.
        """
        for name in arrays:
            snapshot_field(name)
        self._snapshots.append((float(time), {name: np.array(array) for name, array in arrays.items()}))

    def statistics(self, time: float, arrays: Mapping[str, np.ndarray]) -> None:
        """Add what the charge has done by `time` [s]: cumulative arrays named in
        `nutamill.result.fields.STATISTICS`.
        """
        for name in arrays:
            statistics_field(name)
        self._statistics.append((float(time), {name: np.array(array) for name, array in arrays.items()}))

    def checkpoint(
        self,
        time: float,
        groups: Mapping[str, Mapping[str, np.ndarray]],
        attributes: Mapping[str, Any] | None = None,
    ) -> None:
        """Keep the state at `time` [s] for resuming. All samples and snapshots up to it must have been added
        before.

        The file keeps the two newest.  `attributes` are numbers and texts that belong to the state.
        """
        copies = {
            name: {key: np.array(array) for key, array in arrays.items()} for name, arrays in groups.items()
        }
        before = {
            "rows": self._rows_in_file + sum(map(len, self._rows)),
            "snapshots": self._snapshots_in_file + len(self._snapshots),
            "statistics": self._statistics_in_file + len(self._statistics),
        }
        self._checkpoints.append((Checkpoint(float(time), copies, dict(attributes or {})), before))
        del self._checkpoints[: -len(CHECKPOINTS)]
        self._saved_at = clock.monotonic()

    @property
    def unsaved(self) -> float:
        """Wall time since the newest checkpoint, or since the file was opened [s]."""
        return clock.monotonic() - self._saved_at

    def summary(self, values: Mapping[str, Any]) -> None:
        """Set the numbers, texts and (nested) tables of them that are stored under ``/summary``."""
        self._summary = dict(values)

    def state(self, text: str) -> None:
        """Set the state of the run: ``running``, ``interrupted``, ``complete`` or ``failed: ...``."""
        self._attributes["state"] = text

    @property
    def size(self) -> int:
        """Size of the file as of the last commit [bytes]."""
        return self._size

    def commit(self, force: bool = False) -> bool:
        """Bring the file up to date if it is time for it, or at once with `force`, and return whether it was.

        Raises
        ------
        ResultError : the disk is full or cannot be written; the file is as it was, and the commit may be
            repeated. Or the file was deleted, on a system that does not keep the content of a deleted file
        """
        begun = clock.monotonic()
        if not force and begun < self._next_commit:
            return False
        rows = np.concatenate(self._rows) if self._rows else np.empty((0, len(self.names)))
        taken = len(rows)
        if not force and not self._checkpoints:
            # a block that is rewritten leaves a hole in the file: between checkpoints only whole blocks go
            # out
            taken = max(0, (self._rows_in_file + taken) // CHUNK * CHUNK - self._rows_in_file)
        checksums = self._checksums.copy()
        digests = {name: digest.copy() for name, digest in self._digests.items()}
        before = None if self.path.exists() else self._deleted_content()
        replace_file(
            self.path,
            edited(lambda file: self._write(file, rows[:taken], checksums, digests)),
            self._room(taken),
            before,
        )
        self._hold_commit()
        self._checksums, self._digests = checksums, digests
        self._rows = [rows[taken:]] if taken < len(rows) else []
        self._rows_in_file += taken
        self._snapshots_in_file += len(self._snapshots)
        self._statistics_in_file += len(self._statistics)
        self._snapshots, self._statistics, self._checkpoints, self._attributes, self._summary = (
            [],
            [],
            [],
            {},
            None,
        )
        ended = clock.monotonic()
        self._next_commit = ended + max(FIRST_PAUSE, (ended - begun) / COMMIT_SHARE)
        return True

    def close(self) -> None:
        """Commit what is left."""
        self.commit(force=True)
        if self._last_commit is not None:
            self._last_commit.close()
            self._last_commit = None

    def _hold_commit(self) -> None:
        """Hold what has just been committed, so that it can be written anew if somebody deletes or moves the
        file.
        """
        held, self._last_commit = self._last_commit, None
        with contextlib.suppress(OSError):  # deleted already
            self._size = self.path.stat().st_size
            if DELETED_STAYS:
                self._last_commit = self.path.open("rb")
        if held is not None:
            held.close()

    def _deleted_content(self) -> BinaryIO:
        """Return what the file held that is not there any more."""
        if self._last_commit is None:
            raise ResultError(
                f"{self.path}: was deleted or moved during the run, which cannot go on without it. "
                "Put it back and resume it,"
                " or run the case again."
            )
        make_folder(self.path)
        return self._last_commit

    def _room(self, rows: int) -> int:
        """Return an upper bound of what a commit adds to the file [bytes]: the numbers unpacked, and the
        indices of their blocks.
        """
        arrays = [array for _, arrays in self._snapshots + self._statistics for array in arrays.values()]
        arrays += [
            array
            for checkpoint, _ in self._checkpoints
            for group in checkpoint.groups.values()
            for array in group.values()
        ]
        numbers = 8 * rows * len(self.names) + sum(array.nbytes for array in arrays)
        return int(1.25 * numbers) + 2**15 * (len(self.names) + len(arrays)) + 2**20 + self._checksums.room

    def _write(
        self, file: h5py.File, rows: np.ndarray, checksums: Checksums, digests: dict[str, Any]
    ) -> None:
        """Put all that waits into the open copy of the file, and bring `checksums` and `digests` up to
        date.
        """
        end = self._rows_in_file + len(rows)
        for column, name in enumerate(self.names if len(rows) else ()):
            data, numbers = file["series"][name], np.ascontiguousarray(rows[:, column])
            data.resize(end, axis=0)
            data[self._rows_in_file :] = numbers
            digests[name].update(array_bytes(numbers))
            checksums.extend_series(name, end, digests[name])
        for group, waiting, field in (
            ("snapshots", self._snapshots, snapshot_field),
            ("statistics", self._statistics, statistics_field),
        ):
            if waiting:
                checksums.append_moments(file, group, write_arrays(file[group], waiting, field))
        for checkpoint in self._checkpoints:
            checksums.take(
                file, write_checkpoint(file["checkpoints"], *checkpoint, checksums.members("checkpoints"))
            )
        if self._summary is not None:
            if "summary" in file:
                del file["summary"]
            write_attributes(file.create_group("summary"), self._summary)
            checksums.take(file, "summary")
        write_attributes(file, self._attributes)
        file["provenance"].attrs["wall_time"] = clock.monotonic() - self._started
        checksums.take_one(file, "")
        checksums.take_one(file, "provenance")
        checksums.write(file)


def _cut_off(archive: Archive, last: WholeCheckpoint, digests: dict[str, Any]) -> Checksums:
    """Return the checksums of a file that ends at a checkpoint. `digests` are those of the series up to
    there.
    """
    checksums = archive.required_checksums.copy()
    rows, *moments = last.before
    for name, digest in digests.items():
        checksums.extend_series(name, rows, digest)
    for group, count in zip(GROWING, moments, strict=True):
        del checksums.moments[group][count:]
    for slot in checksums.members("checkpoints") - whole_until(archive, last.checkpoint.time):
        checksums.drop(f"checkpoints/{slot}")
    return checksums


def _checked_fields(series: Sequence[str | Field]) -> list[Field]:
    """Return the fields given, or the registered ones of names. Raises CaseError with all faults at once."""
    names = [one.name if isinstance(one, Field) else one for one in series]
    faults = (
        [] if names and names[0] == "time" else [Fault("record", "must begin with time", 'Put "time" first.')]
    )
    faults += [
        Fault(f"record {name}", "must be named once, is named twice")
        for name in sorted({name for name in names if names.count(name) > 1})
    ]
    fields: list[Field] = []
    for one in series:
        try:
            fields.append(one if isinstance(one, Field) else series_field(one))
        except CaseError as error:
            faults += error.faults
    if faults:
        raise CaseError(*faults)
    return fields
