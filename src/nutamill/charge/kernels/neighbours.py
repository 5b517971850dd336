"""Cell grid, Morton order, candidate pairs, and the transfer of contact memory from one list to the next.

A pair within a chunk is listed once, a pair across two chunks in both: each chunk then sums all forces on its
own particles, and no two chunks write the same row.
"""

import math

from nutamill.base.kernel import kernel, like
from nutamill.charge.kernels.clumps import CLUMP, cut_chunks, number_clumps
from nutamill.charge.kernels.publish import publish
from nutamill.charge.kernels.team import barrier
from nutamill.charge.model import PADDING, ChargeModel, ChargeScratch, ChargeState, Clock, Status, stamp_of

STEP, PUBLISHED, LIST, LISTED, SINCE_SORT, REBUILDS, REBUILD, SAVED, DONE, CROWDED = (int(c) for c in Clock)
LISTS_FULL = int(Status.LISTS_FULL)

REBUILDS_PER_SORT = 20
"""Rebuilds of the list after which the slots are sorted anew along the Morton curve [1]."""
GRID_MARGIN = 4e-7
"""Margin of the cell grid on each side of the particles' centres, over the largest radius [1]."""


@kernel(inline="always")
def largest_drift_squared(skin):
    """Return the square of the displacement since the list was made that asks for a new one [m^2], just under
    ``(skin/2)^2``: two particles may approach each other.
    """
    return 0.2475 * skin * skin


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
def thread_share(n, tid, n_threads):
    """Return first and last-plus-one of `n` items for thread `tid`."""
    return n * tid // n_threads, n * (tid + 1) // n_threads


@kernel
def slots_of_chunk(state, c):
    """Return the first slot of chunk `c`, and the one behind its last."""
    return state.pairs.counts[2, c], state.pairs.counts[2, c + 1]


@kernel
def chunk_share(state, tid, n_threads):
    """Return first and last-plus-one chunk of thread `tid`, so that all threads have about equal work.

    Which thread does which chunk changes no bit of the result.
    """
    lst, chunks = state.clock[LIST], state.pairs.counts.shape[1] - 1
    whole = 0
    for c in range(chunks):
        whole += work_of_chunk(state, lst, c)
    first, end, before = chunks, 0, 0
    for c in range(chunks):
        work = work_of_chunk(state, lst, c)
        # the thread into whose share the middle of this chunk's work falls
        if (2 * before + work) * n_threads // max(2 * whole, 1) == tid:
            first, end = min(first, c), c + 1
        before += work
    return first, max(first, end)


@kernel
def work_of_chunk(state, lst, c):
    """Return the cost of a substep of chunk `c` in candidates: a particle, with its walls and its motion,
    costs two.
    """
    lo, hi = slots_of_chunk(state, c)
    return state.pairs.counts[lst, c] + 2 * (hi - lo)


@kernel
def count_sort(cell, n, n_cells, counts_out, order_out):
    """Sort by counting, stably: `order_out` lists the slots by `cell`, ``counts_out[c]`` is the first index
    of cell c afterwards.
    """
    for c in range(n_cells + 2):
        counts_out[c] = 0
    for i in range(n):
        counts_out[cell[i] + 2] += 1
    for c in range(2, n_cells + 2):
        counts_out[c] += counts_out[c - 1]
    for i in range(n):
        c = cell[i] + 1
        order_out[counts_out[c]] = i
        counts_out[c] += 1


@kernel
def find_bounds(x, n, margin, grid_out):
    """Write corner and extents [m] of the box around the first `n` positions `x` (3, M) [m], and a `margin`
    [m] on each side, to ``grid_out[0:3]`` and ``grid_out[4:7]``.
    """
    for k in range(3):
        low, high = x[k, 0], x[k, 0]
        for i in range(n):
            low = min(low, x[k, i])
            high = max(high, x[k, i])
        grid_out[k] = low - margin
        grid_out[4 + k] = high - low + 2.0 * margin


@kernel
def fit_grid(smallest, most, grid_out, cells_out):
    """Cut the box of `grid_out` into cells of at least `smallest` [m], at most `most` of them, and return
    their number.
    """
    size = smallest
    while True:
        total = 1
        for k in range(3):
            cells_out[k] = int(grid_out[4 + k] / size) + 1
            total *= cells_out[k]
        if total <= most:
            break
        size *= 1.26
    grid_out[3] = size
    return total


@kernel
def save_memory(model, state, lo, hi, c):
    """Copy the contacts alive in chunk `c` to the table by particle. Return 0 if the table is too small."""
    lst = state.clock[LIST]
    last = like(stamp_of(state.clock[STEP] - 1), state.published_rows[0, 0, 0])
    memory = state.pairs.memory[lst, c]
    for i in range(lo, hi):
        state.saved.counts[state.ids[i]] = 0
    slots = state.saved.memory.shape[1]
    for k in range(state.pairs.counts[lst, c]):
        if abs(memory[k, 6]) == last:
            i = lo + state.pairs.owners[lst, c, k]
            j = state.pairs.partners[lst, c, k]
            a, b = state.ids[i], state.ids[j]
            inside = lo <= j < hi
            if state.saved.counts[a] >= slots or (inside and state.saved.counts[b] >= slots):
                return 0
            n = state.saved.counts[a]
            state.saved.counts[a] = n + 1
            state.saved.partners[a, n] = b
            for e in range(8):
                state.saved.memory[a, n, e] = memory[k, e]
            if inside:
                n = state.saved.counts[b]
                state.saved.counts[b] = n + 1
                state.saved.partners[b, n] = a
                for e in range(8):
                    state.saved.memory[b, n, e] = memory[k, e] if e > 5 else -memory[k, e]
    return 1


