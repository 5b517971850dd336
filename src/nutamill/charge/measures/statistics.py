"""Statistics of a charge, summed while it runs: work and load on the walls, density and velocity fields,
touching neighbours.

A *sample* (`nutamill.charge.measures.sampling`) is taken at the rows of the record: contacts with walls as
the next substep will meet them, everything else as it is.  The sum of samples times their interval is the
integral over time by the rectangle rule.  Its error is that of counting samples: contacts begin and end
within an interval, so that a total that comes from n seen contacts is uncertain by about 1/sqrt(n) of itself.

All sums are whole numbers of a small unit.  They add up to the same sum in any order: every thread keeps its
own, and the total has the same bits for any number of threads (`nutamill.charge.measures.totals`).
"""

import math
from typing import NamedTuple

import numpy as np

from nutamill.charge.kernels.clumps import CLUMP
from nutamill.charge.model import ChargeModel, ChargeState

WALL_SUMS = ("normal_work", "shear_work", "rolling_work", "load", "contacts")
"""Sums of a patch: work taken out by the three parts of the law [J], normal load [N s], contacts [s]."""
FIELD_SUMS = (
    "solid_volume",
    "mass",
    "momentum_r",
    "momentum_a",
    "momentum_z",
    "square_speed",
    "particles",
    "neighbours",
)
"""Sums of a cell: solid volume [m^3 s], mass [kg s], momentum relative to the body, radial, azimuthal, axial
[kg m], mass times squared speed [J s], particles [s], touching neighbours of its particles [s].  The first
goes by volume, the others by particle centres.
"""
MOST_NEIGHBOURS = 16
"""Places of the histogram of touching neighbours [1]; the last counts all that have as many or more."""
FINE = 2.0**30
"""Small units in the quantity that one mean particle at 1 m/s stands for [1]."""
POINTS = 1024
"""Places within a particle at which its volume is put, one after the other [1]."""


class StatisticsPlan(NamedTuple):
    """What is summed, and where: constants."""

    on: int
    """1: take samples, 0: none [1]."""
    body: int
    """Body whose axes the grid has, and in whose motion velocities are measured [1]."""
    origin: np.ndarray
    """Origin of the grid [m] (3,), body axes, from the body's mass centre."""
    cells: np.ndarray
    """Cells along radius, azimuth and height [1], int64 (3,)."""
    extent: np.ndarray
    """Largest radius, lowest and highest height [m] (3,), grid axes; points beyond count in the outermost
    cell.
    """
    within: np.ndarray
    """Places within a ball of radius 1, evenly spread [1] (POINTS, 3)."""
    mass_of: np.ndarray
    """Mass of each sphere by id, of a pebble its share of the clump's by volume [kg] (n,)."""
    volume_of: np.ndarray
    """Solid volume of each sphere by id, of a pebble its share of the clump's [m^3] (n,)."""
    per_wall: np.ndarray
    """Small units in 1 of each of `WALL_SUMS` [1/unit], (5,)."""
    per_field: np.ndarray
    """Small units in 1 of each of `FIELD_SUMS` [1/unit], (8,)."""


class ChargeStatistics(NamedTuple):
    """Sums over all samples since the start, by thread; the sum over threads is what counts."""

    samples: np.ndarray
    """Samples taken [1], int64 (1,)."""
    walls: np.ndarray
    """`WALL_SUMS` of each patch in small units, int64 (T, P, 5)."""
    fields: np.ndarray
    """`FIELD_SUMS` of each cell in small units, int64 (T, cells, 8); radius outermost, height innermost."""
    neighbours: np.ndarray
    """Particles with 0, 1, 2 ... touching neighbours, int64 (T, MOST_NEIGHBOURS)."""


def points_within() -> np.ndarray:
    """Return evenly spread points in a ball of radius 1 (POINTS, 3), whose mean is the centre.

    Source: M. Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018 (R3 sequence); each
    place is used with its opposite.
    """
    root = 1.2207440846057596  # of x^4 = x + 1
    u = np.mod(0.5 + np.outer(np.arange(1, POINTS // 2 + 1), root ** -np.arange(1.0, 4.0)), 1.0)
    height, azimuth = 2.0 * u[:, 1] - 1.0, math.tau * u[:, 2]
    flat = np.sqrt(1.0 - height**2)
    half = np.cbrt(u[:, :1]) * np.stack([flat * np.cos(azimuth), flat * np.sin(azimuth), height], axis=1)
    return np.stack([half, -half], axis=1).reshape(POINTS, 3)


def statistics_plan(
    model: ChargeModel,
    state: ChargeState,
    dt: float,
    body: int = 0,
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0),
    cells: tuple[int, int, int] = (1, 1, 1),
    extent: tuple[float, float, float] = (1.0, 0.0, 1.0),
    on: bool = True,
    volumes: np.ndarray | None = None,
) -> StatisticsPlan:
    """Return what is summed for a charge, and where.

    Parameters
    ----------
    dt : substep [s]
    body, origin, cells, extent, on : as in `StatisticsPlan`
    volumes : `StatisticsPlan.volume_of` where particles are clumps, whose pebbles overlap; that of spheres if
        None
    """
    n, ids = model.n_particles, state.ids[: model.n_particles]
    mass_of, volume_of = np.empty(n), np.empty(n)
    volume_of[ids] = 4.0 / 3.0 * math.pi * state.mass_props[0, :n] ** 3
    volume_of = volume_of if volumes is None else np.array(volumes, float)
    mass_of[ids] = state.mass_props[1, :n]
    if len(state.clumps):
        clump = state.mass_props[CLUMP, :n].astype(int)
        mass_of[ids] *= volume_of[ids] / np.bincount(clump, volume_of[ids])[clump]
    mass, volume = float(mass_of.mean()), float(volume_of.mean())
    power, force = mass / dt, mass / dt
    return StatisticsPlan(
        on=int(on),
        body=body,
        origin=np.array(origin, float),
        cells=np.array(cells, np.int64),
        extent=np.array(extent, float),
        within=points_within(),
        mass_of=mass_of,
        volume_of=volume_of,
        per_wall=FINE / np.array([power, power, power, force, FINE]),  # contacts are counted, one unit each
        per_field=FINE / np.array([volume, mass, mass, mass, mass, mass, FINE, FINE]),  # and so are particles
    )


def charge_statistics(plan: StatisticsPlan, state: ChargeState) -> ChargeStatistics:
    """Return empty sums for a charge, without room for samples where the plan is off."""
    threads, patches = state.impacts.cut.shape
    cells = int(plan.cells.prod())
    if not plan.on:
        threads, patches, cells = 1, 0, 0
    return ChargeStatistics(
        np.zeros(1, np.int64),
        np.zeros((threads, patches, len(WALL_SUMS)), np.int64),
        np.zeros((threads, cells, len(FIELD_SUMS)), np.int64),
        np.zeros((threads, MOST_NEIGHBOURS), np.int64),
    )
