"""Sizes of particles: classes by share of the mass, or a normal or Rosin-Rammler law between two cuts.

A size is the diameter of a sphere, or of the sphere of a clump's volume.  Sizes are not random: of n
particles, particle i has the quantile (i + 1/2)/n of the law.  No sample is nearer to it: the distribution of
the sample differs from the law by 1/(2 n) at most.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr

CELLS = 8192
"""Cells of the table of a law [1]; its relative error is of the order of the square of a cell."""

SLACK = 1e-6
"""Share of a particle by which a target may be missed [1]: forgives a mass given as an exact multiple."""


@dataclass(frozen=True, slots=True)
class SizeClasses:
    """A few sizes, each with its share of the mass.

    Attributes
    ----------
    classes : pairs of diameter [m] and share of the mass [1]; the shares sum to 1
    """

    classes: tuple[tuple[float, float], ...]

    @property
    def mean_volume(self) -> float:
        """Mean volume of a particle [m^3]."""
        return 1.0 / sum(share / sphere_volume(diameter) for diameter, share in self.classes)

    def of_volume(self, volume: float) -> np.ndarray:
        """Return the diameters [m] (n,), rising, of the fewest particles whose solid volume is at least
        `volume` [m^3].
        """
        counts = [
            math.ceil(share * volume / sphere_volume(diameter) - SLACK) for diameter, share in self.classes
        ]
        return np.repeat([diameter for diameter, _ in self.classes], counts)

    def of_number(self, number: int) -> np.ndarray:
        """Return the diameters [m] of exactly `number` particles, rising."""
        mean = self.mean_volume
        exact = np.array(
            [number * share * mean / sphere_volume(diameter) for diameter, share in self.classes]
        )
        counts = np.floor(exact + 1e-9).astype(int)
        rest = np.argsort(-(exact - counts), kind="stable")[: number - counts.sum()]
        counts[rest] += 1
        return np.repeat([diameter for diameter, _ in self.classes], counts)


@dataclass(frozen=True, slots=True, eq=False)
class SizeLaw:
    """A continuous law of sizes between two cuts, tabulated.

    Attributes
    ----------
    diameter : [m] (m,), rising
    number_below : share of the particles that are smaller [1] (m,), from 0 to 1
    """

    diameter: np.ndarray
    number_below: np.ndarray

    @property
    def mean_volume(self) -> float:
        """Mean volume of a particle [m^3]."""
        return float(np.diff(self.number_below) @ _cell_volume(self.diameter))

    def of_volume(self, volume: float) -> np.ndarray:
        """Return the diameters [m] (n,), rising, of the fewest particles whose solid volume is at least
        `volume` [m^3].
        """
        target = volume - SLACK * self.mean_volume
        number = max(1, math.ceil(volume / self.mean_volume))
        while number > 1 and _solid(self.of_number(number - 1)) >= target:
            number -= 1
        while _solid(sizes := self.of_number(number)) < target:
            number += 1
        return sizes

    def of_number(self, number: int) -> np.ndarray:
        """Return the diameters [m] of exactly `number` particles, rising."""
        return np.interp((np.arange(number) + 0.5) / number, self.number_below, self.diameter)


def normal_sizes(mean: float, deviation: float, smallest: float, largest: float, by: str) -> SizeLaw:
    """Return the normal law of diameters, truncated at both ends and normalised.

    Parameters
    ----------
    mean, deviation : of the law before it is cut [m]
    smallest, largest : cuts [m]
    by : "number" or "mass": whose share the law gives

    Raises
    ------
    ValueError : the law has no share between the cuts
    """
    return _tabulated(lambda d: ndtr((d - mean) / deviation), smallest, largest, by)


def rosin_rammler_sizes(size: float, exponent: float, smallest: float, largest: float) -> SizeLaw:
    """Return the Rosin-Rammler law: the share ``exp(-(d/size)^exponent)`` of the mass is coarser than d,
    between two cuts.

    Source: P. Rosin and E. Rammler, "The laws governing the fineness of powdered coal", J. Inst. Fuel 7,
    29-36 (1933).

    Parameters
    ----------
    size : diameter [m] that the share 1/e of the mass exceeds
    exponent : uniformity [1]
    smallest, largest : cuts [m]

    Raises
    ------
    ValueError : the law has no share between the cuts
    """
    return _tabulated(lambda d: -np.expm1(-((d / size) ** exponent)), smallest, largest, "mass")


def mass_percentiles(
    diameters: np.ndarray, volumes: np.ndarray, shares: Sequence[float] = (0.1, 0.5, 0.9)
) -> list[float]:
    """Return d10, d50 and d90 by mass [m] of particles of one density."""
    order = np.argsort(diameters)
    below = np.cumsum(volumes[order])
    return [
        float(diameters[order[min(np.searchsorted(below, share * below[-1]), len(order) - 1)]])
        for share in shares
    ]


def sphere_volume(diameter: float) -> float:
    """Return the volume of a sphere [m^3]."""
    return math.pi / 6.0 * diameter**3


def _solid(diameters) -> float:
    return math.pi / 6.0 * float((diameters**3).sum())


def _cell_volume(diameter) -> np.ndarray:
    """Return the mean volume [m^3] of the sizes in each cell of a table, uniform within a cell."""
    a, b = diameter[:-1], diameter[1:]
    return math.pi / 24.0 * (a + b) * (a * a + b * b)


def _tabulated(below, smallest: float, largest: float, by: str) -> SizeLaw:
    """Return the law whose share of number or mass below d [m] is `below`, between two cuts."""
    diameter = np.geomspace(smallest, largest, CELLS + 1)
    diameter[[0, -1]] = smallest, largest
    weight = np.diff(below(diameter))
    if not weight.sum() > 1e-9:
        raise ValueError("the law has no share between the cuts")
    if by == "mass":
        weight = weight / _cell_volume(diameter)
    number = np.concatenate([[0.0], np.cumsum(weight)])
    return SizeLaw(diameter, number / number[-1])
