"""Copies of a charge's state, for restoring and repeating a window."""

from typing import Any

import numpy as np

from nutamill.base.kernel import copy_numbers, kernel
from nutamill.charge.kernels.team import thread_share
from nutamill.charge.model import PADDING, ChargeState, Clock

LIST, SAVED = int(Clock.LIST), int(Clock.SAVED)


def copied(part: Any) -> Any:
    """Return a copy of a struct of arrays and of the structs within it."""
    return part._make(copied(field) if isinstance(field, tuple) else np.copy(field) for field in part)


def state_arrays(state: ChargeState) -> dict[str, np.ndarray]:
    """Return all arrays of a state by name, those of a struct within it as ``saved_memory``.

    Impacts are left out: they are booked by thread, and `nutamill.charge.measures.totals.gathered` sums
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
def copy_share(source, target_out, tid, n_threads):
    """Copy the share of thread `tid` of the numbers of an array to one of the same shape."""
    numbers, target = source.reshape(source.size), target_out.reshape(target_out.size)
    first, end = thread_share(numbers.size, tid, n_threads)
    for k in range(first, end):
        target[k] = numbers[k]


@kernel
def copy_state(source: ChargeState, target_out: ChargeState, tid: int, n_threads: int):
    """Copy all that decides how `source` goes on to `target_out`, a state of the same charge and the same
    sizes. Called by all threads of a team, each for its share.

    A repeated window then gives the same bits.  Of the neighbour lists only the current one, as far as it is
    filled, is copied.
    """
    copy_share(source.x, target_out.x, tid, n_threads)
    copy_share(source.v, target_out.v, tid, n_threads)
    copy_share(source.w, target_out.w, tid, n_threads)
    copy_share(source.mass_props, target_out.mass_props, tid, n_threads)
    copy_share(source.material, target_out.material, tid, n_threads)
    copy_share(source.ids, target_out.ids, tid, n_threads)
    copy_share(source.published_points, target_out.published_points, tid, n_threads)
    copy_share(source.published_rows, target_out.published_rows, tid, n_threads)
    copy_share(source.clumps, target_out.clumps, tid, n_threads)
    copy_share(source.pairs.counts[2], target_out.pairs.counts[2], tid, n_threads)
    lst = source.clock[LIST]
    first, end = thread_share(source.pairs.counts.shape[1] - 1, tid, n_threads)
    for c in range(first, end):
        n = source.pairs.counts[lst, c]
        target_out.pairs.counts[lst, c] = n
        # behind the last pair: padding that the filter reads
        for k in range(min(n + PADDING, source.pairs.partners.shape[2])):
            target_out.pairs.partners[lst, c, k] = source.pairs.partners[lst, c, k]
            target_out.pairs.owners[lst, c, k] = source.pairs.owners[lst, c, k]
        for k in range(n):
            for e in range(8):
                target_out.pairs.memory[lst, c, k, e] = source.pairs.memory[lst, c, k, e]
    copy_share(source.wall_memory, target_out.wall_memory, tid, n_threads)
    copy_share(source.listed_x, target_out.listed_x, tid, n_threads)
    copy_share(source.listed_at, target_out.listed_at, tid, n_threads)
    if source.clock[SAVED] == 1:
        copy_share(source.saved.memory, target_out.saved.memory, tid, n_threads)
        copy_share(source.saved.partners, target_out.saved.partners, tid, n_threads)
        copy_share(source.saved.starts, target_out.saved.starts, tid, n_threads)
    copy_share(source.saved.counts, target_out.saved.counts, tid, n_threads)
    copy_share(source.impacts.spectra, target_out.impacts.spectra, tid, n_threads)
    copy_share(source.impacts.cut, target_out.impacts.cut, tid, n_threads)
    if tid == 0:
        copy_numbers(source.poses, target_out.poses)
        copy_numbers(source.list_angle, target_out.list_angle)
        copy_numbers(source.last_dt, target_out.last_dt)
        copy_numbers(source.halt_speeds, target_out.halt_speeds)
        copy_numbers(source.impulse, target_out.impulse)
        copy_numbers(source.ledger, target_out.ledger)
        copy_numbers(source.largest_overlap, target_out.largest_overlap)
        copy_numbers(source.status, target_out.status)
        copy_numbers(source.clock, target_out.clock)
