"""`Result` reads a result file, without an engine."""

import difflib
import math
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from nutamill.base.errors import CaseError, Fault, ResultError
from nutamill.base.files import exists
from nutamill.base.notebook_hook import notebook_html
from nutamill.result.archive import Archive
from nutamill.result.checkpoints import newest_whole
from nutamill.result.fields import Field, statistics_field
from nutamill.result.layout import STATES, STATES_WITH_REASON, Checkpoint, WallMesh

if TYPE_CHECKING:
    import xarray

MISSING = "missing"
"""State of a file that is not there."""
NOT_STEADY = "not steady"
"""Begin of the state of a run that should have ended when it was steady, and did not."""


class Snapshots(Sequence[dict[str, Any]]):
    """The snapshots of a result, each read on access: ``result.snapshots[-1]["positions"]``."""

    def __init__(self, archive: Archive):
        self._archive = archive

    @property
    def time(self) -> np.ndarray:
        """Simulated times [s], (n_snapshots,)."""
        return self._archive.times("snapshots")

    def __len__(self) -> int:
        return len(self.time)

    def __getitem__(self, index: int) -> dict[str, Any]:  # type: ignore[override]  # no slices
        """Return the arrays of one snapshot and its ``time``. Names, units and axes are those of
        `nutamill.result.fields.SNAPSHOT`.
        """
        if not -len(self) <= index < len(self):
            raise IndexError(f"snapshot {index}: the result holds {len(self)}")
        return self._archive.moment("snapshots", index % len(self))


