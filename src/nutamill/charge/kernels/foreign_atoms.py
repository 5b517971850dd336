"""The walls of a charge whose particles another program moves: one substep of walls for its atom_state.

The other program is a velocity Verlet: when it asks for forces, positions belong to the middle of a substep
of ours and velocities to its start, as in `nutamill.charge.kernels.dynamics`.  Walls, laws and sums are those
of that file; here the atoms of the other program are copied into the slots, in its order.
"""

from typing import NamedTuple

import numpy as np

from nutamill.base.kernel import kernel, like
from nutamill.charge.kernels.alarm import name_the_worst
from nutamill.charge.kernels.chunks import slots_of_chunk
from nutamill.charge.kernels.dynamics import LEFT, WALL, move_bodies
from nutamill.charge.kernels.publish import publish
from nutamill.charge.kernels.wall_contacts import find_walls, wall_contacts
from nutamill.charge.model import Clock, Ledger, stamp_of
from nutamill.charge.walls.surfaces import place_surfaces

STEP, PUBLISHED = int(Clock.STEP), int(Clock.PUBLISHED)
PAIR_NORMAL, WALL_NORMAL = int(Ledger.PAIR_NORMAL), int(Ledger.WALL_NORMAL)
INTERFACE, GRAVITY, SCHEME = int(Ledger.INTERFACE), int(Ledger.GRAVITY), int(Ledger.SCHEME)


class AtomState(NamedTuple):
    """Arrays of the other program, in its order, with room for ``m`` atom_state."""

    id: np.ndarray
    """Id of the particle, from 1 [1] (m,)."""
    type: np.ndarray
    """Material, from 1 [1] (m,)."""
    x: np.ndarray
    """Positions [m] (m, 3), world."""
    v: np.ndarray
    """Velocities [m/s] (m, 3), world axes."""
    w: np.ndarray
    """Spins [rad/s] (m, 3), world axes."""
    radius: np.ndarray
    """[m] (m,)."""
    mass: np.ndarray
    """[kg] (m,)."""
    force: np.ndarray
    """Force of the pairs [N] (m, 3), world axes."""
    moment: np.ndarray
    """Moment of the pairs, and after `push_atoms` of all contacts [N m] (m, 3), world axes."""
    kick: np.ndarray
    """What the last forces add to velocity [m/s] and spin [rad/s] in half a substep (m, 6), world axes."""
    wall: np.ndarray
    """Memory of the contacts with walls, as `ChargeState.wall_memory`, of atom i and surface s in row i S + s
    (m S, 8); the last row is spare.
    """


@kernel
def take_atoms(model, state, atom_state, n):
    """Copy `n` atoms, at the middle of a substep, into the slots: positions, velocities at the start of the
    substep, and those that the law sees.
    """
    rows = state.published_rows[state.clock[PUBLISHED]]
    bounds = state.pairs.counts[2]
    for c in range(bounds.shape[0]):
        bounds[c] = min(c * model.chunk, n)
    for i in range(n):
        mass, radius = atom_state.mass[i], atom_state.radius[i]
        state.ids[i], state.material[i] = atom_state.id[i] - 1, atom_state.type[i] - 1
        state.mass_props[0, i], state.mass_props[1, i] = radius, mass
        state.mass_props[2, i], state.mass_props[3, i] = 1.0 / mass, 2.5 / (mass * radius * radius)
        rows[i, 3], rows[i, 7] = mass, radius
        for k in range(3):
            state.x[k, i], state.v[k, i], state.w[k, i] = (
                atom_state.x[i, k],
                atom_state.v[i, k],
                atom_state.w[i, k],
            )
            rows[i, k], rows[i, 4 + k] = (
                atom_state.v[i, k] + atom_state.kick[i, k],
                atom_state.w[i, k] + atom_state.kick[i, 3 + k],
            )
        publish(model, state, i)


@kernel
def finish_atoms(model, state, atom_state, n, dt):
    """Copy `n` atoms at the end of a window into the slots, as a march of this engine leaves them: velocities
    at the end of the last substep, positions half a substep later.
    """
    take_atoms(model, state, atom_state, n)
    rows = state.published_rows[state.clock[PUBLISHED]]
    for i in range(n):
        for k in range(3):
            # the other program has added half of the last forces
            state.v[k, i], state.w[k, i] = rows[i, k], rows[i, 4 + k]
            state.x[k, i] += dt * state.v[k, i]
            rows[i, k] += atom_state.kick[i, k]
            rows[i, 4 + k] += atom_state.kick[i, 3 + k]
        publish(model, state, i)


