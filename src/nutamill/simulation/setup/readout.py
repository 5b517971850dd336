"""From the rows a compiled march writes to the recorded quantities of `nutamill.result.fields`.

A row is: time; columns of the sensors; kinetic, potential and elastic energy, drive work, losses of bushings
and joints of the mechanism; and, with a charge, what `observe` saw, the contact ledger, the mean wrench on
the chamber about the nutation point, impulses given and received, and the largest overlaps.
"""

from collections.abc import Callable

import numpy as np

from nutamill.case import Case
from nutamill.charge.model import Ledger
from nutamill.result.fields import JOINTS, TURNING
from nutamill.simulation.setup.mill import (
    CHAMBER_PIVOT,
    COUPLING,
    CRANK_PIN,
    DRIVE,
    FRAME_FIX,
    LOAD_CELL,
    NUTATION_POINT,
    SHAFT_BEARING,
)
from nutamill.simulation.setup.particles import charge_mass

FRICTIONLESS = (FRAME_FIX, SHAFT_BEARING, LOAD_CELL)
"""Joints that no case gives friction: their losses are zero and not recorded."""

WRENCH = ("force_x", "force_y", "force_z", "moment_x", "moment_y", "moment_z")
CONTACT_KINDS = ("normal", "tangential", "rolling")
READING = (
    "kinetic_translational",
    "kinetic_rotational",
    *(f"elastic_{where}_{kind}" for where in ("pair", "wall") for kind in CONTACT_KINDS),
    "pair_contacts",
    "wall_contacts",
    *(f"mass_centre_{axis}" for axis in "xyz"),
    *(f"momentum_{axis}" for axis in "xyz"),
    "coordination_number",
)
"""Columns of `nutamill.charge.measures.observe.ChargeReading`, in its order."""


