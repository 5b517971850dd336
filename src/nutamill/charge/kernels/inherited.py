"""Contact memory that passes from one list of candidate pairs to the next, by the ids of the two particles.

Memory of a pair is stored at both of its particles, that of a pair across two chunks at the particle whose
chunk it belongs to: every chunk writes only what belongs to its own particles.
"""

from nutamill.base.kernel import kernel, like
from nutamill.charge.model import Clock, stamp_of

STEP, LIST = int(Clock.STEP), int(Clock.LIST)

MANY = 32
"""Contacts of a particle [1] from which on memory is looked up at its partners, which have fewer."""


@kernel
def save_memory(state, c, lo, hi):
    """Copy the contacts alive in chunk `c`, slots `lo` to `hi`, to `SavedContacts`. Return 0 if there is too
    little room.
    """
    lst, saved, ids = state.clock[LIST], state.saved, state.ids
    last = like(stamp_of(state.clock[STEP] - 1), state.published_rows[0, 0, 0])
    memory, owners, partners = (
        state.pairs.memory[lst, c],
        state.pairs.owners[lst, c],
        state.pairs.partners[lst, c],
    )
    room = saved.partners.shape[1]
    for i in range(lo, hi):
        saved.counts[ids[i]] = 0
    for k in range(state.pairs.counts[lst, c]):
        if abs(memory[k, 6]) == last:
            saved.counts[ids[lo + owners[k]]] += 1
            if lo <= partners[k] < hi:
                saved.counts[ids[partners[k]]] += 1
    behind = c * room
    for i in range(lo, hi):
        saved.starts[ids[i]] = behind
        behind += saved.counts[ids[i]]
        saved.counts[ids[i]] = 0
    if behind > (c + 1) * room:
        return 0
    for k in range(state.pairs.counts[lst, c]):
        if abs(memory[k, 6]) == last:
            a, b = ids[lo + owners[k]], ids[partners[k]]
            save_contact(state, c, a, b, like(1.0, last), memory[k])
            if lo <= partners[k] < hi:
                save_contact(state, c, b, a, like(-1.0, last), memory[k])
    return 1


@kernel
def save_contact(state, c, a, b, sign, memory):
    """Store the `memory` (8,) of a contact of particle `a`, in chunk `c`, with particle `b`.

    `sign` [1] is -1 where the memory is that of `b` with `a`.
    """
    saved = state.saved
    at = saved.starts[a] + saved.counts[a] - c * saved.partners.shape[1]
    saved.counts[a] += 1
    saved.partners[c, at] = b
    for e in range(8):
        saved.memory[c, at, e] = memory[e] if e > 5 else sign * memory[e]


@kernel
def inherit_memory(state, scratch, i, partners, start, end, memory_out):
    """Write the memory of the candidates ``partners[start:end]`` of slot `i`. Those without one are marked as
    not in contact.
    """
    saved, ids = state.saved, state.ids
    size = saved.partners.size
    known, numbers = saved.partners.reshape(size), saved.memory.reshape((size, 8))
    zero, one = like(0.0, memory_out[0, 0]), like(1.0, memory_out[0, 0])
    for p in range(start, end):
        memory_out[p, 6] = zero
    a = ids[i]
    if saved.counts[a] <= MANY:
        for q in range(saved.starts[a], saved.starts[a] + saved.counts[a]):
            j = scratch.lists.slot_of[known[q]]
            for p in range(start, end):
                if partners[p] == j:
                    copy_memory(numbers[q], one, memory_out[p])
                    break
        return
    for p in range(start, end):
        b = ids[partners[p]]
        for q in range(saved.starts[b], saved.starts[b] + saved.counts[b]):
            if known[q] == a:
                copy_memory(numbers[q], -one, memory_out[p])
                break


@kernel
def copy_memory(memory, sign, memory_out):
    """Copy the memory of a contact (8,), with -1 for `sign` [1] as its other particle sees it."""
    for e in range(8):
        memory_out[e] = memory[e] if e > 5 else sign * memory[e]
