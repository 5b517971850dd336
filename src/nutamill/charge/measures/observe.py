"""Sums over a charge at the end of a window: energies, contacts, mass centre, momentum."""

from typing import NamedTuple

import numpy as np

from nutamill.base.kernel import kernel, like
from nutamill.charge.kernels.chunks import chunks_of_group, slots_of_chunk
from nutamill.charge.kernels.clumps import CENTRE, CLUMP, MASS, SPIN_ENERGY, VELOCITY
from nutamill.charge.kernels.team import barrier, thread_share
from nutamill.charge.laws.composition import stored_energy
from nutamill.charge.model import ChargeModel, ChargeScratch, ChargeState, Clock, stamp_of, without_law
from nutamill.charge.walls.surfaces import place_surfaces
from nutamill.charge.walls.walls import wall_overlap

STEP, LIST = int(Clock.STEP), int(Clock.LIST)

PAIRS, WALLS, CONTACTS, MOMENT, MOMENTUM, WHOLE = 2, 5, 8, 10, 13, 16
"""Where the sums of a chunk begin, behind the two kinetic energies [J]: energies stored in the springs of
pairs and of walls [J] (3 each), pair contacts and wall contacts [1], mass times position [kg m] (3), momentum
[kg m/s] (3), mass [kg].
"""
READINGS = 17
"""Number of these sums [1]."""


class ChargeReading(NamedTuple):
    """Present sums over the charge, at the time of its velocities."""

    energy: np.ndarray
    """Kinetic energy of translation and rotation, energy stored in normal, tangential and rolling springs of
    pairs, and of walls [J] (8,)."""
    contacts: np.ndarray
    """Pair contacts, wall contacts [1] (2,)."""
    mass_centre: np.ndarray
    """[m] (3,), world."""
    momentum: np.ndarray
    """[kg m/s] (3,), world axes."""
    coordination: np.ndarray
    """Mean number of particles a particle touches [1] (1,)."""


def charge_reading() -> ChargeReading:
    """Return an empty `ChargeReading` for `observe` to fill."""
    return ChargeReading(np.zeros(8), np.zeros(2), np.zeros(3), np.zeros(3), np.zeros(1))


@kernel
def observe_pairs(model, state, c, back, last, out):
    """Add energies and number of the touching pairs of chunk `c`, `back` [s] before the positions."""
    lst = state.clock[LIST]
    x, v, mass_props = state.x, state.v, state.mass_props
    lo, hi = slots_of_chunk(state, c)
    for p in range(state.pairs.counts[lst, c]):
        i, j = lo + state.pairs.owners[lst, c, p], state.pairs.partners[lst, c, p]
        square = 0.0
        for k in range(3):
            gap = x[k, j] - x[k, i] - back * (v[k, j] - v[k, i])
            square += gap * gap
        overlap = mass_props[0, i] + mass_props[0, j] - square**0.5
        if overlap > 0.0:
            weight = 1.0 if j < hi and j >= lo else 0.5
            a, b = mass_props[0, i], mass_props[0, j]
            law = model.law_of[state.material[i], state.material[j]]
            normal, tangential, rolling = stored_energy(
                model.law,
                model.laws[law],
                state.pairs.memory[lst, c, p],
                last,
                overlap,
                a,
                b,
                a * b / (a + b),
            )
            out[PAIRS] += weight * normal
            out[PAIRS + 1] += weight * tangential
            out[PAIRS + 2] += weight * rolling
            out[CONTACTS] += weight


@kernel
def observe_walls(model, state, c, surface_poses, back, last, out):
    """Add energies and number of the wall contacts of chunk `c`, `back` [s] before the positions, surfaces at
    `surface_poses` (S, 12).
    """
    n_surfaces = model.surface_kind.shape[0]
    x, v = state.x, state.v
    lo, hi = slots_of_chunk(state, c)
    for i in range(lo, hi):
        r = state.mass_props[0, i]
        for s in range(n_surfaces):
            overlap, _, _, _ = wall_overlap(
                model.surface_kind[s],
                without_law(model),
                surface_poses,
                s,
                x[0, i] - back * v[0, i],
                x[1, i] - back * v[1, i],
                x[2, i] - back * v[2, i],
                r,
            )
            if overlap > 0.0:
                law = model.law_of[state.material[i], model.surface_material[s]]
                normal, tangential, rolling = stored_energy(
                    model.law, model.laws[law], state.wall_memory[i * n_surfaces + s], last, overlap, r, r, r
                )
                out[WALLS] += normal
                out[WALLS + 1] += tangential
                out[WALLS + 2] += rolling
                out[CONTACTS + 1] += 1.0


