"""Moves the clumps of one chunk by one substep, `BATCH` at a time, and publishes their pebbles.

The forces on pebbles are summed to their clump, the clump is moved, and its motion is given to its pebbles.

Leapfrog of rotation: angular momentum L belongs to the end of a substep, the attitude q to half a substep
later, as velocities and positions do (`nutamill.charge.kernels.dynamics`):

    L <- L + dt T,     q' = turn(q, w(q, L) dt/2),     w = w(q', L),     q <- turn(q, w dt)

with ``w(q, L) = R I^-1 R^T L``: without a moment L stays exactly the same, and q is of second order.

Source: D. Fincham, "Leapfrog rotational algorithms", Molecular Simulation 8 (1992) 165, the explicit scheme.
"""

import numpy as np

from nutamill.base.frames import cross, half_angle_series, rotate, rotation_numbers, turned_by_half_angle
from nutamill.base.kernel import kernel
from nutamill.charge.kernels.clumps import (
    AT_VELOCITY,
    ATTITUDE,
    CENTRE,
    CLUMP,
    COLUMNS,
    INERTIA,
    MASS,
    MOMENTUM,
    OFFSET,
    SPIN_ENERGY,
    VELOCITY,
    clump_end,
    spin_of,
)
from nutamill.charge.kernels.neighbours import largest_drift_squared
from nutamill.charge.kernels.publish import fixed_point
from nutamill.charge.laws.lanes import BATCH
from nutamill.charge.model import Clock, Ledger

PUBLISHED = int(Clock.PUBLISHED)
GRAVITY, SCHEME = int(Ledger.GRAVITY), int(Ledger.SCHEME)

FORCE, MOMENT = COLUMNS, COLUMNS + 3
"""Rows of lanes behind the numbers of a clump: force [N] (3) and moment [N m] (3) about its mass centre."""
NEXT_VELOCITY, NEXT_SPIN = COLUMNS + 6, COLUMNS + 9
"""Velocity [m/s] (3) and spin [rad/s] (3) predicted for the middle of the next substep, which the law is to
see.
"""
ROTATION = COLUMNS + 12
"""Rotation matrix [1] (9) from the clump's axes, row by row, at the time of its centre."""
FALLING, GAIN = COLUMNS + 21, COLUMNS + 22
"""Power of gravity [W]; gain of the clump's kinetic energy per time less that [W]."""
LANE_ROWS = COLUMNS + 23
"""Rows of lanes that a batch of clumps needs [1]."""


@kernel(inline="always")
def turned_for(q, w, time):
    """Return the attitude, a 4-tuple, of `q` (4,) turned with the spin `w` [rad/s] (3,) for a `time` [s] in
    which it turns by less than 1 rad.
    """
    t0, t1, t2 = time * w[0], time * w[1], time * w[2]
    scale, cosine = half_angle_series(t0 * t0 + t1 * t1 + t2 * t2)
    return turned_by_half_angle(q, scale * t0, scale * t1, scale * t2, cosine)


