"""The variables of a machine as an FMU: what a master sets and gets, and where that is in the block."""

from typing import NamedTuple

import numpy as np

from nutamill.base.errors import CaseError, Fault
from nutamill.base.object_code import Block
from nutamill.case.drive import Motor
from nutamill.case.machine import Machine
from nutamill.export.fmu.series import Made, made_series
from nutamill.simulation.entry import record_first_row
from nutamill.simulation.setup.model import Model, State, build

DRIVES = ("programme", "speed", "torque")
"""What the drives of an exported machine do: as the case says, or as inputs ask."""
NUMBER, KNOT = 8, 24
"""Sizes of a number and of a knot of a drive [bytes]."""
MOTION = (
    ("position", "xyz", "m", "mass centre, world"),
    ("quaternion", "wxyz", "1", "attitude, from axes of the body to world axes"),
    ("velocity", "xyz", "m/s", "velocity of the mass centre, world axes"),
    ("angular_velocity", "xyz", "rad/s", "angular velocity, world axes"),
    ("acceleration", "xyz", "m/s^2", "acceleration of the mass centre, world axes"),
    ("angular_acceleration", "xyz", "rad/s^2", "angular acceleration, world axes"),
)
"""Outputs of every body: name, components, unit, meaning."""
WRENCH = (
    ("force", "N", "external force, mean over the step, world axes"),
    ("moment", "N m", "external moment about the moving mass centre, mean over the step, world axes"),
)
"""Inputs of every body."""


class ExportedVariable(NamedTuple):
    """A variable of an FMU; its value reference is its place in the list."""

    name: str
    """Its name."""
    causality: str
    """Causality: independent, input or output."""
    unit: str
    """Unit as `nutamill.base.units` writes it; 1 for a plain number."""
    meaning: str
    """One line."""
    kind: str
    """Where it is: "CLOCK", "IN_BLOCK" or "IN_SLOTS"."""
    at: int
    """Place in the block [bytes], or slot [1]."""
    start: float | None
    """Start value of an input [SI]."""


class Input(NamedTuple):
    """What is done with an input before a step."""

    kind: str
    """Kind: "PLAIN", copied to its place, or "SPEED", a drive that comes to it during the step."""
    at: int
    """Place that it is copied to, or of the first knot of the drive [bytes]."""
    motion: int
    """Place of the motion of the drive [bytes]."""


class Interface(NamedTuple):
    """A machine, ready to be written as an FMU."""

    model: Model
    """Constants of the machine."""
    state: State
    """Its start."""
    arguments: dict
    """Arguments of the kernels by name."""
    block: Block
    """The same as one block."""
    variables: list[ExportedVariable]
    """The variables by value reference."""
    inputs: list[Input]
    """The inputs, in the order of their numbers in the block."""
    made: list[Made]
    """Series that are computed of a row."""


def mechanism_interface(machine: Machine, drives: str = "programme") -> Interface:
    """Return a machine without its charge as the parts of an FMU.

    Parameters
    ----------
    machine : the machine; its charge is left out
    drives : one of `DRIVES`

    Raises
    ------
    CaseError : every fault of the machine
    StepError : no first accelerations, or no equilibrium where it starts from rest
    """
    if machine.fmus:
        hint = 'Take them out, e.g. -s "fmus=[]"'
        raise CaseError(Fault("fmus", "cannot be exported in an FMU", hint))
    if drives != "programme" and not machine.drives:
        raise CaseError(Fault("--drives", f"has no use here, got {drives}: the machine has no drives"))
    bare = _with_own_quantities(_without_charge(machine, drives))
    model, state, scratch = build(bare, None)
    if drives == "torque":
        names = [drive.name for drive in machine.drives]
        for name in ("gain", "integral_gain"):
            model.mechanism.drives[name][: len(names)] = 0.0
        state.mechanism.motor_integral[: len(names)] = 0.0
    record_first_row(model, state, scratch)
    count = 6 * len(bare.bodies) + (0 if drives == "programme" else len(bare.drives))
    arguments = {
        "mechanism": model.mechanism,
        "state": state.mechanism,
        "scratch": scratch.mechanism,
        "sensors": model.sensors,
        "starts": model.readout.table.starts,
        "row": np.zeros(model.readout.n_columns),
        "inputs": np.zeros(count),
    }
    if drives == "speed":
        arguments["mechanism"] = _two_knots(model, len(bare.drives))
    block = Block(arguments)
    variables = [ExportedVariable("time", "independent", "s", "simulated time", "CLOCK", 0, None)]
    inputs: list[Input] = []
    _add_inputs(bare, drives, arguments, block, variables, inputs)
    _add_bodies(bare, block, variables)
    made, slots = made_series(model, state)
    for field in model.readout.fields:
        if field.name != "time":
            variables.append(
                ExportedVariable(
                    field.name, "output", field.unit, field.meaning, "IN_SLOTS", slots[field.name], None
                )
            )
    return Interface(model, state, arguments, block, variables, inputs, made)


