"""Checkpoints: everything a run needs to continue bit for bit, and a backup of the state in memory."""

import dataclasses

import numpy as np

from nutamill.case.machine import Machine
from nutamill.charge.kernels.copying import copied, state_arrays
from nutamill.charge.measures.totals import gathered
from nutamill.charge.measures.totals import put_back as put_back_sums
from nutamill.charge.saved_state import put_back, saved_arrays, saved_poses
from nutamill.simulation.setup.carriers import carriers_of
from nutamill.simulation.setup.charge import bed_in_carriers
from nutamill.simulation.setup.model import Model, Scratch, State

LARGEST_BACKUP = 2**28
"""Largest state of which a run makes a copy at every entry of the march [bytes]; a larger one falls back on
its newest checkpoint.
"""


def checkpoint_groups(
    model: Model, state: State, sums: dict[str, dict[str, np.ndarray]] | None = None
) -> dict[str, dict[str, np.ndarray]]:
    """Return the arrays of a checkpoint by group and name. `sums` are those of `sum_groups`, the present
    ones if None.
    """
    groups = {
        "mechanism": state.mechanism._asdict(),
        "coupling": state.coupling._asdict(),
        "record": {"first_row": state.first_row},
    }
    if state.grains is not None:
        groups["charge"] = state.grains.saved_arrays()
    elif model.charge is not None and state.charge is not None:
        groups["charge"] = saved_arrays(model.charge, state.charge)
    return groups | (sum_groups(model, state) if sums is None else sums)


def sum_groups(model: Model, state: State) -> dict[str, dict[str, np.ndarray]]:
    """Return the groups of a checkpoint that a backup has not: statistics and FMUs."""
    fmus = {} if state.exchange is None else state.exchange.groups(float(state.mechanism.time[0]))
    return statistics_group(model, state) | fmus


def statistics_group(model: Model, state: State) -> dict[str, dict[str, np.ndarray]]:
    """Return the group of a checkpoint with the present statistics, or no group for a run without charge."""
    if state.charge is None or state.statistics is None:
        return {}
    return {"statistics": gathered(state.statistics, state.charge.impacts)}


def restore(model: Model, state: State, scratch: Scratch, groups: dict[str, dict[str, np.ndarray]]) -> Model:
    """Put the arrays of a checkpoint into a state that has just been built, in place, make its neighbour
    lists anew, and return the model.
    """
    for part, struct in (("mechanism", state.mechanism), ("coupling", state.coupling)):
        for name, array in struct._asdict().items():
            array[...] = groups[part][name]
    state.first_row[...] = groups["record"]["first_row"]
    if state.exchange is not None:
        state.exchange.restore(groups, float(state.mechanism.time[0]))
    if model.charge is None or state.charge is None or scratch.charge is None:
        return model
    if "restart" in groups["charge"]:  # the particles are put back by LAMMPS
        if state.statistics is not None:
            put_back_sums(state.statistics, state.charge.impacts, groups["statistics"])
        return model
    charge, state.charge, scratch.charge = put_back(
        model.charge, state.charge, scratch.charge, groups["charge"], state.coupling.reference
    )
    if state.statistics is not None:
        put_back_sums(state.statistics, state.charge.impacts, groups["statistics"])
    return dataclasses.replace(model, charge=charge)


def backup(state: State, former: State | None) -> State | None:
    """Return a copy of `state`, made in place of the `former` backup where it fits, or None if it would be
    larger than `LARGEST_BACKUP`.

    The statistics are not copied: `statistics_group` saves their sums.  Particles in LAMMPS are not copied,
    there is no backup of them.
    """
    if state.grains is not None:
        return None
    arrays = _all_arrays(state)
    if sum(array.nbytes for array in arrays) > LARGEST_BACKUP:
        return None
    targets = [] if former is None else _all_arrays(former)
    if [array.shape for array in targets] != [array.shape for array in arrays]:
        charge = None if state.charge is None else copied(state.charge)
        return State(
            copied(state.mechanism),
            charge,
            state.statistics,
            copied(state.coupling),
            state.first_row.copy(),
        )
    for target, array in zip(targets, arrays, strict=True):
        np.copyto(target, array)
    return former


def _all_arrays(state: State) -> list[np.ndarray]:
    """Return all arrays of a state but the statistics."""
    charge = {} if state.charge is None else state_arrays(state.charge)
    return [*state.mechanism, *charge.values(), *state.coupling, state.first_row]


def placed_by_checkpoint(
    machine: Machine, groups: dict[str, dict[str, np.ndarray]]
) -> tuple[np.ndarray | None, np.ndarray | None]:
    """Return the bed of a checkpoint's particles and the poses of the carriers in it, as
    `nutamill.simulation.setup.model.build` takes them, or None for both without a charge.

    The model is built around them before `restore` puts in the exact state.
    """
    if "charge" not in groups:
        return None, None
    poses = saved_poses(groups["charge"])
    bodies = [carrier.body for carrier in carriers_of(machine)]
    of_carriers = np.column_stack([groups["mechanism"][name][bodies] for name in ("position", "quaternion")])
    attitudes = poses[:, 3:] if poses.shape[1] > 3 else None
    return bed_in_carriers(machine, poses[:, :3], attitudes, of_carriers), of_carriers
