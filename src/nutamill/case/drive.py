"""The drive programme: a ramp to a speed, or a measured profile of speed over time."""

import csv
import difflib
import itertools
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator, WithJsonSchema, model_validator

from nutamill.base import units
from nutamill.base.errors import CaseError, Fault
from nutamill.base.files import MOST_CASE_TEXT, is_file, is_folder, read_text
from nutamill.base.library import LONGEST_WORD
from nutamill.base.required import required
from nutamill.base.schema import (
    MotorTorque,
    Power,
    ProfileSpeed,
    Ramp,
    RotationalGain,
    Speed,
    StartTime,
    Table,
    Time,
    refusal,
)
from nutamill.base.units import Kind


def _as_table(given: Any) -> Any:
    """Return the table of a profile. Points alone stand for a profile without a source."""
    return {"points": given} if isinstance(given, (list, tuple)) else given


class Profile(Table):
    """Speed over time, linear between points."""

    source: str = ""
    """File it was read from."""
    points: tuple[tuple[StartTime, ProfileSpeed], ...]
    """Pairs of time [s] and speed [rad/s], times rising from 0."""

    @model_validator(mode="after")
    def _rising(self) -> "Profile":
        if fault := profile_fault([time for time, _ in self.points]):
            raise refusal(fault[1])
        return self


class Motor(Table):
    """A motor on a frequency converter that is asked for the speed, in place of a prescribed rotation."""

    power: Power | None = None
    """Largest power at the driveshaft [W]; no limit if left out."""
    torque: MotorTorque | None = None
    """Largest torque at the driveshaft [N m]; no limit if left out."""
    gain: RotationalGain = 2.0
    """Torque of the speed controller per error of the speed [N m s/rad]."""
    integral_time: Time = 0.2
    """Time in which its integral part adds as much again [s]."""
    cut: StartTime | None = None
    """When the supply fails or is switched off [s]; from then on the mill coasts."""
    restored: Time | None = None
    """When the supply is back [s]; never if left out."""

    @model_validator(mode="after")
    def _in_order(self) -> "Motor":
        if self.restored is not None and (self.cut is None or self.restored <= self.cut):
            raise refusal("restored must come after cut", 'Write e.g. cut = "8 s" and restored = "8.5 s"')
        return self


class DriveProgramme(Table):
    """What the driveshaft is made to do."""

    speed: Speed
    """Speed reached at the end of the ramp, or the cap of the profile [rad/s]."""
    ramp: Ramp | None = None
    """Rise of the speed from rest [rad/s^2]."""
    profile: Annotated[Profile | None, BeforeValidator(_as_table), WithJsonSchema({"type": "string"})] = None
    """Speed over time, instead of the ramp: a CSV file with the columns ``time [s]`` and ``speed [rpm]``."""

    motor: Motor | None = None
    """The motor that is to reach the speed; without it the rotation is prescribed, whatever torque it
    takes.
    """

    @model_validator(mode="after")
    def _one_of_two(self) -> "DriveProgramme":
        if (self.ramp is None) == (self.profile is None):
            raise refusal(
                "needs either a ramp or a profile, not both or none", 'Write e.g. ramp = "70 rpm/s"'
            )
        return self

    def breakpoints(self) -> tuple[np.ndarray, np.ndarray]:
        """Return times [s] and speeds [rad/s] between which the speed is linear.

        The last speed holds from then on.

        A profile that exceeds `speed` stays at `speed` meanwhile; the times at which it crosses the cap are
        inserted.
        """
        if self.profile is None:
            return np.array([0.0, self.speed / required(self.ramp)]), np.array([0.0, self.speed])
        times, speeds = [], []
        for (t0, w0), (t1, w1) in itertools.pairwise(self.profile.points):
            times.append(t0)
            speeds.append(min(w0, self.speed))
            if (w0 - self.speed) * (w1 - self.speed) < 0.0:
                times.append(t0 + (t1 - t0) * (self.speed - w0) / (w1 - w0))
                speeds.append(self.speed)
        last_time, last_speed = self.profile.points[-1]
        return np.array([*times, last_time]), np.array([*speeds, min(last_speed, self.speed)])

    @property
    def ramp_end(self) -> float:
        """Time from which the speed stays what it is [s]."""
        times, speeds = self.breakpoints()
        moving = np.flatnonzero(speeds != speeds[-1])
        return float(times[moving[-1] + 1]) if moving.size else 0.0


def profile_fault(times: list[float]) -> tuple[int, str] | None:
    """Return index and message of the first time that is out of order, or None."""
    if len(times) < 2:
        return 0, f"needs at least two points, got {len(times)}"
    if times[0] != 0.0:
        return 0, f"must begin at 0 s, got {times[0]:g} s"
    for k, (before, after) in enumerate(itertools.pairwise(times), start=1):
        if not after > before:
            return k, f"times must rise, got {after:g} s after {before:g} s"
    return None


