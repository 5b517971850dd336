"""How much can be placed in a chamber: the one rule for the pre-flight sheet and for the fill itself."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from nutamill.base.errors import Fault
from nutamill.base.units import shown

DENSEST, WALL_LOSS = 0.637, 0.12
"""Solids fraction that can be placed far from walls, and what walls take from it: times diameter and wall
area, over volume [1].

Random close packing of equal spheres is 0.637 (G. D. Scott, "Packing of spheres", Nature 188, 908 (1960)).
The loss was measured by filling cylinders as high as wide: of 12 and 20 diameters, 0.58 and 0.60 can be
placed, 0.59 and 0.61 could not be in 2000 sweeps; `python -m validation.filling` fills cylinders of 12 to 30
diameters up to the rule.
"""

CROWDED = 0.9
"""Share of the largest fill from which on particles are in each other's way [1]: pushed apart one overlap at
a time they need a thousand sweeps and more, with inertia some hundred.
"""


class Room(NamedTuple):
    """The space inside a chamber that particles are placed in."""

    volume: float
    """Free volume [m^3]."""
    area: float
    """Area of all walls around it and in it [m^2]."""


def cylinder_room(radius: float, floor: float, ceiling: float, boxes: Sequence = ()) -> Room:
    """Return the room of a cylinder of `radius` between `floor` and `ceiling` [m].

    `boxes` are centre, rotation and half sizes of what stands in it, as in `random_fill`; of each, three long
    faces count.
    """
    height = ceiling - floor
    volume = math.pi * radius**2 * height - sum(8.0 * float(np.prod(half)) for _, _, half in boxes)
    faces = sum(4.0 * half[2] * (2.0 * half[0] + half[1]) for _, _, half in boxes)
    return Room(volume, 2.0 * math.pi * radius * (height + radius) + faces)


def largest_fill(radii: np.ndarray, room: Room) -> float:
    """Return the solid volume of spheres of these sizes that can be placed in a room without overlaps [m^3].

    This is the one rule for the pre-flight sheet and for the fill itself.

    Parameters
    ----------
    radii : of the particles, or of spheres that hold them [m] (n,)
    """
    lost = WALL_LOSS * 2.0 * float(np.mean(radii)) * room.area / room.volume
    return max(0.0, DENSEST - lost) * room.volume


def is_crowded(radii: np.ndarray, room: Room) -> bool:
    """Return whether spheres of these radii [m] (n,) nearly fill a room, so that they are relaxed with
    inertia.
    """
    return _solid_volume(radii) > CROWDED * largest_fill(radii, room)


def fill_faults(radii: np.ndarray, room: Room) -> list[Fault]:
    """Return what is wrong with placing spheres of these radii [m] (n,) in a room, nothing if they can be
    placed.
    """
    solid, most = _solid_volume(radii), largest_fill(radii, room)
    if solid <= most * (1.0 + 1e-9):
        return []
    what = (
        f"must be placed without overlaps, got {shown(solid, 'cm^3', '.0f')} of spheres where "
        f"{shown(most, 'cm^3', '.0f')} can be"
    )
    return [Fault("charge", what, "Take less charge, smaller particles or a larger chamber")]


def _solid_volume(radii: np.ndarray) -> float:
    """Return the volume of spheres of these radii [m] (n,) together [m^3]."""
    return float((4.0 / 3.0 * math.pi * np.asarray(radii, float) ** 3).sum())
