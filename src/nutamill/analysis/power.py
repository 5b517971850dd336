"""Where the power of the motor goes, from the ledger of a result."""

import fnmatch
from typing import NamedTuple

import numpy as np

from nutamill.analysis.source import case_of
from nutamill.analysis.windows import PAPER_WINDOW, steady_window
from nutamill.result import Result

SINKS: dict[str, tuple[str, ...]] = {
    "pellet-pellet": ("pair_normal_loss", "pair_tangential_loss", "pair_rolling_loss"),
    "pellet-wall": ("wall_normal_loss", "wall_tangential_loss", "wall_rolling_loss"),
    "substep": ("substep_loss",),
    "joints": ("driveshaft_bearing_loss", "pin_joint_loss", "chamber_pivot_loss", "yoke_pivot_loss"),
    "mounts": ("mount_*_loss",),
    "coupling": ("coupling_loss",),
    "stored": ("kinetic_energy_mechanism", "kinetic_energy_charge", "potential_energy", "elastic_energy"),
}
"""Where the motor's work can go: series of the power ledger in groups, ``*`` for every mount."""


LEDGER_LIMIT = 0.005
"""Share of the motor's work in the steady window that the ledger may leave open [1]."""


class PowerSplit(NamedTuple):
    """Mean power over the whole turns of the steady window."""

    motor: float
    """Power of the motor [W].  A prescribed motion, which the charge does not slow, supplies power too, which
    is included.
    """
    sinks: dict[str, float]
    """Where it goes [W], by the groups of `SINKS`."""
    residual: float
    """Power that the ledger leaves open [W]."""


def power_split(result: Result, last: float | str = PAPER_WINDOW) -> PowerSplit:
    """Compute where the motor's power goes, mean over the whole turns of the steady window.

    Parameters
    ----------
    last : length of the window [s], or a text with a unit as ``"3 s"``

    Raises
    ------
    ResultError : the run has not made one turn at its last speed
    """
    turns = steady_window(result, last).turns

    def power(name: str) -> float:
        first, end = np.interp(turns[[0, -1]], result.series["time"].values, result.series[name].values)
        return float((end - first) / (turns[-1] - turns[0]))

    sinks = {group: sum(map(power, names)) for group, names in ledger_groups(result).items()}
    supplied = power("motor_work") + (power("interface_work") if _prescribed(result) else 0.0)
    return PowerSplit(supplied, sinks, power("ledger_residual"))


def _prescribed(result: Result) -> bool:
    """Return whether the motion was imposed on the charge."""
    return bool(result.case_text) and case_of(result).run.coupling == "prescribed"


def ledger_groups(result: Result) -> dict[str, list[str]]:
    """Return `SINKS` with the series that this result holds, without empty groups."""
    recorded = list(map(str, result.series.data_vars))
    groups = {
        group: [name for name in recorded if any(fnmatch.fnmatchcase(name, pattern) for pattern in patterns)]
        for group, patterns in SINKS.items()
    }
    return {group: names for group, names in groups.items() if names}
