"""Chunks of slots, and groups of chunks: who works on what, and in which order sums are added.

A group is one chunk, or, where there are more chunks than `MOST_GROUPS`, a run of neighbouring ones.  Threads
share groups, and each sums the chunks of its own; what is left for one thread to add up does not grow with
the charge.  Groups depend on the number of chunks alone, so that sums have the same bits on any number of
threads.
"""

from nutamill.base.kernel import kernel
from nutamill.charge.kernels.clumps import CLUMP
from nutamill.charge.kernels.team import thread_share

MOST_GROUPS = 256
"""Largest number of groups [1]."""


@kernel
def slots_of_chunk(state, c):
    """Return the first slot of chunk `c`, and the one behind its last."""
    return state.pairs.counts[2, c], state.pairs.counts[2, c + 1]


@kernel
def cut_chunks(model, state):
    """Cut the slots into chunks of whole clumps: the first slot of each chunk, to the last row of
    `PairLists.counts`.
    """
    n, bounds = model.n_particles, state.pairs.counts[2]
    clumped = state.clumps.shape[0] > 0
    places = state.mass_props[CLUMP if clumped else 0]
    lo = 0
    for c in range(bounds.shape[0]):
        bounds[c] = lo
        hi = min(lo + model.chunk, n)
        while clumped and hi < n and places[hi] == places[hi - 1]:
            hi -= 1
        lo = hi


@kernel
def chunks_of_group(scratch, g):
    """Return the first chunk of group `g`, and the one behind its last."""
    return thread_share(scratch.alarms.shape[0], g, scratch.group_work.shape[0])


@kernel
def weigh_groups(state, scratch, lst, tid, n_threads):
    """Write the cost of a substep of each group with list `lst`, in candidates, to ``scratch.group_work``.
    Called by all threads, each for its share.

    A particle, with its walls and its motion, costs as much as two candidates.
    """
    begin, end = thread_share(scratch.group_work.shape[0], tid, n_threads)
    for g in range(begin, end):
        work = 0
        first, last = chunks_of_group(scratch, g)
        for c in range(first, last):
            lo, hi = slots_of_chunk(state, c)
            work += state.pairs.counts[lst, c] + 2 * (hi - lo)
        scratch.group_work[g] = work


@kernel
def share_groups(work, tid, n_threads):
    """Return first and last-plus-one group of thread `tid`, so that all threads have about equal work.

    Which thread does which group changes no bit of the result.

    Parameters
    ----------
    work : cost of each group, as from `weigh_groups`
    tid, n_threads : number of this thread and size of the team
    """
    groups = work.shape[0]
    whole = 0
    for g in range(groups):
        whole += work[g]
    first, end, before = groups, 0, 0
    for g in range(groups):
        # the thread into whose share the middle of this group's work falls
        if (2 * before + work[g]) * n_threads // max(2 * whole, 1) == tid:
            first, end = min(first, g), g + 1
        before += work[g]
    return first, max(first, end)


@kernel
def sum_group(scratch, g):
    """Add the sums, works and alarms of the chunks of group `g`, in their order, to those of its first
    chunk.
    """
    first, end = chunks_of_group(scratch, g)
    alarms = scratch.alarms[first]
    for c in range(first + 1, end):
        alarms |= scratch.alarms[c]
        for k in range(scratch.work.shape[1]):
            scratch.work[first, k] += scratch.work[c, k]
        for b in range(scratch.sums.shape[1]):
            for k in range(6):
                scratch.sums[first, b, k] += scratch.sums[c, b, k]
    scratch.group_alarms[g] = alarms
