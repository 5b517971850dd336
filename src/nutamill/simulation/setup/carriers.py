"""The bodies that carry walls."""

from typing import NamedTuple

import numpy as np

from nutamill.base.frames import rotation_matrix_of
from nutamill.case.machine import Machine
from nutamill.case.machine_checks import GROUND
from nutamill.case.placement import quaternion_of


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
        return rotation_matrix_of(self.quaternion)

    @property
    def pose(self) -> np.ndarray:
        """Position [m] and quaternion (7,)."""
        return np.concatenate([self.position, self.quaternion])


def carriers_of(machine: Machine) -> list[Carrier]:
    """Return the bodies that carry walls, regions or the axes of the fields, in the order of the file, the
    ground last.
    """
    used = {wall.body for wall in machine.walls} | {region.body for region in machine.regions}
    if machine.fields.body is not None:
        used.add(machine.fields.body)
    carriers = [
        Carrier(body.name, number, np.array(body.position, float), quaternion_of(body.turn))
        for number, body in enumerate(machine.bodies)
        if body.name in used
    ]
    if GROUND in used:
        carriers.append(
            Carrier(
                GROUND, len(machine.bodies) + len(machine.unbalance_motors), np.zeros(3), quaternion_of(None)
            )
        )
    return carriers


def carrier_index(machine: Machine, body: str) -> int:
    """Return the index of a body among the carriers [1]."""
    return [carrier.name for carrier in carriers_of(machine)].index(body)