@kernel(fast=True)
def move_batch(gravity, dt, lanes_out):
    """Kick and drift `BATCH` clumps.

    Parameters
    ----------
    lanes_out : (LANE_ROWS * BATCH,), rows as `ClumpColumn`, which are brought up to date, then from FORCE on
        as named above
    gravity : (3,) [m/s^2]; dt : substep [s]
    """
    half, per_dt = 0.5 * dt, 1.0 / dt
    g0, g1, g2 = gravity[0], gravity[1], gravity[2]
    for b in range(BATCH):
        mass = lanes_out[MASS * BATCH + b]
        f0, f1, f2 = (
            lanes_out[FORCE * BATCH + b],
            lanes_out[(FORCE + 1) * BATCH + b],
            lanes_out[(FORCE + 2) * BATCH + b],
        )
        t0, t1, t2 = (
            lanes_out[MOMENT * BATCH + b],
            lanes_out[(MOMENT + 1) * BATCH + b],
            lanes_out[(MOMENT + 2) * BATCH + b],
        )
        per_mass = 1.0 / mass
        a0, a1, a2 = half * (f0 * per_mass + g0), half * (f1 * per_mass + g1), half * (f2 * per_mass + g2)
        u0 = lanes_out[VELOCITY * BATCH + b] + a0
        u1 = lanes_out[(VELOCITY + 1) * BATCH + b] + a1
        u2 = lanes_out[(VELOCITY + 2) * BATCH + b] + a2
        lanes_out[FALLING * BATCH + b] = mass * (g0 * u0 + g1 * u1 + g2 * u2)
        gain = f0 * u0 + f1 * u1 + f2 * u2
        u0, u1, u2 = u0 + a0, u1 + a1, u2 + a2
        (
            lanes_out[VELOCITY * BATCH + b],
            lanes_out[(VELOCITY + 1) * BATCH + b],
            lanes_out[(VELOCITY + 2) * BATCH + b],
        ) = (
            u0,
            u1,
            u2,
        )
        lanes_out[CENTRE * BATCH + b] += dt * u0
        lanes_out[(CENTRE + 1) * BATCH + b] += dt * u1
        lanes_out[(CENTRE + 2) * BATCH + b] += dt * u2
        lanes_out[NEXT_VELOCITY * BATCH + b] = u0 + a0
        lanes_out[(NEXT_VELOCITY + 1) * BATCH + b] = u1 + a1
        lanes_out[(NEXT_VELOCITY + 2) * BATCH + b] = u2 + a2
        l0 = lanes_out[MOMENTUM * BATCH + b] + dt * t0
        l1 = lanes_out[(MOMENTUM + 1) * BATCH + b] + dt * t1
        l2 = lanes_out[(MOMENTUM + 2) * BATCH + b] + dt * t2
        (
            lanes_out[MOMENTUM * BATCH + b],
            lanes_out[(MOMENTUM + 1) * BATCH + b],
            lanes_out[(MOMENTUM + 2) * BATCH + b],
        ) = (
            l0,
            l1,
            l2,
        )
        i0, i1, i2 = (
            lanes_out[INERTIA * BATCH + b],
            lanes_out[(INERTIA + 1) * BATCH + b],
            lanes_out[(INERTIA + 2) * BATCH + b],
        )
        q = (
            lanes_out[ATTITUDE * BATCH + b],
            lanes_out[(ATTITUDE + 1) * BATCH + b],
            lanes_out[(ATTITUDE + 2) * BATCH + b],
            lanes_out[(ATTITUDE + 3) * BATCH + b],
        )
        then = turned_for(q, spin_of(q, (l0, l1, l2), (i0, i1, i2)), half)
        w0, w1, w2 = spin_of(then, (l0, l1, l2), (i0, i1, i2))
        q = turned_for(q, (w0, w1, w2), dt)
        energy = 0.5 * (w0 * l0 + w1 * l1 + w2 * l2)
        lanes_out[GAIN * BATCH + b] = gain + (energy - lanes_out[SPIN_ENERGY * BATCH + b]) * per_dt
        lanes_out[SPIN_ENERGY * BATCH + b] = energy
        lanes_out[AT_VELOCITY * BATCH + b], lanes_out[(AT_VELOCITY + 1) * BATCH + b] = then[0], then[1]
        lanes_out[(AT_VELOCITY + 2) * BATCH + b], lanes_out[(AT_VELOCITY + 3) * BATCH + b] = then[2], then[3]
        lanes_out[ATTITUDE * BATCH + b], lanes_out[(ATTITUDE + 1) * BATCH + b] = q[0], q[1]
        lanes_out[(ATTITUDE + 2) * BATCH + b], lanes_out[(ATTITUDE + 3) * BATCH + b] = q[2], q[3]
        w0, w1, w2 = spin_of(q, (l0 + half * t0, l1 + half * t1, l2 + half * t2), (i0, i1, i2))
        (
            lanes_out[NEXT_SPIN * BATCH + b],
            lanes_out[(NEXT_SPIN + 1) * BATCH + b],
            lanes_out[(NEXT_SPIN + 2) * BATCH + b],
        ) = w0, w1, w2
        r0, r1, r2, r3, r4, r5, r6, r7, r8 = rotation_numbers(q[0], q[1], q[2], q[3])
        (
            lanes_out[ROTATION * BATCH + b],
            lanes_out[(ROTATION + 1) * BATCH + b],
            lanes_out[(ROTATION + 2) * BATCH + b],
        ) = (
            r0,
            r1,
            r2,
        )
        (
            lanes_out[(ROTATION + 3) * BATCH + b],
            lanes_out[(ROTATION + 4) * BATCH + b],
            lanes_out[(ROTATION + 5) * BATCH + b],
        ) = r3, r4, r5
        (
            lanes_out[(ROTATION + 6) * BATCH + b],
            lanes_out[(ROTATION + 7) * BATCH + b],
            lanes_out[(ROTATION + 8) * BATCH + b],
        ) = r6, r7, r8


