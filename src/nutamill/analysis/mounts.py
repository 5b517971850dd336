"""What the mounts do: travel and force of each, the force on the floor, and how near the chamber comes to
what is around it.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from nutamill.analysis.load_paths import attitude, order_amplitudes
from nutamill.analysis.source import machine_of
from nutamill.analysis.windows import PAPER_WINDOW, steady_window, turn_series
from nutamill.base.errors import CaseError, Fault
from nutamill.base.units import in_unit, shown
from nutamill.case import Machine
from nutamill.case.drawing import CHAMBER, FRAME, GROUND
from nutamill.case.loads import StopEntry
from nutamill.case.machine import BushingEntry, JointEntry, SpringEntry, series_called
from nutamill.result import Result


class MountReading(NamedTuple):
    """One support in steady running: a mount of a mill, or any bushing between a body and the ground."""

    name: str
    """Name of the bushing."""
    mean_travel: np.ndarray
    """Mean travel [m], (3,), axes of the bushing, of a mill those of the world."""
    swing: np.ndarray
    """Half of the range of the travel [m], (3,)."""
    largest_travel: float
    """Largest distance from its place as assembled, over the whole run [m]."""
    mean_force: np.ndarray
    """Mean force on the body that it carries [N], (3,)."""
    swing_force: np.ndarray
    """Half of the range of the force [N], (3,)."""


class FloorForce(NamedTuple):
    """Force of the machine on the floor in steady running, through all that connects it with the ground: of a
    mill mounts or rigid fixing, and the intermediate shaft's bearing.
    """

    mean: np.ndarray
    """Mean force [N], (3,), world axes."""
    once: np.ndarray
    """Amplitude once per turn [N], (3,); NaN where nothing turns."""
    twice: np.ndarray
    """Amplitude twice per turn [N], (3,)."""


class Clearance(NamedTuple):
    """The smallest room between a ring on the chamber and a round opening over a run."""

    room: float
    """Opening's radius less the farthest point of the ring [m]; negative where they meet."""
    time: float
    """When [s]."""
    angle: float
    """Crank angle then, within a turn [rad]; NaN where nothing turns."""
    azimuth: float
    """Azimuth of the point about the opening's axis [rad]."""


def mount_readings(result: Result, last: float | str = PAPER_WINDOW) -> list[MountReading]:
    """Return travel and force of every support over the whole turns of the steady window.

    Raises
    ------
    CaseError : a machine without bushings to the ground, or measured data
    ResultError : the run has not made one turn at its last speed, or records none of their series
    """
    machine = machine_of(result)
    names = [bushing.name for bushing in machine.bushings if GROUND in bushing.between]
    if not names:
        what = "must be the run of a machine on bushings, nothing else is between it and the ground"
        raise CaseError(Fault(str(result.path), what, "Of a mill set mechanism.mounting=flexible"))
    inside = _steady(result, last)
    readings = []
    for name in names:
        travel, force = (
            recorded_vector(result, machine, f"bushing_{name}_{what}") for what in ("travel", "force")
        )
        steady = [(part[inside].mean(axis=0), 0.5 * np.ptp(part[inside], axis=0)) for part in (travel, force)]
        farthest = float(np.linalg.norm(travel, axis=1).max())
        readings.append(MountReading(name, *steady[0], farthest, *steady[1]))
    return readings


def floor_force(result: Result, last: float | str = PAPER_WINDOW) -> FloorForce:
    """Return the force on the floor over the whole turns of the steady window."""
    inside, turning = _steady(result, last), turn_series(result)
    force = floor_series(result.series, machine_of(result))[inside]
    if turning is None:
        return FloorForce(force.mean(axis=0), np.full(3, np.nan), np.full(3, np.nan))
    angle = result.series[turning].values[inside]
    return FloorForce(force.mean(axis=0), *order_amplitudes(angle, force, (1, 2)))