@kernel
def morton_order(model, state, scratch):
    """Fill ``scratch.lists.source`` with the slots in Morton order."""
    n = model.n_particles
    bits = morton_bits(n)
    find_bounds(state.x, n, GRID_MARGIN * model.largest_radius, scratch.lists.grid)
    extent = max(scratch.lists.grid[4], max(scratch.lists.grid[5], scratch.lists.grid[6]))
    h = (2**bits - 1e-6) / extent
    leader = 0
    for i in range(n):
        # the pebbles of a clump stay together: all have the key of the first
        if state.clumps.shape[0] == 0 or state.mass_props[CLUMP, i] != state.mass_props[CLUMP, leader]:
            leader = i
        a = int((state.x[0, leader] - scratch.lists.grid[0]) * h)
        b = int((state.x[1, leader] - scratch.lists.grid[1]) * h)
        c = int((state.x[2, leader] - scratch.lists.grid[2]) * h)
        scratch.lists.cell[i] = spread_bits(a) | spread_bits(b) << 1 | spread_bits(c) << 2
    count_sort(scratch.lists.cell, n, 8**bits, scratch.lists.counts, scratch.lists.source)


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
def sort_slots(model, state, scratch, tid, n_threads):
    """Sort all slots along the Morton curve."""
    n = model.n_particles
    if tid == 0:
        morton_order(model, state, scratch)
    barrier(scratch.barrier, n_threads)
    for k in range(3):
        reorder(scratch, n, tid, n_threads, state.x[k])
        reorder(scratch, n, tid, n_threads, state.v[k])
        if state.clumps.shape[0] == 0:
            reorder(scratch, n, tid, n_threads, state.w[k])
    for k in range(state.mass_props.shape[0]):
        reorder(scratch, n, tid, n_threads, state.mass_props[k])
    if state.clumps.shape[0] > 0:
        if tid == 0:
            number_clumps(state, scratch, n)
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


@kernel
def fill_cells(model, state, scratch):
    """Sort the slots into cells at least as large as the longest candidate distance."""
    n = model.n_particles
    longest = 2.0 * model.largest_radius + model.skin
    find_bounds(state.listed_x, n, GRID_MARGIN * model.largest_radius, scratch.lists.grid)
    total = fit_grid(longest, scratch.lists.counts.shape[0] - 2, scratch.lists.grid, scratch.lists.cells)
    h = 1.0 / scratch.lists.grid[3]
    n0, n1 = scratch.lists.cells[0], scratch.lists.cells[1]
    for i in range(n):
        a = int((state.listed_x[0, i] - scratch.lists.grid[0]) * h)
        b = int((state.listed_x[1, i] - scratch.lists.grid[1]) * h)
        c = int((state.listed_x[2, i] - scratch.lists.grid[2]) * h)
        scratch.lists.cell[i] = (c * n1 + b) * n0 + a
    count_sort(scratch.lists.cell, n, total, scratch.lists.counts, scratch.lists.order)


