"""Lists of candidate pairs.

A pair within a chunk is listed once, a pair across two chunks in both: each chunk then sums all forces on its
own particles, and no two chunks write the same row.
"""

import math

from nutamill.base.kernel import kernel, like
from nutamill.charge.kernels.candidates import candidates_of, fill_cells
from nutamill.charge.kernels.chunks import slots_of_chunk, weigh_groups
from nutamill.charge.kernels.clumps import CLUMP
from nutamill.charge.kernels.inherited import inherit_memory, save_memory
from nutamill.charge.kernels.sorting import sort_slots
from nutamill.charge.kernels.team import barrier, thread_share
from nutamill.charge.model import PADDING, ChargeModel, ChargeScratch, ChargeState, Clock, Status

LIST, LISTED, SINCE_SORT, REBUILDS, REBUILD, SAVED, CROWDED, STEP = (
    int(c)
    for c in (
        Clock.LIST,
        Clock.LISTED,
        Clock.SINCE_SORT,
        Clock.REBUILDS,
        Clock.REBUILD,
        Clock.SAVED,
        Clock.CROWDED,
        Clock.STEP,
    )
)
LISTS_FULL = int(Status.LISTS_FULL)

REBUILDS_PER_SORT = 20
"""Rebuilds of the list after which the slots are sorted anew along the Morton curve [1]."""


@kernel(inline="always")
def largest_drift_squared(skin):
    """Return the square of the displacement since the list was made that asks for a new one [m^2], just under
    ``(skin/2)^2``: two particles may approach each other. `skin` is the gap of candidates less that across
    which a film acts [m].
    """
    return 0.2475 * skin * skin


@kernel
def without_own_clump(state, i, start, k, partners_out):
    """Remove the pebbles of its own clump from the candidates `start` to `k` of slot `i`, and return the new
    end.
    """
    new_end = start
    for p in range(start, k):
        if state.mass_props[CLUMP, partners_out[p]] != state.mass_props[CLUMP, i]:
            partners_out[new_end] = partners_out[p]
            new_end += 1
    return new_end


@kernel
def list_chunk(model, state, scratch, lst, c, lo, hi):
    """List the candidate pairs of chunk `c`, with the memory they inherit, and return 0 where the list is too
    small.
    """
    partners, owners, memory = (
        state.pairs.partners[lst, c],
        state.pairs.owners[lst, c],
        state.pairs.memory[lst, c],
    )
    room = partners.shape[0] - PADDING
    grid = scratch.lists.grid
    real = state.published_rows[0, 0, 0]
    # rounding of the positions relative to the grid, in the precision of the law
    slack = like(1.0 + 1e-5, real)
    k = 0
    for i in range(lo, hi):
        start = k
        x = like(state.listed_x[0, i] - grid[0], real)
        y = like(state.listed_x[1, i] - grid[1], real)
        z = like(state.listed_x[2, i] - grid[2], real)
        reach = like(state.mass_props[0, i] + model.skin, real) * slack
        for q in range(model.class_radius.shape[0]):
            radius = like(model.class_radius[q], real)
            k = candidates_of(scratch, i, lo, x, y, z, reach, q, radius, k, room, partners)
            if k < 0:
                return 0
        if state.clumps.shape[0] > 0:
            k = without_own_clump(state, i, start, k, partners)
        for p in range(start, k):
            owners[p] = i - lo
        inherit_memory(state, scratch, i, partners, start, k, memory)
    state.pairs.counts[lst, c] = k
    for p in range(k, k + PADDING):
        partners[p] = lo
        owners[p] = 0
    if 4 * k > 3 * room:
        state.clock[CROWDED] = 1
    return 1


@kernel
def vote(state, scratch, full, tid, n_threads):
    """Report LISTS_FULL if any thread had a list that is `full`, and return whether. Called by all threads of
    the team.
    """
    votes = scratch.lists.votes
    votes[tid] = full
    barrier(scratch.barrier, n_threads)
    full = 0
    for t in range(n_threads):
        full |= votes[t]
    if full != 0 and tid == 0:
        state.status[0] = LISTS_FULL
        state.status[3] = state.clock[STEP]
    barrier(scratch.barrier, n_threads)
    return full != 0


