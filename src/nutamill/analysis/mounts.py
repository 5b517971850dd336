"""What the mounts do: travel and force of each, the force on the floor, and how near the chamber comes to
what is around it.
"""

import fnmatch
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from nutamill.analysis.load_paths import attitude, order_amplitudes
from nutamill.analysis.source import case_of, vector
from nutamill.analysis.windows import PAPER_WINDOW, steady_window
from nutamill.base.errors import CaseError, Fault
from nutamill.base.units import in_unit, shown
from nutamill.result import Result


class MountReading(NamedTuple):
    """One mount in steady running."""

    number: int
    """Number of the mount, from 1."""
    mean_travel: np.ndarray
    """Mean travel [m], (3,), world axes."""
    swing: np.ndarray
    """Half of the range of the travel [m], (3,)."""
    largest_travel: float
    """Largest distance from its place as assembled, over the whole run [m]."""
    mean_force: np.ndarray
    """Mean force on the frame [N], (3,)."""
    swing_force: np.ndarray
    """Half of the range of the force [N], (3,)."""


class FloorForce(NamedTuple):
    """Force of the machine on the floor in steady running: through mounts or rigid fixing, and the
    intermediate shaft's bearing.
    """

    mean: np.ndarray
    """Mean force [N], (3,), world axes."""
    once: np.ndarray
    """Amplitude once per turn [N], (3,)."""
    twice: np.ndarray
    """Amplitude twice per turn [N], (3,)."""


class Clearance(NamedTuple):
    """The smallest room between a ring on the chamber and a round opening over a run."""

    room: float
    """Opening's radius less the farthest point of the ring [m]; negative where they meet."""
    time: float
    """When [s]."""
    angle: float
    """Crank angle then, within a turn [rad]."""
    azimuth: float
    """Azimuth of the point about the opening's axis [rad]."""


def mount_readings(result: Result, last: float | str = PAPER_WINDOW) -> list[MountReading]:
    """Return travel and force of every mount over the whole turns of the steady window.

    Raises
    ------
    CaseError : a machine on rigid mounts
    ResultError : the run has not made one turn at its last speed
    """
    inside = _steady(result, last)
    readings = []
    for number in range(1, _count(result) + 1):
        travel, force = (vector(result.series, f"mount_{number}_{what}") for what in ("travel", "force"))
        steady = [(part[inside].mean(axis=0), 0.5 * np.ptp(part[inside], axis=0)) for part in (travel, force)]
        readings.append(
            MountReading(number, *steady[0], float(np.linalg.norm(travel, axis=1).max()), *steady[1])
        )
    return readings


def floor_force(result: Result, last: float | str = PAPER_WINDOW) -> FloorForce:
    """Return the force on the floor over the whole turns of the steady window."""
    inside = _steady(result, last)
    angle, force = result.series["crank_angle"].values[inside], floor_series(result.series)[inside]
    return FloorForce(force.mean(axis=0), *order_amplitudes(angle, force, (1, 2)))


def floor_series(series: Mapping[Any, Any]) -> np.ndarray:
    """Return the force of the machine on the floor [N] at every sample, (n, 3), world axes, from its series
    by name.

    Through the mounts or the rigid fixing, and the bearing of the intermediate shaft.
    """
    feet = [
        str(name).removesuffix("_x") for name in series if fnmatch.fnmatchcase(str(name), "mount_*_force_x")
    ]
    names = [*(feet or ["frame_fix_reaction_force"]), "intermediate_shaft_bearing_reaction_force"]
    return -np.sum([vector(series, name) for name in names], axis=0)