class Readout:
    """Names of the series of a case, and their numbers from rows.

    Parameters
    ----------
    case : the case
    sensor_columns : names of the sensor columns, ``load_cell_force_x``
    bushings, joints : names, in the order of the mechanism
    with_charge : whether rows have a charge part
    """

    def __init__(
        self, case: Case, sensor_columns: list[str], bushings: list[str], joints: list[str], with_charge: bool
    ):
        self._case = case
        self._with_charge = with_charge
        columns = ["time", *sensor_columns, "kinetic", "potential", "elastic", "drive_work"]
        columns += [f"loss {name}" for name in (*bushings, *joints)]
        if with_charge:
            columns += [f"charge {name}" for name in READING]
            columns += [f"work {kind.name.lower()}" for kind in Ledger]
            columns += [f"charge {name}" for name in WRENCH]
            columns += [f"{way} {axis}" for way in ("given", "received") for axis in "xyz"]
            columns += ["overlap pair", "overlap wall"]
        self._place = {name: place for place, name in enumerate(columns)}
        self._losses = [name for name in columns if name.startswith("loss ")]
        self.n_columns = len(columns)
        self.names = list(self._read(np.zeros((1, self.n_columns)), np.zeros(self.n_columns)))

    def series(self, rows: np.ndarray, first: np.ndarray) -> np.ndarray:
        """Numbers (n, n_names) of the series, SI, in the order of `names`.

        Parameters
        ----------
        rows : (n, n_columns) as the march wrote them
        first : (n_columns,) row at the start of the run, from which ledgers count and gravity's share is read
        """
        return np.column_stack(list(self._read(rows, first).values()))

    def _read(self, rows: np.ndarray, first: np.ndarray) -> dict[str, np.ndarray]:
        """Every series by name."""
        at = self._columns_of(rows)
        at_first = self._columns_of(first[None, :])
        series = {"time": at("time")}
        series |= self._drive(at)
        for name, joint in (("crank_pin_force", LOAD_CELL), ("pin_joint_force", CRANK_PIN)):
            series |= _crank_force(name, joint, at, at_first)
        series |= _vector("nutation_point_force", f"{CHAMBER_PIVOT}_force", at)
        series["nutation_point_force_resultant"] = np.linalg.norm(
            [at(f"{CHAMBER_PIVOT}_force_{axis}") for axis in "xyz"], axis=0
        )
        series |= self._mounts(at)
        series |= self._reactions(at)
        for sensor in self._case.sensors:
            series |= {f"{sensor}_acceleration_{axis}": at(f"{sensor}_a{axis}") for axis in "xyz"}
        if self._with_charge:
            series |= self._charge(at)
        return series | self._ledger(at, at_first)

    def _columns_of(self, rows: np.ndarray) -> Callable[[str], np.ndarray]:
        return lambda name: rows[:, self._place[name]]

    def _drive(self, at: Callable[[str], np.ndarray]) -> dict[str, np.ndarray]:
        torque, speed = at(f"{DRIVE}_torque"), at(f"{DRIVE}_speed")
        return {
            "crank_angle": at(f"{DRIVE}_angle"),
            "driveshaft_speed": speed,
            "driveshaft_torque": torque,
            "driveshaft_power": torque * speed,
            "coupling_torque": at(f"{COUPLING}_moment_z"),
        }

    def _mounts(self, at: Callable[[str], np.ndarray]) -> dict[str, np.ndarray]:
        if self._case.mechanism.mounting == "rigid":
            return {}
        series = {}
        for number in range(1, self._case.mounts.count + 1):
            series |= _vector(f"mount_{number}_force", f"mount_{number}_force", at)
            series |= _vector(f"mount_{number}_travel", f"mount_{number} travel", at)
        return series

    def _reactions(self, at: Callable[[str], np.ndarray]) -> dict[str, np.ndarray]:
        rigid = self._case.mechanism.mounting == "rigid"
        joints = [joint for joint in JOINTS if joint != FRAME_FIX or rigid]
        series = {
            f"{joint}_reaction_{part}": at(f"{joint} reaction_{part}") for joint in joints for part in WRENCH
        }
        return series | {
            f"{body}_attitude_{part}": at(f"{body} attitude_q{part}") for body in TURNING for part in "wxyz"
        }

    def _charge(self, at: Callable[[str], np.ndarray]) -> dict[str, np.ndarray]:
        place = [at(f"charge mass_centre_{axis}") for axis in "xyz"]
        point = [at(f"{NUTATION_POINT}_{axis}") for axis in "xyz"]
        azimuth = np.arctan2(place[1] - point[1], place[0] - point[0])
        lag = at(f"{DRIVE}_angle") - azimuth
        series = {f"charge_mass_centre_{axis}": values for axis, values in zip("xyz", place, strict=True)}
        series["charge_phase_lag"] = np.pi - np.mod(np.pi - lag, 2 * np.pi)  # into (-pi, pi]
        series |= {f"charge_{name}": at(f"charge {name}") for name in WRENCH}
        for name in ("coordination_number", "pair_contacts", "wall_contacts"):
            series[name] = at(f"charge {name}")
        for kind in ("pair", "wall"):
            series[f"largest_{kind}_overlap"] = at(f"overlap {kind}")
        return series

    def _ledger(
        self, at: Callable[[str], np.ndarray], at_first: Callable[[str], np.ndarray]
    ) -> dict[str, np.ndarray]:
        """The power ledger, cumulative from the first row, and what is left over of it."""
        stored = {
            "kinetic_energy_mechanism": at("kinetic"),
            "potential_energy": at("potential"),
            "elastic_energy": at("elastic"),
        }
        supplied = at("drive_work")
        lost = {}
        for name in self._losses:
            part = name.removeprefix("loss ")
            if part in FRICTIONLESS:
                continue
            lost["coupling_loss" if part == COUPLING else f"{part}_loss"] = at(name)
        charge = {}
        if self._with_charge:
            stored["kinetic_energy_charge"] = at("charge kinetic_translational") + at(
                "charge kinetic_rotational"
            )
            stored["potential_energy"] = stored["potential_energy"] - at("work gravity")
            for where in ("pair", "wall"):
                for kind in CONTACT_KINDS:
                    elastic = at(f"charge elastic_{where}_{kind}")
                    stored["elastic_energy"] = stored["elastic_energy"] + elastic
                    lost[f"{where}_{kind}_loss"] = (
                        at_first(f"charge elastic_{where}_{kind}") - elastic - at(f"work {where}_{kind}")
                    )
            lost["substep_loss"] = -at("work scheme")
            charge["interface_work"] = at("work interface")
            if self._case.run.coupling == "prescribed":
                supplied = (
                    supplied + charge["interface_work"]
                )  # an imposed motion supplies what it does on the charge
            momentum = [at(f"charge momentum_{axis}") - at_first(f"charge momentum_{axis}") for axis in "xyz"]
            weight = charge_mass(self._case) * self._case.mechanism.gravity * (at("time") - at_first("time"))
            defect = [
                momentum[k] + at(f"given {axis}") + (weight if axis == "z" else 0.0)
                for k, axis in enumerate("xyz")
            ]
            charge["interface_impulse_defect"] = np.linalg.norm(defect, axis=0)
        total = sum(stored.values()) + sum(lost.values()) - supplied
        return {
            "motor_work": at("drive_work"),
            **stored,
            **lost,
            **charge,
            "ledger_residual": total - self._start_energy(at_first),
        }

    def _start_energy(self, at_first: Callable[[str], np.ndarray]) -> np.ndarray:
        """Energy stored at the first row [J]; all cumulative works are zero there."""
        energy = at_first("kinetic") + at_first("potential") + at_first("elastic")
        if self._with_charge:
            energy = energy + at_first("charge kinetic_translational") + at_first("charge kinetic_rotational")
            energy = energy + sum(
                at_first(f"charge elastic_{where}_{kind}")
                for where in ("pair", "wall")
                for kind in CONTACT_KINDS
            )
        return energy


def _vector(name: str, column: str, at: Callable[[str], np.ndarray]) -> dict[str, np.ndarray]:
    """Three components under the name of a series."""
    return {f"{name}_{axis}": at(f"{column}_{axis}") for axis in "xyz"}


def _crank_force(
    name: str, joint: str, at: Callable[[str], np.ndarray], at_first: Callable[[str], np.ndarray]
) -> dict[str, np.ndarray]:
    """Radial (towards the axis), tangential and resultant force of the crank on what it drives; raw and less
    the force at rest.

    Columns are in driveshaft axes, x from the axis to the pin. A reading zeroed at rest loses gravity's
    radial share, which turns with the crank; its tangential share at rest is zero, as the file's first row
    may hold the start of a ramp.
    """
    radial, tangential = -at(f"{joint}_force_x"), at(f"{joint}_force_y")
    radial_tared = radial + at_first(f"{joint}_force_x")
    return {
        f"{name}_radial": radial,
        f"{name}_tangential": tangential,
        f"{name}_resultant": np.hypot(radial, tangential),
        f"{name}_radial_tared": radial_tared,
        f"{name}_tangential_tared": tangential,
        f"{name}_resultant_tared": np.hypot(radial_tared, tangential),
    }