@kernel
def make_lists(
    model: ChargeModel, state: ChargeState, scratch: ChargeScratch, reference, lst, tid, n_threads
):
    """Make the neighbour list `lst` of the positions ``state.listed_x``, with the contact memory of
    ``state.saved``, and return 1 where it is too small for a chunk of this thread. Called by all threads of
    the team.

    The march and a resumed run both call it, so that a checkpoint need not hold the list.

    Parameters
    ----------
    reference : point [m] (3) and axis [1] (3) of the frame the displacement is measured in
    """
    lo, hi = thread_share(model.n_particles, tid, n_threads)
    for i in range(lo, hi):
        scratch.lists.slot_of[state.ids[i]] = i
        for k in range(3):
            state.listed_at[k, i] = state.listed_x[k, i] - reference[k]
    fill_cells(model, state, scratch, tid, n_threads)
    full = 0
    first, end = thread_share(scratch.alarms.shape[0], tid, n_threads)
    for c in range(first, end):
        lo, hi = slots_of_chunk(state, c)
        full |= 1 - list_chunk(model, state, scratch, lst, c, lo, hi)
    return full


@kernel
def rebuild(model: ChargeModel, state: ChargeState, scratch: ChargeScratch, reference, angle, tid, n_threads):
    """Make a new neighbour list, and sort the slots when it is time. Called by all threads of the team.

    Where the lists are too small ``state.status`` is LISTS_FULL, nothing is lost, and the next call begins
    anew.

    Parameters
    ----------
    reference : point [m] (3) and axis [1] (3) of the frame the displacement is measured in
    angle : present angle of that frame [rad]
    """
    clock = state.clock
    first, end = thread_share(scratch.alarms.shape[0], tid, n_threads)
    sort = clock[SAVED] == 0 and (clock[LISTED] == 0 or clock[SINCE_SORT] >= REBUILDS_PER_SORT)
    keep = clock[SAVED] == 0 and clock[LISTED] == 1
    fresh = clock[LISTED] == 0
    lst = 1 - clock[LIST]
    barrier(scratch.barrier, n_threads)
    full = 0
    for c in range(first, end):
        lo, hi = slots_of_chunk(state, c)
        if keep:
            full |= 1 - save_memory(state, c, lo, hi)
        if fresh:
            for i in range(lo, hi):
                state.saved.counts[state.ids[i]] = 0
    if vote(state, scratch, full, tid, n_threads):
        return
    if sort:
        sort_slots(model, state, scratch, tid, n_threads)
    lo, hi = thread_share(model.n_particles, tid, n_threads)
    for i in range(lo, hi):
        for k in range(3):
            state.listed_x[k, i] = state.x[k, i]
    if tid == 0:
        clock[SAVED] = 1
        if sort:
            clock[SINCE_SORT] = 0
    full = make_lists(model, state, scratch, reference, lst, tid, n_threads)
    if vote(state, scratch, full, tid, n_threads):
        return
    weigh_groups(state, scratch, lst, tid, n_threads)
    if tid == 0:
        clock[LIST] = lst
        clock[LISTED] = 1
        clock[SAVED] = 0
        clock[SINCE_SORT] += 1
        clock[REBUILDS] += 1
        clock[REBUILD] = 0
        state.list_angle[0] = angle
    barrier(scratch.barrier, n_threads)


@kernel
def rotation_about(reference, angle, R_out):
    """Write the rotation matrix (3, 3) by `angle` [rad] about the axis ``reference[3:6]`` (Rodrigues)."""
    x, y, z = reference[3], reference[4], reference[5]
    c, s = math.cos(angle), math.sin(angle)
    t = 1.0 - c
    R_out[0, 0], R_out[0, 1], R_out[0, 2] = t * x * x + c, t * x * y - s * z, t * x * z + s * y
    R_out[1, 0], R_out[1, 1], R_out[1, 2] = t * x * y + s * z, t * y * y + c, t * y * z - s * x
    R_out[2, 0], R_out[2, 1], R_out[2, 2] = t * x * z - s * y, t * y * z + s * x, t * z * z + c
