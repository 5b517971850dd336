"""Rigid clumps of spheres (pebbles): their motion under the forces on all their pebbles.

A pebble has a slot like any sphere, and the slots of a clump are neighbours in one chunk.  The law sees a pebble's own centre, velocity
and radius with the mass and the spin of its clump; what pebbles feel is summed to the clump here, and what it does is laid back on them.

Leapfrog of rotation: angular momentum L belongs to the end of a substep, the attitude q to half a substep later, as velocities and
positions do (`nutamill.charge.dynamics`):

    L <- L + dt T,     q' = turn(q, w(q, L) dt/2),     w = w(q', L),     q <- turn(q, w dt)

with ``w(q, L) = R I^-1 R^T L``: L is kept exactly without a moment, and q is of second order.

Source: D. Fincham, "Leapfrog rotational algorithms", Molecular Simulation 8 (1992) 165, the explicit scheme.
"""

from enum import IntEnum

from nutamill.charge.model import Clock, Ledger
from nutamill.charge.publish import fixed_point
from nutamill.frames import cross, rotate, turn_quaternion, turn_vector, turn_vector_back
from nutamill.kernel import kernel, like

PUBLISHED = int(Clock.PUBLISHED)
GRAVITY, SCHEME = int(Ledger.GRAVITY), int(Ledger.SCHEME)


class ClumpColumn(IntEnum):
    """Where the numbers of a clump begin in a row of `ChargeState.clumps`."""

    CENTRE = 0
    """Mass centre [m] (3), world, half a substep ahead of the velocity."""
    VELOCITY = 3
    """[m/s] (3), world axes."""
    MOMENTUM = 6
    """Angular momentum about the mass centre [kg m^2/s] (3), world axes."""
    ATTITUDE = 9
    """Quaternion (4) from the clump's principal axes to world axes, at the time of the centre."""
    MASS = 13
    """[kg]."""
    INERTIA = 14
    """Principal moments [kg m^2] (3)."""
    SPIN_ENERGY = 17
    """Kinetic energy of rotation [J], at the time of the velocity."""
    ID = 18
    """Id of the particle [1]."""
    AT_VELOCITY = 19
    """Attitude (4) at the time of the velocity."""


POSE = [0, 1, 2, 9, 10, 11, 12]
"""Places of centre and attitude in a row."""

COLUMNS = 24
"""Numbers in a row of `ChargeState.clumps` [1]."""

OFFSET, PLACE = 4, 7
"""Rows of `ChargeState.body` that only pebbles have: centre in the clump's axes, place of the clump."""

CENTRE, VELOCITY, MOMENTUM, ATTITUDE, MASS, INERTIA, SPIN_ENERGY, ID, AT_VELOCITY = (int(c) for c in ClumpColumn)


@kernel
def spin_of(q, momentum, inertia):
    """Spin [rad/s] (3 numbers), world axes, of a body at attitude `q` (4,) with angular momentum (3,) and principal moments (3,)."""
    a, b, c = turn_vector_back(q, momentum[0], momentum[1], momentum[2])
    return turn_vector(q, a / inertia[0], b / inertia[1], c / inertia[2])


@kernel
def clump_end(state, i, hi):
    """First slot behind the clump that slot `i` belongs to; `hi` ends the chunk."""
    place = state.body[PLACE, i]
    end = i + 1
    while end < hi and state.body[PLACE, end] == place:
        end += 1
    return end


@kernel
def start_clumps(model, state, dt):
    """Half a drift of every clump, and its pebbles' places and predicted velocities, to the current published rows."""
    rows = state.rows[state.clock[PUBLISHED]]
    for p in range(state.clumps.shape[0]):
        clump = state.clumps[p]
        q = clump[ATTITUDE : ATTITUDE + 4]
        for k in range(4):
            clump[AT_VELOCITY + k] = q[k]
        w0, w1, w2 = spin_of(q, clump[MOMENTUM : MOMENTUM + 3], clump[INERTIA : INERTIA + 3])
        clump[SPIN_ENERGY] = 0.5 * (w0 * clump[MOMENTUM] + w1 * clump[MOMENTUM + 1] + w2 * clump[MOMENTUM + 2])
        turn_quaternion(q, 0.5 * dt * w0, 0.5 * dt * w1, 0.5 * dt * w2, q)
        for k in range(3):
            clump[CENTRE + k] += 0.5 * dt * clump[VELOCITY + k]
    for i in range(model.n_particles):
        clump = state.clumps[int(state.body[PLACE, i])]
        q = clump[ATTITUDE : ATTITUDE + 4]
        w0, w1, w2 = spin_of(q, clump[MOMENTUM : MOMENTUM + 3], clump[INERTIA : INERTIA + 3])
        a0, a1, a2 = turn_vector(q, state.body[OFFSET, i], state.body[OFFSET + 1, i], state.body[OFFSET + 2, i])
        u0, u1, u2 = cross(w0, w1, w2, a0, a1, a2)
        g = 0.5 * dt
        state.x[0, i], state.x[1, i], state.x[2, i] = clump[CENTRE] + a0, clump[CENTRE + 1] + a1, clump[CENTRE + 2] + a2
        state.v[0, i], state.v[1, i], state.v[2, i] = clump[VELOCITY] + u0, clump[VELOCITY + 1] + u1, clump[VELOCITY + 2] + u2
        state.w[0, i], state.w[1, i], state.w[2, i] = w0, w1, w2
        for k in range(3):
            rows[i, k] = state.v[k, i] + g * model.gravity[k]
            rows[i, 4 + k] = state.w[k, i]


