"""From particles to their spheres: the arrays of a charge of clumps."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from nutamill.charge.kernels.clumps import COLUMNS, ClumpColumn
from nutamill.charge.particles.particles import Particles


class Pebbles(NamedTuple):
    """All spheres of the particles of a charge, particle after particle."""

    centre: np.ndarray
    """Centres [m] (m, 3), world."""
    radius: np.ndarray
    """Radii [m] (m,)."""
    material: np.ndarray
    """Materials [1], int32 (m,)."""
    clump_of: np.ndarray
    """Particle that each belongs to [1] (m,)."""
    offset: np.ndarray
    """Centre in the particle's axes [m] (m, 3)."""
    clumps: np.ndarray
    """Rows of the particles, as `ClumpColumn` (n, 24)."""


def rotation_matrices(attitudes: np.ndarray) -> np.ndarray:
    """Return the rotation matrices (n, 3, 3) of unit quaternions (n, 4), body to world."""
    w, x, y, z = np.asarray(attitudes, float).T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def pebbles(
    particles: Particles, densities: Sequence[float], velocities: np.ndarray | None, spins: np.ndarray | None
) -> Pebbles:
    """Return the spheres of placed particles.

    Parameters
    ----------
    particles : with centres, and attitudes unless all are spheres
    densities : by material [kg/m^3]
    velocities, spins : of the particles' mass centres [m/s] and of the particles [rad/s] (n, 3), world axes;
        at rest if None
    """
    n = particles.number
    assert particles.centre is not None  # placed
    attitude = particles.attitude if particles.attitude is not None else np.tile([1.0, 0.0, 0.0, 0.0], (n, 1))
    rotation, mass = rotation_matrices(attitude), particles.mass(densities)
    clumps = np.zeros((n, COLUMNS))
    clumps[:, ClumpColumn.CENTRE : ClumpColumn.CENTRE + 3] = particles.centre
    clumps[:, ClumpColumn.VELOCITY : ClumpColumn.VELOCITY + 3] = 0.0 if velocities is None else velocities
    clumps[:, ClumpColumn.ATTITUDE : ClumpColumn.ATTITUDE + 4] = attitude
    clumps[:, ClumpColumn.AT_VELOCITY : ClumpColumn.AT_VELOCITY + 4] = attitude
    clumps[:, ClumpColumn.MASS] = mass
    per_density = np.array([shape.inertia for shape in particles.shapes])[particles.shape_of]
    density = np.asarray(densities, float)[particles.material]
    inertia = per_density * (density * particles.scale**5)[:, None]
    clumps[:, ClumpColumn.INERTIA : ClumpColumn.INERTIA + 3] = inertia
    clumps[:, ClumpColumn.ID] = np.arange(n)
    if spins is not None:
        in_axes = inertia * np.einsum("nji,nj->ni", rotation, np.asarray(spins, float))
        clumps[:, ClumpColumn.MOMENTUM : ClumpColumn.MOMENTUM + 3] = np.einsum(
            "nij,nj->ni", rotation, in_axes
        )
    count = np.array([shape.spheres for shape in particles.shapes])[particles.shape_of]
    clump_of = np.repeat(np.arange(n), count)
    offset = np.concatenate(
        [particles.shapes[s].offsets * f for s, f in zip(particles.shape_of, particles.scale, strict=True)]
    )
    radius = np.concatenate(
        [particles.shapes[s].radii * f for s, f in zip(particles.shape_of, particles.scale, strict=True)]
    )
    centre = particles.centre[clump_of] + np.einsum("nij,nj->ni", rotation[clump_of], offset)
    return Pebbles(centre, radius, particles.material[clump_of].astype(np.int32), clump_of, offset, clumps)
