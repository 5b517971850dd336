"""A sample of the statistics of a charge, by all threads of a team."""

from nutamill.base.kernel import kernel
from nutamill.charge.kernels.dynamics import move_bodies
from nutamill.charge.kernels.team import thread_share
from nutamill.charge.measures.field_sample import sample_fields, sample_neighbours
from nutamill.charge.measures.statistics import ChargeStatistics, StatisticsPlan
from nutamill.charge.measures.wall_sample import sample_chunks_at_walls
from nutamill.charge.model import ChargeModel, ChargeScratch, ChargeState, without_law


@kernel
def sample(
    model: ChargeModel,
    state: ChargeState,
    scratch: ChargeScratch,
    plan: StatisticsPlan,
    motions,
    angle: float,
    sums_out: ChargeStatistics,
    tid: int,
    n_threads: int,
):
    """Take one sample between two windows. Called by all threads of a team, each for its share of the chunks.

    Nobody may change the state meanwhile, and the next sample may begin only after all threads have left this
    one; ``sums_out.samples`` is for the caller to count.

    Parameters
    ----------
    motions : (n_bodies, 19) motion of each body from now on, as `frames.MOTION_SIZE`, world axes
    angle : by which the grid is turned about the z axis of the body [rad]
    plan, sums_out : what is summed, and the sums
    """
    first, end = thread_share(scratch.alarms.shape[0], tid, n_threads)
    move_bodies(motions, 0.0, scratch.motion[tid], scratch.twists[tid])
    for c in range(first, end):
        sample_neighbours(without_law(model), state, scratch, c, tid, sums_out)
        sample_fields(without_law(model), state, scratch, plan, c, angle, tid, sums_out)
    sample_chunks_at_walls(model, state, scratch, plan, motions, first, end, tid, sums_out)
