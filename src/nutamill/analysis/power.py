"""Where the power of the motor goes, from the ledger of a result."""

import fnmatch
from typing import NamedTuple

import numpy as np

from nutamill.analysis.source import any_case_of
from nutamill.analysis.windows import PAPER_WINDOW, steady_window
from nutamill.result import Result

SINKS: dict[str, tuple[str, ...]] = {
    "pellet-pellet": ("pair_normal_loss", "pair_tangential_loss", "pair_rolling_loss"),
    "pellet-wall": ("wall_normal_loss", "wall_tangential_loss", "wall_rolling_loss"),
    "liquid": ("pair_film_loss", "wall_film_loss"),
    "substep": ("substep_loss",),
    "joints": (
        "driveshaft_bearing_loss",
        "pin_joint_loss",
        "chamber_pivot_loss",
        "yoke_pivot_loss",
        "joint_*_loss",
    ),
    "mounts": ("mount_*_loss",),
    "coupling": ("coupling_loss",),
    "bushings": ("bushing_*_loss",),
    "springs": ("spring_*_loss",),
    "stops": ("stop_*_loss",),
    "stored": ("kinetic_energy_mechanism", "kinetic_energy_charge", "potential_energy", "elastic_energy"),
}
"""Where the work that is put in can go: series of the power ledger in groups, ``*`` for every part."""
SUPPLIES = (
    "motor_work",
    "drive_*_work",
    "linear_drive_*_work",
    "force_*_work",
    "torque_*_work",
    "fmu_*_work",
)
"""Series of the works that motors, drives, given loads and the machines of FMUs do."""

LEDGER_LIMIT = 0.005
"""Share that the ledger may leave open [1]: of the motor's work in the steady window, or of the energy that
moved where there is none.
"""


class PowerSplit(NamedTuple):
    """Mean power over the whole turns of the steady window."""

    motor: float
    """Power of motors, drives, given loads and the machines of FMUs [W].  A prescribed motion, which the
    charge does not slow, supplies power too, which is included.
    """
    sinks: dict[str, float]
    """Where it goes [W], by the groups of `SINKS`; stored energy that is given off is negative."""
    residual: float
    """Power that the ledger leaves open [W]."""


def power_split(result: Result, last: float | str = PAPER_WINDOW) -> PowerSplit:
    """Compute where the power that is put in goes, mean over the whole turns of the steady window.

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
    supplied = sum(map(power, supply_series(result)))
    if _prescribed(result) and not _recorded(result, ("fmu_*_work",)):
        supplied += power("interface_work")
    return PowerSplit(supplied, sinks, power("ledger_residual"))


def _prescribed(result: Result) -> bool:
    """Return whether the motion was imposed on the charge."""
    return bool(result.case_text) and any_case_of(result).run.coupling == "prescribed"


def ledger_groups(result: Result) -> dict[str, list[str]]:
    """Return `SINKS` with the series that this result holds, without empty groups."""
    groups = {group: _recorded(result, patterns) for group, patterns in SINKS.items()}
    return {group: names for group, names in groups.items() if names}


def supply_series(result: Result) -> list[str]:
    """Return the series of the works that are put into a machine."""
    return _recorded(result, SUPPLIES)


def _recorded(result: Result, patterns: tuple[str, ...]) -> list[str]:
    """Return the series of a result whose names match one of the patterns."""
    names = map(str, result.series.data_vars)
    return [name for name in names if any(fnmatch.fnmatchcase(name, pattern) for pattern in patterns)]
