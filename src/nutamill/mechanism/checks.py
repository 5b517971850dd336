"""What the parts of a mechanism must satisfy one by one, before they are assembled."""

from collections.abc import Iterator, Sequence
from itertools import chain
from typing import Any

import numpy as np

from nutamill.base.errors import Fault
from nutamill.base.units import shown
from nutamill.mechanism.load_checks import drive_faults, force_faults, gear_faults, load_faults, stop_faults
from nutamill.mechanism.model import NAME_WIDTH
from nutamill.mechanism.number_checks import VECTOR, not_numbers, number_faults
from nutamill.mechanism.parts import (
    GROUND,
    JOINTS,
    Body,
    Bushing,
    Drive,
    Force,
    Gear,
    Joint,
    JointKind,
    Spring,
    Stop,
    Torque,
)
from nutamill.mechanism.rows import unit

KINDS: dict[str, type[Any]] = {
    "body": Body,
    "joint": Joint,
    "bushing": Bushing,
    "spring": Spring,
    "drive": Drive,
    "torque": Torque,
    "force": Force,
    "gear": Gear,
    "stop": Stop,
}
"""Parts by the names of their kinds."""


def part_faults(groups, gravity, redundant) -> list[Fault]:
    """Return every fault of the parts (kind -> parts, kinds of `KINDS`), of gravity and of the choice
    `redundant`, as of `assemble`.
    """
    faults = [*type_faults(groups), *option_faults(gravity, redundant)]
    if faults:
        return faults
    numbers = list(chain.from_iterable(number_faults(kind, parts) for kind, parts in groups.items()))
    broken = {fault.where for fault in numbers}
    sound = {
        kind: [part for part in parts if f"{kind} {part.name!r}" not in broken]
        for kind, parts in groups.items()
    }
    return [
        *name_faults(groups),
        *numbers,
        *body_faults(sound["body"]),
        *joint_faults(sound["joint"]),
        *load_faults(sound["bushing"], sound["spring"]),
        *drive_faults(groups["joint"], sound["drive"]),
        *force_faults(sound["force"]),
        *gear_faults(groups["joint"], sound["gear"]),
        *stop_faults(sound["stop"]),
    ]


def option_faults(gravity, redundant):
    """Yield faults of gravity and of the choice `redundant`."""
    if redundant not in ("refuse", "allow"):
        yield Fault("redundant", f"no such choice, got {redundant!r}", 'Give "refuse" or "allow"')
    if wrong := not_numbers(gravity, VECTOR):
        yield Fault("gravity", f"it is {wrong}", "Give an acceleration in world axes [m/s^2]")


def type_faults(groups: dict[str, Sequence[Any]]) -> Iterator[Fault]:
    """Yield parts of another kind than their list, names that are no text, and unknown kinds of joints."""
    for kind, parts in groups.items():
        expected = KINDS[kind]
        for number, part in enumerate(parts):
            if not isinstance(part, expected):
                yield Fault(
                    f"{kind} number {number}",
                    f"not a {expected.__name__}, got {type(part).__name__}",
                    f"Give nutamill.mechanism.parts.{expected.__name__}(...)",
                )
            elif not isinstance(part.name, str):
                yield Fault(f"{kind} number {number}", f"the name is no text, got {part.name!r}")
            elif isinstance(part, Joint) and not isinstance(part.kind, JointKind):
                kinds = ", ".join(f"JointKind.{known.name}" for known in JointKind)
                yield Fault(
                    f"joint {part.name!r}", f"unknown kind, got {part.kind!r}", f"Give one of {kinds}"
                )


