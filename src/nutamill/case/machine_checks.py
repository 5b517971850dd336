"""Checks of a mechanism's parts against each other: names, what they refer to, what has no size.

A finding is (key, what, hint), as in `nutamill.case.charge_checks`.  What needs the engine (closure,
redundancy) is checked by `nutamill.mechanism.assembly.assemble` before a step is run.
"""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from nutamill.base.file_kind import MECHANISM
from nutamill.base.library import similar
from nutamill.case.charge_checks import Finding, charge_findings
from nutamill.case.fmus import machine_fmu_findings
from nutamill.case.load_checks import TURNING, load_findings
from nutamill.case.record_checks import record_findings
from nutamill.case.walls import region_findings, wall_findings

if TYPE_CHECKING:
    from nutamill.case.machine import JointEntry, Machine

GROUND = "ground"
"""Name of the body that never moves, as the engine knows it."""
LISTS = (*MECHANISM, "sensors", "walls", "regions", "quantities")
"""Lists of a machine whose entries have names, each name once."""
WITHOUT_AXIS = ("fixed", "spherical")
MOMENT_KEYS: tuple[str, ...] = ("radius", "constant", "viscous")
FORCE_KEYS: tuple[str, ...] = ("constant_force", "viscous_force")
"""Keys of the friction of joints that turn, and of prismatic joints."""
TERMS = {"sum": (1, 1000), "resultant": (2, 1000), "product": (1, 1000), "lag": (5, 5)}
"""Fewest and most series that a quantity is taken of [1]."""
TAKEN = ("joint_", "bushing_", "drive_", "spring_", "torque_", "force_", "stop_", "gear_", "linear_", "fmu_")
"""Beginnings of series that a sensor's name may not have."""


def findings(case: "Machine") -> list[Finding]:
    """Return every contradiction in the machine."""
    checks = (
        _names,
        _references,
        _bodies,
        _joints,
        _bushings,
        _springs,
        _drives,
        _sensors,
        _walls,
        _quantities,
    )
    contradictions = [finding for check in checks for finding in check(case)]
    contradictions += load_findings(case)
    contradictions += machine_fmu_findings(case)
    contradictions += record_findings(case, series_count(case))
    if case.charge.parts or case.charge.kind is None:
        contradictions += [*_carriers(case), *charge_findings(case)]
    elif case.run.dt != "auto":
        what = "is the substep of a charge, and this machine has none"
        contradictions.append((("run", "dt"), what, "The step of a machine without a charge is run.step"))
    return contradictions


def series_count(case: "Machine") -> int:
    """Return the number of series that a run records, rounded up [1]."""
    three = (*case.drives, *case.linear_drives, *case.gears, *case.stops, *case.sensors)
    joints = 6 * len(case.joints) + 9 * len(case.unbalance_motors)
    return joints + 12 * len(case.bushings) + 3 * len(three) + 10


def _names(case: "Machine") -> Iterator[Finding]:
    for where in LISTS:
        seen = {GROUND} if where == "bodies" else set()
        for number, part in enumerate(getattr(case, where)):
            if part.name in seen:
                yield (
                    (where, number, "name"),
                    f'is the name of two parts, got "{part.name}"',
                    "Rename one of the two",
                )
            seen.add(part.name)
    if not case.bodies:
        yield ("bodies",), "must hold at least one body", "Add a [[bodies]] table"


