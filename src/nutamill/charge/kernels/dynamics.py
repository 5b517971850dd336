"""Moves the charge: one window of substeps inside the given motion of the walls.

Leapfrog.  With velocities v at the end of a substep and positions x half a substep later, one substep is

    a = forces(x, v*)/m + g,     v <- v + dt a,     x <- x + dt v,     v* = v + dt a/2

where v* is the velocity predicted for the next mid-substep, so that dashpots and friction are of second order
too.

Source: D. C. Rapaport, "The Art of Molecular Dynamics Simulation", 2nd ed. 2004, section 3.5 (leapfrog).
"""

from nutamill.base.frames import pose_in_window, rotation_matrix, twist_in_window
from nutamill.base.kernel import kernel, like
from nutamill.charge.kernels.alarm import name_the_worst
from nutamill.charge.kernels.chunks import (
    chunks_of_group,
    share_groups,
    slots_of_chunk,
    sum_group,
    weigh_groups,
)
from nutamill.charge.kernels.clump_integration import integrate_clumps
from nutamill.charge.kernels.clumps import start_clumps
from nutamill.charge.kernels.film_lanes import measured_radii, set_film
from nutamill.charge.kernels.integration import integrate_spheres
from nutamill.charge.kernels.neighbours import rebuild, rotation_about
from nutamill.charge.kernels.pair_contacts import filter_pairs, pair_contacts
from nutamill.charge.kernels.publish import publish
from nutamill.charge.kernels.rows import HELD, LAW, PEAK, PEAK_RADIUS
from nutamill.charge.kernels.simd import WIDTH, negated_radii
from nutamill.charge.kernels.team import barrier
from nutamill.charge.kernels.wall_contacts import find_walls, wall_contacts
from nutamill.charge.laws.lanes import BATCH
from nutamill.charge.laws.pair import LAW_NUMBERS
from nutamill.charge.model import (
    ChargeModel,
    ChargeScratch,
    ChargeState,
    Clock,
    Ledger,
    stamp_of,
    without_law,
)
from nutamill.charge.walls.surfaces import place_surfaces

STEP, PUBLISHED, LIST = int(Clock.STEP), int(Clock.PUBLISHED), int(Clock.LIST)
REBUILD, DONE = int(Clock.REBUILD), int(Clock.DONE)

PAIR_FILM, WALL_FILM = int(Ledger.PAIR_FILM), int(Ledger.WALL_FILM)

MOVED, LEFT, PAIR, WALL = 1, 2, 4, 8
"""Alarms of a chunk."""


@kernel
def start(model: ChargeModel, state: ChargeState, scratch: ChargeScratch, dt: float):
    """Make a charge ready to march: half a drift, so that positions are staggered, and the first publication.

    Parameters
    ----------
    model, state, scratch : as `charge` made them, positions and velocities at the same time
    dt : substep [s]
    """
    rows = state.published_rows[state.clock[PUBLISHED]]
    for i in range(model.n_particles):
        rows[i, 3] = state.mass_props[1, i]
        rows[i, 7] = state.mass_props[0, i]
    if state.clumps.shape[0] > 0:
        start_clumps(without_law(model), state, dt)
    for i in range(model.n_particles):
        for k in range(3 if state.clumps.shape[0] == 0 else 0):
            state.x[k, i] += 0.5 * dt * state.v[k, i]
            rows[i, k] = state.v[k, i] + 0.5 * dt * model.gravity[k]
            rows[i, 4 + k] = state.w[k, i]
        publish(without_law(model), state, i)
    state.clock[REBUILD] = 1
    state.last_dt[0] = dt


@kernel
def pose_of_body(motion, s, out):
    """Write mass centre [m] (3) and rotation matrix [1] (9) of a body `s` seconds into a window to
    ``out[0:12]``.
    """
    # out[12:16] is overwritten by the velocity afterwards
    pose_in_window(motion, s, out[0:3], out[12:16])
    rotation_matrix(out[12:16], out[3:12].reshape((3, 3)))


@kernel
def move_bodies(motions, s, out, twists_out):
    """Write poses and twists of all bodies `s` seconds into the window to `out` (B, 18), and their twists in
    the precision of the law to `twists_out`.
    """
    n = motions.shape[0]
    for b in range(n):
        pose_of_body(motions[b], s, out[b])
        twist_in_window(motions[b], s, out[b, 12:15], out[b, 15:18])
        for k in range(6):
            twists_out[b, k] = out[b, 12 + k]
        twists_out[b, 6] = b
    twists_out[n, 6] = n