def floor_series(series: Mapping[Any, Any], machine: Machine) -> np.ndarray:
    """Return the force of a machine on the floor [N] at every sample, (n, 3), world axes, from its series by
    name: through all joints and bushings that the ground has.

    Raises
    ------
    CaseError : springs or stops to the ground, a bushing to it that is not along z, or no joint and no
        bushing; a force that is not recorded
    """
    ties: list[JointEntry | BushingEntry] = [*machine.joints, *machine.bushings]
    standing = [entry for entry in ties if GROUND in entry.between]
    elastic: list[SpringEntry | StopEntry] = [*machine.springs, *machine.stops]
    others = [entry.name for entry in elastic if GROUND in entry.between]
    feet = [entry for entry in machine.bushings if GROUND in entry.between]
    tilted = [foot.name for foot in feet if any(foot.axis[:2]) or foot.between[0] != GROUND]
    if others or tilted or not standing:
        through = ", ".join(others + tilted) or "nothing that is recorded"
        what = f"stands on the ground by {through}, whose force on it in world axes is not known"
        hint = "Describe what it stands on as joints, or as bushings along z from the ground"
        raise CaseError(Fault(machine.name, what, hint))
    total = np.zeros((len(next(iter(series.values()))), 3))
    for entry in standing:
        kind = "bushing" if isinstance(entry, BushingEntry) else "joint"
        force = _vector(series, machine, f"{kind}_{entry.name}_force")
        total += force if entry.between[1] == GROUND else -force
    return total


def recorded_vector(result: Result, machine: Machine, own: str) -> np.ndarray:
    """Return a vector of a part among the series of a result, (n, 3), by its own name or that of quantities.

    Raises
    ------
    CaseError : it is not recorded
    """
    return _vector(result.series, machine, own)


def _vector(series: Mapping[Any, Any], machine: Machine, own: str) -> np.ndarray:
    """Return a vector of a part among series, (n, 3). Raises CaseError where it is not recorded."""
    columns = []
    for name in (f"{own}_{axis}" for axis in "xyz"):
        known = next((called for called in (name, series_called(machine, name)) if called in series), None)
        if known is None:
            raise CaseError(Fault("run.series", f"leaves out {name}, which this answer needs", "Add it"))
        columns.append(np.asarray(series[known]))
    return np.column_stack(columns)


def nutation_point_path(result: Result) -> np.ndarray:
    """Return the displacement of the nutation point, the origin as assembled, with the frame [m], (n, 3),
    world axes, from the travel of the bushings between frame and ground.
    """
    machine = machine_of(result)
    feet = [entry for entry in machine.bushings if {*entry.between} == {GROUND, FRAME}]
    if not feet:
        return np.zeros((len(result.series["time"]), 3))
    turn = attitude(result, FRAME)
    paths = [
        np.array(foot.point)
        + recorded_vector(result, machine, f"bushing_{foot.name}_travel")
        - turn @ np.array(foot.point)
        for foot in feet
    ]
    return np.mean(paths, axis=0)


