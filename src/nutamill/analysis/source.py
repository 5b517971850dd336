"""What readings begin with: a result, if it is that of a mill, and vectors among its series."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from nutamill.base.errors import ResultError
from nutamill.result import Result, open_result


def open_mill_result(path: str | Path) -> Result:
    """Open a result file of a mill, with its crank angle and joint reactions.

    Raises
    ------
    ResultError : no such file, or the result of a mechanism of listed parts, or of a version that recorded no
        reactions
    """
    result = open_result(path)
    try:
        series = result.series
    except BaseException:
        result.close()
        raise
    if "crank_angle" not in series or "pin_joint_reaction_force_x" not in series:
        result.close()
        raise ResultError(
            f"{path}: not the run of a mill with the joint reactions that this version records. Run the case "
            "again."
        )
    return result


def vector(series: Mapping[str, Any], name: str) -> np.ndarray:
    """The three components of a vector among series by name, (n, 3)."""
    return np.column_stack([np.asarray(series[f"{name}_{axis}"]) for axis in "xyz"])