def name_faults(groups):
    """Yield names that are empty, too long, repeated, or refer to no part."""
    for kind, parts in groups.items():
        seen = {GROUND} if kind == "body" else set()
        for part in parts:
            where = f"{kind} {part.name!r}"
            if not part.name or len(part.name) > NAME_WIDTH:
                yield Fault(where, f"a name has 1 to {NAME_WIDTH} characters, got {len(part.name)}")
            if part.name in seen:
                yield Fault(where, "the name is taken, got it twice", "Rename one of them")
            seen.add(part.name)
    known = {GROUND, *(body.name for body in groups["body"])}
    hint = f"Known bodies are {', '.join(sorted(known))}"
    for kind in ("joint", "bushing", "spring", "stop"):
        for part in groups[kind]:
            where = f"{kind} {part.name!r}"
            for side in (part.body_a, part.body_b):
                if side not in known:
                    yield Fault(where, f"unknown body, got {side!r}", hint)
            if part.body_a == part.body_b:
                yield Fault(where, f"joins a body to itself, got {part.body_a!r} twice", "Name two bodies")
    for kind in ("torque", "force"):
        for part in groups[kind]:
            if part.body not in known - {GROUND}:
                yield Fault(f"{kind} {part.name!r}", f"unknown moving body, got {part.body!r}", hint)
    names = {joint.name for joint in groups["joint"]}
    for drive in groups["drive"]:
        if drive.joint not in names:
            hint = f"Known joints are {', '.join(sorted(names)) or 'none'}"
            yield Fault(f"drive {drive.name!r}", f"unknown joint, got {drive.joint!r}", hint)


def body_faults(bodies):
    """Yield masses, inertias and attitudes that no rigid body has."""
    for body in bodies:
        where = f"body {body.name!r}"
        if not body.mass > 0.0:
            yield Fault(where, f"mass is not positive, got {body.mass:g} kg")
        inertia = np.asarray(body.inertia, float)
        if not np.allclose(inertia, inertia.T, rtol=0.0, atol=1e-12 * np.abs(inertia).max()):
            yield Fault(where, f"inertia is not symmetric, got {inertia.tolist()}")
            continue
        small, middle, large = np.linalg.eigvalsh(inertia)
        text = f"principal values {small:g}, {middle:g}, {large:g} kg m^2"
        if not small > 0.0:
            yield Fault(where, f"inertia is not positive definite, got {text}")
        elif large > (small + middle) * (1.0 + 1e-9):
            yield Fault(
                where,
                f"the largest principal inertia exceeds the sum of the others, got {text}",
                "No mass distribution has this inertia",
            )
        length = np.linalg.norm(body.quaternion)
        if abs(length - 1.0) > 1e-6:
            yield Fault(where, f"the quaternion has not length 1, got {length:g}")


def joint_faults(joints):
    """Yield axes that are missing, zero or not square, and friction of a kind that has none."""
    for joint in joints:
        where, rows = f"joint {joint.name!r}", JOINTS[joint.kind]
        if rows.needs_axis and (joint.axis is None or not np.linalg.norm(joint.axis) > 0.0):
            yield Fault(
                where, f"a {joint.kind.name} joint needs an axis of non-zero length, got {joint.axis}"
            )
            continue
        if joint.kind == JointKind.UNIVERSAL:
            if joint.second_axis is None or not np.linalg.norm(joint.second_axis) > 0.0:
                yield Fault(
                    where,
                    f"a UNIVERSAL joint needs a second_axis of non-zero length, got {joint.second_axis}",
                    "Give the axis fixed in body b",
                )
                continue
            cosine = unit(joint.axis) @ unit(joint.second_axis)
            if abs(cosine) > 1e-9:
                angle = shown(np.arccos(cosine), "deg", ".6g")
                yield Fault(where, f"the two axes are not square to each other, got {angle}")
        if joint.friction is not None:
            law = joint.friction
            of_force, of_moment = (
                (law.constant_force, law.viscous_force),
                (law.radius, law.constant, law.viscous),
            )
            if not rows.rubs:
                yield Fault(where, f"a {joint.kind.name} joint does not move and has no friction", "Drop it")
            elif rows.slides and any(of_moment):
                what = "its friction is a force along the axis, got a radius or a part in N m"
                yield Fault(where, what, "Give coefficient, constant_force and viscous_force")
            elif not rows.slides and any(of_force):
                what = "its friction is a moment, got a part in N"
                yield Fault(where, what, "Give coefficient and radius, constant and viscous")
            if min(law.coefficient, *of_force, *of_moment) < 0.0:
                yield Fault(where, f"friction values are negative, got {law}")
