"""The walls of a charge whose particles another program moves: one substep of walls for its atom_state.

The other program is a velocity Verlet: when it asks for forces, positions belong to the middle of a substep
of ours and velocities to its start, as in `nutamill.charge.kernels.dynamics`.  Walls, laws and sums are those
of that file.

An atom costs what is moved through memory for it.  So the places of a chunk are copied into the first slots,
which stay in the cache, and all else of those atoms only that touch a wall.
"""

from typing import NamedTuple

import numpy as np

from nutamill.base.kernel import kernel, like
from nutamill.charge.kernels.alarm import name_the_worst
from nutamill.charge.kernels.dynamics import LEFT, WALL, move_bodies
from nutamill.charge.kernels.publish import fixed_point, publish
from nutamill.charge.kernels.wall_contacts import find_walls, wall_contacts
from nutamill.charge.model import Clock, Ledger, stamp_of, without_law
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
def take_atom(model, state, atom_state, i, slot):
    """Copy atom `i`, at the middle of a substep, into a slot: position, velocity at the start of the substep,
    and the one that the law sees.
    """
    rows = state.published_rows[state.clock[PUBLISHED]]
    mass, radius = atom_state.mass[i], atom_state.radius[i]
    state.ids[slot], state.material[slot] = atom_state.id[i] - 1, atom_state.type[i] - 1
    state.mass_props[0, slot], state.mass_props[1, slot] = radius, mass
    state.mass_props[2, slot], state.mass_props[3, slot] = 1.0 / mass, 2.5 / (mass * radius * radius)
    rows[slot, 3], rows[slot, 7] = mass, radius
    for k in range(3):
        state.x[k, slot], state.v[k, slot], state.w[k, slot] = (
            atom_state.x[i, k],
            atom_state.v[i, k],
            atom_state.w[i, k],
        )
        rows[slot, k], rows[slot, 4 + k] = (
            atom_state.v[i, k] + atom_state.kick[i, k],
            atom_state.w[i, k] + atom_state.kick[i, 3 + k],
        )
    publish(without_law(model), state, slot)


@kernel
def take_atoms(model, state, atom_state, n):
    """Copy `n` atoms, at the middle of a substep, into the slots, as `take_atom`."""
    bounds = state.pairs.counts[2]
    for c in range(bounds.shape[0]):
        bounds[c] = min(c * model.chunk, n)
    for i in range(n):
        take_atom(model, state, atom_state, i, i)


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
        publish(without_law(model), state, i)


@kernel(fast=True)
def place_chunk(model, state, x, radius, lo, hi, first, local_out):
    """Copy the places `x` [m] (m, 3), world, and radii [m] of the atoms `lo` to `hi` to the slots from
    `first` on, and write two corners around them to `local_out`, for the sphere of `find_walls` about them.
    """
    l0, l1, l2 = x[lo, 0], x[lo, 1], x[lo, 2]
    h0, h1, h2 = l0, l1, l2
    for i in range(lo, hi):
        slot, a, b, c = first + i - lo, x[i, 0], x[i, 1], x[i, 2]
        state.x[0, slot], state.x[1, slot], state.x[2, slot] = a, b, c
        state.mass_props[0, slot] = radius[i]
        l0, l1, l2 = min(l0, a), min(l1, b), min(l2, c)
        h0, h1, h2 = max(h0, a), max(h1, b), max(h2, c)
    local_out[0, 0] = fixed_point(l0 - model.centre[0], model.scale)
    local_out[0, 1] = fixed_point(l1 - model.centre[1], model.scale)
    local_out[0, 2] = fixed_point(l2 - model.centre[2], model.scale)
    last = min(hi - lo, 2) - 1
    local_out[last, 0] = fixed_point(h0 - model.centre[0], model.scale)
    local_out[last, 1] = fixed_point(h1 - model.centre[1], model.scale)
    local_out[last, 2] = fixed_point(h2 - model.centre[2], model.scale)
    for l in range(2, hi - lo):
        for k in range(3):
            local_out[l, k] = local_out[1, k]