def existing_file(name: str, where: str, folders: Iterable[Path]) -> Path:
    """Return the full path of a file that a case names.

    A relative name is looked up in each of the folders.

    Raises
    ------
    CaseError : no such file; the message names similar ones
    """
    folders = list(dict.fromkeys(folder.resolve() for folder in folders))
    path = next((folder / name for folder in folders if is_file(folder / name)), None)
    if path is None:
        near = [
            file.name for folder in folders if is_folder(folder) for file in folder.iterdir() if is_file(file)
        ]
        similar = difflib.get_close_matches(Path(name).name[:LONGEST_WORD], near, n=3, cutoff=0.6)
        looked = " and ".join(str(folder) for folder in folders)
        raise CaseError(
            Fault(
                where,
                f"{name} not found (looked in {looked})",
                f"Similar: {', '.join(similar)}" if similar else "",
            )
        )
    return path


def read_profile(name: str, where: str, folders: Iterable[Path]) -> dict[str, Any]:
    """Read the table of a `Profile` from a CSV file, which is looked up in each of the folders.

    Parameters
    ----------
    name : file as written in the case
    where : file, line and key that name it, for messages
    folders : where a relative name is looked for, in order

    Raises
    ------
    CaseError : no such file, or each line that is wrong (the first ten)
    """
    path = existing_file(name, where, folders)
    try:
        text = read_text(path, MOST_CASE_TEXT)
    except (OSError, UnicodeDecodeError) as error:
        raise CaseError(Fault(where, f"{name} cannot be read as text: {error}")) from None
    lines = [
        (number, row)
        for number, row in enumerate(csv.reader(text.splitlines()), start=1)
        if any(cell.strip() for cell in row)
    ]
    columns = _columns(name, lines[0] if lines else (1, []))
    points: list[tuple[int, list[float]]] = []
    faults: list[Fault] = []
    for number, row in lines[1:]:
        cells = _cells(f"{name}:{number}", row, columns)
        faults += [cell for cell in cells if isinstance(cell, Fault)]
        points.append((number, [cell for cell in cells if not isinstance(cell, Fault)]))
    if not faults and (wrong := profile_fault([cells[0] for _, cells in points])):
        faults.append(
            Fault(
                f"{name}:{points[wrong[0]][0] if points else 1}",
                wrong[1],
                "Sort the rows and let the time begin at 0",
            )
        )
    if faults:
        more = (
            [Fault(name, f"{len(faults) - 10} more cells are wrong, of {2 * len(points)}")]
            if len(faults) > 10
            else []
        )
        raise CaseError(*faults[:10], *more)
    shown = [(units.format(time, Kind.TIME), units.format(speed, Kind.SPEED)) for _, (time, speed) in points]
    return {"source": name, "points": shown}


def _columns(name: str, first: tuple[int, list[str]]) -> list[tuple[str, str, Kind]]:
    """Return header, unit and kind of the two columns."""
    number, row = first
    kinds = (Kind.TIME, Kind.SPEED)
    headers = [cell.strip() for cell in row]
    written = [header.partition("[")[2].removesuffix("]").strip() for header in headers]
    if len(row) != 2 or any(unit not in units.UNITS[kind] for unit, kind in zip(written, kinds, strict=True)):
        shown = ",".join(row)
        raise CaseError(
            Fault(
                f"{name}:{number}",
                f'must name two columns with their units, got "{shown}"',
                'Write "time [s],speed [rpm]"',
            )
        )
    return list(zip(headers, written, kinds, strict=True))


def _cells(where: str, row: list[str], columns: list[tuple[str, str, Kind]]) -> list[float | Fault]:
    """Return the SI values of one row, or a fault for each bad cell."""
    if len(row) > 2:
        return [
            Fault(
                where,
                f"must have 2 cells, got {len(row)}",
                "Write numbers with a decimal point, cells apart by a comma",
            )
        ]
    values: list[float | Fault] = []
    for k, (header, unit, kind) in enumerate(columns):
        cell = row[k].strip() if k < len(row) else ""
        if not cell:
            values.append(Fault(where, f'column "{header}" is empty', "Interpolate or leave the row out"))
            continue
        try:
            value = units.parse(f"{cell} {unit}", kind)
        except units.UnitError:
            values.append(
                Fault(
                    where,
                    f'column "{header}" must be a finite number, got "{cell}"',
                    "Interpolate or leave the row out",
                )
            )
            continue
        values.append(
            value if value >= 0.0 else Fault(where, f'column "{header}" must be zero or more, got {cell}')
        )
    return values
