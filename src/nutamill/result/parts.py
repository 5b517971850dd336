"""Write arrays and checkpoints into the open copy of a result file."""

import zlib
from collections.abc import Callable, Mapping
from pathlib import Path
from string import ascii_lowercase
from typing import Any

import h5py
import numpy as np

from nutamill.result.checksums import moment_digest
from nutamill.result.fields import Field
from nutamill.result.layout import Checkpoint, write_attributes
from nutamill.result.opening import refuse_outside_storage

CHECKPOINTS = ("a", "b")
LAYOUT = ("v110", "v110")
"""Layout of HDF5 with checksums on its own tables: what is damaged there is refused, and crashes nothing."""
SMALLEST_PACKED = 4096
"""Size from which an array of a checkpoint is packed [bytes]."""
SMALLEST_ROOM = 256
"""Least room behind a packed block of a checkpoint [bytes]."""
QUICKLY: dict[str, Any] = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
PACKED: dict[str, Any] = {"compression": "gzip", "compression_opts": 4, "shuffle": True}


def write_arrays(
    group: h5py.Group, snapshots: list[tuple[float, dict[str, np.ndarray]]], field: Callable[[str], Field]
) -> list[tuple[float, str]]:
    """Append arrays, one compressed block each, to datasets whose first axis is time, and return time and
    digest of each moment.
    """
    if "time" not in group:
        times = group.create_dataset("time", (0,), "f8", maxshape=(None,), chunks=(256,))
        write_attributes(times, {"units": "s"})
        for name, array in snapshots[0][1].items():
            longest = (
                None,
                *(n or None for n in array.shape),
            )  # a block must fit, and an empty charge has no length
            blocks = (1, *(max(1, n) for n in array.shape))
            data = group.create_dataset(
                name, (0, *array.shape), array.dtype, maxshape=longest, chunks=blocks, **PACKED
            )
            write_attributes(data, field(name).attributes())
    first = len(group["time"])
    for data in group.values():
        if isinstance(data, h5py.Dataset):
            data.resize(first + len(snapshots), axis=0)
    moments = []
    for k, (time, arrays) in enumerate(snapshots, start=first):
        written = {"time": np.asarray(time, np.float64)}
        for name, array in arrays.items():
            written[name] = np.asarray(array, group[name].dtype)
        for name, array in written.items():
            group[name][k] = array
        moments.append((float(time), moment_digest(written)))
    return moments


def write_checkpoint(
    group: h5py.Group, checkpoint: Checkpoint, before: Mapping[str, int], whole: set[str]
) -> str:
    """Write a checkpoint over the older of the two in `whole`, the slots in use, and return its path.

    Arrays keep their place, so that the file does not grow (`write_over`).  A slot that is there and not
    in use is damaged.
    """
    if len(whole) < len(CHECKPOINTS):
        slot = group.create_group(next(name for name in ascii_lowercase if name not in group))
    else:
        slot = group[min(whole, key=lambda name: group[name].attrs["time"])]
    for name in set(slot) - set(checkpoint.groups):
        del slot[name]
    for name, arrays in checkpoint.groups.items():
        target = slot.require_group(name)
        for key in set(target) - set(arrays):
            del target[key]
        for key, array in arrays.items():
            write_over(target, key, np.asarray(array))
    for key in list(slot.attrs):
        del slot.attrs[key]
    write_attributes(slot, {**checkpoint.attributes, "time": checkpoint.time, **before})
    return slot.name.strip("/")


def write_over(group: h5py.Group, key: str, array: np.ndarray) -> None:
    """Write an array over the one of this name, packed if it is large, in the same place where it fits.

    HDF5 gives a packed block a new place when its size changes, and the old place is lost.  A block is
    therefore written with some room behind it, which the unpacking passes over: little room where only the
    numbers change, half as much again where the length of the array does.
    """
    old = group.get(key)
    same = old is not None and old.shape[1:] == array.shape[1:] and old.dtype == array.dtype
    if same and old.chunks is not None and 0 < len(array) <= old.chunks[0] and old.id.get_num_chunks():
        block, room = packed(array, old.chunks), old.id.get_chunk_info(0).size
        if len(block) <= room:
            old.resize(len(array), axis=0)
            old.id.write_direct_chunk((0,) * array.ndim, block.ljust(room, b"\0"))
            return
    if same and old.chunks is None and old.shape == array.shape and array.nbytes < SMALLEST_PACKED:
        old[...] = array
        return
    varies = old is not None and old.shape != array.shape
    if old is not None:
        del group[key]
    if array.nbytes < SMALLEST_PACKED:
        group[key] = array
        return
    shape = (len(array) + varies * len(array) // 2, *array.shape[1:])
    block = packed(array, shape)
    room = len(block) + len(block) // (2 if varies else 32) + SMALLEST_ROOM
    most = (None, *array.shape[1:])
    new = group.create_dataset(key, array.shape, array.dtype, maxshape=most, chunks=shape, **QUICKLY)
    new.id.write_direct_chunk((0,) * array.ndim, block.ljust(room, b"\0"))


def packed(array: np.ndarray, shape: tuple[int, ...]) -> bytes:
    """Return an array, with zeros up to `shape` along its first axis, as HDF5 packs a block of it: bytes
    shuffled by significance, then deflated.
    """
    whole = np.zeros(shape, array.dtype)
    whole[: len(array)] = array
    by_byte = np.frombuffer(whole.tobytes(), np.uint8).reshape(-1, array.dtype.itemsize).T
    return zlib.compress(by_byte.tobytes(), QUICKLY["compression_opts"])


def edited(edit: Callable[[h5py.File], None]) -> Callable[[Path], None]:
    """Return `edit` as a function of the path of the copy. HDF5 gives reserved space back when it closes the
    file.
    """

    def edit_path(part: Path) -> None:
        with h5py.File(part, "r+", libver=LAYOUT) as file:
            refuse_outside_storage(file, part)
            edit(file)

    return edit_path


def empty_file() -> bytes:
    """Return an empty HDF5 file, made in memory: HDF5 must not be the first to meet a full disk."""
    with h5py.File("empty", "w", driver="core", backing_store=False, libver=LAYOUT) as file:
        file.flush()
        return file.id.get_file_image()