@kernel(fast=True)
def candidates_of(scratch, i, lo, x, y, z, reach, a, b, c, k, room, partners_out):
    """Append the candidates of slot `i` to `partners_out` from index `k` on.

    Parameters
    ----------
    i : slot
    lo : first slot of the chunk; slots before it are in other chunks
    x, y, z : centre from the corner of the cells [m]
    reach : radius + skin [m]
    a, b, c : its cell
    room : size of the list

    Returns
    -------
    new end of the list, -1 where there is no room
    """
    n0, n1, n2 = scratch.lists.cells[0], scratch.lists.cells[1], scratch.lists.cells[2]
    px, py, pz, pr = (
        scratch.lists.sorted[0],
        scratch.lists.sorted[1],
        scratch.lists.sorted[2],
        scratch.lists.sorted[3],
    )
    a0 = max(0, a - 1)
    a1 = min(n0 - 1, a + 1)
    for cell_z in range(max(0, c - 1), min(n2 - 1, c + 1) + 1):
        for cell_y in range(max(0, b - 1), min(n1 - 1, b + 1) + 1):
            row = (cell_z * n1 + cell_y) * n0
            begin, end = scratch.lists.counts[row + a0], scratch.lists.counts[row + a1 + 1]
            if k + end - begin > room:
                return -1
            for d in range(begin, end):
                j = scratch.lists.order[d]
                dx = px[d] - x
                dy = py[d] - y
                dz = pz[d] - z
                far = reach + pr[d]
                partners_out[k] = j
                k += int((dx * dx + dy * dy + dz * dz < far * far) & ((j > i) | (j < lo)))
    return k


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
    n0, n1 = scratch.lists.cells[0], scratch.lists.cells[1]
    real = state.published_rows[0, 0, 0]
    # rounding of the positions relative to the grid, in the precision of the law
    slack = like(1.0 + 1e-5, real)
    k = 0
    for i in range(lo, hi):
        start = k
        cell = scratch.lists.cell[i]
        x = like(state.listed_x[0, i] - scratch.lists.grid[0], real)
        y = like(state.listed_x[1, i] - scratch.lists.grid[1], real)
        z = like(state.listed_x[2, i] - scratch.lists.grid[2], real)
        reach = like(state.mass_props[0, i] + model.skin, real) * slack
        k = candidates_of(
            scratch, i, lo, x, y, z, reach, cell % n0, cell // n0 % n1, cell // (n0 * n1), k, room, partners
        )
        if k < 0:
            return 0
        if state.clumps.shape[0] > 0:
            k = without_own_clump(state, i, start, k, partners)
        for p in range(start, k):
            owners[p] = i - lo
            memory[p, 6] = like(0.0, real)
        a = state.ids[i]
        for q in range(state.saved.counts[a]):
            j = scratch.lists.slot_of[state.saved.partners[a, q]]
            for p in range(start, k):
                if partners[p] == j:
                    for e in range(8):
                        memory[p, e] = state.saved.memory[a, q, e]
                    break
    state.pairs.counts[lst, c] = k
    for p in range(k, k + PADDING):
        partners[p] = lo
        owners[p] = 0
    if 4 * k > 3 * room:
        state.clock[CROWDED] = 1
    return 1


@kernel
def make_lists(
    model: ChargeModel, state: ChargeState, scratch: ChargeScratch, reference, lst, tid, n_threads
):
    """Make the neighbour list `lst` of the positions ``state.listed_x``, with the contact memory of
    ``state.saved``. Called by all threads of the team.

    The march and a resumed run both call it, so that a checkpoint need not hold the list.  The alarm of a
    chunk is 1 where the list is too small.

    Parameters
    ----------
    reference : point [m] (3) and axis [1] (3) of the frame the displacement is measured in
    """
    n = model.n_particles
    if tid == 0:
        for i in range(n):
            scratch.lists.slot_of[state.ids[i]] = i
        fill_cells(model, state, scratch)
    barrier(scratch.barrier, n_threads)
    lo, hi = thread_share(n, tid, n_threads)
    real = state.published_rows[0, 0, 0]
    for d in range(lo, hi):
        i = scratch.lists.order[d]
        for k in range(3):
            scratch.lists.sorted[k, d] = like(state.listed_x[k, i] - scratch.lists.grid[k], real)
            state.listed_at[k, i] = state.listed_x[k, i] - reference[k]
        scratch.lists.sorted[3, d] = like(state.mass_props[0, i], real)
    barrier(scratch.barrier, n_threads)
    first, end = thread_share(scratch.alarms.shape[0], tid, n_threads)
    for c in range(first, end):
        lo, hi = slots_of_chunk(state, c)
        if list_chunk(model, state, scratch, lst, c, lo, hi) == 0:
            scratch.alarms[c] = 1
    barrier(scratch.barrier, n_threads)


@kernel
def collect(state, scratch):
    """Report LISTS_FULL if any chunk had too little room. Called by one thread."""
    full = False
    for c in range(scratch.alarms.shape[0]):
        full = full or scratch.alarms[c] != 0
    if full:
        state.status[0] = LISTS_FULL
        state.status[3] = state.clock[STEP]


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
    n = model.n_particles
    clock = state.clock
    first, end = thread_share(scratch.alarms.shape[0], tid, n_threads)
    sort = clock[SAVED] == 0 and (clock[LISTED] == 0 or clock[SINCE_SORT] >= REBUILDS_PER_SORT)
    keep = clock[SAVED] == 0 and clock[LISTED] == 1
    fresh = clock[LISTED] == 0
    barrier(scratch.barrier, n_threads)
    for c in range(first, end):
        lo, hi = slots_of_chunk(state, c)
        scratch.alarms[c] = 0
        if keep and save_memory(model, state, lo, hi, c) == 0:
            scratch.alarms[c] = 1
        if fresh:
            for i in range(lo, hi):
                state.saved.counts[state.ids[i]] = 0
    barrier(scratch.barrier, n_threads)
    if tid == 0:
        collect(state, scratch)
    barrier(scratch.barrier, n_threads)
    if state.status[0] == LISTS_FULL:
        return
    if sort:
        sort_slots(model, state, scratch, tid, n_threads)
    lo, hi = thread_share(n, tid, n_threads)
    for i in range(lo, hi):
        for k in range(3):
            state.listed_x[k, i] = state.x[k, i]
    if tid == 0:
        clock[SAVED] = 1
        if sort:
            clock[SINCE_SORT] = 0
    lst = 1 - clock[LIST]
    barrier(scratch.barrier, n_threads)
    make_lists(model, state, scratch, reference, lst, tid, n_threads)
    if tid == 0:
        collect(state, scratch)
        if state.status[0] != LISTS_FULL:
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
