"""The row of the record, declared once: the coupled step writes it, the readouts read it.

A row is a run of groups of columns.  `row_groups` names the columns of every group in order.  `RowStarts` has
the first column of each group, for kernels, and `RowTable` reads columns by group and name.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from nutamill.base.kernel import copy_numbers, kernel
from nutamill.charge.model import Ledger
from nutamill.mechanism.energy import energies
from nutamill.mechanism.model import Mechanism, SensorTable
from nutamill.mechanism.sensors import column_names, names_of, read_sensors

AXES = ("x", "y", "z")
WRENCH = ("force_x", "force_y", "force_z", "moment_x", "moment_y", "moment_z")
CONTACT_TERMS = ("normal", "tangential", "rolling")

CHARGE_GROUPS = {
    "charge_energy": (
        "kinetic_translational",
        "kinetic_rotational",
        *(f"{where}_{term}" for where in ("pair", "wall") for term in CONTACT_TERMS),
    ),
    "contacts": ("pair", "wall"),
    "mass_centre": AXES,
    "momentum": AXES,
    "coordination": ("mean",),
    "ledger": tuple(kind.name.lower() for kind in Ledger),
    "wrench": (),
    "charge_impulse": AXES,
    "mechanism_impulse": AXES,
    "largest_overlap": ("pair", "wall"),
}
"""Groups of the columns of a charge, in order; none without charge.  The wrench has one of each carrier."""


class RowStarts(NamedTuple):
    """First column of each group of a row [1]."""

    time: int
    """Time [s]."""
    sensors: int
    """Columns of the sensors [SI]."""
    mechanism_energy: int
    """Kinetic, potential and elastic energy of the mechanism [J]."""
    drive_work: int
    """Work of each drive [J], cumulative."""
    bushing_loss: int
    """Energy dissipated by each bushing [J], cumulative."""
    spring_loss: int
    """Energy dissipated by each spring [J], cumulative."""
    joint_loss: int
    """Energy dissipated by each joint [J], cumulative."""
    stop_loss: int
    """Energy dissipated by each stop [J], cumulative."""
    torque_work: int
    """Work of each constant moment [J], cumulative."""
    force_work: int
    """Work of each given force [J], cumulative."""
    charge_energy: int
    """Kinetic energies of the charge, and energies stored in its contacts [J]."""
    contacts: int
    """Numbers of pair contacts and of wall contacts [1]."""
    mass_centre: int
    """Mass centre of the charge [m], world."""
    momentum: int
    """Momentum of the charge [kg m/s], world axes."""
    coordination: int
    """Mean number of particles that a particle touches [1]."""
    ledger: int
    """Works of the contact ledger [J], cumulative."""
    wrench: int
    """Mean force [N] and moment [N m] of the charge on each carrier since the last row, about the recorded
    point of the carrier, world axes.
    """
    charge_impulse: int
    """Impulse of the charge on its carriers [N s], cumulative, world axes."""
    mechanism_impulse: int
    """Impulse of the wrenches that the mechanism received [N s], cumulative, world axes."""
    largest_overlap: int
    """Largest overlaps since the last row, of pairs and with walls, share of the smaller diameter [1]."""
    columns: int
    """Number of columns."""


def row_groups(
    mechanism: Mechanism, sensors: SensorTable, carriers: Sequence[str] = ()
) -> dict[str, tuple[str, ...]]:
    """Return the names of the columns of each group of a row, in order, with the bodies that carry walls of a
    charge, if there is one.
    """
    names = names_of(mechanism)
    groups = {
        "time": ("time",),
        "sensors": tuple(column_names(sensors)),
        "mechanism_energy": ("kinetic", "potential", "elastic"),
        "drive_work": tuple(names["drive"]),
        "bushing_loss": tuple(names["bushing"]),
        "spring_loss": tuple(names["spring"]),
        "joint_loss": tuple(names["joint"]),
        "stop_loss": tuple(names["stop"]),
        "torque_work": tuple(names["torque"]),
        "force_work": tuple(names["force"]),
    }
    if not carriers:
        return groups | dict.fromkeys(CHARGE_GROUPS, ())
    wrench = tuple(f"{carrier}_{part}" for carrier in carriers for part in WRENCH)
    return groups | CHARGE_GROUPS | {"wrench": wrench}


class RowTable:
    """The columns of a row by group and name.

    Parameters
    ----------
    groups : names of the columns of each group, in order (`row_groups`)

    Attributes
    ----------
    groups : as given
    starts : first column of each group
    """

    def __init__(self, groups: dict[str, tuple[str, ...]]):
        ends = np.cumsum([0, *map(len, groups.values())]).tolist()
        self.groups = groups
        self.starts = RowStarts(**dict(zip((*groups, "columns"), ends, strict=True)))
        self._column = {
            (group, name): getattr(self.starts, group) + number
            for group, names in groups.items()
            for number, name in enumerate(names)
        }

    def column(self, group: str, name: str) -> int:
        """Return the number of a column of a row [1]."""
        return self._column[group, name]

    def read(self, rows: np.ndarray, group: str, name: str | None = None) -> np.ndarray:
        """Return a column (n,) of `rows` (n, n_columns), or all columns (n, m) of a group if no name is
        given.
        """
        if name is None:
            start = getattr(self.starts, group)
            return rows[:, start : start + len(self.groups[group])]
        return rows[:, self._column[group, name]]


@kernel
def mechanism_row(mechanism, state, scratch, sensors, starts, row_out):
    """Write the groups of the mechanism: time, sensors, energies and cumulative works and losses."""
    row_out[starts.time] = state.time[0]
    read_sensors(mechanism, state, scratch, sensors, row_out[starts.sensors : starts.mechanism_energy])
    energies(mechanism, state, scratch, row_out[starts.mechanism_energy : starts.drive_work])
    copy_numbers(state.drive_work, row_out[starts.drive_work : starts.bushing_loss])
    copy_numbers(state.loss, row_out[starts.bushing_loss : starts.torque_work])
    copy_numbers(state.torque_work, row_out[starts.torque_work : starts.force_work])
    copy_numbers(state.force_work, row_out[starts.force_work : starts.charge_energy])


@kernel
def charge_row(state, reading, coupling_state, interval, starts, row_out):
    """Write the groups of the charge, and reset the sums and the largest overlaps of the row.

    `reading` is the present one of `observe`, `interval` the time since the last row [s].
    """
    copy_numbers(reading.energy, row_out[starts.charge_energy : starts.contacts])
    copy_numbers(reading.contacts, row_out[starts.contacts : starts.mass_centre])
    copy_numbers(reading.mass_centre, row_out[starts.mass_centre : starts.momentum])
    copy_numbers(reading.momentum, row_out[starts.momentum : starts.coordination])
    copy_numbers(reading.coordination, row_out[starts.coordination : starts.ledger])
    copy_numbers(state.ledger, row_out[starts.ledger : starts.wrench])
    for c in range(coupling_state.row_impulse.shape[0]):
        for k in range(6):
            row_out[starts.wrench + 6 * c + k] = coupling_state.row_impulse[c, k] / interval
            coupling_state.row_impulse[c, k] = 0.0
    copy_numbers(coupling_state.charge_impulse, row_out[starts.charge_impulse : starts.mechanism_impulse])
    copy_numbers(coupling_state.mechanism_impulse, row_out[starts.mechanism_impulse : starts.largest_overlap])
    for k in range(2):
        row_out[starts.largest_overlap + k] = state.largest_overlap[k]
        state.largest_overlap[k] = 0.0
