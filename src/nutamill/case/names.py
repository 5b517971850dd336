"""Names, points, directions and rotations of the parts of a machine, as its file gives them."""

import re
from typing import Annotated, Any

from pydantic import BeforeValidator

from nutamill.base.schema import AnyAngle, Coordinate, Number, Table, refusal, spelled


def _name(given: Any) -> Any:
    if not isinstance(given, str) or not re.fullmatch("[a-z][a-z0-9_]*", given):
        raise refusal(
            f"must begin with a small letter and hold small letters, digits and _ only, got {spelled(given)}"
        )
    return given


Name = Annotated[str, BeforeValidator(_name)]
Point = tuple[Coordinate, Coordinate, Coordinate]
Direction = tuple[Number, Number, Number]


class Turn(Table):
    """A rotation from world axes to the axes of a body as assembled."""

    axis: Direction
    """What it turns about; any length."""
    angle: AnyAngle
    """How far, by the right hand [rad]."""
