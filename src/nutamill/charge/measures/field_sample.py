"""A sample of the density, the velocity and the touching neighbours of a charge.

Fields are taken in a cylindrical grid that moves with a body and turns about its z axis by an angle handed
in, in a mill the crank angle, so that the crescent of a nutating charge stands still in it.  Velocities are
those relative to the body.
"""

import math

from nutamill.base.kernel import kernel
from nutamill.charge.kernels.chunks import slots_of_chunk
from nutamill.charge.kernels.pair_contacts import filter_pairs
from nutamill.charge.kernels.publish import fixed_point
from nutamill.charge.measures.statistics import MOST_NEIGHBOURS, POINTS
from nutamill.charge.model import Clock
from nutamill.charge.walls.patches import part_of, sector_of, whole

PUBLISHED, LIST = int(Clock.PUBLISHED), int(Clock.LIST)


@kernel
def sample_neighbours(model, state, scratch, c, tid, sums_out):
    """Count the touching neighbours of each particle of chunk `c`, to ``scratch.lists.cell``, and put them in
    the histogram.
    """
    lo, hi = slots_of_chunk(state, c)
    points, lst = state.published_points[state.clock[PUBLISHED]], state.clock[LIST]
    local, lanes, counts = scratch.local[tid], scratch.lanes[tid], scratch.lists.cell
    reach = fixed_point(model.film_reach, model.scale)
    for l in range(hi - lo):
        i = lo + l
        counts[i] = 0
        local[l, 0], local[l, 1], local[l, 2], local[l, 3] = (
            points[i, 0],
            points[i, 1],
            points[i, 2],
            reach - points[i, 3],
        )
    n_pairs = filter_pairs(
        points,
        state.pairs.partners[lst, c],
        state.pairs.owners[lst, c],
        local,
        state.pairs.counts[lst, c],
        lo,
        hi,
        lanes,
    )
    for q in range(n_pairs):
        counts[lanes[4, q]] += 1
        # a pair within the chunk is listed once
        if lanes[3, q] != local.shape[0] - 1:
            counts[lanes[1, q]] += 1
    for i in range(lo, hi):
        sums_out.neighbours[tid, min(counts[i], MOST_NEIGHBOURS - 1)] += 1


@kernel(inline="always")
def cell_of(plan, a, b, c, angle):
    """Return cell, distance from the axis [m] and azimuth [rad] in the body's axes of the point (a, b, c) [m]
    from the grid's origin.
    """
    radius = math.sqrt(a * a + b * b)
    azimuth = math.atan2(b, a)
    across, around, up = plan.cells[0], plan.cells[1], plan.cells[2]
    r = part_of(radius, 0.0, plan.extent[0], across)
    z = part_of(c, plan.extent[1], plan.extent[2], up)
    return (r * around + sector_of(azimuth - angle, around)) * up + z, radius


@kernel
def sample_fields(model, state, scratch, plan, c, angle, tid, sums_out):
    """Add the particles of chunk `c` to the fields. ``scratch.motion[tid]`` is the pose of the body."""
    lo, hi = slots_of_chunk(state, c)
    x, v, fields, per = state.x, state.v, sums_out.fields[tid], plan.per_field
    motion = scratch.motion[tid, plan.body]
    m0, m1, m2 = motion[0], motion[1], motion[2]
    R00, R01, R02, R10, R11, R12, R20, R21, R22 = (
        motion[3], motion[4], motion[5], motion[6], motion[7], motion[8], motion[9], motion[10], motion[11],
    )  # fmt: skip
    V0, V1, V2, W0, W1, W2 = motion[12], motion[13], motion[14], motion[15], motion[16], motion[17]
    back = 0.5 * state.last_dt[0]
    sample = sums_out.samples[0]
    for i in range(lo, hi):
        radius, mass = state.mass_props[0, i], plan.mass_of[state.ids[i]]
        v0, v1, v2 = v[0, i], v[1, i], v[2, i]
        d0, d1, d2 = x[0, i] - back * v0 - m0, x[1, i] - back * v1 - m1, x[2, i] - back * v2 - m2
        u0, u1, u2 = (
            v0 - V0 - (W1 * d2 - W2 * d1),
            v1 - V1 - (W2 * d0 - W0 * d2),
            v2 - V2 - (W0 * d1 - W1 * d0),
        )
        a = R00 * d0 + R10 * d1 + R20 * d2 - plan.origin[0]
        b = R01 * d0 + R11 * d1 + R21 * d2 - plan.origin[1]
        z = R02 * d0 + R12 * d1 + R22 * d2 - plan.origin[2]
        va, vb, vz = (
            R00 * u0 + R10 * u1 + R20 * u2,
            R01 * u0 + R11 * u1 + R21 * u2,
            R02 * u0 + R12 * u1 + R22 * u2,
        )
        k, r = cell_of(plan, a, b, z, angle)
        per_r = 1.0 / (r + 1e-300)
        fields[k, 1] += whole(mass, per[1])
        fields[k, 2] += whole(mass * (va * a + vb * b) * per_r, per[2])
        fields[k, 3] += whole(mass * (vb * a - va * b) * per_r, per[3])
        fields[k, 4] += whole(mass * vz, per[4])
        fields[k, 5] += whole(mass * (u0 * u0 + u1 * u1 + u2 * u2), per[5])
        fields[k, 6] += 1
        fields[k, 7] += scratch.lists.cell[i]
        q = (sample + 7919 * state.ids[i]) & (POINTS - 1)
        k, _ = cell_of(
            plan,
            a + radius * plan.within[q, 0],
            b + radius * plan.within[q, 1],
            z + radius * plan.within[q, 2],
            angle,
        )
        fields[k, 0] += whole(plan.volume_of[state.ids[i]], per[0])
