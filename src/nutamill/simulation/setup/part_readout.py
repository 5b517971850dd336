"""From the rows of a march without charge to the series of a mechanism's parts
(`nutamill.result.fields.PART_SERIES`).
"""

import numpy as np

from nutamill.case import Machine
from nutamill.simulation.row import RowTable


class PartReadout:
    """Names of the series of a mechanism, and their values from rows.

    Parameters
    ----------
    case : the mechanism
    table : columns of a row
    sensor_series : names of the series of the sensor columns, in their order

    Attributes
    ----------
    table : as given
    names : names of the series
    n_columns : number of columns of a row
    """

    def __init__(self, case: Machine, table: RowTable, sensor_series: list[str]):
        self.table, self.n_columns = table, table.starts.columns
        stored = ["kinetic_energy_mechanism", "potential_energy", "elastic_energy"]
        works = [f"drive_{part.name}_work" for part in case.drives]
        losses = [f"bushing_{part.name}_loss" for part in case.bushings]
        losses += [f"spring_{part.name}_loss" for part in case.springs]
        losses += [f"joint_{part.name}_loss" for part in case.joints]
        torques = [f"torque_{part.name}_work" for part in case.torques]
        columns = ["time", *sensor_series, *stored, *works, *losses, *torques]
        frictionless = {f"joint_{part.name}_loss" for part in case.joints if part.friction is None}
        recorded = [name for name in columns if name not in frictionless]
        self._recorded = [columns.index(name) for name in recorded]
        self._plus = [columns.index(name) for name in (*stored, *losses)]
        self._minus = [columns.index(name) for name in (*works, *torques)]
        self.names = [*recorded, "ledger_residual"]

    def series(self, rows: np.ndarray, first: np.ndarray) -> np.ndarray:
        """Return the values (n, n_names) of the series, SI, in the order of `names`.

        Parameters
        ----------
        rows : (n, n_columns) of the march
        first : (n_columns,) row at the start of the run, from which the ledger counts
        """
        change = rows - first
        residual = change[:, self._plus].sum(axis=1) - change[:, self._minus].sum(axis=1)
        return np.column_stack([rows[:, self._recorded], residual])
