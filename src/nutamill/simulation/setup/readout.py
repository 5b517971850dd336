"""From the rows of a march to the series of the record: what every machine has, and its named quantities.

Signs are those of docs/conventions.md.  Reactions act on the second body of a joint, torques on the driven
body.
"""

from functools import partial

import numpy as np

from nutamill.base.errors import CaseError, Fault
from nutamill.base.library import similar
from nutamill.base.wrench import WRENCH
from nutamill.case.machine import Machine, QuantityEntry
from nutamill.case.series_fields import machine_field
from nutamill.simulation.row import CONTACT_TERMS, RowTable
from nutamill.simulation.setup.particles import charge_mass

LOSSES = {"bushing_loss": "bushing", "spring_loss": "spring", "joint_loss": "joint", "stop_loss": "stop"}
"""Groups of a row that hold energies dissipated by parts, and what their series begin with."""

WORKS = {"drive_work": "drive", "torque_work": "torque", "force_work": "force"}
"""Groups of a row that hold works done on the mechanism, and what their series begin with."""


STORED = ("kinetic_energy_mechanism", "potential_energy", "elastic_energy")
"""Series of the energies stored in the mechanism, in the order of their columns."""


class Readout:
    """Names of the series of a machine, and their values from rows.

    Parameters
    ----------
    machine : the machine
    table : columns of a row
    sensor_series : names of the series of the sensor columns, in their order

    Attributes
    ----------
    table : as given
    names : names of the series
    fields : what each series is
    n_columns : number of columns of a row
    """

    def __init__(self, machine: Machine, table: RowTable, sensor_series: list[str]):
        self._machine, self._sensor_series = machine, sensor_series
        self._carriers = [
            name.removesuffix(f"_{WRENCH[0]}") for name in table.groups["wrench"] if name.endswith(WRENCH[0])
        ]
        rubs = {joint.name for joint in machine.joints if joint.friction is not None}
        self._frictionless = {
            f"joint_{joint}_loss" for joint in table.groups["joint_loss"] if joint not in rubs
        }
        self._sliding = {drive.name for drive in machine.linear_drives}
        self.table, self.n_columns = table, table.starts.columns
        values = self._all_at_zero()
        self.values_by_name = tuple(values)
        known = [name for name in values if name not in self._frictionless]
        self.names = known if machine.run.series is None else list(machine.run.series)
        self._refuse_unknown(known)
        self.fields = [machine_field(machine, name) for name in self.names]

    def series(self, rows: np.ndarray, first: np.ndarray) -> np.ndarray:
        """Return the values (n, n_names) of the series, SI, in the order of `names`.

        Parameters
        ----------
        rows : (n, n_columns) of the march
        first : (n_columns,) row at the start of the run, from which ledgers count and quantities are zeroed
        """
        values = self.values(rows, first)
        return np.column_stack([values[name] for name in self.names])

    def _all_at_zero(self) -> dict[str, np.ndarray]:
        """Return every series of a row of zeros. Raises CaseError where a quantity is taken of a series that
        the machine does not have.
        """
        row = np.zeros((1, self.n_columns))
        held = self._plain(row, row[0]) | self._ledger(row, row[0])
        held |= {entry.name: np.zeros(1) for entry in self._machine.quantities}
        faults = [
            Fault(f"quantities.{entry.name}.of", f'no series is called "{name}"', similar(name, list(held)))
            for entry in self._machine.quantities
            for name in (source.removeprefix("-") for source in entry.of)
            if name not in held
        ]
        if faults:
            raise CaseError(*faults)
        return self.values(row, row[0])

    def columns(self) -> dict[str, int]:
        """Return the column of each series that is a column of a row. With a charge, those of the energies of
        the mechanism are terms of series.
        """
        starts, groups = self.table.starts, self.table.groups
        columns = {"time": starts.time}
        columns |= {name: starts.sensors + k for k, name in enumerate(self._sensor_series)}
        columns |= {name: starts.mechanism_energy + k for k, name in enumerate(STORED)}
        for group in WORKS:
            for k, part in enumerate(groups[group]):
                columns[f"{self._prefix(group, part)}_{part}_work"] = getattr(starts, group) + k
        for group, prefix in LOSSES.items():
            for k, part in enumerate(groups[group]):
                columns[f"{prefix}_{part}_loss"] = getattr(starts, group) + k
        return columns | (self._charge_columns() if self._carriers else {})

    def _charge_columns(self) -> dict[str, int]:
        """Return the column of each series of the charge that is a column of a row."""
        at = self.table.column
        columns = {f"charge_mass_centre_{axis}": at("mass_centre", axis) for axis in "xyz"}
        for carrier in self._carriers:
            for name in WRENCH:
                columns[f"{carrier}_charge_{name}"] = at("wrench", f"{carrier}_{name}")
        columns["coordination_number"] = at("coordination", "mean")
        for kind in ("pair", "wall"):
            columns[f"{kind}_contacts"] = at("contacts", kind)
            columns[f"largest_{kind}_overlap"] = at("largest_overlap", kind)
        return columns | {"interface_work": at("ledger", "interface")}

    def _refuse_unknown(self, known: list[str]) -> None:
        """Raise CaseError with every recorded name that is no series of the machine."""
        unknown = [name for name in self.names if name not in known]
        if unknown or self.names[:1] != ["time"]:
            faults = [Fault("run.series", f'no series is called "{n}"', similar(n, known)) for n in unknown]
            raise CaseError(*(faults or [Fault("run.series", 'the first must be "time"')]))

    def values(self, rows: np.ndarray, first: np.ndarray) -> dict[str, np.ndarray]:
        """Return every series by name, the quantities among them. Arguments are those of `series`."""
        values, at_first = self._plain(rows, first), self._plain(first[None, :], first)
        ledger = self._ledger(rows, first)
        known, known_first = values | ledger, at_first | self._ledger(first[None, :], first)
        quantities: dict[str, np.ndarray] = {}
        for entry in self._machine.quantities:
            known_first[entry.name] = taken(entry, known_first, None)
            quantities[entry.name] = known[entry.name] = taken(entry, known, known_first)
        return values | quantities | {name: known[name] for name in ledger}

    def _plain(self, rows: np.ndarray, first: np.ndarray) -> dict[str, np.ndarray]:
        """Return time, sensors and charge by the names of their series."""
        at = partial(self.table.read, rows)
        series = {"time": at("time", "time")}
        series |= dict(zip(self._sensor_series, at("sensors").T, strict=True))
        if not self._carriers:
            return series
        for axis in "xyz":
            series[f"charge_mass_centre_{axis}"] = at("mass_centre", axis)
        for carrier in self._carriers:
            for name in WRENCH:
                series[f"{carrier}_charge_{name}"] = at("wrench", f"{carrier}_{name}")
        series["coordination_number"] = at("coordination", "mean")
        series |= {f"{kind}_contacts": at("contacts", kind) for kind in ("pair", "wall")}
        return series | {f"largest_{kind}_overlap": at("largest_overlap", kind) for kind in ("pair", "wall")}

    def _prefix(self, group: str, part: str) -> str:
        """Return what the series of the work of a part begins with."""
        return "linear_drive" if group == "drive_work" and part in self._sliding else WORKS[group]

    def _ledger(self, rows: np.ndarray, first: np.ndarray) -> dict[str, np.ndarray]:
        """Return the energy ledger, cumulative from the first row, and its residual."""
        at, at_first = partial(self.table.read, rows), partial(self.table.read, first[None, :])
        stored = {
            "kinetic_energy_mechanism": at("mechanism_energy", "kinetic"),
            "potential_energy": at("mechanism_energy", "potential"),
            "elastic_energy": at("mechanism_energy", "elastic"),
        }
        works = {
            f"{self._prefix(group, part)}_{part}_work": at(group, part)
            for group in WORKS
            for part in self.table.groups[group]
        }
        lost = {
            f"{prefix}_{part}_loss": at(group, part)
            for group, prefix in LOSSES.items()
            for part in self.table.groups[group]
        }
        supplied = sum(works.values()) if works else np.zeros(len(rows))
        charge = self._charge_ledger(at, at_first, stored, lost) if self._carriers else {}
        movers = [fmu.name for fmu in self._machine.fmus if fmu.bodies]
        if charge and movers:
            # a foreign machine supplies the work it does on the charge; its own energy is not known here
            works[f"fmu_{movers[0]}_work"] = charge["interface_work"]
        if charge and (movers or self._machine.run.coupling == "prescribed"):
            # an imposed motion supplies the work it does on the charge
            supplied = supplied + charge["interface_work"]
        total = sum(stored.values()) + sum(lost.values()) - supplied
        return {
            **works,
            **stored,
            **lost,
            **charge,
            "ledger_residual": total - self._start_energy(at_first),
        }

    def _charge_ledger(self, at, at_first, stored: dict, lost: dict) -> dict[str, np.ndarray]:
        """Add the entries of the charge to `stored` and `lost`, and return those that are neither."""
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
            if self._machine.contact.film != "none":
                lost[f"{where}_film_loss"] = -at("ledger", f"{where}_film")
        lost["substep_loss"] = -at("ledger", "scheme")
        time = at("time", "time") - at_first("time", "time")
        defect = [
            at("momentum", axis)
            - at_first("momentum", axis)
            + at("charge_impulse", axis)
            - charge_mass(self._machine) * self._machine.gravity[k] * time
            for k, axis in enumerate("xyz")
        ]
        return {
            "interface_work": at("ledger", "interface"),
            "interface_impulse_defect": np.linalg.norm(defect, axis=0),
        }

    def start_energy(self, first: np.ndarray) -> float:
        """Return the energy stored at the first row (n_columns,) [J], which the ledger counts from."""
        return float(self._start_energy(partial(self.table.read, first[None, :]))[0])

    def _start_energy(self, at_first) -> np.ndarray:
        """Return the energy stored at the first row [J], where all cumulative works are zero."""
        energy = sum(at_first("mechanism_energy", name) for name in ("kinetic", "potential", "elastic"))
        if self._carriers:
            kinetic, springs = self.table.groups["charge_energy"][:2], self.table.groups["charge_energy"][2:]
            for name in kinetic:
                energy = energy + at_first("charge_energy", name)
            energy = energy + sum(at_first("charge_energy", name) for name in springs)
        return energy


def taken(
    entry: QuantityEntry, known: dict[str, np.ndarray], known_first: dict[str, np.ndarray] | None
) -> np.ndarray:
    """Return the values (n,) of a quantity from the series that it is taken of.

    `known_first` are the values at the first row, for quantities that are zeroed there; None at that row
    itself.
    """
    terms = []
    for name in entry.of:
        sign, source = (-1.0, name[1:]) if name.startswith("-") else (1.0, name)
        term = known[source] if sign > 0.0 else -known[source]
        if entry.zeroed:
            zero = known[source] if known_first is None else known_first[source]
            term = term - sign * zero
        terms.append(term)
    if entry.take == "resultant":
        return np.linalg.norm(terms, axis=0) if len(terms) > 2 else np.hypot(*terms)
    if entry.take == "product":
        return np.prod(terms, axis=0)
    if entry.take == "lag":
        angle, x, y, x0, y0 = terms
        lag = angle - np.arctan2(y - y0, x - x0)
        return np.pi - np.mod(np.pi - lag, 2 * np.pi)  # into (-pi, pi]
    return terms[0] if len(terms) == 1 else sum(terms[1:], 0.0 + terms[0])