def _references(case: "Machine") -> Iterator[Finding]:
    """Return faults of names of bodies and joints that do not exist."""
    rotors = [motor.name for motor in case.unbalance_motors]
    bodies = [GROUND, *(body.name for body in case.bodies), *rotors]
    joints = [*(joint.name for joint in case.joints), *rotors]
    for where in ("joints", "bushings", "springs", "stops"):
        for number, part in enumerate(getattr(case, where)):
            for side, name in enumerate(part.between):
                if name not in bodies:
                    yield (
                        (where, number, "between", side),
                        f'no body is called "{name}"',
                        similar(name, bodies),
                    )
            if part.between[0] == part.between[1]:
                yield (
                    (where, number, "between"),
                    f'must name two different bodies, got "{part.between[0]}" twice',
                    "",
                )
    named = [
        (where, number, "body", part.body, bodies[1:])
        for where in ("torques", "forces", "unbalance_motors")
        for number, part in enumerate(getattr(case, where))
    ]
    named += [
        (where, number, "joint", drive.joint, joints)
        for where in ("drives", "linear_drives")
        for number, drive in enumerate(getattr(case, where))
    ]
    named += [
        ("gears", number, side, getattr(gear, side), joints)
        for number, gear in enumerate(case.gears)
        for side in ("input", "output")
    ]
    springs = [spring.name for spring in case.springs]
    for number, sensor in enumerate(case.sensors):
        known = {"reaction": joints, "spring": springs}.get(sensor.kind, bodies)
        named.append(("sensors", number, "of", sensor.of, known))
        if sensor.axes is not None:
            named.append(("sensors", number, "axes", sensor.axes, bodies))
    for where, number, key, name, known in named:
        if name not in known:
            kinds = {id(joints): "joint", id(springs): "spring", id(bodies): "body"}
            what = kinds.get(id(known), "body that moves")
            yield (where, number, key), f'no {what} is called "{name}"', similar(name, known)


def _walls(case: "Machine") -> Iterator[Finding]:
    """Return faults of walls and regions whose shape lacks a key or whose body does not exist."""
    bodies, meshes = (
        [GROUND, *(body.name for body in case.bodies)],
        [wall.name for wall in case.walls if wall.shape == "mesh" and wall.charge_side == "inside"],
    )
    for number, wall in enumerate(case.walls):
        if wall.body not in bodies:
            yield ("walls", number, "body"), f'no body is called "{wall.body}"', similar(wall.body, bodies)
        yield from wall_findings(number, wall)
    for number, region in enumerate(case.regions):
        if region.body not in bodies:
            yield (
                ("regions", number, "body"),
                f'no body is called "{region.body}"',
                similar(region.body, bodies),
            )
        if region.wall is not None and region.wall not in meshes:
            hint = (
                similar(region.wall, meshes) if meshes else 'Give a wall shape = "mesh" and side = "inside"'
            )
            yield ("regions", number, "wall"), f'no mesh around a charge is called "{region.wall}"', hint
        yield from region_findings(number, region)
    drives = [drive.name for drive in case.drives]
    if case.run.period is not None and case.run.period not in drives:
        what = f'no drive is called "{case.run.period}"'
        yield ("run", "period"), what, similar(case.run.period, drives)
    if case.run.until == "steady" and not (case.run.watch and case.period):
        what = '"steady" needs a drive whose turns are averaged over, and series to watch'
        yield ("run", "until"), what, "Give run.period and [[run.watch]], or a time"
    for key, known in (("body", bodies), ("drive", drives)):
        name = getattr(case.fields, key)
        if name is not None and name not in known:
            yield ("fields", key), f'no {key} is called "{name}"', similar(name, known)


def _carriers(case: "Machine") -> Iterator[Finding]:
    """Return the fault of a charge without walls or without a region."""
    if not case.walls:
        yield ("walls",), "is missing: nothing holds the charge", "Add [[walls]], each with the body it is on"
    if not case.regions:
        yield ("regions",), "is missing: the charge has no place at the start", "Add a [[regions]] table"


def _bodies(case: "Machine") -> Iterator[Finding]:
    for number, body in enumerate(case.bodies):
        if not body.mass > 0.0:
            yield (
                ("bodies", number, "mass"),
                f"must be positive, got {body.mass:g} kg",
                "A part without mass is no body: leave it out",
            )
        if body.turn is not None and not any(body.turn.axis):
            yield ("bodies", number, "turn", "axis"), "must have a length, got zero", ""


def _joints(case: "Machine") -> Iterator[Finding]:
    for number, joint in enumerate(case.joints):
        needed = {"axis": joint.kind not in WITHOUT_AXIS, "second_axis": joint.kind == "universal"}
        for key, needs in needed.items():
            axis = getattr(joint, key)
            if needs and axis is None:
                yield (
                    ("joints", number, key),
                    f"is missing for a {joint.kind} joint",
                    f"Add e.g. {key} = [0, 0, 1]",
                )
            elif not needs and axis is not None:
                yield ("joints", number, key), f"has no meaning for a {joint.kind} joint", "Leave it out"
            elif needs and not any(axis):
                yield ("joints", number, key), "must have a length, got zero", ""
        yield from _friction(number, joint)