@kernel
def observe_clumps(state, c, back, out):
    """Add mass, motion and kinetic energies of the clumps of chunk `c`, `back` [s] before the positions."""
    lo, hi = slots_of_chunk(state, c)
    if lo == hi:
        return
    for p in range(int(state.mass_props[CLUMP, lo]), int(state.mass_props[CLUMP, hi - 1]) + 1):
        clump = state.clumps[p]
        out[WHOLE] += clump[MASS]
        v2 = 0.0
        for k in range(3):
            v = clump[VELOCITY + k]
            v2 += v * v
            out[MOMENT + k] += clump[MASS] * (clump[CENTRE + k] - back * v)
            out[MOMENTUM + k] += clump[MASS] * v
        out[0] += 0.5 * clump[MASS] * v2
        out[1] += clump[SPIN_ENERGY]


@kernel
def observe_spheres(state, c, back, out):
    """Add mass, motion and kinetic energies of the spheres of chunk `c`, `back` [s] before the positions."""
    lo, hi = slots_of_chunk(state, c)
    for i in range(lo, hi):
        m, per_inertia = state.mass_props[1, i], state.mass_props[3, i]
        out[WHOLE] += m
        v2, w2 = 0.0, 0.0
        for k in range(3):
            v, w = state.v[k, i], state.w[k, i]
            v2 += v * v
            w2 += w * w
            out[MOMENT + k] += m * (state.x[k, i] - back * v)
            out[MOMENTUM + k] += m * v
        out[0] += 0.5 * m * v2
        out[1] += 0.5 * w2 / per_inertia


@kernel
def observe(
    model: ChargeModel,
    state: ChargeState,
    scratch: ChargeScratch,
    out: ChargeReading,
    tid: int,
    n_threads: int,
):
    """Read the charge at the end of the last window. Called by all threads of a team, each for its share of
    the chunks.

    Nobody may change the state meanwhile.  The sums of chunks are added up in the order of the chunks, so
    that they have the same bits on any number of threads.

    Parameters
    ----------
    model, state, scratch : the charge, between two windows
    out : filled by thread 0, see `charge_reading`
    """
    back = 0.5 * state.last_dt[0]
    last = like(stamp_of(state.clock[STEP] - 1), state.published_rows[0, 0, 0])
    poses = scratch.surface_poses[tid]
    place_surfaces(without_law(model), state.poses, poses)
    groups = scratch.group_work.shape[0]
    begin, behind = thread_share(groups, tid, n_threads)
    for g in range(begin, behind):
        first, end = chunks_of_group(scratch, g)
        for c in range(first, end):
            sums = scratch.readings[c]
            for k in range(READINGS):
                sums[k] = 0.0
            if state.clumps.shape[0] > 0:
                observe_clumps(state, c, back, sums)
            else:
                observe_spheres(state, c, back, sums)
            observe_pairs(model, state, c, back, last, sums)
            observe_walls(model, state, c, poses, back, last, sums)
            for k in range(READINGS if c > first else 0):
                scratch.readings[first, k] += sums[k]
    barrier(scratch.barrier, n_threads)
    if tid == 0:
        sums = scratch.readings[0]
        for g in range(1, groups):
            first, _ = chunks_of_group(scratch, g)
            for k in range(READINGS):
                sums[k] += scratch.readings[first, k]
        for k in range(8):
            out.energy[k] = sums[k]
        for k in range(2):
            out.contacts[k] = sums[CONTACTS + k]
        for k in range(3):
            out.mass_centre[k] = sums[MOMENT + k] / sums[WHOLE]
            out.momentum[k] = sums[MOMENTUM + k]
        particles = state.clumps.shape[0] if state.clumps.shape[0] > 0 else model.n_particles
        out.coordination[0] = 2.0 * out.contacts[0] / particles
