"""The loop over contacts between particles of one chunk: select the touching candidates, then apply the law
to all of them.
"""

import numpy as np

from nutamill.base.kernel import kernel, like
from nutamill.charge.kernels.columns import pair_batch
from nutamill.charge.kernels.film_lanes import film_power, set_film
from nutamill.charge.kernels.impacts import note_pair_impacts
from nutamill.charge.kernels.loading import count_turned, note_pair_loading
from nutamill.charge.kernels.rows import HELD, LAW, MEMORY, WEIGHT, A, B
from nutamill.charge.kernels.simd import WIDTH, add_rows, gather_differences, gather_rows, set_rows, touching
from nutamill.charge.laws.lanes import BATCH
from nutamill.charge.laws.pair import LAW_NUMBERS

SET_BITS = np.array(
    [([e for e in range(WIDTH) if mask >> e & 1] + [0] * WIDTH)[:WIDTH] for mask in range(1 << WIDTH)],
    np.uint32,
)
"""Places of the bits that are set in each mask of eight, then zeros [1]."""

BIT_COUNTS = np.array([bin(mask).count("1") for mask in range(1 << WIDTH)], np.uint64)
"""Number of bits set in each mask of eight [1]."""


@kernel(fast=True, inline="always")
def filter_pairs(points, partners, owners, local, n_listed, lo, hi, lanes_out):
    """Select the touching pairs among the candidates of a chunk.

    Parameters
    ----------
    points : published positions and radii, fixed point (M, 4)
    partners, owners : slot of the second particle and position of the first one of each candidate
    local : `points` of the chunk with negative radius
    n_listed : number of candidates
    lo, hi : slots of the chunk
    lanes_out : rows are position of the first particle in the chunk, slot of the second, index in the list,
        position of the second in the chunk (or behind its end), slot of the first.  Behind the last pair come
        empty lanes up to a full batch

    Returns
    -------
    number of touching pairs
    """
    chunk = local.shape[0] - 1
    n = np.uint64(0)
    first, second, listed, second_in_chunk, first_slot = (
        lanes_out[0],
        lanes_out[1],
        lanes_out[2],
        lanes_out[3],
        lanes_out[4],
    )
    for k in range(0, n_listed, WIDTH):
        mask = touching(points, partners, local, owners, k)
        if k + WIDTH > n_listed:
            mask &= (1 << (n_listed - k)) - 1
        bits = np.uint64(mask)
        for e in range(np.uint64(WIDTH)):
            listed[n + e] = np.uint32(k) + SET_BITS[bits, e]
        n += BIT_COUNTS[bits]
    for q in range(n):
        k = listed[q]
        i, j = owners[k], partners[k]
        position = np.uint32(j - np.uint32(lo))  # slots before the chunk wrap to large numbers
        first[q] = i
        second[q] = j
        second_in_chunk[q] = position if position < np.uint32(hi - lo) else np.uint32(chunk)
        first_slot[q] = i + np.uint32(lo)
    for q in range(n, n + np.uint64(BATCH + WIDTH)):
        first[q] = chunk
        second[q] = lo
        listed[q] = partners.shape[0] - 1
        second_in_chunk[q] = chunk
        first_slot[q] = lo
    return np.int64(n)


@kernel(inline="always")
def set_law(model, law, b, columns_out):
    """Set the numbers of pair law `law` in lane `b`, unless they are there."""
    number = like(law, columns_out[0])
    if columns_out[HELD * BATCH + b] != number:
        columns_out[HELD * BATCH + b] = number
        for k in range(LAW_NUMBERS):
            columns_out[(LAW + k) * BATCH + b] = model.laws[law, k]
        set_film(model.law.film, model.laws, law, b, columns_out)


@kernel(fast=True, inline="always")
def pair_contacts(
    model,
    points,
    rows,
    material,
    lanes,
    local,
    n,
    last,
    now,
    dt,
    tid,
    memory_out,
    columns_out,
    forces_out,
    book_out,
):
    """Add the forces of all touching pairs of a chunk to `forces_out`, bring their memory up to date, and
    book the contacts that begin and those that turn.

    Parameters
    ----------
    points, rows : published positions and velocities
    material : of each slot
    lanes, local : as for `filter_pairs`
    n : number of touching pairs
    last, now : stamps of the last and of this substep [1]
    dt : substep [s]
    tid : number of this thread, whose page of `book_out` is used
    memory_out : contact memory of the chunk's list
    columns_out : work space of `pair_batch`
    forces_out : force [N] (3), spare, moment [N m] (3), spare, on each particle of the chunk, world axes

    Returns
    -------
    powers of normal, tangential and rolling part and of the film [W] (4), number of overlaps beyond their
    limit
    """
    real = columns_out[0]
    unit, reach = like(1.0 / model.scale, real), like(model.film_reach, real)
    zero, half, one = like(0.0, real), like(0.5, real), like(1.0, real)
    across = np.uint32(forces_out.shape[0] - 1)
    several = model.laws.shape[0] > 1
    books = book_out.on[0] > 0
    first_in_chunk, second, listed, second_in_chunk, first_slot = (
        lanes[0],
        lanes[1],
        lanes[2],
        lanes[3],
        lanes[4],
    )
    sum_n, sum_t, sum_r, sum_f = 0.0, 0.0, 0.0, 0.0
    beyond = 0.0
    for first in range(0, n, BATCH):
        m = min(BATCH, n - first)
        for g in range(0, m, WIDTH):
            q = first + g
            gather_differences(points, second, local, first_in_chunk, q, g, columns_out)
            gather_rows(rows, first_slot, q, g, A, columns_out)
            gather_rows(rows, second, q, g, B, columns_out)
            gather_rows(memory_out, listed, q, g, MEMORY, columns_out)
        for b in range(BATCH):
            columns_out[WEIGHT * BATCH + b] = (
                half if second_in_chunk[np.uint32(first) + np.uint32(b)] == across else one
            )
        for b in range(m, BATCH):
            columns_out[WEIGHT * BATCH + b] = zero
        if several:
            for b in range(m):
                set_law(
                    model,
                    model.law_of[material[first_slot[first + b]], material[second[first + b]]],
                    b,
                    columns_out,
                )
        power_n, power_t, power_r, over, begun = pair_batch(
            model.law, columns_out, unit, reach, last, now, dt
        )
        if books and begun > 0.0:
            note_pair_impacts(
                columns_out, lanes, material, first, across, model.law_of.shape[0], tid, book_out
            )
        if books and count_turned(model.law.normal, columns_out) > 0.0:
            note_pair_loading(
                model.law.normal,
                lanes,
                rows,
                material,
                memory_out,
                first,
                across,
                model.law_of.shape[0],
                dt,
                tid,
                columns_out,
                book_out,
            )
        sum_n += power_n
        sum_t += power_t
        sum_r += power_r
        sum_f += film_power(model.law.film, columns_out)
        beyond += over
        for g in range(0, m, WIDTH):
            q = first + g
            add_rows(first_in_chunk, q, columns_out, g, A, forces_out)
            add_rows(second_in_chunk, q, columns_out, g, B, forces_out)
            set_rows(listed, q, columns_out, g, MEMORY, memory_out)
    return sum_n, sum_t, sum_r, sum_f, beyond
