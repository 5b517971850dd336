"""Checks of the forces, stops, gears, linear drives and unbalance motors of a machine.

A finding is (key, what, hint), as in `nutamill.case.charge_checks`.
"""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from nutamill.case.charge_checks import Finding
from nutamill.case.drive import profile_fault

if TYPE_CHECKING:
    from nutamill.case.machine import Machine

TURNING = ("revolute", "cylindrical")
"""Kinds of joints that a drive can turn."""

LEAST_RESTITUTION = 0.05
"""Smallest coefficient of restitution that the engine takes [1]."""


def load_findings(case: "Machine") -> Iterator[Finding]:
    """Yield everything that contradicts."""
    for check in (_forces, _stops, _gears, _linear_drives, _unbalance_motors):
        yield from check(case)


def _forces(case: "Machine") -> Iterator[Finding]:
    for number, force in enumerate(case.forces):
        if (force.force is None) == (force.table is None):
            yield (
                ("forces", number),
                "must have either a force or a table",
                'Write e.g. force = ["0 N", "0 N", "-50 N"]',
            )
        elif force.table is not None and (fault := profile_fault([time for time, _ in force.table])):
            yield ("forces", number, "table", fault[0]), fault[1], ""


def _stops(case: "Machine") -> Iterator[Finding]:
    for number, stop in enumerate(case.stops):
        where = ("stops", number)
        if (stop.normal is None) == (stop.radius_a is None):
            yield where, "must have either a normal or a radius_a", "Write e.g. normal = [0, 0, 1]"
        elif stop.normal is not None and not any(stop.normal):
            yield (*where, "normal"), "must have a length, got zero", ""
        elif stop.normal is None and stop.point_a == stop.point_b:
            yield (*where, "point_b"), "is the centre of both spheres", ""
        if stop.restitution < LEAST_RESTITUTION:
            yield (
                (*where, "restitution"),
                f"must be at least {LEAST_RESTITUTION:g}, got {stop.restitution:g}",
                "",
            )


def _gears(case: "Machine") -> Iterator[Finding]:
    kinds = {joint.name: joint.kind for joint in case.joints}
    for number, gear in enumerate(case.gears):
        for side in ("input", "output"):
            joint = getattr(gear, side)
            kind = kinds.get(joint, "revolute")
            if kind not in TURNING:
                what = f'must be a revolute or cylindrical joint, got "{joint}", a {kind} joint'
                yield ("gears", number, side), what, ""
        if gear.input == gear.output:
            yield (
                ("gears", number, "output"),
                f'must be another joint than the input, got "{gear.output}"',
                "",
            )
        if gear.ratio == 0.0:
            yield ("gears", number, "ratio"), "must not be zero", ""


def _linear_drives(case: "Machine") -> Iterator[Finding]:
    kinds = {joint.name: joint.kind for joint in case.joints}
    turning = {drive.name for drive in case.drives}
    for number, drive in enumerate(case.linear_drives):
        where = ("linear_drives", number)
        kind = kinds.get(drive.joint, "prismatic")
        if kind != "prismatic":
            yield (*where, "joint"), f'must be a prismatic joint, got "{drive.joint}", a {kind} joint', ""
        if drive.name in turning:
            yield (*where, "name"), f'is the name of a drive, got "{drive.name}"', "Rename one of the two"
        if fault := profile_fault([time for time, _ in drive.speeds]):
            yield (*where, "speeds", fault[0]), fault[1], 'Write e.g. [["0 s", "0 m/s"], ["1 s", "0.2 m/s"]]'
        motor = drive.motor
        if (
            motor is not None
            and motor.restored is not None
            and (motor.cut is None or motor.restored <= motor.cut)
        ):
            yield (*where, "motor", "restored"), "must come after cut", ""


def _unbalance_motors(case: "Machine") -> Iterator[Finding]:
    taken = {part.name for list_ in (case.bodies, case.joints, case.drives) for part in list_}
    taken |= {drive.name for drive in case.linear_drives} | {"ground"}
    for number, motor in enumerate(case.unbalance_motors):
        where = ("unbalance_motors", number)
        if motor.name in taken:
            what = f'is the name of a body, a joint or a drive, got "{motor.name}"'
            yield (*where, "name"), what, "Rename one of the two"
        for key in ("axis", "towards"):
            if not any(getattr(motor, key)):
                yield (*where, key), "must have a length, got zero", ""
        across = sum(x * y for x, y in zip(motor.axis, motor.towards, strict=True))
        size = math.hypot(*motor.axis) * math.hypot(*motor.towards)
        if abs(across) > 1e-9 * size:
            yield (*where, "towards"), "must be square to the axis", ""
