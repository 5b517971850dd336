"""Masses that an answer adds to a machine: on what its drive turns, and the charge as a rigid mass.

Answers know machines only.  Two questions are put to the drawing of a mill, where there is one: where the
mass of the charge sits as a rigid ring (``chamber.bars``), and which balance masses its driveshaft has
already (``balance``).  The bodies of a machine hold neither apart from the rest.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from nutamill.base.errors import CaseError, Fault
from nutamill.base.frames import rotation_matrix_of
from nutamill.base.required import required
from nutamill.case import Case, Machine
from nutamill.case.machine import BodyEntry, DriveEntry, JointEntry
from nutamill.case.machine_checks import GROUND
from nutamill.case.placement import axes_along, quaternion_of
from nutamill.case.rigid_parts import RigidPart, compose
from nutamill.simulation.setup.altered import altered, turning_drive
from nutamill.simulation.setup.particles import charge_mass


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
    return altered(machine, bodies=bodies)


def weighted_body(machine: Machine, weights: Sequence[Weight]) -> BodyEntry:
    """Return the body that the drive of a machine turns, with these masses on it. Raises as `weighted`."""
    joint = _driven_joint(machine)
    body = next(body for body in machine.bodies if body.name == joint.between[1])
    axes, point = axes_along(required(joint.axis)), np.array(joint.point)
    foot = point - axes[:, 2] * (point @ axes[:, 2])  # of the axis, next to the origin
    rotation = rotation_matrix_of(quaternion_of(body.turn))
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
