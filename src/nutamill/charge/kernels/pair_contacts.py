"""The loop over contacts between particles of one chunk: which candidates touch, then the law for all that
do.
"""

import numpy as np

from nutamill.base.kernel import kernel, like
from nutamill.charge.kernels.columns import HELD, LAW, MEMORY, WEIGHT, A, B, pair_batch
from nutamill.charge.kernels.impacts import note_pair_impacts
from nutamill.charge.kernels.simd import WIDTH, add_rows, gather_differences, gather_rows, set_rows, touching
from nutamill.charge.laws.lanes import BATCH
from nutamill.charge.laws.pair import LAW_NUMBERS

PLACES = np.array(
    [([e for e in range(WIDTH) if mask >> e & 1] + [0] * WIDTH)[:WIDTH] for mask in range(1 << WIDTH)],
    np.uint32,
)
"""Places of the bits that are set in each mask of eight, then zeros [1]."""

BITS = np.array([bin(mask).count("1") for mask in range(1 << WIDTH)], np.uint64)
"""Number of bits set in each mask of eight [1]."""


@kernel(fast=True, inline="always")
def filter_pairs(points, partners, owners, local, n_listed, lo, hi, lanes):
    """Find the touching pairs among the candidates of a chunk.

    Rows of `lanes`: place of the first particle in the chunk, slot of the second, place in the list, place of
    the second in the chunk (or behind its end), slot of the first.  Behind the last pair come empty lanes up
    to a full batch.  Returns the number of pairs.
    """
    chunk = local.shape[0] - 1
    n = np.uint64(0)
    first, second, found, place_second, slot_first = lanes[0], lanes[1], lanes[2], lanes[3], lanes[4]
    for k in range(0, n_listed, WIDTH):
        mask = touching(points, partners, local, owners, k)
        if k + WIDTH > n_listed:
            mask &= (1 << (n_listed - k)) - 1
        bits = np.uint64(mask)
        for e in range(np.uint64(WIDTH)):
            found[n + e] = np.uint32(k) + PLACES[bits, e]
        n += BITS[bits]
    for q in range(n):
        k = found[q]
        i, j = owners[k], partners[k]
        place = np.uint32(j - np.uint32(lo))  # slots before the chunk wrap to large numbers
        first[q] = i
        second[q] = j
        place_second[q] = place if place < np.uint32(hi - lo) else np.uint32(chunk)
        slot_first[q] = i + np.uint32(lo)
    for q in range(n, n + np.uint64(BATCH + WIDTH)):
        first[q] = chunk
        second[q] = lo
        found[q] = partners.shape[0] - 1
        place_second[q] = chunk
        slot_first[q] = lo
    return np.int64(n)


@kernel(inline="always")
def hold_law(columns, b, laws, law):
    """Lay the numbers of pair law `law` into lane `b`, unless they are there."""
    number = like(law, columns[0])
    if columns[HELD * BATCH + b] != number:
        columns[HELD * BATCH + b] = number
        for k in range(LAW_NUMBERS):
            columns[(LAW + k) * BATCH + b] = laws[law, k]


@kernel(fast=True, inline="always")
def pair_contacts(
    model, points, rows, memory, material, n, lanes, local, columns, last, now, dt, forces, book, tid
):
    """Forces of all touching pairs of a chunk, added to `forces`; memory is brought up to date, contacts that
    begin are booked.

    Returns
    -------
    powers of normal, tangential and rolling part [W] (3), number of overlaps beyond their limit
    """
    real = columns[0]
    unit = like(1.0 / model.scale, real)
    zero, half, one = like(0.0, real), like(0.5, real), like(1.0, real)
    across = np.uint32(forces.shape[0] - 1)
    several = model.laws.shape[0] > 1
    first_place, second, found, second_place, first_slot = lanes[0], lanes[1], lanes[2], lanes[3], lanes[4]
    sum_n, sum_t, sum_r = 0.0, 0.0, 0.0
    beyond = 0.0
    for first in range(0, n, BATCH):
        m = min(BATCH, n - first)
        for g in range(0, m, WIDTH):
            q = first + g
            gather_differences(points, second, local, first_place, q, columns, g)
            gather_rows(rows, first_slot, q, columns, g, A)
            gather_rows(rows, second, q, columns, g, B)
            gather_rows(memory, found, q, columns, g, MEMORY)
        for b in range(BATCH):
            columns[WEIGHT * BATCH + b] = (
                half if second_place[np.uint32(first) + np.uint32(b)] == across else one
            )
        for b in range(m, BATCH):
            columns[WEIGHT * BATCH + b] = zero
        if several:
            for b in range(m):
                hold_law(
                    columns,
                    b,
                    model.laws,
                    model.law_of[material[first_slot[first + b]], material[second[first + b]]],
                )
        power_n, power_t, power_r, over, begun = pair_batch(model.law, columns, unit, last, now, dt)
        if begun > 0.0:
            note_pair_impacts(columns, first, lanes, across, material, model.law_of.shape[0], book, tid)
        sum_n += power_n
        sum_t += power_t
        sum_r += power_r
        beyond += over
        for g in range(0, m, WIDTH):
            q = first + g
            add_rows(forces, first_place, q, columns, g, A)
            add_rows(forces, second_place, q, columns, g, B)
            set_rows(memory, found, q, columns, g, MEMORY)
    return sum_n, sum_t, sum_r, beyond
