"""Copies of a charge's state, for restoring and repeating a window, and for checkpoints."""

from nutamill.base.kernel import kernel
from nutamill.charge.model import PADDING, ChargeState, Clock

LIST, KEPT = int(Clock.LIST), int(Clock.KEPT)


@kernel
def copy_all(source, target):
    """Copy every number of an array to one of the same shape; an assignment of slices would allocate."""
    numbers, room = source.reshape(source.size), target.reshape(target.size)
    for k in range(numbers.size):
        room[k] = numbers[k]


@kernel
def copy_state(source: ChargeState, target: ChargeState):
    """Copy all that decides how `source` goes on to `target`, a state of the same charge with arrays of the
    same sizes.

    A repeated window then gives the same bits.  Of the neighbour lists only the current one, as far as it is
    filled, is copied.
    """
    copy_all(source.x, target.x)
    copy_all(source.v, target.v)
    copy_all(source.w, target.w)
    copy_all(source.body, target.body)
    copy_all(source.material, target.material)
    copy_all(source.ids, target.ids)
    copy_all(source.points, target.points)
    copy_all(source.rows, target.rows)
    lst = source.clock[LIST]
    copy_all(source.listed[2], target.listed[2])
    copy_all(source.clumps, target.clumps)
    for c in range(source.listed.shape[1] - 1):
        n = source.listed[lst, c]
        target.listed[lst, c] = n
        # behind the last pair: padding that the filter reads
        for k in range(min(n + PADDING, source.partners.shape[2])):
            target.partners[lst, c, k] = source.partners[lst, c, k]
            target.owners[lst, c, k] = source.owners[lst, c, k]
        for k in range(n):
            for e in range(8):
                target.memory[lst, c, k, e] = source.memory[lst, c, k, e]
    copy_all(source.wall_memory, target.wall_memory)
    copy_all(source.listed_at, target.listed_at)
    if source.clock[KEPT] == 1:
        copy_all(source.kept, target.kept)
        copy_all(source.kept_with, target.kept_with)
    copy_all(source.kept_count, target.kept_count)
    copy_all(source.poses, target.poses)
    copy_all(source.turn, target.turn)
    copy_all(source.impulse, target.impulse)
    copy_all(source.ledger, target.ledger)
    copy_all(source.largest_overlap, target.largest_overlap)
    copy_all(source.status, target.status)
    copy_all(source.clock, target.clock)
