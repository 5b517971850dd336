"""A machine as an answer runs it: without its charge, bolted down, driven otherwise, with balance masses.

Answers know machines only.  Two questions are put to the drawing of a mill, where there is one: where the
mass of the charge sits as a rigid ring (``chamber.bars``), and which balance masses its driveshaft has
already (``balance``).  The bodies of a machine hold neither apart from the rest.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from nutamill.base.errors import CaseError, Fault
from nutamill.base.frames import rotation_matrix
from nutamill.base.required import required
from nutamill.case import Case, Machine
from nutamill.case.charge import ChargeRecipe
from nutamill.case.loads import StopEntry, UnbalanceMotorEntry
from nutamill.case.machine import BodyEntry, DriveEntry, JointEntry, SpringEntry, drive_series
from nutamill.case.machine_checks import GROUND
from nutamill.case.placement import axes_along, quaternion_of
from nutamill.case.rigid_parts import RigidPart, compose
from nutamill.simulation.setup.mechanism import assemble_machine
from nutamill.simulation.setup.model import machine_readout
from nutamill.simulation.setup.particles import charge_mass

TurningDrive = DriveEntry | UnbalanceMotorEntry


class Weight(NamedTuple):
    """A balance mass on what a drive turns."""

    mass: float
    """Mass [kg]."""
    radius: float
    """Distance from the axis of the drive [m]."""
    depth: float
    """Along that axis, below the origin of the world as assembled, of a mill the nutation point [m]."""
    azimuth: float
    """About that axis in the direction of rotation [rad], in [0, 2 pi), from the crank pin of a mill: the
    direction of the world's x axis as assembled.
    """


def with_charge_mass(case: Case | Machine) -> Case:
    """Return the mill with the mass of its charge fixed to the chamber's base, where the rigid bars are.

    Raises
    ------
    CaseError : a case whose drawing has no ring for the bars, or that has no drawing
    """
    mill = case.drawing
    if mill is None or mill.chamber.bars is None:
        what = "is missing, so that the mass of the charge has no position"
        raise CaseError(
            Fault(
                "chamber.bars",
                what,
                "Leave the mass of the charge out, or give the drawing of a mill radius and depth of a ring",
            )
        )
    return mill.with_("chamber.bars.mass", mill.chamber.bars_mass + charge_mass(mill.machine))


def without_charge(machine: Machine) -> Machine:
    """Return the machine without its charge, every series recorded: its quantities are those that the parts
    give that are left.
    """
    sensors = tuple(entry for entry in machine.sensors if entry.kind != "charge")
    run = machine.run.model_copy(update={"dt": "auto"})
    return _with_its_quantities(machine, charge=ChargeRecipe(kind="none"), sensors=sensors, run=run, fmus=())


def supports(machine: Machine) -> list[str]:
    """Return the names of the bushings between a body and the ground."""
    return [bushing.name for bushing in machine.bushings if GROUND in bushing.between]


def bolted(machine: Machine) -> Machine:
    """Return the machine with every body that stands on bushings fixed to the ground in their place.

    Raises
    ------
    CaseError : springs or stops to the ground, whose place no fixed joint takes
    """
    elastic: list[SpringEntry | StopEntry] = [*machine.springs, *machine.stops]
    loose = [entry.name for entry in elastic if GROUND in entry.between]
    if loose:
        what = f"stands on {', '.join(loose)}, which the force on the floor is not read from"
        raise CaseError(Fault(machine.name, what, "Describe what it stands on as [[bushings]]"))
    on_ground = {
        next(name for name in bushing.between if name != GROUND): bushing
        for bushing in machine.bushings
        if GROUND in bushing.between
    }
    fixed = []
    for body in on_ground:
        feet = [entry.point for entry in machine.bushings if set(entry.between) == {GROUND, body}]
        x, y, z = map(float, np.mean(feet, axis=0))
        fixed.append(JointEntry(name=f"{body}_fix", kind="fixed", between=(GROUND, body), point=(x, y, z)))
    joints = [
        entry
        for entry in machine.joints
        if not (GROUND in entry.between and on_ground.keys() & {*entry.between})
    ]
    bushings = tuple(entry for entry in machine.bushings if GROUND not in entry.between)
    return _with_its_quantities(machine, joints=(*fixed, *joints), bushings=bushings)


def without_friction(machine: Machine) -> Machine:
    """Return the machine with joints that nothing rubs in."""
    joints = tuple(joint.model_copy(update={"friction": None}) for joint in machine.joints)
    return _altered(machine, joints=joints)


def turning_drive(machine: Machine) -> TurningDrive:
    """Return the drive that turns the machine: that of its period, or the only one.

    Raises
    ------
    CaseError : no drive that turns, or several and none of them named
    """
    drives: list[TurningDrive] = [*machine.drives, *machine.unbalance_motors]
    named = [drive for drive in drives if drive.name == machine.period]
    if len(named or drives) == 1:
        return (named or drives)[0]
    if not drives:
        what = "no drive turns this machine, and this answer is about the speed of one"
        raise CaseError(Fault(machine.name, what, "Give it [[drives]] or [[unbalance_motors]]"))
    what = f"several drives turn: {', '.join(drive.name for drive in drives)}"
    raise CaseError(Fault(machine.name, what, "Name one as run.period"))


def driven(machine: Machine, until: float, speed: float | None = None, ramp: float | None = None) -> Machine:
    """Return the machine with another speed [rad/s] or ramp [rad/s^2] of its drive, run until a time [s].

    Raises
    ------
    CaseError : as `turning_drive`; numbers that no case has
    """
    drive = turning_drive(machine)
    home = f"{'drives' if isinstance(drive, DriveEntry) else 'unbalance_motors'}.{drive.name}"
    changes = {
        f"{home}.{key}": value for key, value in (("speed", speed), ("ramp", ramp)) if value is not None
    }
    return machine.with_({"run.until": until, **changes})


def angle_series(machine: Machine) -> str:
    """Return the series with the angle of the drive that turns the machine. Raises as `turning_drive`."""
    return drive_series(machine, turning_drive(machine).name, "angle")


def driven_bodies(machine: Machine) -> list[str]:
    """Return the bodies that the drive moves: those that joints connect with what it turns, up to the body
    that carries its bearing. Raises as `turning_drive`.
    """
    joint = _driven_joint(machine)
    carrier, moved, before = joint.between[0], {joint.between[1]}, 0
    while len(moved) > before:
        before = len(moved)
        pairs = [entry.between for entry in machine.joints if not {carrier, GROUND} & {*entry.between}]
        moved.update(body for pair in pairs if moved & {*pair} for body in pair)
    return [body.name for body in machine.bodies if body.name in moved]


def weighted(case: Case | Machine, weights: Sequence[Weight]) -> Machine:
    """Return the machine with these balance masses on what its drive turns, two at most: of a mill as drawn
    in place of its own, of any other machine added to that body.

    Raises
    ------
    CaseError : as `turning_drive`; a drive that turns no body of the file
    """
    if (mill := case.drawing) is not None:
        none = Weight(0.0, mill.balance.radius, mill.balance.depth, np.pi)
        first, second = [*weights, none, none][:2]
        changes = {f"balance__{name}": value for name, value in first._asdict().items()}
        return mill.with_(**changes, balance__second=second._asdict()).machine
    machine = case.machine
    changed = weighted_body(machine, weights)
    bodies = tuple(changed if body.name == changed.name else body for body in machine.bodies)
    return _altered(machine, bodies=bodies)


def weighted_body(machine: Machine, weights: Sequence[Weight]) -> BodyEntry:
    """Return the body that the drive of a machine turns, with these masses on it. Raises as `weighted`."""
    joint = _driven_joint(machine)
    body = next(body for body in machine.bodies if body.name == joint.between[1])
    axes, point = axes_along(required(joint.axis)), np.array(joint.point)
    foot = point - axes[:, 2] * (point @ axes[:, 2])  # of the axis, next to the origin
    rotation = np.empty((3, 3))
    rotation_matrix(quaternion_of(body.turn), rotation)
    inertia = np.diag(body.inertia[:3])
    for (i, j), product in zip(((0, 1), (0, 2), (1, 2)), body.inertia[3:], strict=False):
        inertia[i, j] = inertia[j, i] = product
    parts = [RigidPart(body.mass, np.array(body.position), rotation @ inertia @ rotation.T)]
    for weight in weights:
        across = weight.radius * np.array([np.cos(weight.azimuth), np.sin(weight.azimuth)])
        place = foot + axes @ np.array([*across, -weight.depth])
        parts.append(RigidPart(weight.mass, place, np.zeros((3, 3))))
    whole = compose(*parts)
    own = rotation.T @ whole.inertia @ rotation
    six = (own[0, 0], own[1, 1], own[2, 2], own[0, 1], own[0, 2], own[1, 2])
    x, y, z = map(float, whole.mass_centre)
    return body.model_copy(
        update={"mass": float(whole.mass), "position": (x, y, z), "inertia": tuple(map(float, six))}
    )


def _driven_joint(machine: Machine) -> JointEntry:
    """Return the joint that the drive of a machine turns. Raises CaseError for that of an unbalance motor."""
    drive = turning_drive(machine)
    if not isinstance(drive, DriveEntry):
        what = "turns a rotor of its own, to which no balance mass can be added"
        raise CaseError(Fault(f"unbalance_motors.{drive.name}", what, "Change its mass or eccentricity"))
    joint = next(joint for joint in machine.joints if joint.name == drive.joint)
    if joint.between[1] == GROUND:
        what = "turns the ground, to which no balance mass can be added"
        raise CaseError(Fault(f"joints.{joint.name}.between", what, "Name the body that turns second"))
    return joint


def _with_its_quantities(machine: Machine, **parts: Any) -> Machine:
    """Return a machine with other parts, and those of its quantities whose series they still give."""
    bare = _altered(machine, **{**parts, "quantities": ()})
    ends = {"until": bare.run.end, "max": None, "precision": None}
    bare = _altered(bare, run=bare.run.model_copy(update={"series": None, "watch": (), **ends}))
    mechanism, state, _ = assemble_machine(bare)
    given = set(machine_readout(bare, mechanism, state, []).values_by_name)
    whole = []
    for entry in machine.quantities:
        if given.issuperset(source.removeprefix("-") for source in entry.of):
            whole.append(entry)
            given.add(entry.name)
    return _altered(bare, quantities=tuple(whole))


def _altered(machine: Machine, **parts: Any) -> Machine:
    """Return a machine with other parts."""
    content = {name: getattr(machine, name) for name in Machine.model_fields if name != "schema_version"}
    other = Machine(**(content | parts))
    other._name, other._written = machine._name, machine._written
    return other
