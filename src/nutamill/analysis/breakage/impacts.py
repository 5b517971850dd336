"""What a run does to whatever is between its balls: the work that loads its contacts, how much ore each
captures, and the power that all this takes.

The charge of the run is the grinding media.  Ore is not simulated: each impact loads a layer of it, one
particle thick, that two balls, or a ball and a wall, close upon.
"""

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from nutamill.analysis.flow import refuse_without_loading, window, window_parts
from nutamill.analysis.power import power_split
from nutamill.analysis.source import any_case_of
from nutamill.analysis.windows import PAPER_WINDOW
from nutamill.base.errors import ResultError
from nutamill.result import Result

if TYPE_CHECKING:
    import xarray

DENSEST = math.pi / math.sqrt(12.0)
"""Share of a plane that equal discs cover in their densest arrangement [1]."""


class Impacts(NamedTuple):
    """Contacts of a run by the work that loads them, by pair of classes of balls and bin of energy
    (n_pairs, n_bins).
    """

    edges: np.ndarray
    """Edges of the bins [J] (n_bins + 1,)."""
    number: np.ndarray
    """Impacts [1]."""
    energy: np.ndarray
    """Mean work of those of a bin [J]; its middle where it is empty."""
    rate: np.ndarray
    """Impacts per energy that the mill takes up [1/J]."""
    reduced_radius: np.ndarray
    """Reduced radius of the two bodies [m] (n_pairs, 1)."""


class Grinding(NamedTuple):
    """What a run does, in its last part."""

    path: str
    """The result file."""
    title: str
    """Title of the case that was run."""
    duration: float
    """Length of that part [s]."""
    power: float
    """Mean power that motors, drives and given loads supply [W]."""
    smallest_ball: float
    """Diameter of the smallest class of balls [m]."""
    whole: Impacts
    """All its impacts."""
    parts: tuple[Impacts, ...]
    """The same of successive lengths of time, from which the scatter is estimated."""


def grinding_of(result: Result, last: float | str = PAPER_WINDOW) -> Grinding:
    """Read the impacts and the power of the last part of a run.

    Statistics are recorded at checkpoints; up to ten groups of them give the scatter.

    Raises
    ------
    ResultError : an empty chamber, no statistics or those of an earlier version, no power put in, or no turn
        at the last speed
    """
    done = window(result, last)
    refuse_without_loading(result, done)
    power = power_split(result, last).motor
    if not power > 0.0:
        raise ResultError(
            f"{result.path}: the energy that breaks ore is counted against the power of the mill, and this "
            f"run takes up {power:.3g} W. Give a run whose drive or loads do work."
        )
    first, second = done["pair_first"].values, done["pair_second"].values
    if np.isnan(second).all():
        raise ResultError(
            f"{result.path}: holds no impacts of particles with each other, as LAMMPS moved them. Run the "
            "case without charge.engine."
        )
    reduced = reduced_radii(first, second)
    return Grinding(
        str(result.path),
        any_case_of(result).title,
        float(done["sampled_time"]),
        power,
        float(first.min()),
        _impacts_of(done, power, reduced),
        tuple(_impacts_of(part, power, reduced) for part in window_parts(result, last)),
    )


def _impacts_of(done: "xarray.Dataset", power: float, reduced: np.ndarray) -> Impacts:
    """Return the impacts of a window, at a `power` of the mill [W], with the `reduced` radius of each pair
    [m].

    A contact that was booked before the window and is pressed deeper within it leaves its old bin: what then
    is below zero counts as none.
    """
    number, energy = (done[name].sel(part="loading").values for name in ("impact_number", "impact_energy"))
    number = np.maximum(number, 0.0)
    centre = done["energy"].values
    ratio = math.sqrt(centre[1] / centre[0])
    edges = np.append(centre / ratio, centre[-1] * ratio)
    mean = np.clip(energy / np.maximum(number, 1.0), edges[:-1], np.append(edges[1:-1], np.inf))
    return Impacts(
        edges,
        number,
        np.where(number > 0.0, mean, centre),
        number / (float(done["sampled_time"]) * power),
        reduced[:, None],
    )


def reduced_radii(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return the reduced radii of pairs of particles [m] from their diameters [m]. Walls are flat, their
    diameter is not a number.
    """
    return np.where(np.isnan(second), 0.5 * first, 0.5 * first * second / (first + second))


def captured_mass(size: float, reduced_radius: np.ndarray, density: float) -> np.ndarray:
    """Return the mass of ore [kg] that an impact loads: the particles of one layer between two bodies that
    close upon it, one particle at least.

    The gap of two bodies that touch is less than the particle's size d up to the radius ``sqrt(2 R d)``, R
    the reduced radius; the layer is as dense as spheres in a plane can be.

    Parameters
    ----------
    size : diameter of the particles [m]
    reduced_radius : of the two bodies [m]
    density : of the ore [kg/m^3]

    Source
    ------
    Geometry. The layer of one particle is that of L. M. Tavares, KONA Powder and Particle Journal 34 (2017)
    106-124.
    """
    particle = math.pi / 6.0 * size**3 * density
    number = DENSEST * 2.0 * math.pi * reduced_radius * size / (0.25 * math.pi * size**2)
    return particle * np.maximum(number, 1.0)
