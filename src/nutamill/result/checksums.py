"""Checksums of a result file: a digest of every object, written with each commit and compared on every
reading.

They stand in the file twice, as text, because nothing can be verified without them.  A group has a digest of
its attributes, a dataset also its type, its shape and a digest of its content.  The arrays of ``/snapshots``
and ``/statistics`` grow by one moment at a time and are read so: they have one digest per moment, over all
arrays.
"""

import hashlib
import json
from collections.abc import Mapping
from typing import Any, NamedTuple, Self

import h5py
import numpy as np

COPIES = ("checksums", "checksums_copy")
"""Datasets that hold the text."""
GROWING = ("snapshots", "statistics")
"""Groups whose arrays have one digest per moment."""
HIDDEN = {"CLASS", "NAME", "DIMENSION_LIST", "REFERENCE_LIST"}
"""Attributes that HDF5 itself keeps for dimension scales; they hold places in the file, no facts."""
BLOCK = 2**14
"""The text is padded to a multiple of this, so that most commits write it over the one before [bytes]."""


class Entry(NamedTuple):
    """What is known of one object."""

    attributes: str
    """Digest of its attributes."""
    dtype: str = ""
    """NumPy type of a dataset; empty for a group."""
    shape: tuple[int, ...] = ()
    """Shape of a dataset; of one that grows by moments, the shape at one moment."""
    content: str = ""
    """Digest of a dataset's content; empty if it grows by moments."""


def new_hash() -> "hashlib._Hash":
    """Return an empty digest of the kind used throughout, SHA-256."""
    return hashlib.sha256()


def written(digest: "hashlib._Hash") -> str:
    """Return a digest as the file holds it: its first 64 bits as 16 hexadecimal digits."""
    return digest.hexdigest()[:16]


def array_digest(array: np.ndarray) -> str:
    """Compute the digest of the bytes of an array, of texts their UTF-8 with zeros between."""
    digest = new_hash()
    digest.update(array_bytes(array))
    return written(digest)


def array_bytes(array: np.ndarray) -> Any:
    """Return the bytes of an array in C order, of texts their UTF-8 with zeros between."""
    if array.dtype == object:
        return b"\0".join(text.encode() for text in array.ravel())
    return np.ascontiguousarray(array).reshape(-1).view(np.uint8).data if array.size else b""


def whole_content(data: h5py.Dataset) -> np.ndarray:
    """Return the content of a dataset, texts as an object array of Python texts."""
    if h5py.check_string_dtype(data.dtype) is not None:
        return np.asarray(data.asstr()[()], dtype=object)
    return np.asarray(data[()])


def attributes_digest(values: Mapping[str, Any]) -> str:
    """Compute the digest of attributes as `plain_attributes` returns them."""
    digest = new_hash()
    digest.update(json.dumps(values, sort_keys=True, default=repr).encode())
    return written(digest)


def moment_digest(arrays: Mapping[str, np.ndarray]) -> str:
    """Compute the digest over the names and bytes of all arrays of one moment."""
    digest = new_hash()
    for name in sorted(arrays):
        digest.update(name.encode() + b"\0")
        digest.update(array_bytes(np.asarray(arrays[name])))
    return written(digest)


def plain_attributes(thing: h5py.HLObject) -> dict[str, Any]:
    """Return the attributes of an object as Python numbers, texts and lists, without those of HDF5 itself."""
    return {name: _plain(thing.attrs[name]) for name in thing.attrs if name not in HIDDEN}


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return [_plain(one) for one in value.tolist()]
    if isinstance(value, bytes):
        return value.decode()
    return value.item() if isinstance(value, np.generic) else value


