"""Work of each thread of a team of 1 to 16 in a developed flow of the pellets:
``python benchmarks/shares.py``.

Chunks depend on the number of particles alone, so that results have the same bits on any number of threads;
threads share them by their work.  The table needs no cores: it counts pairs and particles, the work that
`nutamill.charge.kernels.chunks.weigh_groups` weighs, for each thread of a team.
"""

import time

import numpy as np

from nutamill.base.provenance import processor
from nutamill.charge.kernels.chunks import chunks_of_group, share_groups, slots_of_chunk, weigh_groups
from nutamill.charge.model import ChargeScratch, ChargeState, Clock
from nutamill.simulation.speed import developed_case, developed_flow
from nutamill.simulation.warm_up import warm_up

TEAMS = (1, 2, 4, 8, 12, 16)


def shares(state: ChargeState, scratch: ChargeScratch, threads: int) -> np.ndarray:
    """Return work [candidates], candidate pairs and particles of each thread of a team (threads, 3)."""
    lst = int(state.clock[Clock.LIST])
    weigh_groups(state, scratch, lst, 0, 1)
    out = np.zeros((threads, 3), np.int64)
    for tid in range(threads):
        first, end = share_groups(scratch.group_work, tid, threads)
        for g in range(first, end):
            out[tid, 0] += scratch.group_work[g]
            for c in range(*chunks_of_group(scratch, g)):
                lo, hi = slots_of_chunk(state, c)
                out[tid, 1:] += state.pairs.counts[lst, c], hi - lo
    return out


def main() -> None:
    """Print a line for each team, and one for each thread of the largest."""
    warm_up(print)
    model, flow, work = developed_flow(developed_case())
    chunks = len(work.charge.alarms)
    print(f"$ python benchmarks/shares.py      # {processor()}, {time.strftime('%Y-%m-%d')}")
    print(f"{model.charge.n_particles} particles in {chunks} chunks of at most {model.charge.chunk}")
    print("threads  with work  largest over mean work")
    for threads in TEAMS:
        each = shares(flow.charge, work.charge, threads)
        print(f"{threads:7d}  {(each[:, 0] > 0).sum():9d}  {each[:, 0].max() / each[:, 0].mean():22.2f}")
    for threads in TEAMS[3:]:
        each = shares(flow.charge, work.charge, threads)
        print(f"{threads} threads: pairs {' '.join(map(str, each[:, 1]))}")
        print(f"{'':{len(str(threads))}}      particles {' '.join(map(str, each[:, 2]))}")


if __name__ == "__main__":
    main()