@kernel(fast=True)
def load_clumps(state, forces, i, lo, hi, lanes_out):
    """Load up to `BATCH` clumps from slot `i` on into `lanes_out`, with the forces on their pebbles.

    Returns
    -------
    slot behind the last pebble, number of clumps, power of the forces on the velocities that the law saw [W]
    """
    rows, x, mass_props = state.published_rows[state.clock[PUBLISHED]], state.x, state.mass_props
    seen, b = 0.0, 0
    while i < hi and b < BATCH:
        clump = state.clumps[int(mass_props[CLUMP, i])]
        for k in range(COLUMNS):
            lanes_out[k * BATCH + b] = clump[k]
        c0, c1, c2 = clump[CENTRE], clump[CENTRE + 1], clump[CENTRE + 2]
        f0, f1, f2, t0, t1, t2 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        end = clump_end(state, i, hi)
        for slot in range(i, end):
            p = np.uint32(slot)
            row = forces[np.uint32(slot - lo)]
            q0, q1, q2 = float(row[0]), float(row[1]), float(row[2])
            m0, m1, m2 = float(row[4]), float(row[5]), float(row[6])
            seen += (
                q0 * rows[p, 0]
                + q1 * rows[p, 1]
                + q2 * rows[p, 2]
                + m0 * rows[p, 4]
                + m1 * rows[p, 5]
                + m2 * rows[p, 6]
            )
            n0, n1, n2 = cross(x[0, p] - c0, x[1, p] - c1, x[2, p] - c2, q0, q1, q2)
            f0, f1, f2 = f0 + q0, f1 + q1, f2 + q2
            t0, t1, t2 = t0 + n0 + m0, t1 + n1 + m1, t2 + n2 + m2
        (
            lanes_out[FORCE * BATCH + b],
            lanes_out[(FORCE + 1) * BATCH + b],
            lanes_out[(FORCE + 2) * BATCH + b],
        ) = f0, f1, f2
        (
            lanes_out[MOMENT * BATCH + b],
            lanes_out[(MOMENT + 1) * BATCH + b],
            lanes_out[(MOMENT + 2) * BATCH + b],
        ) = (
            t0,
            t1,
            t2,
        )
        i = end
        b += 1
    return i, b, seen


@kernel(fast=True)
def integrate_clumps(model, state, scratch, forces, point, lo, hi, dt, tid, work_out):
    """Kick and drift the clumps of one chunk, and publish their pebbles in the other buffer.

    Parameters
    ----------
    forces : force [N] (3), spare, moment about its centre [N m] (3), spare, on each pebble, real (chunk + 1,
        8), world axes
    point : reference point of the displacement since the list was made [m] (3,)
    lo, hi : slots of the chunk
    dt : substep [s]
    tid : number of this thread
    work_out : power by kind [W] (9,), as `Ledger`.  Gravity, and what the law's work misses of the gain in
        kinetic energy, as for spheres; of a clump that includes the error of the rotation's scheme

    Returns
    -------
    number of pebbles moved beyond the skin, number of pebbles that left the domain
    """
    lanes = scratch.moving[tid]
    missed, falling = 0.0, 0.0
    moved, gone = 0, 0
    i = lo
    while i < hi:
        end, count, seen = load_clumps(state, forces, i, lo, hi, lanes)
        # unused lanes hold stale data: they are computed and discarded
        move_batch(model.gravity, dt, lanes)
        first = int(state.mass_props[CLUMP, i])
        for b in range(count):
            clump = state.clumps[first + b]
            for k in range(COLUMNS):
                clump[k] = lanes[k * BATCH + b]
            missed += lanes[GAIN * BATCH + b]
            falling += lanes[FALLING * BATCH + b]
        missed -= seen
        far, out = publish_pebbles(model, state, i, end, lanes, scratch.rotation[tid], point, 1.0 / dt)
        moved += far
        gone += out
        i = end
    work_out[SCHEME] = missed
    work_out[GRAVITY] = falling
    return moved, gone


