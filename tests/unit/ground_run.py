"""A result of four turns of a second each with known statistics, for tests of what the charge grinds and
wears.
"""

import math

import numpy as np

from nutamill.case import load_case
from nutamill.result import Recorder
from nutamill.result.fields import STATISTICS

ENERGY = 2.0 ** (np.arange(40) / 2.0 - 25.0)
AXES = {
    "pair": np.array(["steel-steel", "steel-acrylic wall"]),
    "pair_materials": np.array(["steel-steel", "steel-acrylic wall"]),
    "pair_first": np.array([0.005, 0.005]),
    "pair_second": np.array([0.005, np.nan]),
    "pair_share": np.array([0.5, 0.2]),
    "part": np.array(["normal", "tangential", "loading"]),
    "energy": ENERGY,
    "radius": np.array([0.01, 0.03]),
    "azimuth": np.array([1.0, 4.0]),
    "height": np.array([0.01, 0.02]),
    "cell_volume": np.ones((2, 2)),
    "neighbours": np.arange(16),
    "patch_surface": np.array(["bore", "bore"]),
    "patch_column": np.array([0, 1]),
    "patch_azimuth": np.array([1.0, 4.0]),
    "patch_along": np.array([0.1, 0.1]),
    "patch_area": np.array([1.0, 1.0]),
}
NUMBER = np.round(1e6 * np.exp(-np.arange(40) / 3.0))
"""Impacts of a second: fewer the stronger."""
POWER = 400.0


def write(path, factors=(1.0, 1.0, 1.0, 1.0), numbers=NUMBER, statistics=True, axes=AXES, **rates):
    """Write such a run, with `factors` times as much in each turn; `rates` per second of other statistics."""
    sizes = {name: len(axes[name]) for name in ("pair", "part", "energy", "radius", "azimuth", "height")}
    sizes |= {"neighbours": 16, "patch": 2}
    time = np.arange(4001) / 1000.0
    zero = np.zeros_like(time)
    columns = {
        "time": time,
        "crank_angle": math.tau * time,
        "driveshaft_speed": np.full_like(time, math.tau),
        "charge_mass_centre_x": zero,
        "motor_work": POWER * time,
        "ledger_residual": zero,
    }
    case = load_case("numill", ["run.statistics=true"])
    recorder = Recorder.create(path, case.to_toml(), {}, list(columns), 1000.0, axes=axes)
    recorder.append(np.stack(list(columns.values()), axis=1))
    total = np.cumsum((0.0, *factors))
    for k in range(5 if statistics else 0):
        arrays = {}
        for field in STATISTICS:
            shape = [sizes[part.strip()] for part in field.shape.strip("()").split(",") if part.strip()]
            known = {"impact_number": numbers, "impact_energy": numbers * ENERGY, **rates}
            arrays[field.name] = np.broadcast_to(known.get(field.name, 0.0), shape) * total[k]
        arrays["sampled_time"] = np.float64(k)
        recorder.statistics(float(k), arrays)
    recorder.state("complete")
    recorder.close()
    return path
