"""Moves the charge: one window of substeps inside the given motion of the walls.

Leapfrog.  With velocities v at the end of a substep and positions x half a substep later, one substep is

    a = forces(x, v*)/m + g,     v <- v + dt a,     x <- x + dt v,     v* = v + dt a/2

where v* is the velocity predicted for the next mid-substep, so that dashpots and friction are of second order too.

Source: D. C. Rapaport, "The Art of Molecular Dynamics Simulation", 2nd ed. 2004, section 3.5 (leapfrog).
"""

import numpy as np

from nutamill.charge.alarm import name_the_worst
from nutamill.charge.columns import HELD, LAW, PEAK
from nutamill.charge.contacts import filter_pairs, find_walls, pair_contacts, wall_contacts
from nutamill.charge.model import BATCH, ChargeModel, ChargeScratch, ChargeState, Clock
from nutamill.charge.neighbours import rebuild, thread_share, turning
from nutamill.charge.publish import fixed_point, publish
from nutamill.charge.surfaces import place_surfaces
from nutamill.charge.team import barrier
from nutamill.frames import pose_in_window, rotation_matrix, twist_in_window
from nutamill.kernel import kernel, like

STEP, PUBLISHED, LIST, LISTED, SINCE_SORT, REBUILDS, REBUILD, KEPT, DONE, CROWDED = (int(c) for c in Clock)

MOVED, LEFT, PAIR, WALL = 1, 2, 4, 8
"""Alarms of a chunk."""


@kernel
def start(model: ChargeModel, state: ChargeState, scratch: ChargeScratch, dt: float):
    """Make ready to march: half a drift, so that positions are staggered, and the first publication.

    Parameters
    ----------
    model, state, scratch : as `charge` made them, positions and velocities at the same time
    dt : substep [s]
    """
    rows = state.rows[state.clock[PUBLISHED]]
    for i in range(model.n_particles):
        rows[i, 3] = state.body[1, i]
        rows[i, 7] = state.body[0, i]
        for k in range(3):
            state.x[k, i] += 0.5 * dt * state.v[k, i]
            rows[i, k] = state.v[k, i] + 0.5 * dt * model.gravity[k]
            rows[i, 4 + k] = state.w[k, i]
        publish(model, state, i)
    state.clock[REBUILD] = 1
    state.turn[1] = dt


@kernel
def pose_of_body(motion, s, out):
    """Mass centre [m] (3) and rotation matrix [1] (9) of a body `s` seconds into a window, to ``out[0:12]``."""
    # out[12:16] is overwritten by the velocity afterwards
    pose_in_window(motion, s, out[0:3], out[12:16])
    rotation_matrix(out[12:16], out[3:12].reshape((3, 3)))


@kernel
def move_bodies(motions, s, out):
    """Poses and twists of all bodies `s` seconds into the window, to ``out`` (B, 18)."""
    for b in range(motions.shape[0]):
        pose_of_body(motions[b], s, out[b])
        twist_in_window(motions[b], s, out[b, 12:15], out[b, 15:18])


