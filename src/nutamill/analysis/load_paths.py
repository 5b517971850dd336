"""Load paths: the reaction of every joint in ground, frame, crank and chamber axes, its mean, r.m.s., peak
and orders.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import xarray

from nutamill.analysis.replay import rotation_of
from nutamill.analysis.windows import PAPER_WINDOW, steady_window
from nutamill.base.errors import CaseError, Fault
from nutamill.result import Result
from nutamill.result.fields import JOINTS, known_joints

AXES = {"ground": None, "frame": "frame", "crank": "driveshaft", "chamber": "chamber"}
"""Axis systems, and the body each is fixed to."""
PARTS = ("force_x", "force_y", "force_z", "moment_x", "moment_y", "moment_z")
"""Components of a reaction."""
ORDERS = (1, 2, 3, 4)
"""Orders in the table: repetitions per turn [1]."""
STATISTICS = ("mean", "rms", "peak", *(f"{order}x" for order in ORDERS))
"""Mean, root mean square, largest magnitude, and amplitudes of the orders."""
PER_TURN = 256
"""Samples per turn on which orders are taken [1]."""


class Hodograph(NamedTuple):
    """A reaction over whole turns of steady running."""

    angle: np.ndarray
    """Crank angle [rad], (n,)."""
    reaction: np.ndarray
    """Force [N] and moment [N m], (n, 6)."""


def joints_of(result: Result) -> list[str]:
    """Return the joints whose reactions a result holds."""
    return [joint for joint in JOINTS if f"{joint}_reaction_force_x" in result.series]


def joint_reaction(result: Result, joint: str, axes: str = "ground") -> np.ndarray:
    """Return the force [N] and moment [N m] that a joint exerts on its second body about its point there, (n,
    6), at every sample.

    Parameters
    ----------
    joint : one of `joints_of`
    axes : "ground", "frame", "crank" (x from the driveshaft axis to the pin) or "chamber"

    Raises
    ------
    CaseError : no such joint or axes
    """
    if joint not in (known := joints_of(result)):
        raise CaseError(Fault(f"joint {joint}", "its reaction is not recorded", known_joints(joint, known)))
    if axes not in AXES:
        raise CaseError(Fault(f"axes {axes}", "must be axes of the mill", f"Known are {', '.join(AXES)}"))
    world = np.column_stack([result.series[f"{joint}_reaction_{part}"].values for part in PARTS])
    if (body := AXES[axes]) is None:
        return world
    rotation = attitude(result, body)
    return np.hstack([np.einsum("nij,ni->nj", rotation, part) for part in (world[:, :3], world[:, 3:])])


def attitude(result: Result, body: str) -> np.ndarray:
    """Return the rotation matrices (n, 3, 3) from the axes of a body to world axes at every sample."""
    return rotation_of(np.column_stack([result.series[f"{body}_attitude_{part}"].values for part in "wxyz"]))


def load_paths(result: Result, last: float | str = PAPER_WINDOW) -> "xarray.DataArray":
    """Compute the statistics of every joint's reaction over the whole turns of the steady end of a run.

    Parameters
    ----------
    last : length of the steady window [s], or a text with a unit

    Returns
    -------
    over ``joint``, ``axes``, ``part`` (of `PARTS`, N and N m) and ``statistic`` (of `STATISTICS`); resultants
    of force and moment are parts ``force`` and ``moment``

    Raises
    ------
    ResultError : the run has not made one turn at its last speed
    """
    joints = joints_of(result)
    values = np.empty((len(joints), len(AXES), len(PARTS) + 2, len(STATISTICS)))
    for j, joint in enumerate(joints):
        for a, axes in enumerate(AXES):
            turns = hodograph(result, joint, axes, last)
            size = [np.linalg.norm(turns.reaction[:, part], axis=1) for part in (slice(0, 3), slice(3, 6))]
            values[j, a] = statistics(turns.angle, np.column_stack([turns.reaction, *size]))
    coords = {
        "joint": joints,
        "axes": list(AXES),
        "part": [*PARTS, "force", "moment"],
        "statistic": list(STATISTICS),
    }
    return xarray.DataArray(values, coords, tuple(coords), name="reaction")


def hodograph(result: Result, joint: str, axes: str = "frame", last: float | str = PAPER_WINDOW) -> Hodograph:
    """Return the reaction of a joint over the whole turns of the steady window, evenly spaced over the crank
    angle.
    """
    steady = steady_window(result, last)
    time, angle = result.series["time"].values, result.series["crank_angle"].values
    first, end = np.interp(steady.turns[[0, -1]], time, angle)
    count = round((end - first) / (2.0 * np.pi))
    even = first + 2.0 * np.pi * np.arange(count * PER_TURN) / PER_TURN
    reaction = joint_reaction(result, joint, axes)
    return Hodograph(even, np.column_stack([np.interp(even, angle, part) for part in reaction.T]))


def statistics(angle: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Compute `STATISTICS` (m, n_statistics) of signals (n, m) that are evenly spaced over whole turns of
    `angle` (n,).
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
    """Format the forces and moments of all joints in one set of axes as a table."""
    rows = [f"joint reactions on the second body, {axes} axes (N, N m)"]
    rows.append(f"{'joint':27} {'part':9} " + " ".join(f"{name:>9}" for name in STATISTICS))
    for joint in table["joint"].values:
        for part in table["part"].values:
            numbers = table.sel(joint=joint, axes=axes, part=part).values
            rows.append(
                f"{joint:27} {part:9} "
                + " ".join(f"{_round_off(number, numbers):9.4g}" for number in numbers)
            )
    return rows


def _round_off(number: float, beside: np.ndarray) -> float:
    """Return the number, or zero where it is round-off beside the others."""
    return 0.0 if abs(number) < max(1e-9, 1e-10 * np.abs(beside).max()) else float(number)
