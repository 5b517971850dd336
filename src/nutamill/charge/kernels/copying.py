"""Copies of a charge's state, for restoring and repeating a window, and for checkpoints."""

from typing import NamedTuple

import numpy as np

from nutamill.base.kernel import kernel
from nutamill.charge.model import PADDING, ChargeState, Clock

LIST, SAVED = int(Clock.LIST), int(Clock.SAVED)


def copied(part: NamedTuple) -> NamedTuple:
    """Return a copy of a struct of arrays and of the structs within it."""
    return part._make(copied(field) if isinstance(field, tuple) else np.copy(field) for field in part)


def checkpoint_arrays(state: ChargeState) -> dict[str, np.ndarray]:
    """Return all arrays of a state by name, those of a struct within it as ``saved_memory``.

    Impacts are left out: they are booked by thread, and `nutamill.charge.measures.statistics.gathered` sums
    them.
    """
    arrays = {}
    for name, field in state._asdict().items():
        if isinstance(field, np.ndarray):
            arrays[name] = field
        elif name != "impacts":
            arrays |= {f"{name}_{inner}": array for inner, array in field._asdict().items()}
    return arrays


@kernel
def copy_all(source, target_out):
    """Copy every number of an array to one of the same shape; an assignment of slices would allocate."""
    numbers, room = source.reshape(source.size), target_out.reshape(target_out.size)
    for k in range(numbers.size):
        room[k] = numbers[k]


@kernel
def copy_state(source: ChargeState, target_out: ChargeState):
    """Copy all that decides how `source` goes on to `target_out`, a state of the same charge and the same
    sizes.

    A repeated window then gives the same bits.  Of the neighbour lists only the current one, as far as it is
    filled, is copied.
    """
    copy_all(source.x, target_out.x)
    copy_all(source.v, target_out.v)
    copy_all(source.w, target_out.w)
    copy_all(source.mass_props, target_out.mass_props)
    copy_all(source.material, target_out.material)
    copy_all(source.ids, target_out.ids)
    copy_all(source.published_points, target_out.published_points)
    copy_all(source.published_rows, target_out.published_rows)
    lst = source.clock[LIST]
    copy_all(source.pairs.counts[2], target_out.pairs.counts[2])
    copy_all(source.clumps, target_out.clumps)
    for c in range(source.pairs.counts.shape[1] - 1):
        n = source.pairs.counts[lst, c]
        target_out.pairs.counts[lst, c] = n
        # behind the last pair: padding that the filter reads
        for k in range(min(n + PADDING, source.pairs.partners.shape[2])):
            target_out.pairs.partners[lst, c, k] = source.pairs.partners[lst, c, k]
            target_out.pairs.owners[lst, c, k] = source.pairs.owners[lst, c, k]
        for k in range(n):
            for e in range(8):
                target_out.pairs.memory[lst, c, k, e] = source.pairs.memory[lst, c, k, e]
    copy_all(source.wall_memory, target_out.wall_memory)
    copy_all(source.listed_at, target_out.listed_at)
    if source.clock[SAVED] == 1:
        copy_all(source.saved.memory, target_out.saved.memory)
        copy_all(source.saved.partners, target_out.saved.partners)
    copy_all(source.saved.counts, target_out.saved.counts)
    copy_all(source.poses, target_out.poses)
    copy_all(source.list_angle, target_out.list_angle)
    copy_all(source.last_dt, target_out.last_dt)
    copy_all(source.impacts.spectra, target_out.impacts.spectra)
    copy_all(source.impacts.cut, target_out.impacts.cut)
    copy_all(source.halt_speeds, target_out.halt_speeds)
    copy_all(source.impulse, target_out.impulse)
    copy_all(source.ledger, target_out.ledger)
    copy_all(source.largest_overlap, target_out.largest_overlap)
    copy_all(source.status, target_out.status)
    copy_all(source.clock, target_out.clock)