def _friction(number: int, joint: "JointEntry") -> Iterator[Finding]:
    """Yield friction of a joint that cannot move, and keys of it that another kind of joint has."""
    law, where = joint.friction, ("joints", number, "friction")
    if law is None:
        return
    if joint.kind == "fixed":
        yield where, "has no meaning for a fixed joint", "Leave it out"
        return
    slides = joint.kind == "prismatic"
    own, foreign = (FORCE_KEYS, MOMENT_KEYS) if slides else (MOMENT_KEYS, FORCE_KEYS)
    for key in foreign:
        if getattr(law, key):
            hint = f"It has coefficient, {', '.join(own)}"
            yield (*where, key), f"has no meaning for a {joint.kind} joint", hint


def _bushings(case: "Machine") -> Iterator[Finding]:
    for number, bushing in enumerate(case.bushings):
        if not any(bushing.axis):
            yield ("bushings", number, "axis"), "must have a length, got zero", "It points along the bushing"
        if not any(bushing.stiffness + bushing.damping):
            yield (
                ("bushings", number),
                "must have some stiffness or damping, got none",
                "Give e.g. shear_stiffness",
            )


def _springs(case: "Machine") -> Iterator[Finding]:
    for number, spring in enumerate(case.springs):
        if spring.point_a == spring.point_b:
            what, hint = (
                "is the same point as point_a: the force has no direction",
                "Use a bushing for a spring of no length",
            )
            yield ("springs", number, "point_b"), what, hint
        if (spring.free_length is None) == (spring.preload is None):
            yield (
                ("springs", number),
                "must have either a free_length or a preload",
                'Write e.g. free_length = "200 mm"',
            )
        elif spring.preload is not None and not spring.stiffness > 0.0:
            yield ("springs", number, "preload"), "needs a stiffness, got 0 N/m", "Use [[forces]]"
        elif spring.free_length is not None and spring.free_length < 0.0:
            yield (
                ("springs", number, "free_length"),
                f"must be zero or more, got {spring.free_length:g} m",
                "",
            )


def _drives(case: "Machine") -> Iterator[Finding]:
    kinds = {joint.name: joint.kind for joint in case.joints}
    for number, drive in enumerate(case.drives):
        kind = kinds.get(drive.joint, "revolute")
        if kind not in TURNING:
            yield (
                ("drives", number, "joint"),
                f'must be a revolute or cylindrical joint, got "{drive.joint}", a {kind} joint',
                "",
            )


def _quantities(case: "Machine") -> Iterator[Finding]:
    """Yield quantities of too few or too many series, and those taken of quantities that come after them."""
    names = [entry.name for entry in case.quantities]
    for number, entry in enumerate(case.quantities):
        key = ("quantities", number, "of")
        fewest, most = TERMS[entry.take]
        if not fewest <= len(entry.of) <= most:
            wanted = f"{fewest}" if fewest == most else f"at least {fewest}"
            yield key, f'must be {wanted} series with take = "{entry.take}", got {len(entry.of)}', ""
        for source in entry.of:
            if (name := source.removeprefix("-")) in names[number:]:
                yield key, f'must be recorded or stand above it, got "{name}"', "Change the order"


def _sensors(case: "Machine") -> Iterator[Finding]:
    for number, sensor in enumerate(case.sensors):
        key = ("sensors", number)
        if sensor.name.startswith(TAKEN):
            yield (
                (*key, "name"),
                f'begins like the series of a part, got "{sensor.name}"',
                f"Choose a name that does not begin with {', '.join(TAKEN)}",
            )
        if sensor.axes is not None and sensor.kind in ("position", "attitude", "spring"):
            yield (
                (*key, "axes"),
                f"has no meaning for kind = {sensor.kind!r}".replace("'", '"'),
                "Leave it out: world axes",
            )
        if sensor.at is not None and sensor.kind in ("attitude", "reaction", "spring"):
            yield (*key, "at"), f"has no meaning for kind = {sensor.kind!r}".replace("'", '"'), "Leave it out"