def chamber_clearance(
    result: Result, ring: Sequence[float], opening: float, fixed_to: str = "frame"
) -> Clearance:
    """Return the smallest gap between a ring on the chamber and a round opening about the driveshaft axis.

    Parameters
    ----------
    ring : radius, and depth below the nutation point along the chamber axis, of the widest edge of the
        chamber [m]
    opening : radius of the opening [m]; it is as deep as the ring moves
    fixed_to : "frame", or "ground" for something that stands beside the machine

    Raises
    ------
    CaseError : lengths that are none, another body, or a machine that does not record the attitudes of a
        frame and a chamber
    """
    if not all(math.isfinite(length) and length > 0.0 for length in (*ring, opening)):
        what = f"radii and depth must be positive, got ring {tuple(ring)} m and opening {opening:g} m"
        raise CaseError(Fault("clearance", what, 'Write e.g. --ring "90 mm" "480 mm" --opening "100 mm"'))
    if fixed_to not in (FRAME, GROUND):
        raise CaseError(Fault("clearance", f'must be of the "frame" or the "ground", got {fixed_to!r}'))
    if missing := [name for name in (FRAME, CHAMBER) if f"{name}_attitude_w" not in result.series]:
        what = f"needs the attitude of {' and '.join(missing)}, which this run does not record"
        raise CaseError(Fault("clearance", what, 'Add [[sensors]] with kind = "attitude"'))
    around = 2.0 * np.pi * np.arange(180) / 180
    edge = np.column_stack([ring[0] * np.cos(around), ring[0] * np.sin(around), np.full(180, -ring[1])])
    chamber, frame = attitude(result, CHAMBER), attitude(result, FRAME)
    if fixed_to == FRAME:
        points = np.einsum("nki,nkj,mj->nmi", frame, chamber, edge)
    else:
        points = np.einsum("nij,mj->nmi", chamber, edge) + nutation_point_path(result)[:, None, :]
    out = np.hypot(points[:, :, 0], points[:, :, 1])
    n, m = np.unravel_index(out.argmax(), out.shape)
    time, turning = float(result.series["time"].values[n]), turn_series(result)
    angle = math.nan if turning is None else float(result.series[turning].values[n])
    azimuth = float(np.arctan2(points[n, m, 1], points[n, m, 0]))
    return Clearance(opening - float(out[n, m]), time, angle % (2.0 * np.pi), azimuth)


def mounts_lines(result: Result, last: float | str = PAPER_WINDOW) -> list[str]:
    """Format mounts and floor in steady running as a table."""
    rows = []
    if any(GROUND in bushing.between for bushing in machine_of(result).bushings):
        rows.append("mounts: half of the range in steady running, and the largest travel of the run")
        readings = mount_readings(result, last)
        width = max(8, *(len(mount.name) + 1 for mount in readings))
        rows.append(
            f"{'':{width}}"
            + " ".join(
                f"{name:>9}"
                for name in ("x (mm)", "y (mm)", "z (mm)", "Fx (N)", "Fy (N)", "Fz (N)", "max (mm)")
            )
        )
        for mount in readings:
            lengths = [*in_unit(mount.swing, "mm"), in_unit(mount.largest_travel, "mm")]
            columns = [*lengths[:3], *mount.swing_force, lengths[3]]
            rows.append(
                f"{mount.name.replace('_', ' '):{width}}" + " ".join(f"{number:9.4g}" for number in columns)
            )
    floor = floor_force(result, last)
    rows.append(f"force on the floor (N): {'x':>9} {'y':>9} {'z':>9}")
    for name, numbers in (
        ("mean", floor.mean),
        ("once per turn", floor.once),
        ("twice per turn", floor.twice),
    ):
        cells = " ".join(f"{'-' if math.isnan(number) else f'{number:.4g}':>9}" for number in numbers)
        rows.append(f"  {name:20} {cells}")
    return rows


def clearance_line(clearance: Clearance) -> str:
    """Format the clearance as a sentence."""
    crank = "" if math.isnan(clearance.angle) else f"crank angle {_degrees(clearance.angle)}°, "
    where = f"at {crank}azimuth {_degrees(clearance.azimuth)}° (t = {clearance.time:.4g} s)"
    if clearance.room < 0.0:
        inside = shown(-clearance.room, "mm", ".3g")
        return f"clearance: the chamber meets the opening {where}, {inside} inside"
    return f"clearance: {shown(clearance.room, 'mm', '.3g')} left {where}"


def _degrees(angle: float) -> int:
    """Return an angle [rad] in whole degrees, 0 to 359."""
    return round(in_unit(angle, "deg")) % 360


def _steady(result: Result, last: float | str) -> np.ndarray:
    """Mark the samples within the whole turns of the steady window, (n,) of bool. The last one belongs to the
    next turn.
    """
    turns = steady_window(result, last).turns
    time = result.series["time"].values
    return (time >= turns[0]) & (time < turns[-1] * (1.0 - 1e-12))