@kernel(fast=True)
def chunk_substep(model, state, scratch, c, reference, dt, tid):
    """March chunk `c` by one substep: pairs, walls, integration."""
    lo, hi = slots_of_chunk(state, c)
    clock = state.clock
    buffer, lst = clock[PUBLISHED], clock[LIST]
    points, rows = state.published_points[buffer], state.published_rows[buffer]
    partners, memory = state.pairs.partners[lst, c], state.pairs.memory[lst, c]
    local, lanes, forces, work = scratch.local[tid], scratch.lanes[tid], scratch.forces[tid], scratch.work[c]
    real = rows[0, 0]
    now = like(stamp_of(clock[STEP]), real)
    last = like(stamp_of(clock[STEP] - 1), real)
    step = like(dt, real)
    zero = like(0.0, real)
    empty = forces.reshape(forces.size)
    for k in range(empty.size):
        empty[k] = zero
    for l in range(0, hi - lo, WIDTH):
        negated_radii(points, scratch.slots, lo + l, l, local)
    n_pairs = filter_pairs(
        points, partners, state.pairs.owners[lst, c], local, state.pairs.counts[lst, c], lo, hi, lanes
    )
    work[0], work[1], work[2], work[PAIR_FILM], pair_alarm = pair_contacts(
        model,
        points,
        rows,
        state.material,
        lanes,
        local,
        n_pairs,
        last,
        now,
        step,
        tid,
        memory,
        scratch.columns[tid, 0],
        forces,
        state.impacts,
    )
    sums = scratch.sums[c]
    for b in range(model.n_bodies):
        for k in range(6):
            sums[b, k] = 0.0
    measured, motion, surface_poses = scratch.measured[tid], scratch.motion[tid], scratch.surface_poses[tid]
    space, radius, reach = without_law(model), state.mass_props[0], model.film_reach
    n_walls = find_walls(
        model.law.film,
        space,
        scratch.near,
        state.x,
        measured_radii(model.law.film, radius, reach, lo, hi, scratch.lists.moved),
        reach,
        local,
        motion,
        surface_poses,
        lo,
        hi - lo,
        tid,
        lanes,
        measured,
        scratch.test[tid],
    )
    work[3], work[4], work[5], work[6], work[WALL_FILM], wall_alarm = wall_contacts(
        model,
        state.x,
        state.mass_props[0],
        rows,
        state.material,
        scratch.twists[tid],
        surface_poses,
        measured,
        n_walls,
        last,
        now,
        step,
        tid,
        lanes,
        state.wall_memory,
        scratch.columns[tid, 1],
        forces,
        sums,
        state.impacts,
    )
    if state.clumps.shape[0] > 0:
        moved, gone = integrate_clumps(space, state, scratch, forces, reference, lo, hi, dt, tid, work)
    else:
        moved, gone = integrate_spheres(space, state, scratch, forces, reference, lo, hi, dt, tid, work)
    scratch.alarms[c] = (
        MOVED * int(moved > 0)
        + LEFT * int(gone > 0)
        + PAIR * int(pair_alarm > 0)
        + WALL * int(wall_alarm > 0)
    )


@kernel
def close_substep(model, state, scratch, dt):
    """Sum a substep over the groups of chunks in fixed order and advance the clock. Called by one thread."""
    clock = state.clock
    alarms = 0
    for g in range(scratch.group_alarms.shape[0]):
        alarms |= scratch.group_alarms[g]
        c, _ = chunks_of_group(scratch, g)
        for k in range(state.ledger.size):
            state.ledger[k] += dt * scratch.work[c, k]
        for b in range(model.n_bodies):
            for k in range(6):
                state.impulse[b, k] += dt * scratch.sums[c, b, k]
    if alarms > MOVED:
        name_the_worst(model, state, scratch)
    clock[REBUILD] = alarms & MOVED
    clock[PUBLISHED] = 1 - clock[PUBLISHED]
    clock[STEP] += 1


