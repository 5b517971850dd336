"""From the rows a compiled march writes to the series of a mechanism's parts
(`nutamill.result.fields.PART_SERIES`).

A row is: time; columns of the sensors; kinetic, potential and elastic energy; works of the drives, losses of
bushings, springs and joints, works of the constant moments (`nutamill.simulation.coupling.mechanism_row`).
"""

import numpy as np

from nutamill.case import MechanismCase


class PartReadout:
    """Names of the series of a mechanism, and their numbers from rows.

    Parameters
    ----------
    case : the mechanism
    sensor_columns : names of the sensor columns, as `nutamill.simulation.setup.mechanism.case_sensors` makes
        them
    """

    def __init__(self, case: MechanismCase, sensor_columns: list[str]):
        drives = [f"drive_{part.name}_work" for part in case.drives]
        losses = [f"bushing_{part.name}_loss" for part in case.bushings] + [
            f"spring_{part.name}_loss" for part in case.springs
        ]
        losses += [f"joint_{part.name}_loss" for part in case.joints]
        torques = [f"torque_{part.name}_work" for part in case.torques]
        stored = ["kinetic_energy_mechanism", "potential_energy", "elastic_energy"]
        columns = ["time", *map(_series_name, sensor_columns), *stored, *drives, *losses, *torques]
        self.n_columns = len(columns)
        rubbing = {f"joint_{part.name}_loss" for part in case.joints if part.friction is not None}
        kept = [
            name
            for name in columns
            if not (name.startswith("joint_") and name.endswith("_loss")) or name in rubbing
        ]
        self._kept = [columns.index(name) for name in kept]
        self._plus = [columns.index(name) for name in (*stored, *losses)]
        self._minus = [columns.index(name) for name in (*drives, *torques)]
        self.names = [*kept, "ledger_residual"]

    def series(self, rows: np.ndarray, first: np.ndarray) -> np.ndarray:
        """Numbers (n, n_names) of the series, SI, in the order of `names`.

        Parameters
        ----------
        rows : (n, n_columns) as the march wrote them
        first : (n_columns,) row at the start of the run, from which the ledger counts
        """
        change = rows - first
        residual = change[:, self._plus].sum(axis=1) - change[:, self._minus].sum(axis=1)
        return np.column_stack([rows[:, self._kept], residual])


def _series_name(column: str) -> str:
    """Name of the series of a sensor's column: ``"rod velocity_vx"`` is ``rod_velocity_x``."""
    name, _, ending = column.partition(" ")
    if not ending:
        return column
    kind, _, part = ending.partition("_")
    if kind == "travel":
        return f"{name}_{part}" if part.startswith("turn") else f"{name}_travel_{part}"
    return f"{name}_{kind}_{part if kind == 'reaction' else part[-1]}"
