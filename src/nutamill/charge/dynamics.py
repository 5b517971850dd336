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
from nutamill.charge.model import BATCH, ChargeModel, ChargeScratch, ChargeState, Clock, Ledger
from nutamill.charge.neighbours import rebuild, thread_share, turning
from nutamill.charge.publish import publish
from nutamill.charge.simd import WIDTH, copy_lanes, gather_rows, negated_radii, set_points, set_rows
from nutamill.charge.surfaces import place_surfaces
from nutamill.charge.team import barrier
from nutamill.frames import pose_in_window, rotation_matrix, twist_in_window
from nutamill.kernel import kernel, like

STEP, PUBLISHED, LIST, LISTED, SINCE_SORT, REBUILDS, REBUILD, KEPT, DONE, CROWDED = (int(c) for c in Clock)

GRAVITY, SCHEME = int(Ledger.GRAVITY), int(Ledger.SCHEME)

FORCE, ROW = 0, 8 * BATCH
"""Where the columns of `integrate_batch` begin: force and moment; what the law sees of a particle."""

X, V, W, LISTED_AT, MASS = (k * BATCH for k in (0, 3, 6, 9, 12))
"""Where its rows in double precision begin: position, velocity, spin, position when the list was made; mass, 1/mass, 1/inertia."""

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


@kernel(fast=True)
def integrate_batch(columns, motion, turned, point, gravity, centre, slack, reach, scale, dt):
    """Kick and drift `BATCH` particles.

    Parameters
    ----------
    columns : real (16 * BATCH,), rows from FORCE: force [N] (3), spare, moment [N m] (3), spare; from ROW: what the law saw of the
        particle, replaced by what it is to see next
    motion : (18 * BATCH,), rows as `Motion` names them; position, velocity and spin are brought up to date, published positions
        [1/scale] replace the positions when the list was made
    turned : (3, 3) rotation of the reference since the list was made [1]; point : (3,) its reference point [m]
    gravity : (3,) [m/s^2]; centre : (3,) of the domain [m]
    slack : square of the displacement that asks for a new list [m^2]; reach : half size of the domain [m]; scale : [1/m]; dt : substep [s]

    Returns
    -------
    work rate of the forces on the mean velocities less that on the predicted ones the law saw [W], power of gravity [W],
    number of particles moved beyond the slack, number of particles in the domain or padding
    """
    half = 0.5 * dt
    g0, g1, g2 = gravity[0], gravity[1], gravity[2]
    c0, c1, c2 = centre[0], centre[1], centre[2]
    p0, p1, p2 = point[0], point[1], point[2]
    t00, t01, t02 = turned[0, 0], turned[0, 1], turned[0, 2]
    t10, t11, t12 = turned[1, 0], turned[1, 1], turned[1, 2]
    t20, t21, t22 = turned[2, 0], turned[2, 1], turned[2, 2]
    missed, falling = 0.0, 0.0
    moved, stayed = 0, 0
    for b in range(BATCH):
        f0, f1, f2 = float(columns[FORCE + b]), float(columns[FORCE + b + BATCH]), float(columns[FORCE + b + 2 * BATCH])
        m0, m1, m2 = float(columns[FORCE + b + 4 * BATCH]), float(columns[FORCE + b + 5 * BATCH]), float(columns[FORCE + b + 6 * BATCH])
        mass, per_mass, per_inertia = motion[MASS + b], motion[MASS + b + BATCH], motion[MASS + b + 2 * BATCH]
        a0 = half * (per_mass * f0 + g0)
        a1 = half * (per_mass * f1 + g1)
        a2 = half * (per_mass * f2 + g2)
        b0 = half * per_inertia * m0
        b1 = half * per_inertia * m1
        b2 = half * per_inertia * m2
        # mean velocity over the substep, and how far the prediction was from it
        u0, u1, u2 = motion[V + b] + a0, motion[V + b + BATCH] + a1, motion[V + b + 2 * BATCH] + a2
        z0, z1, z2 = motion[W + b] + b0, motion[W + b + BATCH] + b1, motion[W + b + 2 * BATCH] + b2
        falling += mass * (g0 * u0 + g1 * u1 + g2 * u2)
        missed += (
            f0 * (u0 - columns[ROW + b]) + f1 * (u1 - columns[ROW + b + BATCH]) + f2 * (u2 - columns[ROW + b + 2 * BATCH])
            + m0 * (z0 - columns[ROW + b + 4 * BATCH]) + m1 * (z1 - columns[ROW + b + 5 * BATCH])
            + m2 * (z2 - columns[ROW + b + 6 * BATCH])
        )  # fmt: skip
        u0, u1, u2 = u0 + a0, u1 + a1, u2 + a2
        z0, z1, z2 = z0 + b0, z1 + b1, z2 + b2
        motion[V + b], motion[V + b + BATCH], motion[V + b + 2 * BATCH] = u0, u1, u2
        motion[W + b], motion[W + b + BATCH], motion[W + b + 2 * BATCH] = z0, z1, z2
        columns[ROW + b], columns[ROW + b + BATCH], columns[ROW + b + 2 * BATCH] = u0 + a0, u1 + a1, u2 + a2
        columns[ROW + b + 4 * BATCH], columns[ROW + b + 5 * BATCH], columns[ROW + b + 6 * BATCH] = z0 + b0, z1 + b1, z2 + b2
        u0, u1, u2 = motion[X + b] + dt * u0, motion[X + b + BATCH] + dt * u1, motion[X + b + 2 * BATCH] + dt * u2
        motion[X + b], motion[X + b + BATCH], motion[X + b + 2 * BATCH] = u0, u1, u2
        r0, r1, r2 = motion[LISTED_AT + b], motion[LISTED_AT + b + BATCH], motion[LISTED_AT + b + 2 * BATCH]
        z0 = u0 - p0 - (t00 * r0 + t01 * r1 + t02 * r2)
        z1 = u1 - p1 - (t10 * r0 + t11 * r1 + t12 * r2)
        z2 = u2 - p2 - (t20 * r0 + t21 * r1 + t22 * r2)
        padding = mass == 0.0
        moved += 1 if (z0 * z0 + z1 * z1 + z2 * z2 > slack) & (not padding) else 0
        u0, u1, u2 = u0 - c0, u1 - c1, u2 - c2
        stayed += 1 if ((abs(u0) < reach) & (abs(u1) < reach) & (abs(u2) < reach)) | padding else 0
        motion[LISTED_AT + b] = np.floor(u0 * scale + 0.5)
        motion[LISTED_AT + b + BATCH] = np.floor(u1 * scale + 0.5)
        motion[LISTED_AT + b + 2 * BATCH] = np.floor(u2 * scale + 0.5)
    return missed, falling, moved, stayed


