"""The door of the readings: a result, if it is that of a mill."""

from pathlib import Path

from nutamill.errors import ResultError
from nutamill.result import Result, open_result


def open_mill_result(path: str | Path) -> Result:
    """Open a result file of a mill, with its crank angle and joint reactions.

    Raises
    ------
    ResultError : no such file, or the result of a mechanism of listed parts, or of a version that recorded no reactions
    """
    result = open_result(path)
    if "crank_angle" not in result.series or "crank_pin_reaction_force_x" not in result.series:
        result.close()
        raise ResultError(f"{path}: must be the run of a mill with its joint reactions, it has none. Run the case again with this version.")
    return result
