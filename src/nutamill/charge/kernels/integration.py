"""Moves the spheres of one chunk by one substep, eight at a time, and publishes them.

Everything the vector loop touches is first copied into flat arrays of rows of `BATCH` lanes, as for contacts.
"""

import numpy as np

from nutamill.base.kernel import kernel
from nutamill.charge.kernels.neighbours import largest_drift_squared
from nutamill.charge.kernels.simd import WIDTH, copy_lanes, gather_rows, set_points, set_rows
from nutamill.charge.laws.lanes import BATCH
from nutamill.charge.model import Clock, Ledger

PUBLISHED = int(Clock.PUBLISHED)
GRAVITY, SCHEME = int(Ledger.GRAVITY), int(Ledger.SCHEME)

FORCE, ROW = 0, 8 * BATCH
"""Where the columns of `integrate_batch` begin: force and moment; what the law sees of a particle."""

X, V, W, LISTED_AT, MASS = (k * BATCH for k in (0, 3, 6, 9, 12))
"""Where its rows in double precision begin: position, velocity, spin, position when the list was made; mass,
1/mass, 1/inertia.
"""


@kernel(fast=True)
def integrate_batch(rotation, point, gravity, centre, slack, reach, scale, dt, columns_out, motion_out):
    """Kick and drift `BATCH` particles.

    Parameters
    ----------
    rotation : rotation of the reference since the list was made [1] (3, 3)
    point : reference point [m] (3,)
    gravity : [m/s^2] (3,)
    centre : of the domain [m] (3,)
    slack : square of the displacement that asks for a new list [m^2]
    reach : half size of the domain [m]
    scale : fixed-point units in a metre [1/m]
    dt : substep [s]
    columns_out : real (16 * BATCH,), rows from FORCE: force [N] (3), spare, moment [N m] (3), spare.  Rows
        from ROW: what the law saw of the particle, replaced by what it is to see next
    motion_out : (15 * BATCH,), rows as X, V, W, LISTED_AT and MASS name them.  Position, velocity and spin
        are brought up to date, published positions [1/scale] replace the positions when the list was made

    Returns
    -------
    work rate of the forces on the mean velocities less that on the predicted ones the law saw [W], power of
    gravity [W], number of particles moved beyond the slack, number of particles in the domain or padding
    """
    half = 0.5 * dt
    g0, g1, g2 = gravity[0], gravity[1], gravity[2]
    c0, c1, c2 = centre[0], centre[1], centre[2]
    p0, p1, p2 = point[0], point[1], point[2]
    t00, t01, t02 = rotation[0, 0], rotation[0, 1], rotation[0, 2]
    t10, t11, t12 = rotation[1, 0], rotation[1, 1], rotation[1, 2]
    t20, t21, t22 = rotation[2, 0], rotation[2, 1], rotation[2, 2]
    missed, falling = 0.0, 0.0
    moved, stayed = 0, 0
    for b in range(BATCH):
        f0, f1, f2 = (
            float(columns_out[FORCE + b]),
            float(columns_out[FORCE + b + BATCH]),
            float(columns_out[FORCE + b + 2 * BATCH]),
        )
        m0, m1, m2 = (
            float(columns_out[FORCE + b + 4 * BATCH]),
            float(columns_out[FORCE + b + 5 * BATCH]),
            float(columns_out[FORCE + b + 6 * BATCH]),
        )
        mass, per_mass, per_inertia = (
            motion_out[MASS + b],
            motion_out[MASS + b + BATCH],
            motion_out[MASS + b + 2 * BATCH],
        )
        a0 = half * (per_mass * f0 + g0)
        a1 = half * (per_mass * f1 + g1)
        a2 = half * (per_mass * f2 + g2)
        b0 = half * per_inertia * m0
        b1 = half * per_inertia * m1
        b2 = half * per_inertia * m2
        # mean velocity over the substep, and how far the prediction was from it
        u0, u1, u2 = (
            motion_out[V + b] + a0,
            motion_out[V + b + BATCH] + a1,
            motion_out[V + b + 2 * BATCH] + a2,
        )
        z0, z1, z2 = (
            motion_out[W + b] + b0,
            motion_out[W + b + BATCH] + b1,
            motion_out[W + b + 2 * BATCH] + b2,
        )
        falling += mass * (g0 * u0 + g1 * u1 + g2 * u2)
        missed += (
            f0 * (u0 - columns_out[ROW + b])
            + f1 * (u1 - columns_out[ROW + b + BATCH])
            + f2 * (u2 - columns_out[ROW + b + 2 * BATCH])
            + m0 * (z0 - columns_out[ROW + b + 4 * BATCH])
            + m1 * (z1 - columns_out[ROW + b + 5 * BATCH])
            + m2 * (z2 - columns_out[ROW + b + 6 * BATCH])
        )
        u0, u1, u2 = u0 + a0, u1 + a1, u2 + a2
        z0, z1, z2 = z0 + b0, z1 + b1, z2 + b2
        motion_out[V + b], motion_out[V + b + BATCH], motion_out[V + b + 2 * BATCH] = u0, u1, u2
        motion_out[W + b], motion_out[W + b + BATCH], motion_out[W + b + 2 * BATCH] = z0, z1, z2
        columns_out[ROW + b], columns_out[ROW + b + BATCH], columns_out[ROW + b + 2 * BATCH] = (
            u0 + a0,
            u1 + a1,
            u2 + a2,
        )
        (
            columns_out[ROW + b + 4 * BATCH],
            columns_out[ROW + b + 5 * BATCH],
            columns_out[ROW + b + 6 * BATCH],
        ) = (
            z0 + b0,
            z1 + b1,
            z2 + b2,
        )
        u0, u1, u2 = (
            motion_out[X + b] + dt * u0,
            motion_out[X + b + BATCH] + dt * u1,
            motion_out[X + b + 2 * BATCH] + dt * u2,
        )
        motion_out[X + b], motion_out[X + b + BATCH], motion_out[X + b + 2 * BATCH] = u0, u1, u2
        r0, r1, r2 = (
            motion_out[LISTED_AT + b],
            motion_out[LISTED_AT + b + BATCH],
            motion_out[LISTED_AT + b + 2 * BATCH],
        )
        z0 = u0 - p0 - (t00 * r0 + t01 * r1 + t02 * r2)
        z1 = u1 - p1 - (t10 * r0 + t11 * r1 + t12 * r2)
        z2 = u2 - p2 - (t20 * r0 + t21 * r1 + t22 * r2)
        padding = mass == 0.0
        moved += 1 if (z0 * z0 + z1 * z1 + z2 * z2 > slack) & (not padding) else 0
        u0, u1, u2 = u0 - c0, u1 - c1, u2 - c2
        stayed += 1 if ((abs(u0) < reach) & (abs(u1) < reach) & (abs(u2) < reach)) | padding else 0
        motion_out[LISTED_AT + b] = np.floor(u0 * scale + 0.5)
        motion_out[LISTED_AT + b + BATCH] = np.floor(u1 * scale + 0.5)
        motion_out[LISTED_AT + b + 2 * BATCH] = np.floor(u2 * scale + 0.5)
    return missed, falling, moved, stayed


