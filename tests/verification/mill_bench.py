"""Short marches of a mill, without a file: its series by name."""

import numpy as np

from nutamill.case import load_case
from nutamill.simulation.entry import enter, record_first_row
from nutamill.simulation.setup.model import build

SMOOTH = ["mechanism.joint_friction=0", "mechanism.joint_friction_viscous=0 N m s/rad"]
"""Joints without friction."""
EMPTY = ["charge.kind=none", *SMOOTH, "mechanism.gravity=1e-9 m/s^2", "drive.ramp=20000 rpm/s"]
"""An empty chamber without friction and (almost) without weight, soon at speed."""


def mill(*overrides, base="numill"):
    """The case `base`, changed by ``key=value`` texts."""
    return load_case(base, list(overrides))


def march_mill(case, until, bed=None):
    """Series of `case` from rest to `until` [s]: name -> (n,)."""
    model, state, scratch = build(case.machine, bed)
    record_first_row(model, state, scratch)
    _, rows, fault = enter(model, state, scratch, round(until * case.run.series_rate))
    if fault is not None:
        raise fault
    series = model.readout.series(rows, state.first_row)
    return dict(zip(model.readout.names, series.T, strict=True))


def whole_turns(series, speed, turns=1):
    """The last `turns` turns of a run at steady speed [rad/s]."""
    rows = round(turns * 2 * np.pi / speed / (series["time"][-1] - series["time"][-2]))
    return {name: values[-rows:] for name, values in series.items()}