@kernel(fast=True)
def publish_pebbles(model, state, lo, hi, lanes, rotation, point, per_dt):
    """Move the pebbles of a batch of clumps, slots `lo` to `hi`, with their clumps, and publish them in the
    other buffer.

    Returns
    -------
    as `integrate_clumps`
    """
    now = state.clock[PUBLISHED]
    rows, new_rows, points, new_points = (
        state.published_rows[now],
        state.published_rows[1 - now],
        state.published_points[now],
        state.published_points[1 - now],
    )
    x, v, mass_props, listed_at = state.x, state.v, state.mass_props, state.listed_at
    p0, p1, p2 = point[0], point[1], point[2]
    d0, d1, d2 = model.centre[0], model.centre[1], model.centre[2]
    reach, scale, slack = (
        model.reach,
        model.scale,
        largest_drift_squared(model.skin - model.film_reach),
    )
    first = int(mass_props[CLUMP, lo])
    moved, gone = 0, 0
    for slot in range(lo, hi):
        p = np.uint32(slot)
        b = np.uint32(int(mass_props[CLUMP, p]) - first)
        o0, o1, o2 = mass_props[OFFSET, p], mass_props[OFFSET + 1, p], mass_props[OFFSET + 2, p]
        a0 = (
            lanes[ROTATION * BATCH + b] * o0
            + lanes[(ROTATION + 1) * BATCH + b] * o1
            + lanes[(ROTATION + 2) * BATCH + b] * o2
        )
        a1 = (
            lanes[(ROTATION + 3) * BATCH + b] * o0
            + lanes[(ROTATION + 4) * BATCH + b] * o1
            + lanes[(ROTATION + 5) * BATCH + b] * o2
        )
        a2 = (
            lanes[(ROTATION + 6) * BATCH + b] * o0
            + lanes[(ROTATION + 7) * BATCH + b] * o1
            + lanes[(ROTATION + 8) * BATCH + b] * o2
        )
        w0, w1, w2 = (
            lanes[NEXT_SPIN * BATCH + b],
            lanes[(NEXT_SPIN + 1) * BATCH + b],
            lanes[(NEXT_SPIN + 2) * BATCH + b],
        )
        c0, c1, c2 = cross(w0, w1, w2, a0, a1, a2)
        r = new_rows[p]
        r[0] = lanes[NEXT_VELOCITY * BATCH + b] + c0
        r[1] = lanes[(NEXT_VELOCITY + 1) * BATCH + b] + c1
        r[2] = lanes[(NEXT_VELOCITY + 2) * BATCH + b] + c2
        r[3] = rows[p, 3]
        r[4], r[5], r[6], r[7] = w0, w1, w2, rows[p, 7]
        a0, a1, a2 = (
            lanes[CENTRE * BATCH + b] + a0,
            lanes[(CENTRE + 1) * BATCH + b] + a1,
            lanes[(CENTRE + 2) * BATCH + b] + a2,
        )
        # the mean velocity of the drift is that at the substep's end to second order
        v[0, p], v[1, p], v[2, p] = (a0 - x[0, p]) * per_dt, (a1 - x[1, p]) * per_dt, (a2 - x[2, p]) * per_dt
        x[0, p], x[1, p], x[2, p] = a0, a1, a2
        c0, c1, c2 = rotate(rotation, listed_at[0, p], listed_at[1, p], listed_at[2, p])
        c0, c1, c2 = a0 - p0 - c0, a1 - p1 - c1, a2 - p2 - c2
        moved += int(c0 * c0 + c1 * c1 + c2 * c2 > slack)
        a0, a1, a2 = a0 - d0, a1 - d1, a2 - d2
        gone += 1 - int((abs(a0) < reach) & (abs(a1) < reach) & (abs(a2) < reach))
        new_points[p, 0], new_points[p, 1] = fixed_point(a0, scale), fixed_point(a1, scale)
        new_points[p, 2], new_points[p, 3] = fixed_point(a2, scale), points[p, 3]
    return moved, gone
