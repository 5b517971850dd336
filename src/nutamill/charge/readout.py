"""Motion of the particles of a charge by their ids, and the forces of their contacts, as plain arrays."""

import numpy as np

from nutamill.charge.kernels.clumps import ClumpColumn
from nutamill.charge.model import ChargeModel, ChargeState, Clock
from nutamill.charge.pebbles import rotation_matrices


def positions(model: ChargeModel, state: ChargeState, dt: float) -> np.ndarray:
    """Return the mass centres [m] (n, 3) by particle id, world, at the time of the velocities. `dt` is the
    substep [s] of the last window.
    """
    if len(state.clumps):
        centre, velocity = (
            _clumps_by_id(state, column, 3) for column in (ClumpColumn.CENTRE, ClumpColumn.VELOCITY)
        )
        return centre - 0.5 * dt * velocity
    n = model.n_particles
    return _by_id(state, state.x[:, :n] - 0.5 * dt * state.v[:, :n])


def velocities(model: ChargeModel, state: ChargeState) -> np.ndarray:
    """Return the velocities [m/s] (n, 3) of the mass centres by particle id, world axes."""
    if len(state.clumps):
        return _clumps_by_id(state, ClumpColumn.VELOCITY, 3)
    return _by_id(state, state.v[:, : model.n_particles])


def spins(model: ChargeModel, state: ChargeState) -> np.ndarray:
    """Return the spins [rad/s] (n, 3) by particle id, world axes."""
    if len(state.clumps):
        out = np.empty((len(state.clumps), 3))
        out[state.clumps[:, ClumpColumn.ID].astype(int)] = clump_spins(state.clumps)
        return out
    return _by_id(state, state.w[:, : model.n_particles])


def clump_spins(clumps: np.ndarray) -> np.ndarray:
    """Return the spins [rad/s] (n, 3) of rows of clumps, world axes, at the time of their velocities."""
    columns = ClumpColumn.MOMENTUM, ClumpColumn.INERTIA, ClumpColumn.AT_VELOCITY
    momentum, inertia, attitude = (clumps[:, c : c + w] for c, w in zip(columns, (3, 3, 4), strict=True))
    rotation = rotation_matrices(attitude)
    return np.einsum("nij,nj->ni", rotation, np.einsum("nji,nj->ni", rotation, momentum) / inertia)


def attitudes(model: ChargeModel, state: ChargeState) -> np.ndarray | None:
    """Return quaternions (n, 4) by particle id, from the axes of a clump to world axes, at the time of the
    velocities, or None for spheres.
    """
    return _clumps_by_id(state, ClumpColumn.AT_VELOCITY, 4) if len(state.clumps) else None


def contact_forces(model: ChargeModel, state: ChargeState, dt: float) -> np.ndarray | None:
    """Return the resultant of the contact forces on each particle [N] (n,) by id in the last substep `dt`
    [s], or None of clumps.

    The published velocity is that of the middle of the coming substep, ``v* = v + dt a/2`` with the last
    acceleration, so that ``F = m (2 (v* - v)/dt - g)``; published in single precision, it is good to about
    1e-4 N for a pellet.
    """
    if len(state.clumps):
        return None
    n = model.n_particles
    middle = state.published_rows[state.clock[Clock.PUBLISHED], :n, :3].T
    acceleration = 2.0 * (middle - state.v[:, :n]) / dt - np.reshape(model.gravity, (3, 1))
    return np.linalg.norm(_by_id(state, state.mass_props[1, :n] * acceleration), axis=1)


def _by_id(state, columns) -> np.ndarray:
    n = columns.shape[1]
    out = np.empty((n, 3))
    out[state.ids[:n]] = columns.T
    return out


def _clumps_by_id(state, column, width) -> np.ndarray:
    out = np.empty((len(state.clumps), width))
    out[state.clumps[:, ClumpColumn.ID].astype(int)] = state.clumps[:, column : column + width]
    return out
