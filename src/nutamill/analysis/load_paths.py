"""Load paths: the reaction of every joint in the axes of bodies, its mean, r.m.s., peak and orders."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import xarray

from nutamill.analysis.replay import rotation_of
from nutamill.analysis.source import any_case_of
from nutamill.analysis.windows import PAPER_WINDOW, steady_window, turn_series
from nutamill.base.errors import CaseError, Fault, ResultError
from nutamill.base.wrench import WRENCH
from nutamill.result import Result
from nutamill.result.fields import JOINTS, known_joints

GROUND = "ground"
"""Axes of the world."""
CALLED = {"driveshaft": "crank"}
"""Bodies whose axes have a name of their own."""
ORDERS = (1, 2, 3, 4)
"""Orders in the table: repetitions per turn [1]."""
STATISTICS = ("mean", "rms", "peak", *(f"{order}x" for order in ORDERS))
"""Mean, root mean square, largest magnitude, and amplitudes of the orders."""
WIDTH = 9
"""Characters of a number in a table [1]."""
PER_TURN = 256
"""Samples per turn on which orders are taken [1]."""


class Hodograph(NamedTuple):
    """A reaction over whole turns of steady running, or over its lengths of time where nothing turns."""

    angle: np.ndarray
    """Angle of the drive over whose turns means are taken [rad], (n,); NaN where nothing turns."""
    reaction: np.ndarray
    """Force [N] and moment [N m], (n, 6)."""


def joints_of(result: Result) -> list[str]:
    """Return the joints whose reactions a result holds."""
    return list(_reactions(result))


def _reactions(result: Result) -> dict[str, str]:
    """Return what the series of the reaction of each joint begin with, by joint."""
    names = list(JOINTS)  # of measured data
    if result.case_text:
        machine = any_case_of(result).machine
        names = [joint.name for joint in machine.joints]
        names += [motor.name for motor in machine.unbalance_motors]
    begins = {name: (f"joint_{name}", f"{name}_reaction") for name in names}
    recorded = {
        name: next((begin for begin in both if f"{begin}_force_x" in result.series), "")
        for name, both in begins.items()
    }
    return {name: begin for name, begin in recorded.items() if begin}


def axes_of(result: Result) -> dict[str, str]:
    """Return the axes in which reactions can be written: "ground", and every body whose attitude is recorded.
    For each it is what the series of the attitude begin with, nothing for the ground.
    """
    axes = {GROUND: ""}
    if not result.case_text:
        return axes
    for sensor in any_case_of(result).machine.sensors:
        if sensor.kind == "attitude" and f"{sensor.name}_attitude_w" in result.series:
            axes[CALLED.get(sensor.of, sensor.of)] = f"{sensor.name}_attitude"
    return axes


def default_axes(result: Result) -> str:
    """Return the axes of a table of reactions: those of the frame, where there is one, else of the world."""
    return "frame" if "frame" in axes_of(result) else GROUND


def joint_reaction(result: Result, joint: str, axes: str = "ground") -> np.ndarray:
    """Return the force [N] and moment [N m] that a joint exerts on its second body about its point there, (n,
    6), at every sample.

    Parameters
    ----------
    joint : one of `joints_of`
    axes : one of `axes_of`; of a mill "ground", "frame", "crank" (x from the driveshaft axis to the pin) or
        "chamber"

    Raises
    ------
    CaseError : no such joint or axes
    """
    if joint not in (known := _reactions(result)):
        what = "its reaction is not recorded"
        raise CaseError(Fault(f"joint {joint}", what, known_joints(joint, list(known))))
    if axes not in (turning := axes_of(result)):
        hint = f'Known are {", ".join(turning)}. A sensor with kind = "attitude" records the axes of a body'
        raise CaseError(Fault(f"axes {axes}", "must be those of a body whose attitude is recorded", hint))
    world = np.column_stack([result.series[f"{known[joint]}_{part}"].values for part in WRENCH])
    if axes == GROUND:
        return world
    rotation = attitude(result, turning[axes].removesuffix("_attitude"))
    return np.hstack([np.einsum("nij,ni->nj", rotation, part) for part in (world[:, :3], world[:, 3:])])


def attitude(result: Result, body: str) -> np.ndarray:
    """Return the rotation matrices (n, 3, 3) from the axes of a body to world axes at every sample.

    Parameters
    ----------
    body : name of the sensor of its attitude, in a mill that of the body
    """
    return rotation_of(np.column_stack([result.series[f"{body}_attitude_{part}"].values for part in "wxyz"]))


def load_paths(result: Result, last: float | str = PAPER_WINDOW) -> "xarray.DataArray":
    """Compute the statistics of every joint's reaction over the whole turns of the steady end of a run.

    Parameters
    ----------
    last : length of the steady window [s], or a text with a unit

    Returns
    -------
    over ``joint``, ``axes``, ``part`` (of `WRENCH`, N and N m) and ``statistic`` (of `STATISTICS`);
    resultants of force and moment are parts ``force`` and ``moment``

    Raises
    ------
    ResultError : the run has not made one turn at its last speed, or has no joints
    """
    joints, known_axes = joints_of(result), list(axes_of(result))
    if not joints:
        raise ResultError(
            f"{result.path}: holds no reaction of a joint. This machine has none, or none is recorded."
        )
    values = np.empty((len(joints), len(known_axes), len(WRENCH) + 2, len(STATISTICS)))
    for j, joint in enumerate(joints):
        for a, axes in enumerate(known_axes):
            turns = hodograph(result, joint, axes, last)
            size = [np.linalg.norm(turns.reaction[:, part], axis=1) for part in (slice(0, 3), slice(3, 6))]
            values[j, a] = statistics(turns.angle, np.column_stack([turns.reaction, *size]))
    coords = {
        "joint": joints,
        "axes": known_axes,
        "part": [*WRENCH, "force", "moment"],
        "statistic": list(STATISTICS),
    }
    return xarray.DataArray(values, coords, tuple(coords), name="reaction")


def hodograph(result: Result, joint: str, axes: str = "frame", last: float | str = PAPER_WINDOW) -> Hodograph:
    """Return the reaction of a joint over the whole turns of the steady window, evenly spaced over the angle
    of the drive, or over time where nothing turns.
    """
    steady = steady_window(result, last)
    reaction = joint_reaction(result, joint, axes)
    time, turning = result.series["time"].values, turn_series(result)
    if turning is None:
        even = np.linspace(
            steady.turns[0], steady.turns[-1], (len(steady.turns) - 1) * PER_TURN, endpoint=False
        )
        over_time = np.column_stack([np.interp(even, time, part) for part in reaction.T])
        return Hodograph(np.full(len(even), np.nan), over_time)
    angle = result.series[turning].values
    first, end = np.interp(steady.turns[[0, -1]], time, angle)
    count = round((end - first) / (2.0 * np.pi))
    even = first + 2.0 * np.pi * np.arange(count * PER_TURN) / PER_TURN
    return Hodograph(even, np.column_stack([np.interp(even, angle, part) for part in reaction.T]))


def statistics(angle: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Compute `STATISTICS` (m, n_statistics) of signals (n, m) that are evenly spaced over whole turns of
    `angle` (n,). Where the angle is NaN, so are the orders.
    """
    lines = order_amplitudes(angle, values, ORDERS)
    return np.column_stack(
        [values.mean(axis=0), np.sqrt((values**2).mean(axis=0)), np.abs(values).max(axis=0), *lines]
    )


