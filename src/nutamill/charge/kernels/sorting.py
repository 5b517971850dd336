"""Sorts in which every thread takes a share: slots by cell, and all arrays of the state along a Morton curve.

The order is that of a stable sort, whichever thread did what.
"""

import math

from nutamill.base.kernel import kernel, like
from nutamill.charge.kernels.chunks import cut_chunks
from nutamill.charge.kernels.clumps import CLUMP, number_clumps
from nutamill.charge.kernels.publish import publish
from nutamill.charge.kernels.team import barrier, thread_share
from nutamill.charge.model import ChargeModel, ChargeScratch, ChargeState, Clock, stamp_of

STEP, PUBLISHED = int(Clock.STEP), int(Clock.PUBLISHED)

BUCKETS = 256
"""Runs of neighbouring cells into which slots are parted first [1]."""

GRID_MARGIN = 4e-7
"""Margin of the cell grid on each side of the particles' centres, over the largest radius [1]."""


@kernel
def bucket_shift(n_cells):
    """Return the power of two [1] of cells in a bucket."""
    shift = 0
    while n_cells > BUCKETS << shift:
        shift += 1
    return shift


@kernel
def sort_by_cell(scratch, n, n_cells, tid, n_threads, order_out):
    """List the first `n` slots by ``scratch.lists.cell``, stably, in `order_out`. Called by all
    threads of the team.

    ``scratch.lists.counts[c]`` is the first index of cell c afterwards, up to that of `n_cells`.
    """
    lists = scratch.lists
    cell, tally, place, first = lists.cell, lists.tallies, lists.places[tid], lists.firsts[tid]
    shift = bucket_shift(n_cells)
    lo, hi = thread_share(n, tid, n_threads)
    for b in range(BUCKETS):
        tally[tid, b] = 0
    for i in range(lo, hi):
        tally[tid, cell[i] >> shift] += 1
    barrier(scratch.barrier, n_threads)
    whole = 0
    for b in range(BUCKETS):
        first[b] = whole
        for t in range(n_threads):
            if t == tid:
                place[b] = whole
            whole += tally[t, b]
    first[BUCKETS] = whole
    for i in range(lo, hi):
        b = cell[i] >> shift
        lists.bucketed[place[b]] = i
        place[b] += 1
    barrier(scratch.barrier, n_threads)
    # a cell costs a quarter of a slot: the thread into whose share the middle of a bucket's work falls
    work = 4 * n + (BUCKETS << shift)
    for b in range(BUCKETS):
        if (4 * (first[b] + first[b + 1]) + ((2 * b + 1) << shift)) * n_threads // (2 * work) == tid:
            sort_bucket(
                scratch, first[b], first[b + 1], b << shift, min((b + 1) << shift, n_cells), order_out
            )
    if tid == 0:
        lists.counts[n_cells] = n
    barrier(scratch.barrier, n_threads)


@kernel
def sort_bucket(scratch, first, end, lowest, highest, order_out):
    """Sort the slots ``scratch.lists.bucketed[first:end]``, whose cells are from `lowest` to below `highest`,
    by counting.
    """
    lists = scratch.lists
    cell, bucketed, counts = lists.cell, lists.bucketed, lists.counts
    for c in range(lowest, highest):
        counts[c] = 0
    for k in range(first, end):
        counts[cell[bucketed[k]]] += 1
    behind = first
    for c in range(lowest, highest):
        behind += counts[c]
        counts[c] = behind
    for k in range(end - 1, first - 1, -1):
        i = bucketed[k]
        counts[cell[i]] -= 1
        order_out[counts[cell[i]]] = i


@kernel
def find_bounds(scratch, x, n, margin, tid, n_threads):
    """Write corner and extents [m] of the box around the first `n` positions `x` (3, M) [m], and a `margin`
    [m] on each side, to ``scratch.lists.grid``. Called by all threads of the team.
    """
    bounds, grid = scratch.lists.bounds, scratch.lists.grid
    lo, hi = thread_share(n, tid, n_threads)
    for k in range(3):
        # of its own particles alone: other threads may not have written theirs yet
        low, high = math.inf, -math.inf
        for i in range(lo, hi):
            low = min(low, x[k, i])
            high = max(high, x[k, i])
        bounds[tid, k], bounds[tid, 3 + k] = low, high
    barrier(scratch.barrier, n_threads)
    if tid == 0:
        for k in range(3):
            low, high = bounds[0, k], bounds[0, 3 + k]
            for t in range(1, n_threads):
                low, high = min(low, bounds[t, k]), max(high, bounds[t, 3 + k])
            grid[k] = low - margin
            grid[3 + k] = high - low + 2.0 * margin
    barrier(scratch.barrier, n_threads)


