"""What the numbers of the parts of a mechanism must be: finite, and of the right shape."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from nutamill.base.errors import Fault
from nutamill.mechanism.parts import (
    Body,
    Bushing,
    Force,
    Gear,
    Joint,
    JointFriction,
    Motor,
    Spring,
    Stop,
    Torque,
)

VECTOR = (3,)
SHAPES: dict[type, dict[str, tuple[int, ...]]] = {
    Body: {
        "mass": (),
        "inertia": (3, 3),
        "position": VECTOR,
        "quaternion": (4,),
        "velocity": VECTOR,
        "angular_velocity": VECTOR,
    },
    Joint: dict.fromkeys(("point", "axis", "second_axis", "point_b"), VECTOR),
    JointFriction: dict.fromkeys(
        ("coefficient", "radius", "constant", "viscous", "constant_force", "viscous_force"), ()
    ),
    Bushing: {"point": VECTOR, "axis": VECTOR, "stiffness": (4,), "damping": (4,)},
    Spring: {"point_a": VECTOR, "point_b": VECTOR}
    | dict.fromkeys(("stiffness", "damping", "free_length", "preload"), ()),
    Torque: {"moment": VECTOR},
    Force: {"point": VECTOR},
    Gear: {"ratio": ()},
    Stop: dict.fromkeys(("point_a", "point_b", "normal"), VECTOR)
    | dict.fromkeys(("stiffness", "restitution", "radius_a", "radius_b"), ()),
    Motor: dict.fromkeys(("gain", "integral_gain", "torque_limit", "power_limit", "cut", "restored"), ()),
}
"""Shapes of the numbers of each part, by field."""

OPTIONAL = {
    Joint: ("axis", "second_axis", "point_b"),
    Spring: ("free_length", "preload"),
    Force: ("point",),
    Stop: ("normal", "radius_a"),
}
"""Fields of each part that may be None."""


def number_faults(kind: str, parts: Sequence[Any]) -> Iterator[Fault]:
    """Yield a fault for every number, vector or matrix of the parts that is not finite or of another shape
    (`SHAPES`). An optional one may be None.
    """
    for part in parts:
        for owner in (part, getattr(part, "friction", None), getattr(part, "motor", None)):
            for name, shape in SHAPES.get(type(owner), {}).items():
                value = getattr(owner, name)
                if value is None and name in OPTIONAL.get(type(owner), ()):
                    continue
                if wrong := not_numbers(value, shape, infinite=isinstance(owner, Motor)):
                    yield Fault(f"{kind} {part.name!r}", f"{name} is {wrong}")


def not_numbers(value, shape, infinite=False) -> str:
    """Describe what is wrong with numbers of a shape, () for a single one.

    The text is empty if nothing is.
    """
    expected = f"not {' x '.join(map(str, shape))} finite numbers" if shape else "not a finite number"
    try:
        numbers = np.asarray(value, float)
    except (TypeError, ValueError):
        return f"{expected}, got {value!r}"
    sound = not np.isnan(numbers).any() and (infinite or np.isfinite(numbers).all())
    return "" if numbers.shape == shape and sound else f"{expected}, got {value}"
