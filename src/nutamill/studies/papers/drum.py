"""Quantities of the bed in a drum that turns about a level axis through the origin, from its snapshots.

The surface of the bed is a line in the plane across the axis.  Along it counts down the slope, across it out
of the bed: the surface of a half-full drum is at zero, the wall at minus the radius.
"""

import math
from typing import NamedTuple

import numpy as np

from nutamill.base.errors import ResultError
from nutamill.base.steady import Estimate
from nutamill.base.units import shown
from nutamill.result import Result

MIDDLE = 0.5
"""Share of the chord about its middle, in which the surface is straight [1]."""
COLUMNS = 12
"""Columns in which the surface is looked for [1]."""
TOP = 0.995
"""Quantile of the heights of a column that is its surface [1]: single grains in flight are above it."""
STRIP = 5.0
"""Half width of the strip about mid-chord in which speeds are taken, over the mean radius [1]."""
LAYER = 1.0
"""Half thickness of a layer over the mean radius [1]."""


class Bed(NamedTuple):
    """Grains of all snapshots of the last seconds, in axes of the surface."""

    along: np.ndarray
    """Place along the surface, down the slope, from the middle of the drum [m] (n,)."""
    across: np.ndarray
    """Place across it, out of the bed, from the axis of the drum [m] (n,)."""
    speed: np.ndarray
    """Speed down the slope [m/s] (n,)."""
    angle: float
    """Angle of the surface to the level [rad]."""
    radius: float
    """Mean radius of the grains [m]."""


def bed_of(result: Result, last: float) -> Bed:
    """Return the bed of the last seconds.

    The axis of the drum is along x.  The surface is a straight line through the tops of columns about the
    middle of the chord, square to it, determined in three rounds.

    Raises
    ------
    ResultError : no snapshots with a charge
    """
    chosen = [number for number, time in enumerate(result.snapshots.time) if time > result.reached - last]
    if not chosen or "velocities" not in result.snapshots[chosen[0]]:
        raise ResultError(f"{result.path}: has no snapshots of a charge in its last {last:g} s.")
    places = np.concatenate([result.snapshots[number]["positions"] for number in chosen]).astype(float)
    speeds = np.concatenate([result.snapshots[number]["velocities"] for number in chosen]).astype(float)
    radius = float(np.mean(result.snapshots[chosen[0]]["radii"]))
    down = -np.sign(np.median(places[:, 1])) or 1.0  # the bed is on the side that rises
    level, height = down * places[:, 1], places[:, 2]
    angle = 0.0
    for _ in range(3):
        along = math.cos(angle) * level - math.sin(angle) * height
        across = math.sin(angle) * level + math.cos(angle) * height
        angle += math.atan(-_slope(along, across))
    along = math.cos(angle) * level - math.sin(angle) * height
    across = math.sin(angle) * level + math.cos(angle) * height
    speed = math.cos(angle) * down * speeds[:, 1] - math.sin(angle) * speeds[:, 2]
    return Bed(along, across, speed, angle, radius)


def _slope(along: np.ndarray, across: np.ndarray) -> float:
    """Return the slope of the tops of columns about the middle of the chord [1]."""
    half = MIDDLE * np.quantile(np.abs(along), TOP)
    edges = np.linspace(-half, half, COLUMNS + 1)
    column = np.digitize(along, edges) - 1
    tops = [np.quantile(across[column == k], TOP) for k in range(COLUMNS)]
    return float(np.polyfit(0.5 * (edges[1:] + edges[:-1]), tops, 1)[0])


def bed_angle(result: Result, last: float) -> Estimate:
    """Return the angle of the surface to the level [rad]."""
    return Estimate.exact(bed_of(result, last).angle)


def bed_speed(result: Result, last: float, at: float) -> Estimate:
    """Return the mean speed down the slope of the grains at mid-chord in a layer across the bed [m/s].

    Raises
    ------
    ResultError : no grain is there
    """
    bed = bed_of(result, last)
    speed = _layer_speed(bed, at)
    if math.isnan(speed):
        raise ResultError(f"{result.path}: has no grains at {shown(at, 'mm')} at mid-chord.")
    return Estimate.exact(speed)


def still_depth(result: Result, last: float) -> Estimate:
    """Return the place across the bed at which the mean speed along the surface is zero at mid-chord [m].

    Raises
    ------
    ResultError : all of the bed moves one way
    """
    bed = bed_of(result, last)
    strip = np.abs(bed.along) < STRIP * bed.radius
    places = np.arange(bed.across[strip].min(), bed.across[strip].max(), bed.radius)
    speeds = np.array([_layer_speed(bed, place) for place in places])
    known = np.isfinite(speeds)
    places, speeds = places[known], speeds[known]
    crossings = np.flatnonzero((speeds[:-1] < 0.0) & (speeds[1:] >= 0.0))
    if not len(crossings):
        raise ResultError(f"{result.path}: has no place across the bed that stands still.")
    first = crossings[0]
    share = -speeds[first] / (speeds[first + 1] - speeds[first])
    return Estimate.exact(float(places[first] + share * (places[first + 1] - places[first])))


def _layer_speed(bed: Bed, at: float) -> float:
    """Return the mean speed down the slope in a layer at mid-chord [m/s], NaN where no grain is."""
    inside = (np.abs(bed.along) < STRIP * bed.radius) & (np.abs(bed.across - at) < LAYER * bed.radius)
    return float(bed.speed[inside].mean()) if inside.any() else math.nan
