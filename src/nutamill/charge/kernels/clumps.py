"""Rigid clumps of spheres (pebbles): the numbers of a clump, how its motion begins, and the order of clumps
in the slots.

A pebble has a slot like any sphere, and the slots of a clump are neighbours in one chunk.  The law sees a
pebble's own centre, velocity and radius with the mass and the spin of its clump.
"""

from enum import IntEnum

from nutamill.base.frames import cross, turn_quaternion, turn_vector, turn_vector_back
from nutamill.base.kernel import kernel, like
from nutamill.charge.kernels.team import barrier, thread_share
from nutamill.charge.model import Clock

PUBLISHED = int(Clock.PUBLISHED)


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

OFFSET, CLUMP = 4, 7
"""Rows of `ChargeState.mass_props` that only pebbles have: centre in the clump's axes, place of the clump."""

CENTRE, VELOCITY, MOMENTUM, ATTITUDE, MASS, INERTIA, SPIN_ENERGY, ID, AT_VELOCITY = (
    int(c) for c in ClumpColumn
)


@kernel(inline="always")
def spin_of(q, momentum, inertia):
    """Return the spin [rad/s] (3 numbers), world axes, of a body at attitude `q` (4,) with angular momentum
    (3,) and principal moments (3,).
    """
    a, b, c = turn_vector_back(q, momentum[0], momentum[1], momentum[2])
    return turn_vector(q, a / inertia[0], b / inertia[1], c / inertia[2])


@kernel
def clump_end(state, i, hi):
    """Return the first slot behind the clump of slot `i`. `hi` ends the chunk."""
    place = state.mass_props[CLUMP, i]
    end = i + 1
    while end < hi and state.mass_props[CLUMP, end] == place:
        end += 1
    return end


@kernel
def start_clumps(model, state, dt):
    """Return the drift every clump by half a substep, and publish positions and predicted velocities of its
    pebbles.
    """
    rows = state.published_rows[state.clock[PUBLISHED]]
    for p in range(state.clumps.shape[0]):
        clump = state.clumps[p]
        q = clump[ATTITUDE : ATTITUDE + 4]
        for k in range(4):
            clump[AT_VELOCITY + k] = q[k]
        w0, w1, w2 = spin_of(q, clump[MOMENTUM : MOMENTUM + 3], clump[INERTIA : INERTIA + 3])
        clump[SPIN_ENERGY] = 0.5 * (
            w0 * clump[MOMENTUM] + w1 * clump[MOMENTUM + 1] + w2 * clump[MOMENTUM + 2]
        )
        turn_quaternion(q, 0.5 * dt * w0, 0.5 * dt * w1, 0.5 * dt * w2, q)
        for k in range(3):
            clump[CENTRE + k] += 0.5 * dt * clump[VELOCITY + k]
    for i in range(model.n_particles):
        clump = state.clumps[int(state.mass_props[CLUMP, i])]
        q = clump[ATTITUDE : ATTITUDE + 4]
        w0, w1, w2 = spin_of(q, clump[MOMENTUM : MOMENTUM + 3], clump[INERTIA : INERTIA + 3])
        a0, a1, a2 = turn_vector(
            q, state.mass_props[OFFSET, i], state.mass_props[OFFSET + 1, i], state.mass_props[OFFSET + 2, i]
        )
        u0, u1, u2 = cross(w0, w1, w2, a0, a1, a2)
        g = 0.5 * dt
        state.x[0, i], state.x[1, i], state.x[2, i] = (
            clump[CENTRE] + a0,
            clump[CENTRE + 1] + a1,
            clump[CENTRE + 2] + a2,
        )
        state.v[0, i], state.v[1, i], state.v[2, i] = (
            clump[VELOCITY] + u0,
            clump[VELOCITY + 1] + u1,
            clump[VELOCITY + 2] + u2,
        )
        rows[i, 4], rows[i, 5], rows[i, 6] = w0, w1, w2
        for k in range(3):
            rows[i, k] = state.v[k, i] + g * model.gravity[k]


@kernel
def number_clumps(state, scratch, n, tid, n_threads):
    """Sort the rows of the clumps in the order of their pebbles' slots, and renumber them there. Called by
    all threads of the team.
    """
    places, old, starts = state.mass_props[CLUMP], scratch.lists.order, scratch.lists.votes
    lo, hi = thread_share(n, tid, n_threads)
    # before any thread renumbers: which clump the slot before this share belongs to
    before = places[lo - 1] if lo > 0 else like(-1.0, places[0])
    last, count = before, 0
    for i in range(lo, hi):
        count += int(places[i] != last)
        last = places[i]
    starts[tid] = count
    barrier(scratch.barrier, n_threads)
    count = 0
    for t in range(tid):
        count += starts[t]
    last = before
    for i in range(lo, hi):
        if places[i] != last:
            last = places[i]
            old[count] = int(last)
            count += 1
        places[i] = count - 1
    barrier(scratch.barrier, n_threads)
    lo, hi = thread_share(state.clumps.shape[0], tid, n_threads)
    for k in range(COLUMNS):
        for p in range(lo, hi):
            scratch.lists.moved[p] = state.clumps[old[p], k]
        barrier(scratch.barrier, n_threads)
        for p in range(lo, hi):
            state.clumps[p, k] = scratch.lists.moved[p]
        barrier(scratch.barrier, n_threads)