def nutation_point_path(result: Result) -> np.ndarray:
    """Return the displacement of the nutation point from its assembled position [m], (n, 3), world axes, from
    the travel of the mounts.
    """
    if "frame_fix_reaction_force_x" in result.series:
        return np.zeros((len(result.series["time"]), 3))
    case = case_of(result)
    feet = np.array([(x, y, -case.mounts.depth) for x, y in case.mounts.points])
    turn = attitude(result, "frame")
    paths = [
        foot + vector(result.series, f"mount_{number}_travel") - turn @ foot
        for number, foot in enumerate(feet, start=1)
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
    CaseError : lengths that are none, or another body
    """
    if min(*ring, opening) <= 0.0:
        raise CaseError(
            Fault(
                "clearance", f"radii and depth must be positive, got ring {ring} m and opening {opening:g} m"
            )
        )
    if fixed_to not in ("frame", "ground"):
        raise CaseError(Fault("clearance", f'must be of the "frame" or the "ground", got {fixed_to!r}'))
    around = 2.0 * np.pi * np.arange(180) / 180
    edge = np.column_stack([ring[0] * np.cos(around), ring[0] * np.sin(around), np.full(180, -ring[1])])
    chamber, frame = attitude(result, "chamber"), attitude(result, "frame")
    if fixed_to == "frame":
        points = np.einsum("nki,nkj,mj->nmi", frame, chamber, edge)
    else:
        points = np.einsum("nij,mj->nmi", chamber, edge) + nutation_point_path(result)[:, None, :]
    out = np.hypot(points[:, :, 0], points[:, :, 1])
    n, m = np.unravel_index(out.argmax(), out.shape)
    time, angle = (float(result.series[name].values[n]) for name in ("time", "crank_angle"))
    azimuth = float(np.arctan2(points[n, m, 1], points[n, m, 0]))
    return Clearance(opening - float(out[n, m]), time, angle % (2.0 * np.pi), azimuth)


def mounts_lines(result: Result, last: float | str = PAPER_WINDOW) -> list[str]:
    """Format mounts and floor in steady running as a table."""
    rows = []
    if "frame_fix_reaction_force_x" not in result.series:
        rows.append("mounts: half of the range in steady running, and the largest travel of the run")
        rows.append(
            f"{'':8}"
            + " ".join(
                f"{name:>9}"
                for name in ("x (mm)", "y (mm)", "z (mm)", "Fx (N)", "Fy (N)", "Fz (N)", "max (mm)")
            )
        )
        for mount in mount_readings(result, last):
            lengths = [*in_unit(mount.swing, "mm"), in_unit(mount.largest_travel, "mm")]
            columns = [*lengths[:3], *mount.swing_force, lengths[3]]
            rows.append(f"mount {mount.number:<2}" + " ".join(f"{number:9.4g}" for number in columns))
    floor = floor_force(result, last)
    rows.append(f"force on the floor (N): {'x':>9} {'y':>9} {'z':>9}")
    for name, numbers in (
        ("mean", floor.mean),
        ("once per turn", floor.once),
        ("twice per turn", floor.twice),
    ):
        rows.append(f"  {name:20} " + " ".join(f"{number:9.4g}" for number in numbers))
    return rows


def clearance_line(clearance: Clearance) -> str:
    """Format the clearance as a sentence."""
    angles = [round(in_unit(angle, "deg")) % 360 for angle in (clearance.angle, clearance.azimuth)]
    where = f"at crank angle {angles[0]}°, azimuth {angles[1]}° (t = {clearance.time:.4g} s)"
    if clearance.room < 0.0:
        inside = shown(-clearance.room, "mm", ".3g")
        return f"clearance: the chamber meets the opening {where}, {inside} inside"
    return f"clearance: {shown(clearance.room, 'mm', '.3g')} left {where}"


def _count(result: Result) -> int:
    """Count the mounts."""
    if "mount_1_travel_x" not in result.series:
        raise CaseError(
            Fault(
                str(result.path),
                "must be a run on flexible mounts, its frame is fixed",
                "Set mechanism.mounting=flexible",
            )
        )
    return case_of(result).mounts.count


def _steady(result: Result, last: float | str) -> np.ndarray:
    """Mark the samples within the whole turns of the steady window, (n,) of bool. The last one belongs to the
    next turn.
    """
    turns = steady_window(result, last).turns
    time = result.series["time"].values
    return (time >= turns[0]) & (time < turns[-1] * (1.0 - 1e-12))