@kernel(fast=True, inline="always")
def integrate_spheres(model, state, scratch, forces, point, lo, hi, dt, tid, work_out):
    """Kick and drift the particles of one chunk, and publish them in the other buffer.

    Parameters
    ----------
    forces : force [N] (3), spare, moment [N m] (3), spare, on each particle of the chunk, world axes
    point : reference point of the displacement since the list was made [m] (3,)
    lo, hi : slots of the chunk
    dt : substep [s]
    tid : number of this thread
    work_out : power by kind [W] (9,), as `Ledger`.  Gravity, and what the law's work misses because it used
        predicted velocities: with it, the ledger is exact

    Returns
    -------
    number of particles moved beyond the skin, number of particles that left the domain
    """
    now = state.clock[PUBLISHED]
    rows, new_rows, points, new_points = (
        state.published_rows[now],
        state.published_rows[1 - now],
        state.published_points[now],
        state.published_points[1 - now],
    )
    columns, motion, fixed, rotation, slots = (
        scratch.columns[tid, 2],
        scratch.moving[tid],
        scratch.fixed[tid],
        scratch.rotation[tid],
        scratch.slots,
    )
    slack = largest_drift_squared(model.skin - model.film_reach)
    m = state.x.shape[1]
    x, v, w = state.x.reshape(3 * m), state.v.reshape(3 * m), state.w.reshape(3 * m)
    listed_at, mass_props = state.listed_at.reshape(3 * m), state.mass_props.reshape(4 * m)
    missed, falling = 0.0, 0.0
    moved, stayed, expected = 0, 0, 0
    for first in range(lo, hi, BATCH):
        for q in range(0, BATCH, WIDTH):
            gather_rows(forces, slots, first - lo + q, q, 0, columns)
            gather_rows(rows, slots, first + q, q, 8, columns)
        for k in range(3):
            at = k * m + first
            copy_lanes(x, at, X + k * BATCH, motion)
            copy_lanes(v, at, V + k * BATCH, motion)
            copy_lanes(w, at, W + k * BATCH, motion)
            copy_lanes(listed_at, at, LISTED_AT + k * BATCH, motion)
            copy_lanes(mass_props, at + m, MASS + k * BATCH, motion)
        more, fallen, far, inside = integrate_batch(
            rotation,
            point,
            model.gravity,
            model.centre,
            slack,
            model.reach,
            model.scale,
            dt,
            columns,
            motion,
        )
        missed += more
        falling += fallen
        moved += far
        stayed += inside
        expected += BATCH
        for k in range(3):
            at = k * m + first
            copy_lanes(motion, X + k * BATCH, at, x)
            copy_lanes(motion, V + k * BATCH, at, v)
            copy_lanes(motion, W + k * BATCH, at, w)
            copy_lanes(motion, LISTED_AT + k * BATCH, k * BATCH, fixed)
        for b in range(BATCH):
            fixed[3 * BATCH + b] = points[np.uint32(first) + np.uint32(b), 3]
        for q in range(0, BATCH, WIDTH):
            set_rows(slots, first + q, columns, q, 8, new_rows)
            set_points(slots, first + q, fixed, q, new_points)
    work_out[SCHEME] = missed
    work_out[GRAVITY] = falling
    return moved, expected - stayed
