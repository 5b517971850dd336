"""Checkpoints: everything a run needs to continue bit for bit, and a backup of the state in memory."""

import numpy as np

from nutamill.base.errors import ResultError
from nutamill.case.machine import Machine
from nutamill.charge.kernels.clumps import POSE, ClumpColumn
from nutamill.charge.kernels.copying import copied
from nutamill.charge.measures.statistics import gathered, put_back
from nutamill.simulation.entry import grown
from nutamill.simulation.setup.carriers import carriers_of
from nutamill.simulation.setup.charge import bed_in_carriers
from nutamill.simulation.setup.model import Model, Scratch, State
from nutamill.simulation.setup.particles import particle_count

LARGEST_BACKUP = 2**28
"""Largest state of which a run makes a copy at every entry of the march [bytes]; a larger one falls back on
its newest checkpoint.
"""


def checkpoint_groups(model: Model, state: State) -> dict[str, dict[str, np.ndarray]]:
    """Return the arrays of a checkpoint by group and name."""
    return state.arrays() | statistics_group(model, state)


def statistics_group(model: Model, state: State) -> dict[str, dict[str, np.ndarray]]:
    """Return the group of a checkpoint with the present statistics, or no group for a run without charge."""
    if state.charge is None or state.statistics is None:
        return {}
    return {"statistics": gathered(state.statistics, state.charge.impacts)}


def restore(model: Model, state: State, scratch: Scratch, groups: dict[str, dict[str, np.ndarray]]) -> Model:
    """Put the arrays of a checkpoint into `state`, in place, and return the model, its lists as large as they
    were.

    Raises
    ------
    ResultError : neighbour lists of a size that this version does not make
    """
    if state.charge is not None:
        while state.charge.pairs.partners.shape != groups["charge"]["pairs_partners"].shape:
            if state.charge.pairs.partners.size > groups["charge"]["pairs_partners"].size:
                raise ResultError(
                    "checkpoint: its neighbour lists have a size that this version does not make. "
                    "Run the case again."
                )
            model = grown(model, state, scratch)
    for part, arrays in state.arrays().items():
        for name, array in arrays.items():
            array[...] = groups[part][name]
    if state.charge is not None and state.statistics is not None:
        put_back(state.statistics, state.charge.impacts, groups["statistics"])
    return model


def backup(state: State, former: State | None) -> State | None:
    """Return a copy of `state`, made in place of the `former` backup where it fits, or None if it would be
    larger than `LARGEST_BACKUP`.

    The statistics are not copied: `statistics_group` saves their sums.
    """
    arrays = [array for group in state.arrays().values() for array in group.values()]
    if sum(array.nbytes for array in arrays) > LARGEST_BACKUP:
        return None
    groups = {} if former is None else former.arrays()
    targets = [array for group in groups.values() for array in group.values()]
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


def bed_from_checkpoint(machine: Machine, groups: dict[str, dict[str, np.ndarray]]) -> np.ndarray | None:
    """Return the bed of a checkpoint's particles, as `nutamill.simulation.setup.model.build` takes it, or
    None without a charge.

    The model is built around them before `restore` puts in the exact state.
    """
    if "charge" not in groups:
        return None
    x, ids, clumps = (groups["charge"][name] for name in ("x", "ids", "clumps"))
    n = particle_count(machine)
    if len(clumps):
        poses = np.empty((n, 7))
        poses[clumps[:, ClumpColumn.ID].astype(int)] = clumps[:, POSE]
    else:
        poses = np.empty((n, 3))
        poses[ids[:n]] = x[:, :n].T
    bodies = [carrier.body for carrier in carriers_of(machine)]
    of_carriers = np.column_stack([groups["mechanism"][name][bodies] for name in ("position", "quaternion")])
    return bed_in_carriers(machine, poses[:, :3], poses[:, 3:] if len(clumps) else None, of_carriers)