def order_amplitudes(angle: np.ndarray, values: np.ndarray, orders: Sequence[int]) -> list[np.ndarray]:
    """Return, for each order, the amplitudes (m,) of signals (n, m) that are evenly spaced over whole turns
    of `angle` [rad] (n,).
    """
    return [2.0 * np.abs((values * np.exp(-1j * order * angle)[:, None]).mean(axis=0)) for order in orders]


def loads_lines(table: "xarray.DataArray", axes: str = "frame") -> list[str]:
    """Format the forces and moments of all joints in one set of axes as tables of 79 columns, with "-" for
    the orders where nothing turns.
    """
    rows = [f"joint reactions on the second body, {axes} axes (N, N m)"]
    for joint in table["joint"].values:
        rows.append(str(joint))
        rows.append(f"{'':9} " + " ".join(f"{name:>9}" for name in STATISTICS))
        for part in table["part"].values:
            numbers = table.sel(joint=joint, axes=axes, part=part).values
            rows.append(f" {part:8} " + " ".join(_cell(number, numbers) for number in numbers))
    return rows


def _cell(number: float, beside: np.ndarray) -> str:
    """Format a number, or zero where it is round-off beside the others, 9 wide."""
    if np.isnan(number):
        return f"{'-':>9}"
    shown = 0.0 if abs(number) < max(1e-9, 1e-10 * np.nanmax(np.abs(beside))) else float(number)
    text = f"{shown:9.4g}"
    return text if len(text) <= WIDTH else f"{shown:{WIDTH}.3g}"
