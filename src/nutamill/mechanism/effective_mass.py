"""The mass with which a body answers a push at a point, through its joints."""

import numpy as np

from nutamill.mechanism.constraints import dense_jacobian

IMMOVABLE = 1e-12
"""Share of the mobility of the free body below which a point counts as held [1]."""


def mobility(mechanism, state, scratch, body: int, point) -> np.ndarray:
    """Return the velocity (3, 3) that a unit impulse gives a point of a body [1/kg], world axes.

    ``B (M^-1 - M^-1 J^T (J M^-1 J^T)^+ J M^-1) B^T``, with the motion of the point B of the twists and the
    Jacobian J of joints and prescribed rotations: these hold during an impulse, springs and bushings do not
    count.  Columns are the directions of the impulse.

    Parameters
    ----------
    mechanism, state, scratch : as marched; the present pose counts
    body : its number
    point : [m] (3,), world

    Source
    ------
    R. Featherstone, "Rigid Body Dynamics Algorithms", 2008, section 11.3 (impulsive dynamics).
    """
    n = len(mechanism.bodies) - 1
    if body >= n:
        return np.zeros((3, 3))
    arm = np.asarray(point, float) - state.position[body]
    motion = np.zeros((3, 6 * n))
    motion[:, 6 * body : 6 * body + 3] = np.eye(3)
    motion[:, 6 * body + 3 : 6 * body + 6] = np.cross(np.eye(3), arm).T
    free, _ = free_motion(mechanism, state, scratch, motion)
    return free.T @ free


def free_motion(mechanism, state, scratch, push) -> tuple[np.ndarray, np.ndarray]:
    """Return the motions that unit impulses along `push` (k, 6 n_bodies) give, times the root of the inverse
    masses, (6 n_bodies, k): as joints and prescribed drives allow them, and of free bodies.
    """
    jacobian = dense_jacobian(mechanism, state, scratch)
    n = len(mechanism.bodies) - 1
    # roots of the inverse masses: rows of J M^-1/2, so that mass matrix and pseudo-inverse are symmetric
    root = np.zeros((6 * n, 6 * n))
    for b in range(n):
        root[6 * b : 6 * b + 3, 6 * b : 6 * b + 3] = np.sqrt(mechanism.bodies[b].inverse_mass) * np.eye(3)
        root[6 * b + 3 : 6 * b + 6, 6 * b + 3 : 6 * b + 6] = np.linalg.cholesky(scratch.inverse_inertia[b]).T
    free = loose = root @ push.T
    rows = root @ jacobian.T
    if rows.shape[1]:
        rows = rows / np.linalg.norm(rows, axis=0)
        left, size, _ = np.linalg.svd(rows, full_matrices=False)
        held = left[:, size > 1e-6 * size[0]]
        free = loose - held @ (held.T @ loose)
    return free, loose


def effective_mass(mechanism, state, scratch, body: int, point, direction=None) -> float:
    """Return the impulse over the velocity that it gives a point of a body along itself [kg].

    Parameters
    ----------
    as `mobility`, and
    direction : of the push (3,), world axes, any length; None for the direction in which the mass is least

    Returns
    -------
    mass [kg], infinite where the joints hold the point
    """
    yields = mobility(mechanism, state, scratch, body, point)
    if direction is None:
        share = float(np.linalg.eigvalsh(yields)[-1])
    else:
        along = np.asarray(direction, float) / np.linalg.norm(direction)
        share = float(along @ yields @ along)
    least = IMMOVABLE * float(mechanism.bodies[body].inverse_mass)
    return 1.0 / share if share > least else np.inf