@kernel
def open_window(model, state, scratch, tid):
    """Reset a thread's columns, and the impulse unless the window goes on after LISTS_FULL."""
    columns = scratch.columns[tid]
    for p in range(2):
        for k in range(columns.shape[1]):
            columns[p, k] = 1.0
        # no law is loaded yet; a single law is loaded once, below
        for b in range(BATCH):
            columns[p, HELD * BATCH + b] = -1.0
            columns[p, PEAK * BATCH + b] = 0.0
    for b in range(BATCH):
        for k in range(LAW_NUMBERS):
            columns[0, (LAW + k) * BATCH + b] = model.laws[0, k]
        set_film(model.law.film, model.laws, 0, b, columns[0])
    if tid == 0 and state.clock[DONE] == 0:
        for b in range(model.n_bodies):
            for k in range(6):
                state.impulse[b, k] = 0.0


@kernel
def close_window(model, state, scratch, motions, n_substeps, dt, tid, n_threads):
    """Collect the largest overlaps, and the poses of the bodies at the end of the window."""
    for p in range(2):
        peak = 0.0
        for b in range(BATCH):
            columns = scratch.columns[tid, p]
            peak = max(peak, float(columns[PEAK * BATCH + b]) / float(columns[PEAK_RADIUS * BATCH + b]))
        scratch.peaks[tid, p] = peak
    barrier(scratch.barrier, n_threads)
    if tid == 0:
        for p in range(2):
            for t in range(n_threads):
                state.largest_overlap[p] = max(state.largest_overlap[p], scratch.peaks[t, p])
        for b in range(model.n_bodies):
            pose_of_body(motions[b], n_substeps * dt, scratch.motion[0, b])
            state.last_dt[0] = dt
            for k in range(12):
                state.poses[b, k] = scratch.motion[0, b, k]
    barrier(scratch.barrier, n_threads)


@kernel
def window(
    model: ChargeModel,
    state: ChargeState,
    scratch: ChargeScratch,
    motions,
    reference,
    n_substeps: int,
    dt: float,
    tid: int,
    n_threads: int,
):
    """March the charge through one window. Called by all threads of a team with the same arguments.

    Leaves in `state`: ``impulse`` of the window, cumulative ``ledger``, ``largest_overlap``, ``poses`` at the
    window's end, and ``status``.  With a status other than OK it returns at once; after LISTS_FULL, `grow`
    and call it again with the same arguments, and it finishes the window.

    Parameters
    ----------
    motions : (n_bodies, 19) motion of each body over the window, as `frames.MOTION_SIZE`, world axes
    reference : (8,) point [m] and axis [1] (unit, world axes), angle at the window's start [rad] and speed
        [rad/s] of a frame that turns with the charge.  It decides how often lists are rebuilt, and nothing
        else; speed 0 is always right
    n_substeps : number of substeps
    dt : substep [s]
    tid, n_threads : number of this thread and size of the team
    """
    clock, space = state.clock, without_law(model)
    barrier(scratch.barrier, n_threads)
    done = clock[DONE]
    halted = state.status[0]
    if halted == 0:
        open_window(model, state, scratch, tid)
        weigh_groups(state, scratch, clock[LIST], tid, n_threads)
    barrier(scratch.barrier, n_threads)
    if halted != 0:
        return
    first, end = share_groups(scratch.group_work, tid, n_threads)
    for j in range(done, n_substeps):
        if clock[REBUILD] == 1:
            rebuild(
                space, state, scratch, reference, reference[6] + (j + 0.5) * dt * reference[7], tid, n_threads
            )
            if state.status[0] != 0:
                if tid == 0:
                    clock[DONE] = j
                break
            first, end = share_groups(scratch.group_work, tid, n_threads)
        move_bodies(motions, (j + 0.5) * dt, scratch.motion[tid], scratch.twists[tid])
        place_surfaces(space, scratch.motion[tid], scratch.surface_poses[tid])
        rotation_about(
            reference,
            reference[6] + (j + 1.5) * dt * reference[7] - state.list_angle[0],
            scratch.rotation[tid],
        )
        for g in range(first, end):
            begin, behind = chunks_of_group(scratch, g)
            for c in range(begin, behind):
                chunk_substep(model, state, scratch, c, reference, dt, tid)
            sum_group(scratch, g)
        barrier(scratch.barrier, n_threads)
        if tid == 0:
            close_substep(space, state, scratch, dt)
            clock[DONE] = j + 1 if j + 1 < n_substeps else 0
        barrier(scratch.barrier, n_threads)
        if state.status[0] != 0:
            break
    close_window(space, state, scratch, motions, n_substeps, dt, tid, n_threads)