@kernel(fast=True, inline="always")
def integrate(model, state, lo, hi, forces, turned, point, dt, work):
    """Kick and drift the particles of one chunk, and publish them in the other buffer.

    Adds to `work` what the law's work misses because it used predicted velocities: with it, the ledger is exact.
    Returns the chunk's alarms.
    """
    now = state.clock[PUBLISHED]
    rows, new_rows, new_points, points = state.rows[now], state.rows[1 - now], state.points[1 - now], state.points[now]
    x0, x1, x2 = state.x[0], state.x[1], state.x[2]
    v0, v1, v2 = state.v[0], state.v[1], state.v[2]
    w0, w1, w2 = state.w[0], state.w[1], state.w[2]
    r0, r1, r2 = state.listed_at[0], state.listed_at[1], state.listed_at[2]
    mass, per_mass, per_inertia = state.body[1], state.body[2], state.body[3]
    by_pairs, by_walls = forces[0], forces[1]
    g0, g1, g2 = model.gravity[0], model.gravity[1], model.gravity[2]
    c0, c1, c2 = model.centre[0], model.centre[1], model.centre[2]
    t00, t01, t02 = turned[0, 0], turned[0, 1], turned[0, 2]
    t10, t11, t12 = turned[1, 0], turned[1, 1], turned[1, 2]
    t20, t21, t22 = turned[2, 0], turned[2, 1], turned[2, 2]
    half = 0.5 * dt
    slack = 0.2475 * model.skin * model.skin  # just under (skin/2)^2: two particles may approach each other
    reach, scale = model.reach, model.scale
    pair_n, pair_t, wall_n, wall_t, falling = 0.0, 0.0, 0.0, 0.0, 0.0
    moved, stayed = 0, 1
    # unsigned: a signed index could count from the end, and each access would ask
    begin = np.uint32(lo)
    for l in range(np.uint32(hi - lo)):
        i = begin + l
        p0, p1, p2 = float(by_pairs[l, 0]), float(by_pairs[l, 1]), float(by_pairs[l, 2])
        q0, q1, q2 = float(by_pairs[l, 4]), float(by_pairs[l, 5]), float(by_pairs[l, 6])
        f0, f1, f2 = float(by_walls[l, 0]), float(by_walls[l, 1]), float(by_walls[l, 2])
        m0, m1, m2 = float(by_walls[l, 4]), float(by_walls[l, 5]), float(by_walls[l, 6])
        a0 = half * (per_mass[i] * (p0 + f0) + g0)
        a1 = half * (per_mass[i] * (p1 + f1) + g1)
        a2 = half * (per_mass[i] * (p2 + f2) + g2)
        b0 = half * per_inertia[i] * (q0 + m0)
        b1 = half * per_inertia[i] * (q1 + m1)
        b2 = half * per_inertia[i] * (q2 + m2)
        # mean velocity over the substep, and how far the prediction was from it
        a, b, c = v0[i] + a0, v1[i] + a1, v2[i] + a2
        d, e, f = w0[i] + b0, w1[i] + b1, w2[i] + b2
        falling += mass[i] * (g0 * a + g1 * b + g2 * c)
        e0, e1, e2 = a - rows[i, 0], b - rows[i, 1], c - rows[i, 2]
        pair_n += p0 * e0 + p1 * e1 + p2 * e2
        wall_n += f0 * e0 + f1 * e1 + f2 * e2
        e0, e1, e2 = d - rows[i, 4], e - rows[i, 5], f - rows[i, 6]
        pair_t += q0 * e0 + q1 * e1 + q2 * e2
        wall_t += m0 * e0 + m1 * e1 + m2 * e2
        a, b, c = a + a0, b + a1, c + a2
        d, e, f = d + b0, e + b1, f + b2
        v0[i], v1[i], v2[i] = a, b, c
        w0[i], w1[i], w2[i] = d, e, f
        new_rows[i, 0], new_rows[i, 1], new_rows[i, 2], new_rows[i, 3] = a + a0, b + a1, c + a2, rows[i, 3]
        new_rows[i, 4], new_rows[i, 5], new_rows[i, 6], new_rows[i, 7] = d + b0, e + b1, f + b2, rows[i, 7]
        a, b, c = x0[i] + dt * a, x1[i] + dt * b, x2[i] + dt * c
        x0[i], x1[i], x2[i] = a, b, c
        e0 = a - point[0] - (t00 * r0[i] + t01 * r1[i] + t02 * r2[i])
        e1 = b - point[1] - (t10 * r0[i] + t11 * r1[i] + t12 * r2[i])
        e2 = c - point[2] - (t20 * r0[i] + t21 * r1[i] + t22 * r2[i])
        moved |= int(e0 * e0 + e1 * e1 + e2 * e2 > slack)
        a, b, c = a - c0, b - c1, c - c2
        stayed &= int((abs(a) < reach) & (abs(b) < reach) & (abs(c) < reach))
        new_points[i, 0], new_points[i, 1], new_points[i, 2] = fixed_point(a, scale), fixed_point(b, scale), fixed_point(c, scale)
        new_points[i, 3] = points[i, 3]
    work[0] += pair_n
    work[1] += pair_t
    work[3] += wall_n
    work[4] += wall_t
    work[7] = falling
    return MOVED * moved + LEFT * (1 - stayed)


@kernel(fast=True)
def chunk_substep(model, state, scratch, c, reference, dt, tid):
    """One substep of chunk `c`: pairs, walls, integration."""
    n = model.n_particles
    lo = c * model.chunk
    hi = min(n, lo + model.chunk)
    clock = state.clock
    buffer, lst = clock[PUBLISHED], clock[LIST]
    points, rows = state.points[buffer], state.rows[buffer]
    partners, memory = state.partners[lst, c], state.memory[lst, c]
    local, lanes, forces, work = scratch.local[tid], scratch.lanes[tid], scratch.forces[tid], scratch.work[c]
    real = rows[0, 0]
    now = like(clock[STEP] & 0xFFFFFF, real)
    last = like((clock[STEP] - 1) & 0xFFFFFF, real)
    step = like(dt, real)
    zero = like(0.0, real)
    forces.reshape(forces.size)[:] = zero
    begin = np.uint32(lo)
    for l in range(np.uint32(hi - lo)):
        i = begin + l
        local[l, 0], local[l, 1], local[l, 2], local[l, 3] = points[i, 0], points[i, 1], points[i, 2], -points[i, 3]
    found = filter_pairs(points, partners, state.owners[lst, c], local, state.listed[lst, c], lo, lanes)
    work[0], work[1], work[2], pair_alarm = pair_contacts(
        model, points, rows, memory, state.material, found, lanes, local, scratch.columns[tid, 0], last, now, step, forces[0],
        scratch.impacts, tid,
    )  # fmt: skip
    sums = scratch.sums[c]
    for b in range(model.n_bodies):
        for k in range(6):
            sums[b, k] = 0.0
    normals = scratch.normals[tid]
    placed = scratch.placed[tid]
    found = find_walls(model, state.x, state.body[0], local, placed, lo, hi - lo, lanes, normals, scratch.test[tid])
    work[3], work[4], work[5], work[6], wall_alarm = wall_contacts(
        model, state.x, state.body[0], rows, state.wall_memory, state.material, scratch.motion[tid], placed, found, lanes, normals,
        scratch.columns[tid, 1], last, now, step, forces[1], sums, scratch.impacts, tid,
    )  # fmt: skip
    alarms = integrate(model, state, lo, hi, forces, scratch.turned[tid], reference, dt, work)
    scratch.alarms[c] = alarms + PAIR * int(pair_alarm > 0) + WALL * int(wall_alarm > 0)