@kernel(fast=True)
def move_clump(model, clump, f0, f1, f2, t0, t1, t2, dt):
    """Kick and drift one clump under a force [N] and a moment [N m] about its mass centre, world axes.

    Returns
    -------
    power of gravity [W], gain of the clump's kinetic energy per time less that [W], spin at the time of the velocity [rad/s] (3),
    predicted velocity [m/s] (3) and spin [rad/s] (3) in the middle of the next substep
    """
    per_mass, half = 1.0 / clump[MASS], 0.5 * dt
    q, momentum, inertia = clump[ATTITUDE : ATTITUDE + 4], clump[MOMENTUM : MOMENTUM + 3], clump[INERTIA : INERTIA + 3]
    then = clump[AT_VELOCITY : AT_VELOCITY + 4]
    a0 = half * (f0 * per_mass + model.gravity[0])
    a1 = half * (f1 * per_mass + model.gravity[1])
    a2 = half * (f2 * per_mass + model.gravity[2])
    u0, u1, u2 = clump[VELOCITY] + a0, clump[VELOCITY + 1] + a1, clump[VELOCITY + 2] + a2
    falling = clump[MASS] * (model.gravity[0] * u0 + model.gravity[1] * u1 + model.gravity[2] * u2)
    gain = f0 * u0 + f1 * u1 + f2 * u2
    clump[VELOCITY], clump[VELOCITY + 1], clump[VELOCITY + 2] = u0 + a0, u1 + a1, u2 + a2
    momentum[0] += dt * t0
    momentum[1] += dt * t1
    momentum[2] += dt * t2
    w0, w1, w2 = spin_of(q, momentum, inertia)
    turn_quaternion(q, half * w0, half * w1, half * w2, then)
    w0, w1, w2 = spin_of(then, momentum, inertia)
    energy = 0.5 * (w0 * momentum[0] + w1 * momentum[1] + w2 * momentum[2])
    gain += (energy - clump[SPIN_ENERGY]) / dt
    clump[SPIN_ENERGY] = energy
    turn_quaternion(q, dt * w0, dt * w1, dt * w2, q)
    for k in range(3):
        clump[CENTRE + k] += dt * clump[VELOCITY + k]
    b0, b1, b2 = turn_vector_back(q, momentum[0] + half * t0, momentum[1] + half * t1, momentum[2] + half * t2)
    z0, z1, z2 = turn_vector(q, b0 / inertia[0], b1 / inertia[1], b2 / inertia[2])
    return falling, gain, w0, w1, w2, u0 + 2.0 * a0, u1 + 2.0 * a1, u2 + 2.0 * a2, z0, z1, z2