@kernel
def morton_bits(n):
    """Return the bits along each axis of the Morton curve of `n` particles [1]."""
    bits = 1
    while bits < 7 and 8 ** (bits - 1) < n:
        bits += 1
    return bits


@kernel
def spread_bits(v):
    """Return the 10 low bits of `v` at every third position."""
    v = v & 0x3FF
    v = (v | v << 16) & 0x030000FF
    v = (v | v << 8) & 0x0300F00F
    v = (v | v << 4) & 0x030C30C3
    return (v | v << 2) & 0x09249249


@kernel
def morton_order(model, state, scratch, tid, n_threads):
    """Fill ``scratch.lists.source`` with the slots in Morton order."""
    n, places = model.n_particles, state.mass_props[CLUMP if state.clumps.shape[0] > 0 else 0]
    clumped = state.clumps.shape[0] > 0
    bits = morton_bits(n)
    find_bounds(scratch, state.x, n, GRID_MARGIN * model.largest_radius, tid, n_threads)
    grid = scratch.lists.grid
    h = (2**bits - 1e-6) / max(grid[3], max(grid[4], grid[5]))
    lo, hi = thread_share(n, tid, n_threads)
    # the pebbles of a clump stay together: all have the key of the first
    leader = lo
    while clumped and 0 < leader < n and places[leader - 1] == places[leader]:
        leader -= 1
    for i in range(lo, hi):
        if not clumped or places[i] != places[leader]:
            leader = i
        a = int((state.x[0, leader] - grid[0]) * h)
        b = int((state.x[1, leader] - grid[1]) * h)
        c = int((state.x[2, leader] - grid[2]) * h)
        scratch.lists.cell[i] = spread_bits(a) | spread_bits(b) << 1 | spread_bits(c) << 2
    sort_by_cell(scratch, n, 8**bits, tid, n_threads, scratch.lists.source)


@kernel
def reorder(scratch, n, tid, n_threads, column_out):
    """Bring one column of the state into the order of ``scratch.lists.source``."""
    lo, hi = thread_share(n, tid, n_threads)
    for i in range(lo, hi):
        scratch.lists.moved[i] = column_out[scratch.lists.source[i]]
    barrier(scratch.barrier, n_threads)
    for i in range(lo, hi):
        column_out[i] = scratch.lists.moved[i]
    barrier(scratch.barrier, n_threads)


@kernel
def sort_slots(model: ChargeModel, state: ChargeState, scratch: ChargeScratch, tid, n_threads):
    """Sort all slots along the Morton curve. Called by all threads of the team."""
    n = model.n_particles
    morton_order(model, state, scratch, tid, n_threads)
    for k in range(3):
        reorder(scratch, n, tid, n_threads, state.x[k])
        reorder(scratch, n, tid, n_threads, state.v[k])
        if state.clumps.shape[0] == 0:
            reorder(scratch, n, tid, n_threads, state.w[k])
    for k in range(state.mass_props.shape[0]):
        reorder(scratch, n, tid, n_threads, state.mass_props[k])
    if state.clumps.shape[0] > 0:
        number_clumps(state, scratch, n, tid, n_threads)
        if tid == 0:
            cut_chunks(model, state)
        barrier(scratch.barrier, n_threads)
    reorder(scratch, n, tid, n_threads, state.material)
    reorder(scratch, n, tid, n_threads, state.ids)
    rows = state.published_rows[state.clock[PUBLISHED]]
    for k in range(8):
        reorder(scratch, n, tid, n_threads, rows[:, k])
    lo, hi = thread_share(n, tid, n_threads)
    n_surfaces = model.surface_kind.shape[0]
    for i in range(lo, hi):
        for t in range(n_surfaces):
            for e in range(8):
                scratch.lists.moved_memory[i * n_surfaces + t, e] = state.wall_memory[
                    scratch.lists.source[i] * n_surfaces + t, e
                ]
    barrier(scratch.barrier, n_threads)
    last = like(stamp_of(state.clock[STEP] - 1), rows[0, 0])
    for i in range(lo, hi):
        for t in range(i * n_surfaces, (i + 1) * n_surfaces):
            for e in range(8):
                state.wall_memory[t, e] = scratch.lists.moved_memory[t, e]
            if abs(state.wall_memory[t, 6]) != last:
                state.wall_memory[t, 6] = like(0.0, last)
        publish(model, state, i)
    barrier(scratch.barrier, n_threads)
