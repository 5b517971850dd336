"""A sample of the statistics of a charge whose particles another program moves."""

from nutamill.base.kernel import kernel
from nutamill.charge.kernels.chunks import slots_of_chunk
from nutamill.charge.kernels.dynamics import move_bodies
from nutamill.charge.measures.field_sample import sample_fields
from nutamill.charge.measures.statistics import MOST_NEIGHBOURS
from nutamill.charge.measures.wall_sample import sample_chunks_at_walls
from nutamill.charge.model import without_law


@kernel
def sample_atoms(model, state, scratch, plan, motions, angle, touching, sums_out):
    """Take one sample of the atoms that `finish_atoms` has copied, as
    `nutamill.charge.measures.sampling.sample`.

    Parameters
    ----------
    state : with the wall memory of the atoms
    touching : touching neighbours of each atom [1] (n,)
    plan, motions, angle, sums_out : as `sample`
    """
    move_bodies(motions, 0.0, scratch.motion[0], scratch.twists[0])
    counts, chunks = scratch.lists.cell, scratch.alarms.shape[0]
    for c in range(chunks):
        lo, hi = slots_of_chunk(state, c)
        for i in range(lo, hi):
            counts[i] = int(touching[i])
            sums_out.neighbours[0, min(counts[i], MOST_NEIGHBOURS - 1)] += 1
        sample_fields(without_law(model), state, scratch, plan, c, angle, 0, sums_out)
    sample_chunks_at_walls(model, state, scratch, plan, motions, 0, chunks, 0, sums_out)
