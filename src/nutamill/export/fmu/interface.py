"""The variables of a machine as an FMU: what a master sets and gets, and where that is in the block."""

from typing import Any, NamedTuple

import numpy as np

from nutamill.base.errors import CaseError, Fault
from nutamill.base.object_code import Block
from nutamill.case.drive import Motor
from nutamill.case.machine import Machine
from nutamill.export.fmu.series import Made, made_series
from nutamill.mechanism.model import Mechanism
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


class Names(NamedTuple):
    """Where the parts of the mechanism are among the arguments of the kernels."""

    model: str
    """Constants."""
    state: str
    """State."""


class Growing(NamedTuple):
    """An array whose room grows with the lists of a charge."""

    entry: int
    """Place of its entry in the table of the block [bytes]."""
    dimensions: int
    """Number of its dimensions [1]."""
    grows: int
    """Dimension that grows [1]."""
    item: int
    """Size of a number [bytes]."""
    lanes: bool
    """Whether it is work space of the vector loops, which has a length of its own."""


class Whole(NamedTuple):
    """What the skeleton must know of a machine with its charge."""

    growing: list[Growing]
    """Arrays that grow, in the order of the block, behind all others."""
    saved: list[tuple[int, int, int]]
    """Of each book of saved contacts: place of the starts [bytes], number of particles' slots [1], place of
    the table's entry of its partners [bytes].
    """
    chunk: int
    """Particles of a chunk [1]."""
    surface_lanes: int
    """Surfaces times particles of a chunk [1]."""
    places: dict[str, int]
    """Places that the skeleton reads and writes, by their names in its tables [bytes]."""
    wrench: tuple[int, int]
    """First column of the wrenches of the carriers, and their number [1]."""


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
    whole: Whole | None = None
    """The charge; None for a mechanism without it."""


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
    refuse_export(machine, drives)
    bare = _with_own_quantities(driven(_without_charge(machine), drives))
    model, state, scratch = build(bare, None)
    if drives == "torque":
        release_motors(model, state, len(machine.drives))
    record_first_row(model, state, scratch)
    arguments: dict[str, Any] = {
        "mechanism": model.mechanism,
        "state": state.mechanism,
        "scratch": scratch.mechanism,
        "sensors": model.sensors,
        "starts": model.readout.table.starts,
        "row": np.zeros(model.readout.n_columns),
        "inputs": np.zeros(count_inputs(bare, model, drives)),
    }
    if drives == "speed":
        arguments["mechanism"] = two_knots(model.mechanism, len(bare.drives))
    block = Block(arguments)
    names = Names("mechanism", "state")
    variables, inputs = declared(bare, drives, model, arguments["mechanism"], block, names)
    made, slots = made_series(model, state)
    variables += series_outputs(model, slots)
    return Interface(model, state, arguments, block, variables, inputs, made)


def refuse_export(machine: Machine, drives: str) -> None:
    """Raise CaseError for a machine that no FMU can be made of."""
    if machine.fmus:
        hint = 'Take them out, e.g. -s "fmus=[]"'
        raise CaseError(Fault("fmus", "cannot be exported in an FMU", hint))
    if drives != "programme" and not machine.drives:
        raise CaseError(Fault("--drives", f"has no use here, got {drives}: the machine has no drives"))


def driven(machine: Machine, drives: str) -> Machine:
    """Return a machine with motors where the torque of its drives is an input."""
    if drives != "torque":
        return machine
    moved = tuple(drive.model_copy(update={"motor": Motor()}) for drive in machine.drives)
    changed = machine.model_copy(update={"drives": moved})
    changed._name = machine._name
    return changed


def release_motors(model: Model, state: State, count: int) -> None:
    """Take the control off the motors of the first `count` drives, whose torques are inputs."""
    for name in ("gain", "integral_gain"):
        model.mechanism.drives[name][:count] = 0.0
    state.mechanism.motor_integral[:count] = 0.0


def series_outputs(model: Model, slots: dict[str, int]) -> list[ExportedVariable]:
    """Return the recorded series of a machine as outputs. `slots` are theirs by name."""
    return [
        ExportedVariable(field.name, "output", field.unit, field.meaning, "IN_SLOTS", slots[field.name], None)
        for field in model.readout.fields
        if field.name != "time"
    ]


