"""A machine with its charge as the parts of an FMU: the coupled march on one thread, and lists that grow."""

import numpy as np

from nutamill.base.errors import CaseError, Fault
from nutamill.base.object_code import Block
from nutamill.case.machine import Machine
from nutamill.charge.model import Clock
from nutamill.export.fmu.interface import (
    NUMBER,
    Growing,
    Interface,
    Names,
    Whole,
    count_inputs,
    declared,
    driven,
    refuse_export,
    release_motors,
    series_outputs,
    two_knots,
)
from nutamill.export.fmu.series import made_series
from nutamill.simulation.coupling_model import Scheme
from nutamill.simulation.entry import record_first_row
from nutamill.simulation.setup.bed import settled_bed
from nutamill.simulation.setup.model import build

LISTS = {"pairs": {"partners": 2, "owners": 2, "memory": 2}, "saved": {"memory": 1, "partners": 1}}
"""Arrays of the lists of a charge, with the dimension that is the room of a chunk."""
LANES = "scratch.charge.lanes"
"""Work space of the vector loops, as long as the longest list of a chunk."""


def whole_interface(machine: Machine, drives: str = "programme") -> Interface:
    """Return a machine with its charge as the parts of an FMU. The bed is settled if it is not in the cache.

    Parameters
    ----------
    machine : the machine; its statistics are left out
    drives : one of `nutamill.export.fmu.interface.DRIVES`

    Raises
    ------
    CaseError : every fault of the machine, or no charge
    StepError : no first accelerations, no equilibrium, or an overlap beyond its limit in the bed
    """
    refuse_export(machine, drives)
    if not machine.charge.parts:
        hint = "Export the mechanism: --what mechanism"
        raise CaseError(Fault("--what", "whole needs a charge, this machine has none", hint))
    moved = driven(machine, drives).with_("run.statistics", False).with_("run.threads", 1)
    model, state, scratch = build(moved, settled_bed(moved))
    if drives == "torque":
        release_motors(model, state, len(moved.drives))
    record_first_row(model, state, scratch)
    coupled = model.coupled()
    if drives == "speed":
        coupled = coupled._replace(mechanism=two_knots(model.mechanism, len(moved.drives)))
    arguments = {
        "model": coupled,
        "state": state.coupled(),
        "scratch": scratch.coupled(model, state),
        "row": state.first_row[None, :].copy(),
        "inputs": np.zeros(count_inputs(moved, model, drives)),
    }
    charges = ["state.charge"] + ["scratch.start_charge"] * (model.plan.scheme == Scheme.ITERATED)
    grows = {
        f"{charge}.{lists}.{name}": dimension
        for charge in charges
        for lists, arrays in LISTS.items()
        for name, dimension in arrays.items()
    } | {LANES: 2}
    block = Block(arguments, last=list(grows))
    names = Names("model.mechanism", "state.mechanism")
    variables, inputs = declared(moved, drives, model, coupled.mechanism, block, names)
    made, slots = made_series(model, state)
    variables += series_outputs(model, slots)
    assert model.charge is not None and state.charge is not None
    sizes = {name: len(arguments_of(arguments, name).shape) for name in grows}
    in_order = sorted(grows, key=lambda name: block.places[name])
    wrench = model.readout.table.starts.wrench
    whole = Whole(
        growing=[
            Growing(block.entries[name], sizes[name], grows[name], block.items[name], name == LANES)
            for name in in_order
        ],
        saved=[
            (
                block.places[f"{charge}.saved.starts"],
                len(state.charge.saved.starts),
                block.entries[f"{charge}.saved.partners"],
            )
            for charge in charges
        ],
        chunk=model.charge.chunk,
        surface_lanes=len(model.charge.surface_kind) * model.charge.chunk,
        places={
            "WINDOW_AT": block.entries["model.plan.dt"],
            "WINDOWS_AT": block.places["state.coupling.windows"],
            "OUTCOME_AT": block.places["state.coupling.outcome"],
            "STATUS_AT": block.places["state.charge.status"],
            "CROWDED_AT": block.places["state.charge.clock"] + NUMBER * Clock.CROWDED,
            "CAPACITY_AT": block.entries["state.charge.pairs.partners"] + 3 * NUMBER,
        },
        wrench=(wrench, 6 * len(model.plan.carriers)),
    )
    return Interface(model, state, arguments, block, variables, inputs, made, whole)


def arguments_of(arguments: dict, name: str) -> np.ndarray:
    """Return an array by its dotted name."""
    first, *fields = name.split(".")
    value = arguments[first]
    for field in fields:
        value = getattr(value, field)
    return value
