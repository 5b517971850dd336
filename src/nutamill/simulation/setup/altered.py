"""A machine as an answer or a demonstration runs it: without its charge, bolted down, driven otherwise."""

from typing import Any

import numpy as np

from nutamill.base.errors import CaseError, Fault
from nutamill.case import Machine
from nutamill.case.charge import ChargeRecipe
from nutamill.case.loads import StopEntry, UnbalanceMotorEntry
from nutamill.case.machine import DriveEntry, JointEntry, SpringEntry, drive_series
from nutamill.case.machine_checks import GROUND
from nutamill.simulation.setup.carriers import carriers_of
from nutamill.simulation.setup.mechanism import assemble_machine
from nutamill.simulation.setup.model import machine_readout

TurningDrive = DriveEntry | UnbalanceMotorEntry


def without_charge(machine: Machine) -> Machine:
    """Return the machine without its charge, every series recorded: its quantities are those that the parts
    give that are left.
    """
    sensors = tuple(entry for entry in machine.sensors if entry.kind != "charge")
    run = machine.run.model_copy(update={"dt": "auto", "series": None})
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
    return altered(machine, joints=joints)


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
    home = drive_key(machine)
    changes = {
        f"{home}.{key}": value for key, value in (("speed", speed), ("ramp", ramp)) if value is not None
    }
    return machine.with_({"run.until": until, **changes})


def drive_key(machine: Machine) -> str:
    """Return the key of the drive that turns the machine, as in its file. Raises as `turning_drive`."""
    drive = turning_drive(machine)
    return f"{'drives' if isinstance(drive, DriveEntry) else 'unbalance_motors'}.{drive.name}"


def angle_series(machine: Machine) -> str:
    """Return the series with the angle of the drive that turns the machine. Raises as `turning_drive`."""
    return drive_series(machine, turning_drive(machine).name, "angle")


def _with_its_quantities(machine: Machine, **parts: Any) -> Machine:
    """Return a machine with other parts, and those of its quantities, recorded and watched series that they
    still give.
    """
    bare = altered(machine, **{**parts, "quantities": ()})
    ends = {"until": bare.run.end, "max": None, "precision": None, "watch": ()}
    mute = altered(bare, run=bare.run.model_copy(update={"series": None, **ends}))
    mechanism, state, _ = assemble_machine(mute)
    carriers = [part.name for part in carriers_of(mute)] if mute.charge.parts else []
    given = set(machine_readout(mute, mechanism, state, carriers).values_by_name)
    quantities = []
    for entry in machine.quantities:
        if given.issuperset(source.removeprefix("-") for source in entry.of):
            quantities.append(entry)
            given.add(entry.name)
    series = None if bare.run.series is None else tuple(name for name in bare.run.series if name in given)
    run = mute.run.model_copy(update={"series": series})
    return altered(mute, quantities=tuple(quantities), run=run)


def altered(machine: Machine, **parts: Any) -> Machine:
    """Return a machine with other parts, by the names of its tables."""
    content = {name: getattr(machine, name) for name in Machine.model_fields if name != "schema_version"}
    other = Machine(**(content | parts))
    other._name, other._written = machine._name, machine._written
    return other
