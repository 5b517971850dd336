"""`Archive`: a result file open for reading, whose every reading is compared with its checksums.

Whatever is damaged ends in a DamagedError that names the object.  Nothing is read before its type, its shape
and the room it takes in the file agree, so that a damaged shape claims no memory.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Self

import h5py
import numpy as np

from nutamill.base.errors import DamagedError, ResultError
from nutamill.result.checksums import (
    COPIES,
    GROWING,
    Checksums,
    array_digest,
    attributes_digest,
    grows,
    moment_digest,
    plain_attributes,
    whole_content,
)
from nutamill.result.layout import FIRST_WITH_CHECKSUMS
from nutamill.result.opening import opened

LARGEST_BLOCK = 2**27
"""Largest block of a dataset that is stored in blocks [bytes]; HDF5 reads whole blocks."""


class Archive:
    """A result file open for reading.

    Raises
    ------
    ResultError : as `opened`, and from checksums that are damaged
    DamagedError : from every method, where what it reads is damaged
    """

    def __init__(self, path: str | Path):
        self.path = Path(path)
        self._file = opened(self.path)
        self._times: dict[str, np.ndarray] = {}
        try:
            self.version = int(self._file.attrs["format_version"])
            self.checksums = self._checksums()
        except BaseException:
            self._file.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    @property
    def file(self) -> h5py.File:
        """The open file. Raises ResultError after `close`."""
        if not self._file:
            raise ResultError(f"{self.path}: has been closed. Open it again with open_result.")
        return self._file

    def damaged(self, path: str, how: object) -> DamagedError:
        """Return the error for a damaged object."""
        return DamagedError(self.path, f"/{path}", " ".join(str(how).split()))

    def __contains__(self, path: str) -> bool:
        """Return whether the file should hold an object of this path. A missing one that it should hold is
        damage.
        """
        if self.checksums is not None:
            return path in self.checksums.entries
        with self._reading(path):
            return path in self.file

    def members(self, path: str) -> tuple[str, ...]:
        """Return the names of what the group at `path` holds."""
        with self._reading(path):
            group = self.file[path or "/"]
            if not isinstance(group, h5py.Group):
                raise self.damaged(path, "it is no group")
            names = tuple(name for name in group if path or name not in COPIES)
        if odd := [name for name in names if not isinstance(name, str)]:
            raise self.damaged(path, f"it holds a name that is no text, {odd[0]!r}")
        if self.checksums is not None and set(names) != self.checksums.members(path):
            odd = sorted(set(names) ^ self.checksums.members(path))
            missing = "lacks" if odd[0] not in names else "has gained"
            raise self.damaged(path, f"it {missing} {', '.join(odd[:3])}{' ...' * (len(odd) > 3)}")
        return names

    def attributes(self, path: str) -> dict[str, Any]:
        """Return the attributes of the object at `path` as Python numbers, texts and lists."""
        with self._reading(path):
            values = plain_attributes(self.file[path or "/"])
            if self.checksums is not None and attributes_digest(values) != self._entry(path).attributes:
                raise self.damaged(path, "its attributes differ from their checksum")
        return values

    def table(self, path: str) -> dict[str, Any]:
        """Return the attributes of a group, with those of the groups inside it as nested tables."""
        return self.attributes(path) | {name: self.table(f"{path}/{name}") for name in self.members(path)}

    def shape(self, path: str) -> tuple[int, ...]:
        """Return the shape of a dataset, after checking that the file holds as many numbers."""
        return self._dataset(path).shape

    def values(self, path: str) -> np.ndarray:
        """Return the whole content of the dataset at `path`, which must not grow by moments. Texts come as an
        object array.
        """
        data = self._dataset(path)
        with self._reading(path):
            values = whole_content(data)
        if self.checksums is not None and array_digest(values) != self._entry(path).content:
            raise self.damaged(path, "its content differs from its checksum")
        return values

    def times(self, group: str) -> np.ndarray:
        """Return the times [s] of the moments of ``snapshots`` or ``statistics``, (n,)."""
        if group not in self._times:
            self._times[group] = self._read_times(group)
        return self._times[group]

    def _read_times(self, group: str) -> np.ndarray:
        if f"{group}/time" not in self:
            return np.empty(0)
        path = f"{group}/time"
        data = self._dataset(path)
        with self._reading(path):
            times = np.asarray(data[:], float)
        if self.checksums is not None and times.tolist() != [
            time for time, _ in self.checksums.moments[group]
        ]:
            raise self.damaged(path, "its content differs from its checksum")
        if not np.all(np.isfinite(times)):
            raise self.damaged(path, "it holds times that are no numbers")
        return times

    def moment(self, group: str, index: int) -> dict[str, Any]:
        """Return all arrays of one moment of ``snapshots`` or ``statistics``, with its ``time``."""
        datasets = self._growing(group)
        with self._reading(group):
            arrays = {name: data[index] for name, data in datasets.items()}
        self._compare_moment(group, index, arrays)
        return arrays

    def all_moments(self, group: str) -> dict[str, np.ndarray]:
        """Return all arrays of ``snapshots`` or ``statistics`` over all moments, with ``time``."""
        datasets = self._growing(group)
        with self._reading(group):
            arrays = {name: data[()] for name, data in datasets.items()}
        for index in range(len(self.times(group))):
            self._compare_moment(group, index, {name: array[index] for name, array in arrays.items()})
        return arrays

    def _growing(self, group: str) -> dict[str, h5py.Dataset]:
        """Return the datasets of the arrays that grow by moments, all of the same length."""
        count = len(self.times(group))
        arrays = {}
        for name in self.members(group):
            path = f"{group}/{name}"
            with self._reading(path):
                inner = isinstance(self.file[path], h5py.Group)
            if inner:
                continue
            arrays[name] = self._dataset(path)
            if arrays[name].shape[:1] != (count,):
                raise self.damaged(path, f"it needs {count} moments, its shape is {arrays[name].shape}")
        return arrays

    def _compare_moment(self, group: str, index: int, arrays: dict[str, Any]) -> None:
        if self.checksums is None:
            return
        if moment_digest(arrays) != self.checksums.moments[group][index][1]:
            raise self.damaged(
                group, f"number {index} (t = {arrays['time']:.6g} s) differs from its checksum"
            )

    @property
    def required_checksums(self) -> Checksums:
        """The checksums of a file that is known to have them."""
        assert self.checksums is not None
        return self.checksums

    def _entry(self, path: str) -> Any:
        entry = self.checksums.entries.get(path) if self.checksums is not None else None
        if entry is None:
            raise self.damaged(path, "it has no checksum")
        return entry

    def _dataset(self, path: str) -> h5py.Dataset:
        """Return the dataset at `path`, after checking that its type and shape are as they were written and
        that all its numbers are in the file.
        """
        with self._reading(path):
            data = self.file[path]
            if not isinstance(data, h5py.Dataset):
                raise self.damaged(path, "it is no dataset")
            shape, dtype = data.shape, data.dtype
            if self.checksums is not None:
                entry, start = self._entry(path), int(grows(path))
                if dtype.str != entry.dtype or shape is None or shape[start:] != entry.shape:
                    raise self.damaged(
                        path, f"it must hold {entry.dtype} {entry.shape}, got {dtype.str} {shape}"
                    )
            if shape is None or (dtype.kind not in "fiubS" and h5py.check_string_dtype(dtype) is None):
                raise self.damaged(path, f"it holds {dtype.str}, neither numbers nor text")
            if not all_stored(data):
                raise self.damaged(path, f"the numbers of its shape {shape} are not all in the file")
        return data

    @contextmanager
    def _reading(self, path: str) -> Iterator[None]:
        """Turn whatever HDF5 raises on damaged content into a DamagedError that names the object."""
        file = self.file
        try:
            yield
        except (ResultError, DamagedError):
            raise
        except KeyError as fault:
            raise self.damaged(path, "it is missing" if _lacks(file, path) else fault) from fault
        except MemoryError as fault:
            raise self.damaged(path, "it claims more memory than there is") from fault
        except Exception as fault:  # HDF5 raises many kinds on a damaged file
            raise self.damaged(path, fault) from fault

    def _checksums(self) -> Checksums | None:
        """Return the checksums, or None for a file of a version without them."""
        with self._reading(""):
            if self.version < FIRST_WITH_CHECKSUMS:
                if any(name in self.file for name in COPIES):
                    raise self.damaged(
                        "", f"it names format {self.version}, which has no checksums, and holds some"
                    )
                return None
            checksums = Checksums.read(self.file)
        if checksums is None or set(checksums.moments) != set(GROWING):
            raise ResultError(
                f"{self.path}: its checksums are damaged, nothing in it can be verified. Copy it "
                "again, or run the case again."
            )
        return checksums


def _lacks(file: h5py.File, path: str) -> bool:
    """Return whether a file has no object at a path: no for a damaged group, which cannot be searched."""
    try:
        return path not in file
    except KeyError:
        return False


def all_stored(data: h5py.Dataset) -> bool:
    """Return whether the file has space for all numbers that the shape of a dataset claims."""
    if data.size == 0:
        return True
    if data.chunks is None:
        return h5py.check_string_dtype(data.dtype) is not None or data.id.get_storage_size() == data.nbytes
    if np.prod(data.chunks, dtype=float) * data.dtype.itemsize > LARGEST_BLOCK:
        return False
    blocks = [-(-length // block) for length, block in zip(data.shape, data.chunks, strict=True)]
    return data.id.get_num_chunks() == int(np.prod(blocks, dtype=float))
