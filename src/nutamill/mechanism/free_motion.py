"""The steady motion of a mechanism on springs whose drives run, and the coordinates that are free of it."""

import numpy as np
from scipy.linalg import null_space, qr

from nutamill.base.errors import StepError
from nutamill.base.frames import rotation_matrix_of
from nutamill.mechanism.constraints import dense_jacobian
from nutamill.mechanism.loads import world_point
from nutamill.mechanism.model import Mechanism, MechanismScratch, MechanismState
from nutamill.mechanism.modes import displace

STILL = 1e-6
"""Share of the largest velocity below which a body is at rest [1]."""

INDEPENDENT = 1e-9
"""Size of a direction, over the largest, below which it depends on those before it [1]."""

STRAINED = 1e-6
"""Share of the velocities up to which the drives strain no bushing and no spring [1]."""

STEPS, ANGLE = 8, 0.05
"""Steps of the motion [1], and what the fastest body moves in each [m or rad], in which a body must stay at
rest: at a dead centre one may be so for a moment.
"""


def free_motion(
    mechanism: Mechanism, state: MechanismState, scratch: MechanismScratch
) -> tuple[np.ndarray, np.ndarray]:
    """Return the free coordinates of a mechanism whose drives run, and their rates in its steady motion.

    The steady motion is the one that strains no bushing and no spring: a frame on mounts stands still, a
    shaft behind a coupling turns with it.

    Parameters
    ----------
    state : the pose as assembled, at drive angle zero

    Returns
    -------
    indices ``6 body + component`` (m,), of bodies at rest where these suffice, and their rates [m/s, rad/s]
    (m,), as `nutamill.mechanism.running_modes.running_modes` takes them

    Raises
    ------
    StepError
        if the drives strain a bushing or a spring however the rest moves
    """
    position, quaternion, begin = state.position.copy(), state.quaternion.copy(), float(state.time[0])
    basis = null_space(dense_jacobian(mechanism, state, scratch))
    first = _unstrained(mechanism, state, scratch, -scratch.gap_rate)
    fastest, twist = np.abs(first), first
    for _ in range(STEPS):
        dt = ANGLE / np.abs(twist).max()
        displace(state, dt * twist)
        state.time[0] += dt
        dense_jacobian(mechanism, state, scratch)
        displace(state, _unstrained(mechanism, state, scratch, -scratch.gap))
        dense_jacobian(mechanism, state, scratch)
        twist = _unstrained(mechanism, state, scratch, -scratch.gap_rate)
        fastest = np.maximum(fastest, np.abs(twist))
    state.position[:], state.quaternion[:], state.time[0] = position, quaternion, begin
    free = _coordinates(basis, fastest)
    return free, np.round(first[free], 9) + 0.0


def _unstrained(
    mechanism: Mechanism, state: MechanismState, scratch: MechanismScratch, right: np.ndarray
) -> np.ndarray:
    """Return the velocities or moves of all bodies (6 n_bodies,) that give the constraints the rates `right`
    and strain bushings and springs least. Raises StepError where a velocity strains them.
    """
    jacobian, strain = dense_jacobian(mechanism, state, scratch), strain_rates(mechanism, state)
    forced = np.linalg.lstsq(jacobian, right, rcond=None)[0]
    basis = null_space(jacobian)
    if not len(strain) or not basis.shape[1]:
        return forced
    move = forced + basis @ np.linalg.lstsq(strain @ basis, -strain @ forced, rcond=None)[0]
    if np.abs(strain @ move).max() > STRAINED * max(np.abs(strain @ forced).max(), np.abs(forced).max()):
        raise StepError(
            "running modes: the drives strain bushings or springs, so that there is no steady motion to "
            "vibrate about. Take the modes at rest."
        )
    return move


def strain_rates(mechanism: Mechanism, state: MechanismState) -> np.ndarray:
    """Return the matrix (k, 6 n_bodies) from the velocities of all bodies to the rates at which bushings and
    springs are strained [m/s, rad/s], one row for each direction that has stiffness.
    """
    n = 6 * len(mechanism.bodies)
    rows = [np.zeros((0, n))]
    for bushing in mechanism.bushings:
        axes = rotation_matrix_of(state.quaternion[bushing.body_a]) @ rotation_matrix_of(bushing.attitude_a)
        at = np.array(world_point(state.position, state.quaternion, bushing.body_b, bushing.point_b))
        both = _relative(state, n, bushing.body_a, bushing.body_b, at)
        local = np.vstack([axes.T @ both[:3], axes.T @ both[3:]])
        rows.append(local[bushing.stiffness > 0.0])
    for spring in mechanism.springs:
        start, end = (
            np.array(world_point(state.position, state.quaternion, body, point))
            for body, point in ((spring.body_a, spring.point_a), (spring.body_b, spring.point_b))
        )
        along = (end - start) / np.linalg.norm(end - start)
        # the far end alone decides: the lever of a spring between two turning ends is that of its line
        rows.append(along[None, :] @ _relative(state, n, spring.body_a, spring.body_b, end)[:3])
    return np.vstack(rows)[:, : n - 6]


def _relative(state: MechanismState, n: int, a: int, b: int, at: np.ndarray) -> np.ndarray:
    """Return the matrix (6, n) from the velocities of all bodies to that of body b relative to body a at the
    world point `at`, and to its angular velocity relative to a.
    """
    matrix = np.zeros((6, n))
    for body, sign in ((a, -1.0), (b, 1.0)):
        x, y, z = at - state.position[body]
        lever = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])  # lever @ w = w x arm
        matrix[:3, 6 * body : 6 * body + 3] += sign * np.eye(3)
        matrix[:3, 6 * body + 3 : 6 * body + 6] += sign * lever
        matrix[3:, 6 * body + 3 : 6 * body + 6] += sign * np.eye(3)
    return matrix


def _coordinates(basis: np.ndarray, fastest: np.ndarray) -> np.ndarray:
    """Return as many coordinates as there are free directions, the columns of `basis` (n, m), that determine
    them: of bodies at rest where these suffice, so that axes that turn are taken last.

    `fastest` (n,) are the largest velocities of the motion.
    """
    speed = fastest.reshape(-1, 6).max(axis=1)
    still = np.repeat(speed <= STILL * speed.max(), 6)
    chosen: list[int] = []
    left = basis
    for among in (np.flatnonzero(still), np.flatnonzero(~still)):
        if not left.shape[1] or not len(among):
            continue
        _, triangle, order = qr(left[among].T, mode="economic", pivoting=True)
        count = int((np.abs(np.diag(triangle)) > INDEPENDENT).sum())
        picked = np.sort(among[order[:count]])
        chosen += picked.tolist()
        left = left @ null_space(left[picked]) if count else left
    return np.array(chosen, int)