class Result:
    """A result file opened for reading; made by `open_result`, closed by ``with`` or `close`.

    Everything read is compared with its checksum; every property raises DamagedError where what it reads is
    damaged.
    """

    def _repr_html_(self) -> str:
        return notebook_html("results.result_html", self)

    def __init__(self, archive: Archive):
        self.path = archive.path
        self._archive = archive
        self._series: xarray.Dataset | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the file. A dataset from `series` stays usable."""
        self._archive.close()

    @property
    def verifiable(self) -> bool:
        """Whether the file holds checksums. One of format 1 does not, and damage to it may go unnoticed."""
        return self._archive.checksums is not None

    @property
    def case_text(self) -> str:
        """The case file (TOML) that was run."""
        text = self._archive.values("case")
        if text.dtype != object or text.shape != ():
            raise self._archive.damaged("case", "it must be one text")
        return text.item()

    @property
    def state(self) -> str:
        """``running``, ``interrupted``, ``complete`` or ``failed: ...``. That of a killed run stays
        ``running``.
        """
        state = self._archive.attributes("").get("state")
        if not isinstance(state, str) or (state not in STATES and not state.startswith(STATES_WITH_REASON)):
            raise self._archive.damaged(
                "", f"its state must be one of {', '.join(STATES)} or failed, got {state!r}"
            )
        return state

    @property
    def rate(self) -> float:
        """Samples per simulated second [Hz]."""
        rate = self._archive.attributes("").get("rate")
        if not isinstance(rate, (int, float)) or not math.isfinite(rate) or rate <= 0.0:
            raise self._archive.damaged("", f"its rate must be a number of samples per second, got {rate!r}")
        return float(rate)

    @property
    def reached(self) -> float:
        """Simulated time of the last sample [s], or 0 before the first."""
        return float(self._time[-1]) if len(self._time) else 0.0

    @cached_property
    def _time(self) -> np.ndarray:
        """Times of the samples [s], (n,)."""
        time = self._archive.values("series/time")
        if time.ndim != 1 or time.dtype.kind != "f":
            raise self._archive.damaged("series/time", "it must be a list of times")
        if not self.verifiable and (not np.all(np.isfinite(time)) or np.any(np.diff(time) <= 0.0)):
            raise self._archive.damaged("series/time", "its times must rise")
        return time

    @property
    def provenance(self) -> dict[str, Any]:
        """What made these numbers: versions, digest of the kernels, seed, threads, processor, wall time
        [s].
        """
        return self._archive.table("provenance")

    @property
    def summary(self) -> dict[str, Any]:
        """What was printed at the end of the run, empty if it has not ended."""
        return self._archive.table("summary") if "summary" in self._archive else {}

    @property
    def series(self) -> "xarray.Dataset":
        """All series over ``time`` [s], in memory. Each variable carries units, long_name, symbol, frame and
        point.
        """
        if self._series is None:
            import xarray  # takes half a second: a summary does not need it

            count = len(self._time)
            names = series_names(self._archive)
            read: dict[str, Any] = {}
            for name in names:
                read[name] = (
                    "time",
                    series_values(self._archive, name, count),
                    self._archive.attributes(f"series/{name}"),
                )
            self._series = xarray.Dataset(
                read, attrs={"source": self.path.name, "state": self.state, "rate": self.rate}
            ).set_coords("time")
        return self._series

    def field(self, name: str) -> Field:
        """Return what a series of this file is, as the file stores it beside the numbers.

        Raises
        ------
        CaseError : the file holds no series of this name; the nearest is proposed
        """
        if name not in self.series:
            near = difflib.get_close_matches(name, list(map(str, self.series.variables)), 1)
            hint = f'Did you mean "{near[0]}"?' if near else "`nutamill info fields` lists all series"
            raise CaseError(Fault(f"{self.path}: {name}", "must be recorded, this run did not", hint))
        stored = self.series[name].attrs
        keys = {"symbol": "symbol", "unit": "units", "label": "long_name", "meaning": "meaning"}
        known = {key: str(stored.get(attribute, "")) for key, attribute in keys.items()}
        return Field(name, **known, frame=str(stored.get("frame", "")), point=str(stored.get("point", "")))

    @property
    def statistics(self) -> "xarray.Dataset":
        """What the charge has done, cumulative over ``time`` [s], in memory, as
        `nutamill.result.fields.STATISTICS` names it.

        The difference of two times belongs to the window between them: `nutamill.analysis.flow.window` makes
        it.
        """
        import xarray

        archive = self._archive
        if "statistics/time" not in archive:
            raise ResultError(
                f"{self.path}: holds no statistics of the charge. Run it with run.statistics = true."
            )
        lines: dict[str, Any] = {}
        for name in archive.members("statistics/axes"):
            path = f"statistics/axes/{name}"
            values = archive.values(path)
            texts = values.astype(str) if values.dtype == object and values.size else values
            lines[name] = (self._dims(name), texts, archive.attributes(path))
        sums = {
            name: (("time", *self._dims(name)), values, archive.attributes(f"statistics/{name}"))
            for name, values in archive.all_moments("statistics").items()
            if name != "time"
        }
        lines["time"] = ("time", archive.times("statistics"), archive.attributes("statistics/time"))
        try:
            return xarray.Dataset(sums, lines, attrs={"source": self.path.name, "state": self.state})
        except ValueError as fault:
            raise archive.damaged("statistics", fault) from fault

    def _dims(self, name: str) -> tuple[str, ...]:
        """Return the dimensions of a statistics array besides time, as its field names them."""
        try:
            inside = statistics_field(name).shape.strip("()")
        except CaseError as fault:
            raise self._archive.damaged("statistics", fault) from fault
        return tuple(part.strip() for part in inside.split(",") if part.strip())

    @property
    def snapshots(self) -> Snapshots:
        """The snapshots, read one by one."""
        return Snapshots(self._archive)

    @property
    def walls(self) -> dict[str, WallMesh]:
        """Meshed walls by their key in the case (``chamber.mesh``, ``walls[0]``), none in a file of an early
        version.
        """
        archive = self._archive
        names = archive.members("walls") if "walls" in archive else ()
        return {
            name: WallMesh(
                archive.values(f"walls/{name}/vertices"),
                archive.values(f"walls/{name}/triangles"),
                str(archive.attributes(f"walls/{name}/vertices").get("carrier", "chamber")),
            )
            for name in names
        }

    @property
    def has_checkpoint(self) -> bool:
        """Whether the file holds a state to resume from."""
        return len(self._archive.members("checkpoints")) > 0

    def checkpoint(self) -> Checkpoint:
        """Return the newest undamaged checkpoint. Raises ResultError if there is none."""
        newest, faults = newest_whole(self._archive)
        if newest is not None:
            return newest.checkpoint
        if faults:
            raise ResultError(
                "\n".join([*faults, f"{self.path}: no checkpoint of it is whole. Run the case again."])
            )
        raise ResultError(f"{self.path}: holds no checkpoint to continue from. Run the case again.")

    def damaged_checkpoints(self) -> list[str]:
        """Return a sentence on each damaged checkpoint that is newer than the one `checkpoint` returns."""
        return newest_whole(self._archive)[1]


def series_names(archive: Archive) -> tuple[str, ...]:
    """Return the names of the series in the order of the record, all of which the file holds."""
    names = archive.attributes("series").get("names")
    if not isinstance(names, list) or "time" not in names or set(names) != set(archive.members("series")):
        raise archive.damaged("series", "its attribute names must list the series")
    return tuple(names)


def series_values(archive: Archive, name: str, count: int) -> np.ndarray:
    """Return the numbers of a series, of which the file must hold `count`, (count,)."""
    path = f"series/{name}"
    if archive.shape(path) != (count,):
        raise archive.damaged(path, f"it must hold {count} numbers, its shape is {archive.shape(path)}")
    values = archive.values(path)
    if values.dtype.kind != "f":
        raise archive.damaged(path, f"it must hold numbers, got {values.dtype.str}")
    return values


def open_result(path: str | Path) -> Result:
    """Open a result file for reading. It may still be growing, and then shows the last commit.

    Raises
    ------
    ResultError : no such file, cut off or damaged, no result of this package, or written by a newer one
    """
    try:
        return Result(Archive(path))
    except ResultError:
        from nutamill.base.file_kind import (
            FileKind,
            other_kind,
        )  # loads the reader of cases

        if fault := other_kind(path, FileKind.RESULT):
            raise ResultError(str(fault)) from None
        raise


def is_finished(state: str) -> bool:
    """Return whether nothing is left to be done for a run in this state."""
    return state == "complete" or state.startswith(NOT_STEADY)


def state_of(path: Path) -> str:
    """Return the state of a result file as `Result.state`, or `MISSING` if there is none. Raises ResultError
    as `open_result`.
    """
    if not exists(path):
        return MISSING
    with open_result(path) as result:
        return result.state
