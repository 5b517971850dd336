"""`Result` reads a result file, without an engine."""

from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import h5py
import numpy as np

from nutamill.errors import ResultError
from nutamill.fields import statistics_field
from nutamill.result.layout import BEFORE, Checkpoint, WallMesh, opened, read_attributes

if TYPE_CHECKING:
    import xarray

MISSING = "missing"
"""State of a file that is not there."""


class Snapshots(Sequence):
    """The snapshots of a result; each is read when it is asked for: ``result.snapshots[-1]["positions"]``."""

    def __init__(self, result: "Result"):
        self._result = result

    @property
    def time(self) -> np.ndarray:
        """Simulated times [s], (n_snapshots,)."""
        group = self._result.file.get("snapshots", {})
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
        return read_attributes(self.file["provenance"])

    @property
    def summary(self) -> dict[str, Any]:
        """What was printed at the end of the run; empty if it has not ended."""
        return read_attributes(self.file["summary"]) if "summary" in self.file else {}

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

    @property
    def walls(self) -> dict[str, WallMesh]:
        """Meshed walls by their key in the case (``chamber.mesh``, ``walls[0]``); none in a file of a version that did not keep them."""
        meshes = self.file.get("walls", {})
        return {name: WallMesh(mesh["vertices"][:], mesh["triangles"][:]) for name, mesh in meshes.items()}

    def checkpoint(self) -> Checkpoint:
        """The newest state kept for resuming; ResultError if there is none."""
        slots = self.file["checkpoints"].values()
        if not len(slots):
            raise ResultError(f"{self.path}: must hold a checkpoint to be continued, it holds none. Run the case again.")
        slot = max(slots, key=lambda slot: slot.attrs["time"])
        attributes = read_attributes(slot, inner=False)
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
    try:
        return Result(Path(path), opened(Path(path)))
    except ResultError:
        from nutamill.case.file_kind import FileKind, other_kind  # loads the reader of cases: only to say what the file is

        if fault := other_kind(path, FileKind.RESULT):
            raise ResultError(str(fault)) from None
        raise


def state_of(path: Path) -> str:
    """State of a result file as `Result.state` tells it; `MISSING` if there is none. Raises ResultError as `open_result`."""
    if not path.exists():
        return MISSING
    with open_result(path) as result:
        return result.state
