"""Copies of a charge's state, for restoring and repeating a window, and for checkpoints."""

from nutamill.charge.model import PADDING, ChargeState, Clock
from nutamill.kernel import kernel

LIST, KEPT = int(Clock.LIST), int(Clock.KEPT)


@kernel
def copy_state(source: ChargeState, target: ChargeState):
    """Copy all that decides how `source` goes on to `target`, a state of the same charge with arrays of the same sizes.

    A repeated window then gives the same bits.  Of the neighbour lists only the current one, as far as it is filled, is copied.
    """
    target.x[:] = source.x
    target.v[:] = source.v
    target.w[:] = source.w
    target.body[:] = source.body
    target.material[:] = source.material
    target.ids[:] = source.ids
    target.points[:] = source.points
    target.rows[:] = source.rows
    lst = source.clock[LIST]
    for c in range(source.listed.shape[1]):
        n = source.listed[lst, c]
        target.listed[lst, c] = n
        # behind the last pair: padding that the filter reads
        for k in range(min(n + PADDING, source.partners.shape[2])):
            target.partners[lst, c, k] = source.partners[lst, c, k]
            target.owners[lst, c, k] = source.owners[lst, c, k]
        for k in range(n):
            for e in range(8):
                target.memory[lst, c, k, e] = source.memory[lst, c, k, e]
    target.wall_memory[:] = source.wall_memory
    target.listed_at[:] = source.listed_at
    if source.clock[KEPT] == 1:
        target.kept[:] = source.kept
        target.kept_with[:] = source.kept_with
    target.kept_count[:] = source.kept_count
    target.poses[:] = source.poses
    target.turn[:] = source.turn
    target.impulse[:] = source.impulse
    target.ledger[:] = source.ledger
    target.largest_overlap[:] = source.largest_overlap
    target.status[:] = source.status
    target.clock[:] = source.clock
