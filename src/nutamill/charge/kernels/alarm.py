"""Messages of an alarm: the particles that raised it in a substep, their overlap and their speeds."""

import math

from nutamill.base.frames import cross
from nutamill.base.kernel import kernel
from nutamill.charge.kernels.chunks import slots_of_chunk
from nutamill.charge.kernels.clumps import CLUMP, ID
from nutamill.charge.laws.pair import LawColumn
from nutamill.charge.model import ChargeModel, ChargeScratch, ChargeState, Clock, Status
from nutamill.charge.walls.walls import wall_overlap

STEP, PUBLISHED, LIST = int(Clock.STEP), int(Clock.PUBLISHED), int(Clock.LIST)
LIMIT = int(LawColumn.LIMIT)
PAIR_OVERLAP, WALL_OVERLAP, OUTSIDE = int(Status.PAIR_OVERLAP), int(Status.WALL_OVERLAP), int(Status.OUTSIDE)


@kernel
def overlap_of(model, state, points, i, j):
    """Return the overlap [m] of slots `i` and `j` at the positions `points` were published for."""
    square = 0.0
    for k in range(3):
        gap = (float(points[j, k]) - float(points[i, k])) / model.scale
        square += gap * gap
    return state.mass_props[0, i] + state.mass_props[0, j] - square**0.5


@kernel
def particle_in(state, i):
    """Return the id of the particle that the sphere in slot `i` belongs to."""
    return (
        int(state.clumps[int(state.mass_props[CLUMP, i]), ID]) if state.clumps.shape[0] > 0 else state.ids[i]
    )


@kernel
def length(a0, a1, a2):
    """Return the length of a vector."""
    return math.sqrt(a0 * a0 + a1 * a1 + a2 * a2)


@kernel
def note_pair_speeds(points, rows, i, j, speeds_out):
    """Write the speeds of slots `i` and `j` and how fast they close [m/s] to `speeds_out` (3,)."""
    n0, n1, n2 = (
        float(points[j, 0]) - points[i, 0],
        float(points[j, 1]) - points[i, 1],
        float(points[j, 2]) - points[i, 2],
    )
    u0, u1, u2 = rows[i, 0] - rows[j, 0], rows[i, 1] - rows[j, 1], rows[i, 2] - rows[j, 2]
    speeds_out[0] = length(rows[i, 0], rows[i, 1], rows[i, 2])
    speeds_out[1] = length(rows[j, 0], rows[j, 1], rows[j, 2])
    speeds_out[2] = (u0 * n0 + u1 * n1 + u2 * n2) / length(n0, n1, n2)


@kernel
def note_wall_speeds(rows, i, radius, x0, x1, x2, motion, n0, n1, n2, speeds_out):
    """Write the speeds of slot `i` and of the surface where it touches, and how fast they close [m/s], to
    `speeds_out` (3,).

    `x` : centre of the particle [m], world; `motion` (18,) of the body as in `ChargeScratch`; `n` : normal
    [1].
    """
    r0, r1, r2 = x0 + radius * n0 - motion[0], x1 + radius * n1 - motion[1], x2 + radius * n2 - motion[2]
    w0, w1, w2 = cross(motion[15], motion[16], motion[17], r0, r1, r2)
    w0, w1, w2 = w0 + motion[12], w1 + motion[13], w2 + motion[14]
    speeds_out[0] = length(rows[i, 0], rows[i, 1], rows[i, 2])
    speeds_out[1] = length(w0, w1, w2)
    speeds_out[2] = (rows[i, 0] - w0) * n0 + (rows[i, 1] - w1) * n1 + (rows[i, 2] - w2) * n2


@kernel
def name_a_lost_one(model, state, scratch, rows, lo, hi):
    """Report a particle of the slots `lo` to `hi` that left the domain or whose position is not a number, and
    return whether there is one.
    """
    for i in range(lo, hi):
        inside = True
        for k in range(3):
            inside = inside and abs(state.x[k, i] - model.centre[k]) < model.reach
        if not inside:
            state.status[0], state.status[1], state.status[2] = OUTSIDE, particle_in(state, i), -1
            state.halt_speeds[0] = length(rows[i, 0], rows[i, 1], rows[i, 2])
            return True
    return False


@kernel
def name_the_deepest_pair(model, state, scratch, points, rows, c, lo, worst):
    """Report the pair of chunk `c` that exceeds its limit most, if by more than `worst` [1], and return the
    larger excess.
    """
    lst = state.clock[LIST]
    for p in range(state.pairs.counts[lst, c]):
        i, j = lo + state.pairs.owners[lst, c, p], state.pairs.partners[lst, c, p]
        law = model.law_of[state.material[i], state.material[j]]
        share = overlap_of(model, state, points, i, j) / (
            2.0 * min(state.mass_props[0, i], state.mass_props[0, j])
        )
        if share * model.laws[law, LIMIT] > worst:
            worst = share * model.laws[law, LIMIT]
            state.status[0], state.status[1], state.status[2] = (
                PAIR_OVERLAP,
                particle_in(state, i),
                particle_in(state, j),
            )
            state.largest_overlap[2] = share
            note_pair_speeds(points, rows, i, j, state.halt_speeds)
    return worst


@kernel
def name_the_deepest_wall(model, state, scratch, points, rows, lo, hi, worst):
    """Report the wall contact of the slots `lo` to `hi` that exceeds its limit most, if by more than `worst`
    [1], and return the larger excess.
    """
    for i in range(lo, hi):
        r = state.mass_props[0, i]
        x = model.centre[0] + float(points[i, 0]) / model.scale
        y = model.centre[1] + float(points[i, 1]) / model.scale
        z = model.centre[2] + float(points[i, 2]) / model.scale
        for s in range(model.surface_kind.shape[0]):
            law = model.law_of[state.material[i], model.surface_material[s]]
            overlap, n0, n1, n2 = wall_overlap(
                model.surface_kind[s], model, scratch.surface_poses[0], s, x, y, z, r
            )
            share = overlap / (2.0 * r)
            if share * model.laws[law, LIMIT] > worst:
                worst = share * model.laws[law, LIMIT]
                state.status[0], state.status[1], state.status[2] = WALL_OVERLAP, particle_in(state, i), s
                state.largest_overlap[2] = share
                note_wall_speeds(
                    rows,
                    i,
                    r,
                    x,
                    y,
                    z,
                    scratch.motion[0, model.surface_body[s]],
                    n0,
                    n1,
                    n2,
                    state.halt_speeds,
                )
    return worst


@kernel
def name_the_worst(model: ChargeModel, state: ChargeState, scratch: ChargeScratch):
    """Fill ``state.status`` with the contact that exceeds its limit most, or with a particle that left the
    domain.

    Works on the positions and velocities at which the forces of this substep were computed, before the clock
    advances; called by one thread.
    """
    points, rows = (
        state.published_points[state.clock[PUBLISHED]],
        state.published_rows[state.clock[PUBLISHED]],
    )
    worst = 0.0
    state.status[3] = state.clock[STEP]
    for c in range(scratch.alarms.shape[0]):
        lo, hi = slots_of_chunk(state, c)
        if scratch.alarms[c] & 2 and name_a_lost_one(model, state, scratch, rows, lo, hi):
            return
        if scratch.alarms[c] & 4:
            worst = name_the_deepest_pair(model, state, scratch, points, rows, c, lo, worst)
        if scratch.alarms[c] & 8:
            worst = name_the_deepest_wall(model, state, scratch, points, rows, lo, hi, worst)
