"""Reads the checkpoints of a result file: the newest that is whole, and what is wrong with those passed
over.
"""

import math
from contextlib import suppress
from typing import NamedTuple

from nutamill.base.errors import DamagedError
from nutamill.result.archive import Archive
from nutamill.result.layout import BEFORE, Checkpoint


class WholeCheckpoint(NamedTuple):
    """A checkpoint that agrees with its checksums."""

    slot: str
    """Group under ``/checkpoints``."""
    checkpoint: Checkpoint
    """Its time and arrays."""
    before: tuple[int, ...]
    """Rows of the series, snapshots and moments of the statistics that were recorded before it."""


def newest_whole(archive: Archive) -> tuple[WholeCheckpoint | None, list[str]]:
    """Return the newest whole checkpoint, None if there is none, and a sentence on each damaged one that is
    newer.

    A damaged one whose time cannot be read counts as newer.
    """
    ordered, faults = _newest_first(archive)
    for slot, _ in ordered:
        try:
            return read_checkpoint(archive, slot), faults
        except DamagedError as fault:
            faults.append(str(fault))
    return None, faults


def whole_at(archive: Archive, time: float) -> WholeCheckpoint | None:
    """Return a whole checkpoint of this time [s], None if there is none."""
    for slot, at in _newest_first(archive)[0]:
        if at == time:
            try:
                return read_checkpoint(archive, slot)
            except DamagedError:
                continue
    return None


def whole_until(archive: Archive, time: float) -> set[str]:
    """Return the slots of the whole checkpoints up to this time [s]."""
    whole = set()
    for slot, at in _newest_first(archive)[0]:
        if at <= time:
            with suppress(DamagedError):
                read_checkpoint(archive, slot)
                whole.add(slot)
    return whole


def read_checkpoint(archive: Archive, slot: str) -> WholeCheckpoint:
    """Read the checkpoint of a slot. Raises DamagedError where it is damaged."""
    path = f"checkpoints/{slot}"
    attributes = archive.attributes(path)
    time = _time(archive, slot)
    recorded = (
        sum(archive.shape("series/time")[:1]),
        len(archive.times("snapshots")),
        len(archive.times("statistics")),
    )
    before = []
    for name, most in zip(BEFORE, recorded, strict=True):
        count = attributes.get(name)
        if not isinstance(count, int) or not 0 <= count <= most:
            raise archive.damaged(
                path, f"its attribute {name} must be a whole number from 0 to {most}, got {count!r}"
            )
        before.append(count)
    groups = {
        group: {name: archive.values(f"{path}/{group}/{name}") for name in archive.members(f"{path}/{group}")}
        for group in archive.members(path)
    }
    others = {name: value for name, value in attributes.items() if name not in (*BEFORE, "time")}
    return WholeCheckpoint(slot, Checkpoint(time, groups, others), tuple(before))


def slots(archive: Archive) -> list[str]:
    """Return the names of the slots that the file should hold."""
    if archive.checksums is not None:
        return sorted(archive.checksums.members("checkpoints"))
    return sorted(archive.members("checkpoints"))


def _newest_first(archive: Archive) -> tuple[list[tuple[str, float]], list[str]]:
    """Return slots and times [s] of checkpoints with a readable time, and a sentence on each other one."""
    times, faults = {}, []
    for slot in slots(archive):
        try:
            times[slot] = _time(archive, slot)
        except DamagedError as fault:
            faults.append(str(fault))
    return sorted(times.items(), key=lambda item: -item[1]), faults


def _time(archive: Archive, slot: str) -> float:
    time = archive.attributes(f"checkpoints/{slot}").get("time")
    if not isinstance(time, float) or not math.isfinite(time):
        raise archive.damaged(f"checkpoints/{slot}", f"its time must be a number, got {time!r}")
    return time
