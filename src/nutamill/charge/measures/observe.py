"""Sums over a charge at the end of a window: energies, contacts, mass centre, momentum."""

from typing import NamedTuple

import numpy as np

from nutamill.base.kernel import kernel, like
from nutamill.charge.kernels.clumps import CENTRE, MASS, SPIN_ENERGY, VELOCITY
from nutamill.charge.kernels.neighbours import slots_of_chunk
from nutamill.charge.laws.composition import stored_energy
from nutamill.charge.model import ChargeModel, ChargeScratch, ChargeState, Clock, stamp_of
from nutamill.charge.walls.surfaces import place_surfaces
from nutamill.charge.walls.walls import wall_overlap

STEP, PUBLISHED, LIST = int(Clock.STEP), int(Clock.PUBLISHED), int(Clock.LIST)


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
def observe_pairs(model, state, back, last, out):
    """Add energies and number of the touching pairs, `back` [s] before the positions."""
    lst = state.clock[LIST]
    x, v, mass_props = state.x, state.v, state.mass_props
    for c in range(state.pairs.counts.shape[1] - 1):
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
                out.energy[2] += weight * normal
                out.energy[3] += weight * tangential
                out.energy[4] += weight * rolling
                out.contacts[0] += weight


@kernel
def observe_walls(model, state, surface_poses, back, last, out):
    """Add energies and number of the wall contacts, `back` [s] before the positions, surfaces at
    `surface_poses` (S, 12).
    """
    n_surfaces = model.surface_kind.shape[0]
    x, v = state.x, state.v
    for i in range(model.n_particles):
        r = state.mass_props[0, i]
        for s in range(n_surfaces):
            overlap, _, _, _ = wall_overlap(
                model.surface_kind[s],
                model,
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
                out.energy[5] += normal
                out.energy[6] += tangential
                out.energy[7] += rolling
                out.contacts[1] += 1.0


@kernel
def observe(model: ChargeModel, state: ChargeState, scratch: ChargeScratch, out: ChargeReading):
    """Read the charge at the end of the last window. Called by one thread.

    Parameters
    ----------
    model, state, scratch : the charge, between two windows
    out : filled, see `charge_reading`
    """
    out.energy[:] = 0.0
    out.contacts[:] = 0.0
    out.mass_centre[:] = 0.0
    out.momentum[:] = 0.0
    back = 0.5 * state.last_dt[0]
    total = 0.0
    for p in range(state.clumps.shape[0]):
        clump = state.clumps[p]
        total += clump[MASS]
        v2 = 0.0
        for k in range(3):
            v = clump[VELOCITY + k]
            v2 += v * v
            out.mass_centre[k] += clump[MASS] * (clump[CENTRE + k] - back * v)
            out.momentum[k] += clump[MASS] * v
        out.energy[0] += 0.5 * clump[MASS] * v2
        out.energy[1] += clump[SPIN_ENERGY]
    for i in range(model.n_particles if state.clumps.shape[0] == 0 else 0):
        m, per_inertia = state.mass_props[1, i], state.mass_props[3, i]
        total += m
        v2, w2 = 0.0, 0.0
        for k in range(3):
            v, w = state.v[k, i], state.w[k, i]
            v2 += v * v
            w2 += w * w
            out.mass_centre[k] += m * (state.x[k, i] - back * v)
            out.momentum[k] += m * v
        out.energy[0] += 0.5 * m * v2
        out.energy[1] += 0.5 * w2 / per_inertia
    for k in range(3):
        out.mass_centre[k] /= total
    last = like(stamp_of(state.clock[STEP] - 1), state.published_rows[0, 0, 0])
    place_surfaces(model, state.poses, scratch.surface_poses[0])
    observe_pairs(model, state, back, last, out)
    observe_walls(model, state, scratch.surface_poses[0], back, last, out)
    particles = state.clumps.shape[0] if state.clumps.shape[0] > 0 else model.n_particles
    out.coordination[0] = 2.0 * out.contacts[0] / particles
