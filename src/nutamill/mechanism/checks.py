"""What the parts of a mechanism must satisfy one by one, before they are assembled."""

from collections.abc import Iterator, Sequence
from itertools import chain
from typing import Any

import numpy as np

from nutamill.base.errors import Fault
from nutamill.base.units import shown
from nutamill.mechanism.model import NAME_WIDTH
from nutamill.mechanism.parts import (
    GROUND,
    JOINTS,
    Body,
    Bushing,
    Drive,
    Force,
    Gear,
    Joint,
    JointFriction,
    JointKind,
    Motor,
    Spring,
    Stop,
    Torque,
)
from nutamill.mechanism.rows import unit
from nutamill.mechanism.stop_tables import LEAST_RESTITUTION

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
    JointFriction: dict.fromkeys(("coefficient", "radius", "constant", "viscous"), ()),
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
            if not rows.rubs:
                yield Fault(
                    where, f"a {joint.kind.name} joint does not rotate and has no friction", "Drop it"
                )
            if min(law.coefficient, law.radius, law.constant, law.viscous) < 0.0:
                yield Fault(where, f"friction values are negative, got {law}")


def load_faults(bushings, springs):
    """Yield rates that are negative, axes of zero length and springs without direction."""
    for bushing in bushings:
        where = f"bushing {bushing.name!r}"
        if min(*bushing.stiffness, *bushing.damping) < 0.0:
            yield Fault(
                where, f"stiffness or damping is negative, got {bushing.stiffness} and {bushing.damping}"
            )
        if not np.linalg.norm(bushing.axis) > 0.0:
            yield Fault(where, f"the axis has no length, got {bushing.axis}")
    for spring in springs:
        where = f"spring {spring.name!r}"
        values = (spring.stiffness, spring.damping, spring.free_length or 0.0)
        if min(values) < 0.0:
            yield Fault(where, f"stiffness, damping or free_length is negative, got {values}")
        if (spring.free_length is None) == (spring.preload is None):
            yield Fault(
                where,
                f"free_length or preload is needed, one of them, got {spring.free_length} and "
                f"{spring.preload}",
            )
        elif spring.preload is not None and not spring.stiffness > 0.0:
            yield Fault(where, "a preload needs a stiffness, got 0", "Use a Force for a constant force")
        if not np.linalg.norm(np.subtract(spring.point_b, spring.point_a)) > 0.0:
            yield Fault(
                where,
                f"the two ends are one point, so that the force has no direction, got {spring.point_a}",
                "Use a bushing for a spring of no length",
            )


def table_faults(where, times, values, name, shape):
    """Yield what is wrong with a table of `values`, each of `shape`, at `times`."""
    try:
        t, x = np.asarray(times, float), np.asarray(values, float)
    except (TypeError, ValueError):
        yield Fault(where, f"times and {name} are not lists of numbers, got {times} and {values}")
        return
    if t.ndim != 1 or x.shape != t.shape + shape or t.size == 0:
        yield Fault(
            where, f"times and {name} are not two lists of one length, got shapes {t.shape} and {x.shape}"
        )
    elif not (np.isfinite(t).all() and np.isfinite(x).all()):
        yield Fault(where, f"times or {name} are not finite, got {times} and {values}")
    elif t[0] != 0.0 or np.any(np.diff(t) <= 0.0):
        yield Fault(where, f"times do not begin at 0 and increase, got {times}")


def force_faults(forces):
    """Yield forces that are no vectors, and tables that are no function of time."""
    for force in forces:
        where = f"force {force.name!r}"
        if force.times is not None:
            yield from table_faults(where, force.times, force.forces, "forces", VECTOR)
        elif wrong := not_numbers(force.forces, VECTOR):
            yield Fault(where, f"forces is {wrong}", "Give a vector, or times and a vector for each")


def drive_faults(joints, drives):
    """Yield drives of joints that neither turn nor slide, speed tables that are no function of time, and
    motors of negative gain or limit.
    """
    kinds = {joint.name: joint.kind for joint in joints}
    for drive in drives:
        where = f"drive {drive.name!r}"
        kind = kinds.get(drive.joint, JointKind.REVOLUTE)
        if not (JOINTS[kind].turns or JOINTS[kind].slides):
            driven = [known.name for known, rows in JOINTS.items() if rows.turns or rows.slides]
            yield Fault(
                where,
                f"joint {drive.joint!r} neither turns about an axis nor only slides along it, got a "
                f"{kind.name} joint",
                f"Drive a {', '.join(driven[:-1])} or {driven[-1]} joint",
            )
        yield from table_faults(where, drive.times, drive.speeds, "speeds", ())
        motor = drive.motor
        if motor is not None:
            values = (motor.gain, motor.integral_gain, motor.torque_limit, motor.power_limit)
            if min(values) < 0.0:
                yield Fault(where, f"gains or limits of the motor are negative, got {motor}")


def gear_faults(joints, gears):
    """Yield gears of joints that are unknown, the same or do not turn, and ratios of zero."""
    kinds = {joint.name: joint.kind for joint in joints}
    turning = [kind.name for kind, rows in JOINTS.items() if rows.turns]
    for gear in gears:
        where = f"gear {gear.name!r}"
        for name in (gear.input, gear.output):
            if name not in kinds:
                hint = f"Known joints are {', '.join(sorted(kinds)) or 'none'}"
                yield Fault(where, f"unknown joint, got {name!r}", hint)
            elif not JOINTS[kinds[name]].turns:
                yield Fault(
                    where,
                    f"joint {name!r} does not turn about an axis, got a {kinds[name].name} joint",
                    f"Name {' or '.join(turning)} joints",
                )
        if gear.input == gear.output:
            yield Fault(where, f"input and output are one joint, got {gear.input!r}", "Name two joints")
        if gear.ratio == 0.0:
            yield Fault(where, "the ratio is zero", "Fix the output with another joint if it is not to turn")


def stop_faults(stops):
    """Yield stops without one surface, with negative numbers, or with spheres of one centre."""
    for stop in stops:
        where = f"stop {stop.name!r}"
        if (stop.normal is None) == (stop.radius_a is None):
            yield Fault(
                where,
                f"a normal or radius_a is needed, one of them, got {stop.normal} and {stop.radius_a}",
                "Give a normal for a plane of body a, radius_a for a sphere",
            )
        elif stop.normal is not None and not np.linalg.norm(stop.normal) > 0.0:
            yield Fault(where, f"the normal has no length, got {stop.normal}")
        elif stop.normal is None and not np.linalg.norm(np.subtract(stop.point_b, stop.point_a)) > 0.0:
            yield Fault(where, f"both spheres have one centre, got {stop.point_a}")
        if not stop.stiffness > 0.0:
            yield Fault(where, f"stiffness is not positive, got {stop.stiffness:g} N/m")
        if min(stop.radius_a or 0.0, stop.radius_b) < 0.0:
            yield Fault(where, f"a radius is negative, got {stop.radius_a} and {stop.radius_b}")
        if not LEAST_RESTITUTION <= stop.restitution <= 1.0:
            yield Fault(
                where,
                f"restitution is not between {LEAST_RESTITUTION:g} and 1, got {stop.restitution:g}",
            )
