"""What writer and reader of a result file share: the layout's words, its checks, and its small parts."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import h5py
import numpy as np

FORMAT = "nutamill result"
FORMAT_VERSION = 2
FIRST_WITH_CHECKSUMS = 2
"""First version of the format whose files hold checksums; an earlier file cannot be verified."""
STATES = ("running", "interrupted", "complete", "measured")
"""States of a result in one word; others begin as in `STATES_WITH_REASON`."""
STATES_WITH_REASON = ("failed: ", "not steady: ")
BEFORE = ("rows", "snapshots", "statistics")
"""Attributes of a checkpoint: how much had been recorded before it."""


class Checkpoint(NamedTuple):
    """A state to resume from."""

    time: float
    """Simulated time [s]."""
    groups: dict[str, dict[str, np.ndarray]]
    """Arrays of the state, in groups."""
    attributes: dict[str, Any]
    """Numbers and texts that belong to the state and are no arrays."""


class WallMesh(NamedTuple):
    """A meshed wall as the run had it, for pictures."""

    vertices: np.ndarray
    """Corners [m] (n, 3), axes of its carrier from the mass centre as assembled."""
    triangles: np.ndarray
    """Corners of each triangle [1], int32 (m, 3), counter-clockwise seen from outside the solid."""
    carrier: str
    """Body that carries it."""


# HDF5 keeps texts of any length in a heap without checksums, and a flipped bit there may end the program that
# reads it. Texts of a given length are stored in place, under the checksum of what holds them.
def fixed_texts(texts: str | Sequence[str] | np.ndarray) -> np.ndarray:
    """Return texts as an array of their UTF-8, all of one length, as a file stores them."""
    held = [text.encode() for text in np.ravel(texts)]
    kind = h5py.string_dtype("utf-8", max(1, *map(len, held)) if held else 1)
    return np.array(held, dtype=kind).reshape(np.shape(texts))


def write_attributes(thing: h5py.HLObject, values: Mapping[str, Any]) -> None:
    """Write numbers and texts as attributes, nested tables as groups of attributes."""
    for key, value in values.items():
        if isinstance(value, Mapping):
            write_attributes(thing.create_group(key), value)
        elif isinstance(value, str) or (isinstance(value, list) and all(isinstance(v, str) for v in value)):
            stored = fixed_texts(value)
            thing.attrs.create(key, stored, dtype=stored.dtype)
        else:
            thing.attrs[key] = value
