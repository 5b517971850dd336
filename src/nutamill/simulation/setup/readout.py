"""From the rows of a compiled march to the recorded quantities of a mill (`nutamill.result.fields`)."""

from collections.abc import Callable
from functools import partial

import numpy as np

from nutamill.case import Case
from nutamill.result.fields import JOINTS, TURNING
from nutamill.simulation.row import CONTACT_TERMS, WRENCH, RowTable
from nutamill.simulation.setup.mill import (
    CHAMBER_PIVOT,
    COUPLING,
    DRIVE,
    FRAME_FIX,
    LOAD_CELL,
    NUTATION_POINT,
    PIN_JOINT,
    SHAFT_BEARING,
)
from nutamill.simulation.setup.particles import charge_mass

FRICTIONLESS = (FRAME_FIX, SHAFT_BEARING, LOAD_CELL)
"""Joints that no case gives friction; their losses are zero and not recorded."""

Read = Callable[[str, str], np.ndarray]
"""Reads a column by group and name."""


class Readout:
    """Names of the series of a mill, and their values from rows.

    Parameters
    ----------
    case : the case
    table : columns of a row

    Attributes
    ----------
    table : as given
    names : names of the series
    n_columns : number of columns of a row
    """

    def __init__(self, case: Case, table: RowTable):
        self._case = case
        self._with_charge = bool(table.groups["charge_energy"])
        self.table, self.n_columns = table, table.starts.columns
        self.names = list(self._read(np.zeros((1, self.n_columns)), np.zeros(self.n_columns)))

    def series(self, rows: np.ndarray, first: np.ndarray) -> np.ndarray:
        """Return the values (n, n_names) of the series, SI, in the order of `names`.

        Parameters
        ----------
        rows : (n, n_columns) of the march
        first : (n_columns,) row at the start of the run, from which ledgers count and gravity's share is read
        """
        return np.column_stack(list(self._read(rows, first).values()))

    def _read(self, rows: np.ndarray, first: np.ndarray) -> dict[str, np.ndarray]:
        """Return every series by name."""
        at, at_first = partial(self.table.read, rows), partial(self.table.read, first[None, :])
        series = {"time": at("time", "time")}
        series |= self._drive(at)
        for name, joint in (("crank_pin_force", LOAD_CELL), ("pin_joint_force", PIN_JOINT)):
            series |= _crank_force(name, joint, at, at_first)
        series |= _vector("nutation_point_force", f"{CHAMBER_PIVOT}_force", at)
        series["nutation_point_force_resultant"] = np.linalg.norm(
            [at("sensors", f"{CHAMBER_PIVOT}_force_{axis}") for axis in "xyz"], axis=0
        )
        series |= self._mounts(at)
        series |= self._reactions(at)
        for sensor in self._case.sensors:
            series |= {f"{sensor}_acceleration_{axis}": at("sensors", f"{sensor}_a{axis}") for axis in "xyz"}
        if self._with_charge:
            series |= self._charge(at)
        return series | self._ledger(at, at_first)

    def _drive(self, at: Read) -> dict[str, np.ndarray]:
        torque, speed = at("sensors", f"{DRIVE}_torque"), at("sensors", f"{DRIVE}_speed")
        return {
            "crank_angle": at("sensors", f"{DRIVE}_angle"),
            "driveshaft_speed": speed,
            "driveshaft_torque": torque,
            "driveshaft_power": torque * speed,
            "coupling_torque": at("sensors", f"{COUPLING}_moment_z"),
        }

    def _mounts(self, at: Read) -> dict[str, np.ndarray]:
        if self._case.mechanism.mounting == "rigid":
            return {}
        series = {}
        for number in range(1, self._case.mounts.count + 1):
            series |= _vector(f"mount_{number}_force", f"mount_{number}_force", at)
            series |= _vector(f"mount_{number}_travel", f"mount_{number}_travel", at)
        return series

    def _reactions(self, at: Read) -> dict[str, np.ndarray]:
        rigid = self._case.mechanism.mounting == "rigid"
        joints = [joint for joint in JOINTS if joint != FRAME_FIX or rigid]
        series = {
            f"{joint}_reaction_{part}": at("sensors", f"{joint}_reaction_{part}")
            for joint in joints
            for part in WRENCH
        }
        return series | {
            f"{body}_attitude_{part}": at("sensors", f"{body}_attitude_q{part}")
            for body in TURNING
            for part in "wxyz"
        }

    def _charge(self, at: Read) -> dict[str, np.ndarray]:
        centre = [at("mass_centre", axis) for axis in "xyz"]
        point = [at("sensors", f"{NUTATION_POINT}_{axis}") for axis in "xyz"]
        azimuth = np.arctan2(centre[1] - point[1], centre[0] - point[0])
        lag = at("sensors", f"{DRIVE}_angle") - azimuth
        series = {f"charge_mass_centre_{axis}": values for axis, values in zip("xyz", centre, strict=True)}
        series["charge_phase_lag"] = np.pi - np.mod(np.pi - lag, 2 * np.pi)  # into (-pi, pi]
        series |= {f"charge_{name}": at("wrench", name) for name in WRENCH}
        series["coordination_number"] = at("coordination", "mean")
        series |= {f"{kind}_contacts": at("contacts", kind) for kind in ("pair", "wall")}
        return series | {f"largest_{kind}_overlap": at("largest_overlap", kind) for kind in ("pair", "wall")}

    def _ledger(self, at: Read, at_first: Read) -> dict[str, np.ndarray]:
        """Return the energy ledger, cumulative from the first row, and its residual."""
        stored = {
            "kinetic_energy_mechanism": at("mechanism_energy", "kinetic"),
            "potential_energy": at("mechanism_energy", "potential"),
            "elastic_energy": at("mechanism_energy", "elastic"),
        }
        supplied = at("drive_work", DRIVE)
        lost = {}
        for group in ("bushing_loss", "joint_loss"):
            for part in self.table.groups[group]:
                if part not in FRICTIONLESS:
                    lost["coupling_loss" if part == COUPLING else f"{part}_loss"] = at(group, part)
        charge = {}
        if self._with_charge:
            stored["kinetic_energy_charge"] = at("charge_energy", "kinetic_translational") + at(
                "charge_energy", "kinetic_rotational"
            )
            stored["potential_energy"] = stored["potential_energy"] - at("ledger", "gravity")
            for where in ("pair", "wall"):
                for term in CONTACT_TERMS:
                    name = f"{where}_{term}"
                    elastic = at("charge_energy", name)
                    stored["elastic_energy"] = stored["elastic_energy"] + elastic
                    lost[f"{name}_loss"] = at_first("charge_energy", name) - elastic - at("ledger", name)
            lost["substep_loss"] = -at("ledger", "scheme")
            charge["interface_work"] = at("ledger", "interface")
            if self._case.run.coupling == "prescribed":
                # an imposed motion supplies the work it does on the charge
                supplied = supplied + charge["interface_work"]
            momentum = [at("momentum", axis) - at_first("momentum", axis) for axis in "xyz"]
            time = at("time", "time") - at_first("time", "time")
            weight = charge_mass(self._case) * self._case.mechanism.gravity * time
            defect = [
                momentum[k] + at("charge_impulse", axis) + (weight if axis == "z" else 0.0)
                for k, axis in enumerate("xyz")
            ]
            charge["interface_impulse_defect"] = np.linalg.norm(defect, axis=0)
        total = sum(stored.values()) + sum(lost.values()) - supplied
        return {
            "motor_work": at("drive_work", DRIVE),
            **stored,
            **lost,
            **charge,
            "ledger_residual": total - self._start_energy(at_first),
        }

    def _start_energy(self, at_first: Read) -> np.ndarray:
        """Return the energy stored at the first row [J], where all cumulative works are zero."""
        energy = sum(at_first("mechanism_energy", name) for name in ("kinetic", "potential", "elastic"))
        if self._with_charge:
            kinetic, springs = self.table.groups["charge_energy"][:2], self.table.groups["charge_energy"][2:]
            for name in kinetic:
                energy = energy + at_first("charge_energy", name)
            energy = energy + sum(at_first("charge_energy", name) for name in springs)
        return energy


def _vector(name: str, column: str, at: Read) -> dict[str, np.ndarray]:
    """Return three components under the name of a series."""
    return {f"{name}_{axis}": at("sensors", f"{column}_{axis}") for axis in "xyz"}


def _crank_force(name: str, joint: str, at: Read, at_first: Read) -> dict[str, np.ndarray]:
    """Return radial (towards the axis), tangential and resultant force of the crank on the part it drives,
    raw and less the force at rest.

    Columns are in driveshaft axes, x from the axis to the pin.  A reading zeroed at rest loses gravity's
    radial share, which rotates with the crank.  Its tangential share at rest is taken as zero, because the
    first row may contain the start of a ramp.
    """
    radial, tangential = -at("sensors", f"{joint}_force_x"), at("sensors", f"{joint}_force_y")
    radial_tared = radial + at_first("sensors", f"{joint}_force_x")
    return {
        f"{name}_radial": radial,
        f"{name}_tangential": tangential,
        f"{name}_resultant": np.hypot(radial, tangential),
        f"{name}_radial_tared": radial_tared,
        f"{name}_tangential_tared": tangential,
        f"{name}_resultant_tared": np.hypot(radial_tared, tangential),
    }