@kernel(fast=True, inline="always")
def integrate(model, state, scratch, lo, hi, forces, tid, point, dt, work):
    """Kick and drift the particles of one chunk, and publish them in the other buffer.

    Adds to `work` what the law's work misses because it used predicted velocities: with it, the ledger is exact.
    Returns the chunk's alarms.
    """
    now = state.clock[PUBLISHED]
    rows, new_rows, points, new_points = state.rows[now], state.rows[1 - now], state.points[now], state.points[1 - now]
    columns, motion, fixed, turned, slots = scratch.columns[tid, 2], scratch.moving[tid], scratch.fixed[tid], scratch.turned[tid], scratch.slots
    slack = 0.2475 * model.skin * model.skin  # just under (skin/2)^2: two particles may approach each other
    m = state.x.shape[1]
    x, v, w = state.x.reshape(3 * m), state.v.reshape(3 * m), state.w.reshape(3 * m)
    listed_at, body = state.listed_at.reshape(3 * m), state.body.reshape(4 * m)
    missed, falling = 0.0, 0.0
    moved, stayed, expected = 0, 0, 0
    for first in range(lo, hi, BATCH):
        for q in range(0, BATCH, WIDTH):
            gather_rows(forces, slots, first - lo + q, columns, q, 0)
            gather_rows(rows, slots, first + q, columns, q, 8)
        for k in range(3):
            at = k * m + first
            copy_lanes(x, at, motion, X + k * BATCH)
            copy_lanes(v, at, motion, V + k * BATCH)
            copy_lanes(w, at, motion, W + k * BATCH)
            copy_lanes(listed_at, at, motion, LISTED_AT + k * BATCH)
            copy_lanes(body, at + m, motion, MASS + k * BATCH)
        more, fallen, far, inside = integrate_batch(
            columns, motion, turned, point, model.gravity, model.centre, slack, model.reach, model.scale, dt
        )  # fmt: skip
        missed += more
        falling += fallen
        moved += far
        stayed += inside
        expected += BATCH
        for k in range(3):
            at = k * m + first
            copy_lanes(motion, X + k * BATCH, x, at)
            copy_lanes(motion, V + k * BATCH, v, at)
            copy_lanes(motion, W + k * BATCH, w, at)
            copy_lanes(motion, LISTED_AT + k * BATCH, fixed, k * BATCH)
        for b in range(BATCH):
            fixed[3 * BATCH + b] = points[np.uint32(first) + np.uint32(b), 3]
        for q in range(0, BATCH, WIDTH):
            set_rows(new_rows, slots, first + q, columns, q, 8)
            set_points(new_points, slots, first + q, fixed, q)
    work[SCHEME] = missed
    work[GRAVITY] = falling
    return MOVED * int(moved > 0) + LEFT * int(stayed < expected)


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
    empty = forces.reshape(forces.size)
    for k in range(empty.size):
        empty[k] = zero
    for l in range(0, hi - lo, WIDTH):
        negated_radii(points, scratch.slots, lo + l, local, l)
    found = filter_pairs(points, partners, state.owners[lst, c], local, state.listed[lst, c], lo, lanes)
    work[0], work[1], work[2], pair_alarm = pair_contacts(
        model, points, rows, memory, state.material, found, lanes, local, scratch.columns[tid, 0], last, now, step, forces
    )
    sums = scratch.sums[c]
    for b in range(model.n_bodies):
        for k in range(6):
            sums[b, k] = 0.0
    normals = scratch.normals[tid]
    placed = scratch.placed[tid]
    found = find_walls(model, state.x, state.body[0], local, placed, lo, hi - lo, lanes, normals, scratch.test[tid])
    work[3], work[4], work[5], work[6], wall_alarm = wall_contacts(
        model, state.x, rows, state.wall_memory, state.material, scratch.motion[tid], found, lanes, normals, scratch.columns[tid, 1],
        last, now, step, forces, sums,
    )  # fmt: skip
    alarms = integrate(model, state, scratch, lo, hi, forces, tid, reference, dt, work)
    scratch.alarms[c] = alarms + PAIR * int(pair_alarm > 0) + WALL * int(wall_alarm > 0)


@kernel
def close_substep(model, state, scratch, dt):
    """Sum up a substep over the chunks, in fixed order, and turn the clock; called by one thread."""
    clock = state.clock
    alarms = 0
    for c in range(scratch.alarms.shape[0]):
        alarms |= scratch.alarms[c]
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