@kernel(fast=True)
def push_walls(model, state, scratch, atom_state, c, lo, hi, dt):
    """Write the forces of the walls on the atoms `lo` to `hi`, chunk `c`, to ``scratch.forces[0]`` if there
    are any, and book their works.

    Returns
    -------
    number of contacts, number of overlaps beyond their limit
    """
    n, n_surfaces = hi - lo, model.surface_kind.shape[0]
    # the wall list of meshes belongs to slots: there each atom has its own
    first = lo if scratch.near.bodies.shape[0] > 0 else 0
    rows = state.published_rows[state.clock[PUBLISHED]]
    forces, work, lanes, local = scratch.forces[0], scratch.work[c], scratch.lanes[0], scratch.local[0]
    real = rows[0, 0]
    now, last = like(stamp_of(state.clock[STEP]), real), like(stamp_of(state.clock[STEP] - 1), real)
    place_chunk(model, state, atom_state.x, atom_state.radius, lo, hi, first, local)
    n_walls = find_walls(
        model.law.film,
        without_law(model),
        scratch.near,
        state.x,
        state.mass_props[0],
        0.0,
        local,
        scratch.motion[0],
        scratch.surface_poses[0],
        first,
        n,
        0,
        lanes,
        scratch.measured[0],
        scratch.test[0],
    )
    if n_walls == 0:
        return 0, 0.0
    for q in range(n_walls):
        slot = int(lanes[1, q])
        take_atom(model, state, atom_state, lo + slot - first, slot)
        lanes[3, q] += np.uint32((lo - first) * n_surfaces)  # the memory belongs to the atom, not to the slot
    for l in range(forces.shape[0]):
        for k in range(8):
            forces[l, k] = like(0.0, real)
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
    return n_walls, float(beyond)


@kernel(fast=True)
def kick_chunk(model, atom_state, forces, touched, lo, hi, dt, force_out, work_out):
    """Write the forces of walls and gravity on the atoms `lo` to `hi` for the other program, and what all
    forces add to the velocities.

    Books the works of a substep on its mean velocities.

    Parameters
    ----------
    forces : of the walls, as ``ChargeScratch.forces[0]``
    touched : whether there are any
    force_out : force of walls and gravity [N] (n, 3), world axes

    Returns
    -------
    number of atoms outside the domain
    """
    falling, pairs, missed = 0.0, 0.0, 0.0
    left, half = 0, 0.5 * dt
    for i in range(lo, hi):
        mass, radius = atom_state.mass[i], atom_state.radius[i]
        per_mass, per_inertia = 1.0 / mass, 2.5 / (mass * radius * radius)
        inside = True
        for k in range(3):
            of_pairs, of_moments, weight = (
                atom_state.force[i, k],
                atom_state.moment[i, k],
                mass * model.gravity[k],
            )
            push, moment = (float(forces[i - lo, k]), float(forces[i - lo, 4 + k])) if touched else (0.0, 0.0)
            kick = half * per_mass * (of_pairs + push + weight)
            spin_kick = half * per_inertia * (of_moments + moment)
            u, z = atom_state.v[i, k] + kick, atom_state.w[i, k] + spin_kick
            pairs += of_pairs * u + of_moments * z
            falling += weight * u
            force_out[i, k] = push + weight
            if touched:
                # what the law has seen is the velocity with the kick before
                missed += push * (kick - atom_state.kick[i, k]) + moment * (
                    spin_kick - atom_state.kick[i, 3 + k]
                )
                atom_state.moment[i, k] = of_moments + moment
            atom_state.kick[i, k], atom_state.kick[i, 3 + k] = kick, spin_kick
            inside = inside and abs(atom_state.x[i, k] - model.centre[k]) < model.reach
        left += 0 if inside else 1
    work_out[PAIR_NORMAL], work_out[GRAVITY], work_out[SCHEME] = pairs, falling, missed
    return left


@kernel
def push_chunk(model, state, scratch, atom_state, c, lo, hi, dt, force_out):
    """Add walls and gravity to the atoms `lo` to `hi`, chunk `c`, and their sums to the state."""
    work, sums = scratch.work[c], scratch.sums[c]
    for k in range(work.shape[0]):
        work[k] = 0.0
    for b in range(model.n_bodies):
        for k in range(6):
            sums[b, k] = 0.0
    n_walls, beyond = push_walls(model, state, scratch, atom_state, c, lo, hi, dt)
    left = kick_chunk(model, atom_state, scratch.forces[0], n_walls > 0, lo, hi, dt, force_out, work)
    scratch.alarms[c] = WALL * int(beyond > 0) + LEFT * int(left > 0)
    for k in range(state.ledger.size):
        state.ledger[k] += dt * work[k]
    for b in range(model.n_bodies):
        for k in range(6):
            state.impulse[b, k] += dt * sums[b, k]


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
    move_bodies(motions, since, scratch.motion[0], scratch.twists[0])
    place_surfaces(without_law(model), scratch.motion[0], scratch.surface_poses[0])
    alarms = 0
    for c in range(scratch.alarms.shape[0]):
        lo, hi = min(c * model.chunk, n), min((c + 1) * model.chunk, n)
        scratch.alarms[c] = 0
        if hi > lo:
            push_chunk(model, state, scratch, atom_state, c, lo, hi, dt, force_out)
            alarms |= scratch.alarms[c]
    if alarms > 0 and state.status[0] == 0:
        take_atoms(model, state, atom_state, n)
        name_the_worst(without_law(model), state, scratch)
    state.clock[STEP] += 1