@kernel
def close_substep(model, state, scratch, dt):
    """Sum up a substep over the chunks, in fixed order, and turn the clock; called by one thread."""
    clock = state.clock
    alarms = 0
    for c in range(scratch.alarms.shape[0]):
        alarms |= scratch.alarms[c]
        for k in range(8):
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
    """Empty a thread's columns, and the impulse unless the window goes on after LISTS_FULL."""
    columns = scratch.columns[tid]
    for p in range(2):
        for k in range(columns.shape[1]):
            columns[p, k] = 1.0
        # no law held yet; a single law is laid once
        for b in range(BATCH):
            columns[p, HELD * BATCH + b] = -1.0
            columns[p, PEAK * BATCH + b] = 0.0
    for b in range(BATCH):
        for k in range(10):
            columns[0, (LAW + k) * BATCH + b] = model.laws[0, k]
    if tid == 0 and state.clock[DONE] == 0:
        for b in range(model.n_bodies):
            for k in range(6):
                state.impulse[b, k] = 0.0


@kernel
def close_window(model, state, scratch, motions, n_substeps, dt, tid, n_threads):
    """Hand over the largest overlaps and the poses of the bodies at the end of the window."""
    for p in range(2):
        peak = 0.0
        for b in range(BATCH):
            peak = max(peak, float(scratch.columns[tid, p, PEAK * BATCH + b]))
        scratch.peaks[tid, p] = peak
    barrier(scratch.barrier, n_threads)
    if tid == 0:
        for p in range(2):
            for t in range(n_threads):
                state.largest_overlap[p] = max(state.largest_overlap[p], scratch.peaks[t, p])
        for b in range(model.n_bodies):
            pose_of_body(motions[b], n_substeps * dt, scratch.motion[0, b])
            state.turn[1] = dt
            for k in range(12):
                state.poses[b, k] = scratch.motion[0, b, k]
    barrier(scratch.barrier, n_threads)


@kernel
def window(
    model: ChargeModel, state: ChargeState, scratch: ChargeScratch, motions, reference, n_substeps: int, dt: float, tid: int, n_threads: int
):
    """March the charge through one window; called by all threads of a team with the same arguments.

    Leaves in `state`: ``impulse`` of the window, cumulative ``ledger``, ``largest_overlap``, ``poses`` at the window's end, and
    ``status``.  With a status other than OK it returns at once; after LISTS_FULL, `grow` and call it again with the same
    arguments, and it finishes the window.

    Parameters
    ----------
    motions : (n_bodies, 19) motion of each body over the window, as `frames.MOTION_SIZE`, world axes
    reference : (8,) point [m] and axis [1] (unit, world axes), angle at the window's start [rad] and speed [rad/s] of a frame that turns
        with the charge.  It decides how often lists are rebuilt, and nothing else; speed 0 is always right
    n_substeps : number of substeps
    dt : substep [s]
    tid, n_threads : number of this thread and size of the team
    """
    clock = state.clock
    first, end = thread_share(scratch.alarms.shape[0], tid, n_threads)
    barrier(scratch.barrier, n_threads)
    done = clock[DONE]
    halted = state.status[0]
    if halted == 0:
        open_window(model, state, scratch, tid)
    barrier(scratch.barrier, n_threads)
    if halted != 0:
        return
    for j in range(done, n_substeps):
        if clock[REBUILD] == 1:
            rebuild(model, state, scratch, reference, reference[6] + (j + 0.5) * dt * reference[7], tid, n_threads)
            if state.status[0] != 0:
                if tid == 0:
                    clock[DONE] = j
                break
        move_bodies(motions, (j + 0.5) * dt, scratch.motion[tid])
        place_surfaces(model, scratch.motion[tid], scratch.placed[tid])
        turning(reference, reference[6] + (j + 1.5) * dt * reference[7] - state.turn[0], scratch.turned[tid])
        for c in range(first, end):
            chunk_substep(model, state, scratch, c, reference, dt, tid)
        barrier(scratch.barrier, n_threads)
        if tid == 0:
            close_substep(model, state, scratch, dt)
            clock[DONE] = j + 1 if j + 1 < n_substeps else 0
        barrier(scratch.barrier, n_threads)
        if state.status[0] != 0:
            break
    close_window(model, state, scratch, motions, n_substeps, dt, tid, n_threads)
