"""A sample of the work and the load of a charge on its walls, patch by patch."""

from nutamill.base.kernel import kernel, like
from nutamill.charge.kernels.chunks import slots_of_chunk
from nutamill.charge.kernels.columns import wall_batch
from nutamill.charge.kernels.dynamics import move_bodies
from nutamill.charge.kernels.rows import ACT, HELD, A
from nutamill.charge.kernels.wall_contacts import OVERLAP, find_walls, load_walls
from nutamill.charge.laws.lanes import BATCH
from nutamill.charge.model import Clock, stamp_of, without_law
from nutamill.charge.walls.patches import patch_of, whole
from nutamill.charge.walls.surfaces import place_surfaces

STEP, PUBLISHED = int(Clock.STEP), int(Clock.PUBLISHED)


@kernel(fast=True)
def sample_walls(model, state, scratch, plan, c, dt, tid, sums_out):
    """Add work and load of chunk `c` on the walls, as the next substep will meet them."""
    lo, hi = slots_of_chunk(state, c)
    buffer = state.clock[PUBLISHED]
    rows = state.published_rows[buffer]
    lanes, measured, columns = scratch.lanes[tid], scratch.measured[tid], scratch.columns[tid, 1]
    motion, surface_poses = scratch.motion[tid], scratch.surface_poses[tid]
    real = rows[0, 0]
    now, last = like(stamp_of(state.clock[STEP]), real), like(stamp_of(state.clock[STEP] - 1), real)
    walls, per, patches = sums_out.walls[tid], plan.per_wall, model.patches
    n_walls = find_walls(
        model.law.film,
        without_law(model),
        scratch.near,
        state.x,
        state.mass_props[0],
        0.0,
        scratch.local[tid],
        motion,
        surface_poses,
        lo,
        hi - lo,
        tid,
        lanes,
        measured,
        scratch.test[tid],
    )
    for q in range(n_walls, n_walls + BATCH):
        lanes[0, q], lanes[1, q], lanes[3, q], lanes[4, q] = (
            model.chunk,
            0,
            state.wall_memory.shape[0] - 1,
            model.n_bodies,
        )
    for first in range(0, n_walls, BATCH):
        m = min(BATCH, n_walls - first)
        load_walls(
            model,
            rows,
            state.wall_memory,
            state.material,
            scratch.twists[tid],
            lanes,
            measured,
            first,
            m,
            columns,
        )
        wall_batch(model.law, columns, last, now, like(dt, real))
        for b in range(m):
            slot, s = lanes[1, first + b], lanes[2, first + b]
            n0, n1, n2 = (
                float(measured[0, first + b]),
                float(measured[1, first + b]),
                float(measured[2, first + b]),
            )
            arm = state.mass_props[0, slot] - 0.5 * float(measured[OVERLAP, first + b])
            p = patch_of(
                patches,
                surface_poses[s],
                model.surface_size[s],
                s,
                state.x[0, slot] + arm * n0,
                state.x[1, slot] + arm * n1,
                state.x[2, slot] + arm * n2,
            )
            for k in range(3):
                walls[p, k] -= whole(columns[(ACT + k) * BATCH + b], per[k])
            load = -(
                columns[A * BATCH + b] * n0
                + columns[(A + 1) * BATCH + b] * n1
                + columns[(A + 2) * BATCH + b] * n2
            )
            walls[p, 3] += whole(load, per[3])
            walls[p, 4] += 1


@kernel
def sample_chunks_at_walls(model, state, scratch, plan, motions, first, end, tid, sums_out):
    """Add work and load of the chunks `first` to `end` on the walls. The other arguments are those of
    `sample`.
    """
    dt = state.last_dt[0]
    move_bodies(motions, 0.5 * dt, scratch.motion[tid], scratch.twists[tid])
    place_surfaces(without_law(model), scratch.motion[tid], scratch.surface_poses[tid])
    points = state.published_points[state.clock[PUBLISHED]]
    local, columns = scratch.local[tid], scratch.columns[tid, 1]
    for k in range(columns.shape[0]):
        columns[k] = 1.0
    for b in range(BATCH):
        columns[HELD * BATCH + b] = -1.0  # no law is loaded yet
    for c in range(first, end):
        lo, hi = slots_of_chunk(state, c)
        for l in range(hi - lo):
            for k in range(4):
                local[l, k] = points[lo + l, k]
        sample_walls(model, state, scratch, plan, c, dt, tid, sums_out)
