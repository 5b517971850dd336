"""Forces in the six rods that hold the universal joint of the 2025 test rig: three upright, two along y, one
along x.
"""

from typing import NamedTuple

import numpy as np

from nutamill.analysis.load_paths import hodograph, statistics
from nutamill.analysis.source import drawing_of
from nutamill.analysis.windows import PAPER_WINDOW
from nutamill.base.errors import CaseError, Fault
from nutamill.case.drawing import Rod
from nutamill.result import Result

ALONG = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
SINGULAR = 1e-9
"""Ratio of the smallest to the largest singular value [1] below which six rods do not hold a body."""


class RodForces(NamedTuple):
    """Forces in the rods over whole turns."""

    names: tuple[str, ...]
    """Names of the rods, as in the case."""
    angle: np.ndarray
    """Crank angle [rad], (n,)."""
    tension: np.ndarray
    """Tension of each rod, negative where it is pressed [N], (n, 6)."""


def rod_tensions(
    points: np.ndarray, directions: np.ndarray, force: np.ndarray, moment: np.ndarray
) -> np.ndarray:
    """Compute the tensions of six two-force rods that hold a body against a load.

    .. math:: \\sum_i t_i d_i + F = 0, \\quad \\sum_i t_i\\, p_i \\times d_i + M = 0

    Parameters
    ----------
    points : where the rods take hold of the body [m], (6, 3)
    directions : from the body along each rod [1], (6, 3), any length
    force, moment : load on the body [N] and about the origin [N m], (n, 3) each

    Returns
    -------
    tensions [N], (n, 6), positive where a rod pulls

    Raises
    ------
    CaseError : rods that leave the body free to move
    """
    unit = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    matrix = np.vstack([unit.T, np.cross(points, unit).T])
    reach = max(np.linalg.norm(points, axis=1).max(), 1e-12)
    size = np.linalg.svd(matrix / np.array([1.0, 1.0, 1.0, reach, reach, reach])[:, None], compute_uv=False)
    if size[-1] < SINGULAR * size[0]:
        raise CaseError(
            Fault(
                "rods",
                "must hold all six motions of the body, one is free",
                "Put no three along one line or in one point",
            )
        )
    return np.linalg.solve(matrix, -np.hstack([force, moment]).T).T


def drawn_rods(result: Result) -> dict[str, Rod]:
    """Return the rods that hold the yoke, by name, none where the case draws none."""
    drawing = drawing_of(result)
    return {} if drawing is None else drawing.rods


def yoke_rods(result: Result, last: float | str = PAPER_WINDOW) -> RodForces:
    """Compute the tensions of the rods under the load the yoke pivot puts on the frame, over the whole turns
    of steady running.

    Places and directions are those of ``[rods]`` in the case, in frame axes from the nutation point.  The
    weights of the rods and of the yoke are left out: they are constant, and zero where load cells are tared
    at rest.

    Raises
    ------
    CaseError : the case does not have six rods, or they leave the yoke free
    """
    rods = drawn_rods(result)
    if len(rods) != 6:
        raise CaseError(
            Fault(
                "rods",
                f"must be six, the case has {len(rods)}",
                'Write e.g. [rods.upright_1] at = ["150 mm", ...], along = "z"',
            )
        )
    turns = hodograph(result, "yoke_pivot", "frame", last)
    points = np.array([rod.at for rod in rods.values()])
    along = np.array([ALONG[rod.along] for rod in rods.values()])
    # the reaction acts on the cross; the yoke gets the opposite, about the same point
    return RodForces(
        tuple(rods), turns.angle, rod_tensions(points, along, -turns.reaction[:, :3], -turns.reaction[:, 3:])
    )


def rods_lines(rods: RodForces) -> list[str]:
    """Format the forces of the rods as a table."""
    rows = [
        "rod forces (N), positive in tension",
        f"{'rod':14} {'mean':>9} {'rms':>9} {'peak':>9} {'1x':>9} {'2x':>9}",
    ]
    for name, numbers in zip(rods.names, statistics(rods.angle, rods.tension), strict=True):
        rows.append(f"{name:14} " + " ".join(f"{number:9.4g}" for number in numbers[:5]))
    return rows
