"""What went wrong in a substep: names the particles, once, after a chunk raised an alarm."""

from nutamill.charge.clumps import ID, PLACE
from nutamill.charge.model import ChargeModel, ChargeScratch, ChargeState, Clock, LawColumn, Status
from nutamill.charge.neighbours import slots_of_chunk
from nutamill.charge.surfaces import surface_overlap
from nutamill.kernel import kernel

STEP, PUBLISHED, LIST = int(Clock.STEP), int(Clock.PUBLISHED), int(Clock.LIST)
LIMIT = int(LawColumn.LIMIT)
PAIR_OVERLAP, WALL_OVERLAP, OUTSIDE = int(Status.PAIR_OVERLAP), int(Status.WALL_OVERLAP), int(Status.OUTSIDE)


@kernel
def overlap_of(model, state, points, i, j):
    """Overlap [m] of slots `i` and `j` at the positions `points` were published for."""
    square = 0.0
    for k in range(3):
        gap = (float(points[j, k]) - float(points[i, k])) / model.scale
        square += gap * gap
    return state.body[0, i] + state.body[0, j] - square**0.5


@kernel
def particle_in(state, i):
    """Id of the particle that the sphere in slot `i` belongs to."""
    return int(state.clumps[int(state.body[PLACE, i]), ID]) if state.clumps.shape[0] > 0 else state.ids[i]


@kernel
def name_the_worst(model: ChargeModel, state: ChargeState, scratch: ChargeScratch):
    """Fill ``state.status`` with the contact that exceeds its limit most, or with a particle that left the domain.

    Works on the positions the forces of this substep were taken at, before the clock turns; called by one thread.
    """
    points, lst = state.points[state.clock[PUBLISHED]], state.clock[LIST]
    worst = 0.0
    status = state.status
    status[3] = state.clock[STEP]
    for c in range(scratch.alarms.shape[0]):
        lo, hi = slots_of_chunk(state, c)
        if scratch.alarms[c] & 2:
            for i in range(lo, hi):
                inside = True
                for k in range(3):
                    inside = inside and abs(state.x[k, i] - model.centre[k]) < model.reach
                if not inside:
                    status[0], status[1], status[2] = OUTSIDE, particle_in(state, i), -1
                    return
        if scratch.alarms[c] & 4:
            for p in range(state.listed[lst, c]):
                i, j = lo + state.owners[lst, c, p], state.partners[lst, c, p]
                law = model.law_of[state.material[i], state.material[j]]
                share = overlap_of(model, state, points, i, j) / (2.0 * min(state.body[0, i], state.body[0, j]))
                if share * model.laws[law, LIMIT] > worst:
                    worst = share * model.laws[law, LIMIT]
                    status[0], status[1], status[2] = PAIR_OVERLAP, particle_in(state, i), particle_in(state, j)
                    state.largest_overlap[2] = share
        if scratch.alarms[c] & 8:
            for i in range(lo, hi):
                x = model.centre[0] + float(points[i, 0]) / model.scale
                y = model.centre[1] + float(points[i, 1]) / model.scale
                z = model.centre[2] + float(points[i, 2]) / model.scale
                for s in range(model.surface_kind.shape[0]):
                    law = model.law_of[state.material[i], model.surface_material[s]]
                    overlap, _, _, _ = surface_overlap(
                        model.surface_kind, model.surface_size, scratch.placed[0], s, x, y, z, state.body[0, i]
                    )
                    share = overlap / (2.0 * state.body[0, i])
                    if share * model.laws[law, LIMIT] > worst:
                        worst = share * model.laws[law, LIMIT]
                        status[0], status[1], status[2] = WALL_OVERLAP, particle_in(state, i), s
                        state.largest_overlap[2] = share
