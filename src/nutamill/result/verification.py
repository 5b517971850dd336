"""`verify` compares everything in a result file with its checksums and lists what is whole and what is
damaged.
"""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import NamedTuple

from nutamill.base.errors import DamagedError
from nutamill.result.archive import Archive
from nutamill.result.checkpoints import newest_whole, read_checkpoint, slots
from nutamill.result.checksums import GROWING
from nutamill.result.reader import Result

MOST_FAULTS = 5
"""Damaged objects of one part that are listed [1]."""


class PartOfFile(NamedTuple):
    """Whether one part of a result file is whole."""

    name: str
    """The part, as ``case`` or ``checkpoint a``."""
    holds: str
    """How much it holds, as ``114 of 114 series``."""
    faults: tuple[str, ...]
    """A sentence on each damaged object; none if the part is whole."""


class Verification(NamedTuple):
    """Whether the parts of a result file are whole."""

    path: Path
    """The file."""
    version: int
    """Version of the file's format."""
    parts: tuple[PartOfFile, ...]
    """The parts of a file with checksums; none of a file of a version without them."""
    continues_from: float | None
    """Time of the newest whole checkpoint [s]; None if there is none."""

    @property
    def faults(self) -> list[str]:
        """A sentence on each damaged object."""
        return [fault for part in self.parts for fault in part.faults]

    def lines(self) -> list[str]:
        """Format the findings as text, one line for each part."""
        if not self.parts:
            return [
                f"{self.path}: format {self.version} has no checksums: the file can be read, but "
                "nothing in it can be"
                " verified, and it cannot be resumed"
            ]
        width = max(len(part.name) for part in self.parts)
        lines = [f"{self.path}: format {self.version}"]
        for part in self.parts:
            lines.append(
                f"  {part.name:{width}}  {'DAMAGED' if part.faults else 'whole  '}  {part.holds}".rstrip()
            )
            lines += [f"  {'':{width}}  {fault}" for fault in part.faults[:MOST_FAULTS]]
            if len(part.faults) > MOST_FAULTS:
                lines.append(f"  {'':{width}}  and {len(part.faults) - MOST_FAULTS} more")
        if self.continues_from is None:
            return [*lines, "  no checkpoint is whole: this run cannot be resumed"]
        return [*lines, f"  the newest whole checkpoint is at t = {self.continues_from:.6g} s"]


def verify(path: str | Path) -> Verification:
    """Compare everything in a result file with its checksums.

    Raises
    ------
    ResultError : a file that cannot be opened, or with damaged checksums
    """
    with Archive(path) as archive:
        if archive.checksums is None:
            return Verification(archive.path, archive.version, (), None)
        parts = [_attributes(archive), _case(archive), _objects(archive, "provenance")]
        parts += [_objects(archive, name) for name in ("summary", "walls") if name in archive]
        parts += [_objects(archive, "series"), *(_moments(archive, group) for group in GROWING)]
        parts += [_checkpoint(archive, slot) for slot in slots(archive)]
        whole, _ = newest_whole(archive)
        at = None if whole is None else whole.checkpoint.time
        return Verification(archive.path, archive.version, tuple(parts), at)


def _attributes(archive: Archive) -> PartOfFile:
    """Verify state, rate and the list of what the file holds."""
    faults = _faults(lambda: Result(archive).state, lambda: Result(archive).rate)
    faults += _faults(lambda: archive.members(""))
    return PartOfFile("attributes", "", tuple(dict.fromkeys(faults)))


def _case(archive: Archive) -> PartOfFile:
    faults = _faults(lambda: Result(archive).case_text, lambda: archive.attributes("case"))
    return PartOfFile("case", "", tuple(faults))


def _objects(archive: Archive, path: str) -> PartOfFile:
    """Verify that a group and everything inside it is whole."""
    entries = archive.required_checksums.entries
    inside = [name for name in entries if name == path or name.startswith(path + "/")]
    faults = [_fault_of(archive, name) for name in inside]
    damaged = tuple(fault for fault in faults if fault)
    return PartOfFile(path, f"{len(inside) - len(damaged)} of {len(inside)} objects", damaged)


def _fault_of(archive: Archive, path: str) -> str:
    """Return a sentence on what is wrong with one object, empty if it is whole."""
    group = not archive.required_checksums.entries[path].dtype
    faults = _faults(
        lambda: archive.attributes(path), lambda: archive.members(path) if group else archive.values(path)
    )
    return faults[0] if faults else ""


def _moments(archive: Archive, group: str) -> PartOfFile:
    """Verify that a group of arrays that grow by moments is whole, and list which of its moments are not."""
    checksums = archive.required_checksums
    count = len(checksums.moments[group])
    inside = [name for name in checksums.entries if name == group or name.startswith(group + "/")]
    faults = _faults(lambda: archive.times(group))
    for name in inside:
        grows = checksums.entries[name].dtype and name.count("/") == 1
        faults += _faults(partial(archive.attributes, name)) if grows else [_fault_of(archive, name)]
    moments = [_faults(partial(archive.moment, group, k)) for k in range(count)]
    whole = sum(not damage for damage in moments)
    faults += [fault for damage in moments for fault in damage]
    return PartOfFile(
        group, f"{whole} of {count} moments", tuple(dict.fromkeys(fault for fault in faults if fault))
    )


def _checkpoint(archive: Archive, slot: str) -> PartOfFile:
    content, faults = "", []
    try:
        content = f"t = {read_checkpoint(archive, slot).checkpoint.time:.6g} s"
    except DamagedError as damage:
        faults.append(damage.fault)
    return PartOfFile(f"checkpoint {slot}", content, tuple(faults))


def _faults(*readings: Callable[[], object]) -> list[str]:
    """Return a sentence on each reading that finds damage."""
    faults = []
    for reading in readings:
        try:
            reading()
        except DamagedError as damage:
            faults.append(damage.fault)
    return faults
