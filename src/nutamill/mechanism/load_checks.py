"""What loads, drives, gears and stops must satisfy one by one, before a mechanism is assembled."""

import numpy as np

from nutamill.base.errors import Fault
from nutamill.mechanism.number_checks import VECTOR, not_numbers
from nutamill.mechanism.parts import JOINTS, JointKind
from nutamill.mechanism.stop_tables import LEAST_RESTITUTION


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