class Checksums:
    """The checksums of one file."""

    def __init__(self, entries: dict[str, Entry], moments: dict[str, list[tuple[float, str]]]):
        self.entries = entries
        """By the path of the object, ``""`` for the root."""
        self.moments = moments
        """Time [s] and digest of each moment, by group."""

    @classmethod
    def of_new(cls, file: h5py.File) -> Self:
        """Return the checksums of a file that holds no moments yet."""
        new = cls({}, {group: [] for group in GROWING})
        new.take(file, "")
        return new

    def copy(self) -> "Checksums":
        """Return a copy that can be changed alone."""
        return Checksums(
            dict(self.entries), {group: list(moments) for group, moments in self.moments.items()}
        )

    def take(self, file: h5py.File, path: str) -> None:
        """Enter the object at `path` as the file has it now, and everything inside it."""
        self.drop(path)
        self.take_one(file, path)
        if isinstance(group := file[path or "/"], h5py.Group):
            for name in group:
                if path or name not in COPIES:
                    self.take(file, f"{path}/{name}" if path else name)

    def take_one(self, file: h5py.File, path: str) -> None:
        """Enter the object at `path` as the file has it now, without what is inside it."""
        thing = file[path or "/"]
        attributes = attributes_digest(plain_attributes(thing))
        if not isinstance(thing, h5py.Dataset):
            self.entries[path] = Entry(attributes)
        elif grows(path):
            self.entries[path] = Entry(attributes, thing.dtype.str, thing.shape[1:])
        else:
            self.entries[path] = Entry(
                attributes, thing.dtype.str, thing.shape, array_digest(whole_content(thing))
            )

    def extend_series(self, name: str, rows: int, digest: "hashlib._Hash") -> None:
        """Enter that a series holds this many rows, of which `digest` has seen all numbers."""
        path = f"series/{name}"
        self.entries[path] = self.entries[path]._replace(shape=(rows,), content=written(digest))

    def append_moments(self, file: h5py.File, group: str, moments: list[tuple[float, str]]) -> None:
        """Enter moments that were appended to a group: time [s] and digest of each."""
        self.moments[group] += moments
        for name in file[group]:
            if f"{group}/{name}" not in self.entries:
                self.take_one(file, f"{group}/{name}")

    def drop(self, path: str) -> None:
        """Remove the entries of the object at `path` and of everything inside it."""
        for name in [
            name for name in self.entries if name == path or not path or name.startswith(path + "/")
        ]:
            del self.entries[name]

    def members(self, path: str) -> set[str]:
        """Return the names of what the group at `path` holds."""
        start = len(path) + 1 if path else 0
        inside = (name[start:] for name in self.entries if name and (not path or name.startswith(path + "/")))
        return {name for name in inside if "/" not in name}

    def text(self) -> bytes:
        """Return all checksums as text that `parsed` reads, with its digest in front."""
        body = json.dumps({"objects": self.entries, "moments": self.moments}, separators=(",", ":")).encode()
        return hashlib.sha256(body).hexdigest().encode() + b"\n" + body

    @classmethod
    def parsed(cls, text: bytes) -> Self | None:
        """Return the checksums of a text, None if the text is damaged."""
        digest, _, body = text.partition(b"\n")
        if hashlib.sha256(body).hexdigest().encode() != digest:
            return None
        read = json.loads(body)
        entries = {
            path: Entry(one[0], one[1], tuple(one[2]), one[3]) for path, one in read["objects"].items()
        }
        return cls(
            entries, {group: [(time, one) for time, one in rows] for group, rows in read["moments"].items()}
        )

    @classmethod
    def read(cls, file: h5py.File) -> Self | None:
        """Return the checksums of a file, None if both copies are missing or damaged."""
        for name in COPIES:
            try:
                data = file[name]
                size = data.id.get_storage_size()
                if data.shape == () and data.dtype.kind == "S" and data.dtype.itemsize == size:
                    checksums = cls.parsed(bytes(data[()]))
                    if checksums is not None:
                        return checksums
            except Exception:  # HDF5 raises many kinds on a damaged file
                continue
        return None

    def write(self, file: h5py.File) -> None:
        """Write both copies, in the place of those before where there is room."""
        text = self.text()
        for name in COPIES:
            if name in file and file[name].dtype.itemsize < len(text):
                del file[name]
            if name not in file:
                size = -(-len(text) * 5 // 4 // BLOCK) * BLOCK
                file.create_dataset(name, (), f"S{size}")
            file[name][()] = np.bytes_(text)

    @property
    def room(self) -> int:
        """Upper bound of the room that writing them takes [bytes]."""
        return 2 * (2 * len(self.text()) + BLOCK)


def grows(path: str) -> bool:
    """Return whether the object at `path` is an array that grows by moments."""
    return path.rpartition("/")[0] in GROWING
