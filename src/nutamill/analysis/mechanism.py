"""What a run of a mechanism came to: loads of its joints and drives, and whether its energy ledger closes."""

import math
from typing import NamedTuple

import numpy as np

from nutamill.analysis.power import LEDGER_LIMIT
from nutamill.base.wrench import WRENCH
from nutamill.result import Result


class PartLoad(NamedTuple):
    """Force and moment of one part over a run."""

    part: str
    """Name its series begin with, ``joint_pin``."""
    mean_force: float
    """Mean of the force's magnitude [N]."""
    peak_force: float
    """Largest magnitude of the force [N]."""
    mean_moment: float
    """Mean of the moment's magnitude [N m]."""
    peak_moment: float
    """Largest magnitude of the moment [N m]."""


def magnitude(result: Result, vector: str) -> np.ndarray:
    """Return the magnitude (n,) of the series ``vector_x``, ``vector_y``, ``vector_z``, in their unit."""
    return np.sqrt(sum(result.series[f"{vector}_{axis}"].values ** 2 for axis in "xyz"))


def part_loads(result: Result) -> list[PartLoad]:
    """Return the loads of all joints and bushings over the whole run, in the order of the file."""
    names = [
        str(name).removesuffix("_force_x")
        for name in result.series.data_vars
        if str(name).endswith("_force_x")
    ]
    loads = []
    for name in names:
        if any(f"{name}_{part}" not in result.series for part in WRENCH):
            continue  # the case records a part of it only
        force, moment = magnitude(result, f"{name}_force"), magnitude(result, f"{name}_moment")
        loads.append(
            PartLoad(name, float(force.mean()), float(force.max()), float(moment.mean()), float(moment.max()))
        )
    return loads


def ledger_share(result: Result) -> float:
    """Return the largest residual of the energy ledger as a share of the energy that moved [1]: the largest
    swing of a stored energy or of a work. NaN where the run records no ledger.
    """
    series = result.series
    moved = ("kinetic_energy_mechanism", "potential_energy", "elastic_energy")
    names = [
        name for name in map(str, series.data_vars) if name in moved or name.endswith(("_work", "_loss"))
    ]
    if not names or "ledger_residual" not in series:
        return math.nan
    swing = max(float(series[name].max() - series[name].min()) for name in names)
    return float(abs(series["ledger_residual"]).max()) / swing if swing else 0.0


def mechanism_summary_lines(result: Result) -> list[str]:
    """Return the lines at the end of a run: loads of parts, torques of drives, gap of the energy ledger."""
    series = result.series
    if not len(series["time"]):
        return ["the run holds no samples"]
    loads = part_loads(result)
    width = max((len(load.part) for load in loads), default=4)
    lines = [f"t = 0 to {float(series['time'][-1]):g} s, {len(series['time'])} samples"]
    lines += (
        [
            f"{'':{width}}  {'mean force':>11} {'peak force':>11} {'mean moment':>12} "
            f"{'peak moment':>12}   (N, N m)"
        ]
        if loads
        else []
    )
    for load in loads:
        numbers = (
            f"{load.mean_force:11.4g} {load.peak_force:11.4g} {load.mean_moment:12.4g} "
            f"{load.peak_moment:12.4g}"
        )
        lines.append(f"{load.part:{width}}  {numbers}")
    for name in map(str, series.data_vars):
        if name.startswith("drive_") and name.endswith("_torque"):
            torque, drive = series[name].values, name.removesuffix("_torque")
            line = f"{drive}: torque mean {torque.mean():.4g} N m, peak {np.abs(torque).max():.4g} N m"
            if f"{drive}_work" in series:
                line += f"; work {float(series[f'{drive}_work'].values[-1]):.4g} J"
            lines.append(line)
    if not math.isnan(share := ledger_share(result)):
        lines.append(f"energy ledger closes to {100.0 * share:.2g} % of the energy that moved")
    return lines


def mechanism_warning_lines(result: Result) -> list[str]:
    """Return warnings on a run: a ledger that does not close."""
    lines = []
    if len(result.series["time"]) and (share := ledger_share(result)) > LEDGER_LIMIT:
        lines.append(
            f"warning: the ledger leaves {100 * share:.2f} % of the energy that moved open. "
            "Halve run.step, or run.window where there is a charge"
        )
    return lines