@kernel(fast=True)
def push_chunk(model, state, scratch, atom_state, c, dt, force_out):
    """Add walls and gravity to the atoms of chunk `c`. Arguments are those of `push_atoms`."""
    lo, hi = slots_of_chunk(state, c)
    rows = state.published_rows[state.clock[PUBLISHED]]
    forces, work, lanes = scratch.forces[0], scratch.work[c], scratch.lanes[0]
    real = rows[0, 0]
    now, last = like(stamp_of(state.clock[STEP]), real), like(stamp_of(state.clock[STEP] - 1), real)
    for l in range(forces.shape[0]):
        for k in range(8):
            forces[l, k] = like(0.0, real)
    for b in range(model.n_bodies):
        for k in range(6):
            scratch.sums[c, b, k] = 0.0
    points = state.published_points[state.clock[PUBLISHED]]
    n_walls = find_walls(
        model,
        scratch.near,
        state.x,
        state.mass_props[0],
        0.0,
        points[lo:hi],
        scratch.motion[0],
        scratch.surface_poses[0],
        lo,
        hi - lo,
        0,
        lanes,
        scratch.measured[0],
        scratch.test[0],
    )
    # a charge with films stays in this engine: their reach is 0, and so is their power
    work[WALL_NORMAL], work[WALL_NORMAL + 1], work[WALL_NORMAL + 2], work[INTERFACE], _, beyond = (
        wall_contacts(
            model,
            state.x,
            state.mass_props[0],
            rows,
            state.material,
            scratch.twists[0],
            scratch.surface_poses[0],
            scratch.measured[0],
            n_walls,
            last,
            now,
            like(dt, real),
            0,
            lanes,
            atom_state.wall,
            scratch.columns[0, 1],
            forces,
            scratch.sums[c],
            state.impacts,
        )
    )
    left = kick_atoms(model, state, atom_state, rows, forces, lo, hi, dt, force_out, work)
    scratch.alarms[c] = WALL * int(beyond > 0) + LEFT * int(left > 0)


@kernel
def kick_atoms(model, state, atom_state, rows, forces, lo, hi, dt, force_out, work_out):
    """Write the forces of walls and gravity on the atoms `lo` to `hi` for the other program.

    Books the works of a substep, all on its mean velocities.

    Returns
    -------
    number of atoms outside the domain
    """
    missed, falling, pairs = 0.0, 0.0, 0.0
    left, half = 0, 0.5 * dt
    for i in range(lo, hi):
        mass, per_mass, per_inertia = state.mass_props[1, i], state.mass_props[2, i], state.mass_props[3, i]
        inside = True
        for k in range(3):
            push, moment = float(forces[i - lo, k]), float(forces[i - lo, 4 + k])
            of_pairs, moment_of_pairs = atom_state.force[i, k], atom_state.moment[i, k]
            force_out[i, k] = push + mass * model.gravity[k]
            atom_state.moment[i, k] = moment_of_pairs + moment
            kick = half * (per_mass * (of_pairs + push) + model.gravity[k])
            spin_kick = half * per_inertia * (moment_of_pairs + moment)
            u, z = state.v[k, i] + kick, state.w[k, i] + spin_kick
            missed += push * (u - rows[i, k]) + moment * (z - rows[i, 4 + k])
            pairs += of_pairs * u + moment_of_pairs * z
            falling += mass * model.gravity[k] * u
            atom_state.kick[i, k], atom_state.kick[i, 3 + k] = kick, spin_kick
            inside = inside and abs(state.x[k, i] - model.centre[k]) < model.reach
        left += 0 if inside else 1
    work_out[PAIR_NORMAL] = pairs
    work_out[SCHEME] = missed
    work_out[GRAVITY] = falling
    return left


@kernel
def push_atoms(model, state, scratch, motions, atom_state, n, since, dt, force_out):
    """Add the forces of walls and gravity to `n` atoms of another program, in the middle of a substep.

    The sums of the window are added to ``state.impulse`` and ``state.ledger``; the work of pairs is one
    number, at `Ledger.PAIR_NORMAL`.  A contact beyond its limit, or an atom that left the domain, is in
    ``state.status``.

    Parameters
    ----------
    motions : (n_bodies, 19) motion of each body over the window, as `frames.MOTION_SIZE`, world axes
    atom_state : arrays of the other program; its `moment`, `kick` and `wall` are written
    n : number of atoms [1]
    since : time from the start of the window to the middle of the substep [s]
    dt : substep [s]
    force_out : force of walls and gravity [N] (n, 3), world axes
    """
    take_atoms(model, state, atom_state, n)
    move_bodies(motions, since, scratch.motion[0], scratch.twists[0])
    place_surfaces(model, scratch.motion[0], scratch.surface_poses[0])
    alarms = 0
    for c in range(scratch.alarms.shape[0]):
        lo, hi = slots_of_chunk(state, c)
        if hi > lo:
            push_chunk(model, state, scratch, atom_state, c, dt, force_out)
            alarms |= scratch.alarms[c]
            for k in range(state.ledger.size):
                state.ledger[k] += dt * scratch.work[c, k]
            for b in range(model.n_bodies):
                for k in range(6):
                    state.impulse[b, k] += dt * scratch.sums[c, b, k]
    if alarms > 0 and state.status[0] == 0:
        name_the_worst(model, state, scratch)
    state.clock[STEP] += 1