def _without_charge(machine: Machine, drives: str) -> Machine:
    """Return a machine without charge, with motors where the torque is an input."""
    run = machine.run
    changes: dict = {"charge": type(machine.charge)(kind="none"), "walls": (), "regions": ()}
    changes["run"] = run.model_copy(update={"dt": "auto"})
    changes["sensors"] = tuple(sensor for sensor in machine.sensors if sensor.kind != "charge")
    if drives == "torque":
        changes["drives"] = tuple(drive.model_copy(update={"motor": Motor()}) for drive in machine.drives)
    bare = machine.model_copy(update=changes)
    bare._name = machine._name
    return bare


def _with_own_quantities(bare: Machine) -> Machine:
    """Return a machine without the quantities and series that are taken of the charge it had."""
    run = bare.run
    plain = bare.model_copy(update={"quantities": (), "run": run.model_copy(update={"series": None})})
    known = set(build(plain, None)[0].readout.values_by_name)
    quantities = []
    for entry in bare.quantities:
        if {source.removeprefix("-") for source in entry.of} <= known:
            quantities.append(entry)
            known.add(entry.name)
    changes: dict = {"quantities": tuple(quantities)}
    if run.series is not None:
        names = tuple(name for name in run.series if name in known)
        changes["run"] = run.model_copy(update={"series": names})
    made = bare.model_copy(update=changes)
    made._name = bare._name
    return made


def _two_knots(model: Model, count: int):
    """Return the mechanism with two knots for each of its first drives, which an FMU writes at every step."""
    mechanism = model.mechanism
    records = mechanism.drives.copy()
    records["end_knot"][:count] = records["first_knot"][:count] + 2
    return mechanism._replace(drives=records)


def _add_inputs(
    machine: Machine,
    drives: str,
    arguments: dict,
    block: Block,
    variables: list[ExportedVariable],
    inputs: list[Input],
) -> None:
    """Add wrenches on bodies, and speeds or torques of drives."""
    at = block.places["inputs"]

    def add(name: str, unit: str, meaning: str, given: Input) -> None:
        place = at + NUMBER * len(inputs)
        variables.append(ExportedVariable(name, "input", unit, meaning, "IN_BLOCK", place, 0.0))
        inputs.append(given)

    for b, body in enumerate(machine.bodies):
        for k, (load, unit, meaning) in enumerate(WRENCH):
            for axis, letter in enumerate("xyz"):
                place = block.places["state.wrench"] + NUMBER * (6 * b + 3 * k + axis)
                name = f"wrench.{body.name}.{load}.{letter}"
                add(name, unit, f"{meaning}, on {body.name}", Input("PLAIN", place, 0))
    if drives == "programme":
        return
    for d, drive in enumerate(machine.drives):
        motion = block.places["state.drive_motion"] + 3 * NUMBER * d
        if drives == "torque":
            place = block.places["state.motor_integral"] + NUMBER * d
            meaning = f"torque of drive {drive.name} on its joint's body b, held over the step"
            add(f"drives.{drive.name}.torque", "N m", meaning, Input("PLAIN", place, motion))
        else:
            first = int(arguments["mechanism"].drives["first_knot"][d])
            place = block.places["mechanism.knots"] + KNOT * first
            meaning = f"speed that drive {drive.name} comes to at the end of the step, linear in time"
            add(f"drives.{drive.name}.speed", "rad/s", meaning, Input("SPEED", place, motion))


def _add_bodies(machine: Machine, block: Block, variables: list[ExportedVariable]) -> None:
    """Add pose, twist and accelerations of every body."""
    shared = {"acceleration": ("acceleration", 6, 0), "angular_acceleration": ("acceleration", 6, 3)}
    for b, body in enumerate(machine.bodies):
        for part, letters, unit, meaning in MOTION:
            array, width, first = shared.get(part, (part, len(letters), 0))
            for k, letter in enumerate(letters):
                place = block.places[f"state.{array}"] + NUMBER * (width * b + first + k)
                name = f"bodies.{body.name}.{part}.{letter}"
                text = f"{meaning}, of {body.name}"
                variables.append(ExportedVariable(name, "output", unit, text, "IN_BLOCK", place, None))
