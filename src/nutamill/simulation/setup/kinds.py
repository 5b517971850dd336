"""The kinds of particles of a charge, by material and class of size, and the numbers that the engine gives
them.

To the engine a kind is a material: kinds of one material have one law, and impacts are counted for each pair
of kinds.
"""

import functools
import math
from typing import NamedTuple

import numpy as np

from nutamill.base.units import shown
from nutamill.case.machine import Machine
from nutamill.simulation.setup.particles import charge_parts
from nutamill.simulation.setup.walls import material_order

MOST_CLASSES = 3
"""Most classes of size of a material [1]."""
NARROW = 2.0**0.25
"""Ratio of sizes within which a material has one class [1]."""


class Kind(NamedTuple):
    """Particles of a material and a class of size, or the material of a wall."""

    material: str
    """Its material."""
    diameter: float
    """Diameter of the particle of mean volume [m]; not a number for a wall."""
    alone: bool
    """Whether it is the only one of its material."""

    @property
    def name(self) -> str:
        """``steel``, or ``steel 4 mm`` where there are others."""
        return self.material if self.alone else f"{self.material} {shown(self.diameter, 'mm', '.3g')}"


class Kinds(NamedTuple):
    """All kinds of a charge, then the materials of walls that no particle has."""

    kinds: tuple[Kind, ...]
    """In the order of their numbers."""
    of_particles: np.ndarray
    """Number of the kind of each particle, int32 (n,)."""

    def numbers(self, material: str) -> list[int]:
        """Return the numbers of the kinds of a material."""
        return [number for number, kind in enumerate(self.kinds) if kind.material == material]


@functools.lru_cache(maxsize=4)
def particle_kinds(machine: Machine) -> Kinds:
    """Return the kinds of the particles of a machine."""
    parts = charge_parts(machine)
    diameter = np.concatenate([part.diameter for part in parts])
    material = np.concatenate([part.material for part in parts])
    kinds: list[Kind] = []
    of_particles = np.zeros(len(diameter), np.int32)
    for number, name in enumerate(material_order(machine)):
        own = np.flatnonzero(material == number)
        if not len(own):
            kinds.append(Kind(name, math.nan, True))
            continue
        classes = size_classes(diameter[own])
        for one in range(classes.max() + 1):
            members = own[classes == one]
            of_particles[members] = len(kinds)
            mean = float(np.cbrt(np.mean(diameter[members] ** 3)))
            kinds.append(Kind(name, mean, bool(classes.max() == 0)))
    return Kinds(tuple(kinds), of_particles)


def size_classes(diameter: np.ndarray) -> np.ndarray:
    """Return the class of each size, from 0 for the smallest, without empty classes (n,).

    A few different sizes are a class each; of more, classes have equal ratios of their ends.
    """
    sizes = np.unique(diameter)
    if sizes[-1] <= NARROW * sizes[0]:
        return np.zeros(len(diameter), int)
    if len(sizes) <= MOST_CLASSES:
        return np.searchsorted(sizes, diameter)
    inner = np.geomspace(sizes[0], sizes[-1], MOST_CLASSES + 1)[1:-1]
    return np.unique(np.searchsorted(inner, diameter), return_inverse=True)[1]
