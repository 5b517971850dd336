"""The bodies that carry walls, and directions as axes."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from nutamill.base.frames import rotation_matrix
from nutamill.case.machine import Machine, Turn
from nutamill.case.machine_checks import GROUND


class Carrier(NamedTuple):
    """A body that carries walls, as assembled."""

    name: str
    """Name of the body."""
    body: int
    """Index of the body in the mechanism, the ground last [1]."""
    position: np.ndarray
    """Mass centre [m] (3,), world; the origin for the ground."""
    quaternion: np.ndarray
    """Attitude (w, x, y, z) as assembled."""

    @property
    def rotation(self) -> np.ndarray:
        """Rotation (3, 3) from the axes of the body to world axes."""
        matrix = np.empty((3, 3))
        rotation_matrix(self.quaternion, matrix)
        return matrix

    @property
    def pose(self) -> np.ndarray:
        """Position [m] and quaternion (7,)."""
        return np.concatenate([self.position, self.quaternion])


def quaternion_of(turn: Turn | None) -> np.ndarray:
    """Return the attitude (w, x, y, z) after a rotation about an axis."""
    if turn is None:
        return np.array([1.0, 0.0, 0.0, 0.0])
    axis = np.asarray(turn.axis, float) / np.linalg.norm(turn.axis)
    return np.array([math.cos(0.5 * turn.angle), *(math.sin(0.5 * turn.angle) * axis)])


def carriers_of(machine: Machine) -> list[Carrier]:
    """Return the bodies that carry walls, regions or the axes of the fields, in the order of the file, the
    ground last.
    """
    used = {wall.body for wall in machine.walls} | {region.body for region in machine.regions}
    used |= {machine.fields.body} - {None}
    carriers = [
        Carrier(body.name, number, np.array(body.position, float), quaternion_of(body.turn))
        for number, body in enumerate(machine.bodies)
        if body.name in used
    ]
    if GROUND in used:
        carriers.append(Carrier(GROUND, len(machine.bodies), np.zeros(3), quaternion_of(None)))
    return carriers


def carrier_index(machine: Machine, body: str) -> int:
    """Return the index of a body among the carriers [1]."""
    return [carrier.name for carrier in carriers_of(machine)].index(body)


def axes_along(axis: Sequence[float], across: Sequence[float] | None = None) -> np.ndarray:
    """Return right-handed axes as columns (3, 3): z along `axis`, x as near as can be to `across`, or to the
    world's x axis, or where that is parallel to z, to its y axis.
    """
    z = np.asarray(axis, float) / np.linalg.norm(axis)
    if across is None:
        across = (1.0, 0.0, 0.0) if abs(z[0]) < 0.9 else (0.0, 1.0, 0.0)
    x = np.asarray(across, float) - (np.asarray(across, float) @ z) * z
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])