def _without_charge(machine: Machine) -> Machine:
    """Return a machine without charge."""
    run = machine.run
    changes: dict = {"charge": type(machine.charge)(kind="none"), "walls": (), "regions": ()}
    changes["run"] = run.model_copy(update={"dt": "auto"})
    changes["sensors"] = tuple(sensor for sensor in machine.sensors if sensor.kind != "charge")
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


def two_knots(mechanism: Mechanism, count: int) -> Mechanism:
    """Return the mechanism with two knots for each of its first drives, which an FMU writes at every step."""
    records = mechanism.drives.copy()
    records["end_knot"][:count] = records["first_knot"][:count] + 2
    return mechanism._replace(drives=records)


def declared(
    machine: Machine, drives: str, model: Model, mechanism: Mechanism, block: Block, names: Names
) -> tuple[list[ExportedVariable], list[Input]]:
    """Return time, inputs and the motion of the bodies as variables, and what is done with the inputs.

    Wrenches are inputs on bodies that the charge does not push, speeds or torques of drives as `drives` says.
    """
    variables = [ExportedVariable("time", "independent", "s", "simulated time", "CLOCK", 0, None)]
    inputs: list[Input] = []
    at, state = block.places["inputs"], names.state

    def add(name: str, unit: str, meaning: str, given: Input) -> None:
        place = at + NUMBER * len(inputs)
        variables.append(ExportedVariable(name, "input", unit, meaning, "IN_BLOCK", place, 0.0))
        inputs.append(given)

    for b, body in free_bodies(machine, model):
        for k, (load, unit, meaning) in enumerate(WRENCH):
            for axis, letter in enumerate("xyz"):
                place = block.places[f"{state}.wrench"] + NUMBER * (6 * b + 3 * k + axis)
                name = f"wrench.{body}.{load}.{letter}"
                add(name, unit, f"{meaning}, on {body}", Input("PLAIN", place, 0))
    for d, drive in enumerate(machine.drives if drives != "programme" else ()):
        motion = block.places[f"{state}.drive_motion"] + 3 * NUMBER * d
        if drives == "torque":
            place = block.places[f"{state}.motor_integral"] + NUMBER * d
            meaning = f"torque of drive {drive.name} on its joint's body b, held over the step"
            add(f"drives.{drive.name}.torque", "N m", meaning, Input("PLAIN", place, motion))
        else:
            first = int(mechanism.drives["first_knot"][d])
            place = block.places[f"{names.model}.knots"] + KNOT * first
            meaning = f"speed that drive {drive.name} comes to at the end of the step, linear in time"
            add(f"drives.{drive.name}.speed", "rad/s", meaning, Input("SPEED", place, motion))
    _add_bodies(machine, state, block, variables)
    return variables, inputs


def free_bodies(machine: Machine, model: Model) -> list[tuple[int, str]]:
    """Return number and name of the bodies on which the charge exerts nothing."""
    carriers = set() if model.charge is None else set(model.plan.carriers.tolist())
    return [(b, body.name) for b, body in enumerate(machine.bodies) if b not in carriers]


def count_inputs(machine: Machine, model: Model, drives: str) -> int:
    """Return the number of inputs that `declared` makes."""
    return 6 * len(free_bodies(machine, model)) + (0 if drives == "programme" else len(machine.drives))


def _add_bodies(machine: Machine, state: str, block: Block, variables: list[ExportedVariable]) -> None:
    """Add pose, twist and accelerations of every body."""
    shared = {"acceleration": ("acceleration", 6, 0), "angular_acceleration": ("acceleration", 6, 3)}
    for b, body in enumerate(machine.bodies):
        for part, letters, unit, meaning in MOTION:
            array, width, first = shared.get(part, (part, len(letters), 0))
            for k, letter in enumerate(letters):
                place = block.places[f"{state}.{array}"] + NUMBER * (width * b + first + k)
                name = f"bodies.{body.name}.{part}.{letter}"
                text = f"{meaning}, of {body.name}"
                variables.append(ExportedVariable(name, "output", unit, text, "IN_BLOCK", place, None))
