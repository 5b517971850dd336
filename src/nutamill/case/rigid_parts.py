"""Mass properties of the parts of a mill, and their composition into one rigid body."""

from typing import NamedTuple

import numpy as np

from nutamill.base.required import required
from nutamill.case.drawing import Bars, Chamber


class RigidPart(NamedTuple):
    """A rigid part: mass, mass centre and inertia in any one set of axes."""

    mass: float
    """Mass [kg]."""
    mass_centre: np.ndarray
    """Mass centre [m], (3,), from the origin of the caller."""
    inertia: np.ndarray
    """Inertia tensor about the mass centre [kg m^2], (3, 3)."""


def parallel_axis(mass: float, offset: np.ndarray) -> np.ndarray:
    """Return the inertia [kg m^2] (3, 3) that a point mass at `offset` [m] (3,) adds about the origin
    (Huygens-Steiner).
    """
    return mass * (offset @ offset * np.eye(3) - np.outer(offset, offset))


def compose(*parts: RigidPart) -> RigidPart:
    """Return one rigid part composed of several, all in the same axes and from the same origin."""
    mass = sum(part.mass for part in parts)
    mass_centre = sum((part.mass * part.mass_centre for part in parts), np.zeros(3)) / mass
    about_centre = (part.inertia + parallel_axis(part.mass, part.mass_centre - mass_centre) for part in parts)
    return RigidPart(mass, mass_centre, sum(about_centre, np.zeros((3, 3))))


def remove(whole: RigidPart, *parts: RigidPart) -> RigidPart:
    """Return `whole` without `parts`: the inverse of `compose`."""
    return compose(whole, *(RigidPart(-part.mass, part.mass_centre, -part.inertia) for part in parts))


def chamber_shell(chamber: Chamber) -> RigidPart:
    """Return the empty chamber without ribs and bars, in chamber axes from the nutation point.

    The file gives the transverse inertia about the nutation point, because the pin force measures that.
    """
    mass_centre = np.array([0.0, 0.0, -chamber.mass_centre_depth])
    about_point = np.diag([chamber.inertia_transverse, chamber.inertia_transverse, chamber.inertia_axial])
    return RigidPart(chamber.mass, mass_centre, about_point - parallel_axis(chamber.mass, mass_centre))


def bar_ring(bars: Bars) -> RigidPart:
    """Return the rigid bars as a thin ring about the chamber axis, chamber axes from the nutation point."""
    axial = bars.mass * bars.radius**2
    return RigidPart(bars.mass, np.array([0.0, 0.0, -bars.depth]), np.diag([axial / 2, axial / 2, axial]))


def rib_ring(chamber: Chamber) -> RigidPart:
    """Return all ribs as equally spaced boxes on the bore and on the floor, in chamber axes from the nutation
    point.

    For three ribs or more the sum over equal angles makes the transverse inertias equal.  For one or two ribs
    their mean is used.
    """
    rib = required(chamber.rib)
    mass = chamber.ribs_mass
    radius = chamber.inner_diameter / 2 - rib.depth / 2
    section = (rib.width**2 + rib.depth**2) / 12
    axial = mass * (radius**2 + section)
    transverse = mass * (radius**2 / 2 + section / 2 + rib.length**2 / 12)
    mass_centre = np.array([0.0, 0.0, -chamber.floor_depth + rib.length / 2])
    return RigidPart(mass, mass_centre, np.diag([transverse, transverse, axial]))


def whole_chamber(chamber: Chamber) -> RigidPart:
    """Return the chamber with its ribs and bars, in chamber axes from the nutation point."""
    parts = [chamber_shell(chamber)]
    if chamber.ribs:
        parts.append(rib_ring(chamber))
    if chamber.bars_mass > 0:
        parts.append(bar_ring(required(chamber.bars)))
    return compose(*parts)


def rotated(part: RigidPart, rotation: np.ndarray) -> RigidPart:
    """Return the part in other axes. `rotation` (3, 3) is from the part's axes to the new ones."""
    return RigidPart(part.mass, rotation @ part.mass_centre, rotation @ part.inertia @ rotation.T)