@kernel(fast=True)
def integrate_clumps(model, state, lo, hi, forces, turned, point, dt, work):
    """Kick and drift the clumps of one chunk, and publish their pebbles in the other buffer.

    Adds to `work` what the laws' work misses of the gain in kinetic energy, as for spheres; of a clump that includes the error of the
    rotation's scheme.

    Parameters
    ----------
    lo, hi : slots of the chunk
    forces : force [N] (3), spare, moment about its centre [N m] (3), spare, on each pebble, real (chunk + 1, 8), world axes
    turned : rotation of the reference since the list was made [1] (3, 3); point : its reference point [m] (3,)
    dt : substep [s]; work : (9,) as `Ledger` [W]

    Returns
    -------
    number of pebbles moved beyond the skin, number of pebbles that left the domain
    """
    now = state.clock[PUBLISHED]
    rows, new_rows, points, new_points = state.rows[now], state.rows[1 - now], state.points[now], state.points[1 - now]
    x, body = state.x, state.body
    slack = 0.2475 * model.skin * model.skin
    per_dt = 1.0 / dt
    missed, falling = 0.0, 0.0
    moved, gone = 0, 0
    i = lo
    while i < hi:
        end = clump_end(state, i, hi)
        clump = state.clumps[int(body[PLACE, i])]
        f0, f1, f2, t0, t1, t2, seen = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for p in range(i, end):
            row = forces[p - lo]
            q0, q1, q2 = float(row[0]), float(row[1]), float(row[2])
            m0, m1, m2 = float(row[4]), float(row[5]), float(row[6])
            seen += q0 * rows[p, 0] + q1 * rows[p, 1] + q2 * rows[p, 2] + m0 * rows[p, 4] + m1 * rows[p, 5] + m2 * rows[p, 6]
            c0, c1, c2 = cross(x[0, p] - clump[CENTRE], x[1, p] - clump[CENTRE + 1], x[2, p] - clump[CENTRE + 2], q0, q1, q2)
            f0, f1, f2 = f0 + q0, f1 + q1, f2 + q2
            t0, t1, t2 = t0 + c0 + m0, t1 + c1 + m1, t2 + c2 + m2
        fallen, gain, w0, w1, w2, u0, u1, u2, z0, z1, z2 = move_clump(model, clump, f0, f1, f2, t0, t1, t2, dt)
        falling += fallen
        missed += gain - seen
        q = clump[ATTITUDE : ATTITUDE + 4]
        for p in range(i, end):
            a0, a1, a2 = turn_vector(q, body[OFFSET, p], body[OFFSET + 1, p], body[OFFSET + 2, p])
            c0, c1, c2 = cross(z0, z1, z2, a0, a1, a2)
            r = new_rows[p]
            r[0], r[1], r[2], r[3] = u0 + c0, u1 + c1, u2 + c2, rows[p, 3]
            r[4], r[5], r[6], r[7] = z0, z1, z2, rows[p, 7]
            a0, a1, a2 = clump[CENTRE] + a0, clump[CENTRE + 1] + a1, clump[CENTRE + 2] + a2
            # the mean velocity of the drift is that at the substep's end to second order
            state.v[0, p], state.v[1, p], state.v[2, p] = (a0 - x[0, p]) * per_dt, (a1 - x[1, p]) * per_dt, (a2 - x[2, p]) * per_dt
            state.w[0, p], state.w[1, p], state.w[2, p] = w0, w1, w2
            x[0, p], x[1, p], x[2, p] = a0, a1, a2
            c0, c1, c2 = rotate(turned, state.listed_at[0, p], state.listed_at[1, p], state.listed_at[2, p])
            c0, c1, c2 = a0 - point[0] - c0, a1 - point[1] - c1, a2 - point[2] - c2
            moved += int(c0 * c0 + c1 * c1 + c2 * c2 > slack)
            a0, a1, a2 = a0 - model.centre[0], a1 - model.centre[1], a2 - model.centre[2]
            gone += 1 - int((abs(a0) < model.reach) & (abs(a1) < model.reach) & (abs(a2) < model.reach))
            new_points[p, 0], new_points[p, 1] = fixed_point(a0, model.scale), fixed_point(a1, model.scale)
            new_points[p, 2], new_points[p, 3] = fixed_point(a2, model.scale), points[p, 3]
        i = end
    work[SCHEME] = missed
    work[GRAVITY] = falling
    return moved, gone


@kernel
def number_clumps(state, scratch, n):
    """Bring the rows of the clumps into the order of their pebbles' slots, and tell the pebbles; called by one thread."""
    places, old = state.body[PLACE], scratch.lists.order
    count = 0
    last = like(-1.0, places[0])
    for i in range(n):
        if places[i] != last:
            last = places[i]
            old[count] = int(last)
            count += 1
        places[i] = count - 1
    for k in range(COLUMNS):
        for p in range(count):
            scratch.lists.moved[p] = state.clumps[old[p], k]
        for p in range(count):
            state.clumps[p, k] = scratch.lists.moved[p]


@kernel
def cut_chunks(model, state):
    """Cut the slots into chunks, of whole clumps: the first slot of each chunk, to the last row of `ChargeState.listed`."""
    n, bounds = model.n_particles, state.listed[2]
    c, lo, i = 0, 0, 0
    bounds[0] = 0
    while i < n:
        end = clump_end(state, i, n) if state.clumps.shape[0] > 0 else min(i + model.chunk, n)
        if end - lo > model.chunk:  # a new chunk begins with this clump
            c += 1
            bounds[c] = i
            lo = i
        i = end
    for k in range(c + 1, bounds.shape[0]):
        bounds[k] = n
