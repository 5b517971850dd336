"""Static equilibrium of a mechanism, and its small vibrations about rest.

Both use the tangent stiffness of loads and present reactions, by central differences over the positions and
attitudes of the bodies, and the directions that the constraints leave free.  Joint friction is left out: it
has no slope at rest.
"""

from typing import NamedTuple

import numpy as np

from nutamill.base.errors import CaseError, Fault, StepError
from nutamill.base.frames import turn_quaternion
from nutamill.mechanism.constraints import dense_jacobian
from nutamill.mechanism.drives import driven_axis
from nutamill.mechanism.dynamics import OK, start
from nutamill.mechanism.equations import apply_loads
from nutamill.mechanism.loads import world_point
from nutamill.mechanism.model import Mechanism, MechanismScratch, MechanismState

PROBE = 1e-6
"""Displacement [m or rad] and velocity [m/s or rad/s] of the central differences."""

NEWTON_ROUNDS, NEWTON_TOLERANCE, LONGEST_STEP = 300, 1e-11, 0.05
"""Limit of rounds [1], last step [m or rad] that counts as none, and largest step [m or rad] of the search
for equilibrium.
"""

BALANCE = 1e-6
"""Largest load without balance at rest, over the largest load [1]."""

SLOWEST = 0.01
"""Frequency below which a motion counts as free [Hz]; the errors of the central differences are smaller."""


class Modes(NamedTuple):
    """Vibrations about rest, slowest first."""

    frequency: np.ndarray
    """Undamped frequencies ``|sigma| / 2 pi`` of the eigenvalues sigma [Hz], (n_modes,)."""
    damping_ratio: np.ndarray
    """``-Re sigma / |sigma|`` [1], (n_modes,); 1 for an eigenvalue without oscillation, each of which counts
    as a mode.
    """
    shape: np.ndarray
    """Complex displacements and rotation vectors of all bodies [m, rad], (n_bodies, 6, n_modes), world axes;
    the largest is 1.
    """


def static_equilibrium(
    mechanism: Mechanism,
    state: MechanismState,
    scratch: MechanismScratch,
    wrench: np.ndarray | None = None,
    hold_drives: bool = True,
) -> None:
    """Move `state` to static equilibrium under weights, loads and a constant `wrench`, in place, then `start`
    it.

    Newton's method on forces and gaps together.  Velocities become zero, except those that drives prescribe.

    Parameters
    ----------
    wrench : external force [N] and moment about the mass centres [N m], (n_bodies + 1, 6), world axes, put
        into `state.wrench`; None to leave that as it is
    hold_drives : lock the present angles of the drives; otherwise driven joints turn freely to equilibrium

    Raises
    ------
    StepError
        if there is no equilibrium
    """
    if wrench is not None:
        state.wrench[:] = wrench
    state.velocity[:], state.angular_velocity[:] = 0.0, 0.0
    locked = locked_rows(mechanism, hold_drives)
    n, n_locked = 6 * (len(mechanism.bodies) - 1), int(locked.sum())
    reaction = np.zeros(len(locked))
    jacobian = locked_jacobian(mechanism, state, scratch)
    reaction[locked] = np.linalg.lstsq(
        jacobian[locked].T, -residual(mechanism, state, scratch, reaction), rcond=None
    )[0]
    for _ in range(NEWTON_ROUNDS):
        stiffness = tangent_stiffness(mechanism, state, scratch, reaction)
        force = residual(mechanism, state, scratch, reaction)
        jacobian = locked_jacobian(mechanism, state, scratch)[locked]
        gap = np.append(scratch.gap, np.zeros(len(locked) - len(scratch.gap)))
        scale = max(np.abs(stiffness).max(), 1.0)
        matrix = np.block([[stiffness / scale, -jacobian.T], [jacobian, np.zeros((n_locked, n_locked))]])
        solution = np.linalg.lstsq(matrix, np.concatenate([force / scale, -gap[locked]]), rcond=1e-13)[0]
        longest = np.abs(solution[:n]).max(initial=0.0)
        pull = unbalanced(mechanism, state, scratch, locked)
        if pull.any() and (longest < NEWTON_TOLERANCE or pull @ solution[:n] < 0.0):
            # the loads have no slope here, as on a level pendulum, or one that leads uphill: follow the loads
            length = LONGEST_STEP if longest < NEWTON_TOLERANCE else min(longest, LONGEST_STEP)
            displace(state, length / np.abs(pull).max() * pull)
            continue
        share = min(1.0, LONGEST_STEP / max(longest, LONGEST_STEP))
        displace(state, share * solution[:n])
        reaction[locked] += share * scale * solution[n:]
        if longest < NEWTON_TOLERANCE:
            break
    else:
        how = (
            "nothing balances all loads"
            if longest < NEWTON_TOLERANCE
            else f"the last one moved a body by {longest:.3g} m or rad"
        )
        raise StepError(
            f"static equilibrium: none after {NEWTON_ROUNDS} rounds, {how}. "
            "Check that a joint, a bushing or a spring supports every body, and assemble the mechanism near "
            "its equilibrium."
        )
    if start(mechanism, state, scratch) != OK:
        raise StepError(
            "static equilibrium: the accelerations are not finite. Check that every body is supported."
        )


def unbalanced(mechanism, state, scratch, locked) -> np.ndarray:
    """Return the loads along free motions that neither constraints nor stiffness balance [N, N m] (6 n,),
    zeros in equilibrium.
    """
    free = free_directions(locked_jacobian(mechanism, state, scratch)[locked])
    load = residual(mechanism, state, scratch, np.zeros(len(mechanism.rows)))
    rest = free.T @ load
    return (
        free @ rest
        if np.abs(rest).max(initial=0.0) > BALANCE * max(np.abs(load).max(), 1.0)
        else np.zeros_like(load)
    )


def modes(
    mechanism: Mechanism, state: MechanismState, scratch: MechanismScratch, loose: str = "refuse"
) -> Modes:
    """Compute frequencies, damping ratios and shapes of small vibrations about the present pose, drives
    locked.

    `state` does not change and should be in equilibrium (`static_equilibrium`): velocities count as zero.

    Parameters
    ----------
    loose : "refuse" motions without a restoring force (`loose_motions`), or "keep" them as modes of frequency
        zero

    Raises
    ------
    CaseError : the loose motions, by the bodies that move
    """
    if loose == "refuse" and (motions := loose_motions(mechanism, state, scratch)):
        hint = "Support it with a joint, a bushing or a spring"
        raise CaseError(*(Fault("modes", f"no restoring force, got {motion}", hint) for motion in motions))
    jacobian = locked_jacobian(mechanism, state, scratch)
    mass = mass_matrix(mechanism, scratch)
    stiffness = tangent_stiffness(mechanism, state, scratch, state.multiplier)
    damping = tangent_damping(mechanism, state, scratch)
    free = free_directions(jacobian)
    small_mass = free.T @ mass @ free
    a = np.linalg.solve(small_mass, free.T @ stiffness @ free)
    b = np.linalg.solve(small_mass, free.T @ damping @ free)
    return modes_of(a, b, free)


def modes_of(stiffness: np.ndarray, damping: np.ndarray, directions: np.ndarray) -> Modes:
    """Return the modes of ``q'' + damping q' + stiffness q = 0``, matrices (m, m) per unit mass.

    Bodies move by ``directions q``, (6 n_bodies, m).
    """
    m = len(stiffness)
    values, vectors = np.linalg.eig(np.block([[np.zeros((m, m)), np.eye(m)], [-stiffness, -damping]]))
    chosen = np.flatnonzero(values.imag >= 0.0)
    chosen = chosen[np.argsort(np.abs(values[chosen]), kind="stable")]
    size = np.abs(values[chosen])
    shape = directions @ vectors[:m, chosen]
    shape = shape / shape[np.abs(shape).argmax(axis=0), np.arange(len(chosen))]
    ratio = np.where(size > 0.0, -values[chosen].real / np.where(size > 0.0, size, 1.0), 1.0)
    return Modes(size / (2.0 * np.pi), ratio, shape.reshape(len(directions) // 6, 6, len(chosen)))


def loose_motions(mechanism: Mechanism, state: MechanismState, scratch: MechanismScratch) -> list[str]:
    """Return the names of the motions that constraints allow and no stiffness restores, each by the body that
    moves most.

    At the present pose, drives locked; undamped motions slower than `SLOWEST` count.
    """
    free = free_directions(locked_jacobian(mechanism, state, scratch))
    stiffness = free.T @ tangent_stiffness(mechanism, state, scratch, state.multiplier) @ free
    values, vectors = np.linalg.eig(
        np.linalg.solve(free.T @ mass_matrix(mechanism, scratch) @ free, stiffness)
    )
    motions = []
    for k in np.flatnonzero(np.abs(values) < (2.0 * np.pi * SLOWEST) ** 2):
        moves = np.abs(free @ vectors[:, k]).reshape(-1, 6)
        b, way = np.unravel_index(moves.argmax(), moves.shape)
        sort = "translation" if way < 3 else "rotation"
        motions.append(
            f"{sort} of body '{mechanism.names[b]}' {'along' if way < 3 else 'about'} {'xyz'[way % 3]}"
        )
    return list(dict.fromkeys(motions))


def locked_rows(mechanism, hold_drives) -> np.ndarray:
    """Return which rows of `locked_jacobian` apply, (n_rows + n_motors,) of bool."""
    motors = np.full(int((mechanism.drives.row < 0).sum()), hold_drives)
    return np.append((mechanism.rows.drive < 0) | hold_drives, motors)


def locked_jacobian(mechanism, state, scratch) -> np.ndarray:
    """Return the Jacobian (n_rows + n_motors, 6 n_bodies) of the constraints and of a lock in every motor's
    joint.
    """
    jacobian = dense_jacobian(mechanism, state, scratch)
    motors = [drive for drive in mechanism.drives if drive.row < 0]
    locks = np.zeros((len(motors), jacobian.shape[1] + 6))
    for lock, drive in zip(locks, motors, strict=True):
        axis = np.array(driven_axis(drive, state.quaternion))
        point = np.array(world_point(state.position, state.quaternion, drive.body_b, drive.point_b))
        for body, sign in ((drive.body_a, -1.0), (drive.body_b, 1.0)):
            if drive.slides:
                lock[6 * body : 6 * body + 3] += sign * axis
                lock[6 * body + 3 : 6 * body + 6] += sign * np.cross(point - state.position[body], axis)
            else:
                lock[6 * body + 3 : 6 * body + 6] += sign * axis
    return np.vstack([jacobian, locks[:, :-6]])


def free_directions(jacobian) -> np.ndarray:
    """Return an orthonormal basis (n, n - rank) of the motions that satisfy all constraints, of rows scaled
    to unit size.
    """
    if len(jacobian) == 0:
        return np.eye(jacobian.shape[1])
    scaled = jacobian / np.linalg.norm(jacobian, axis=1, keepdims=True)
    _, size, right = np.linalg.svd(scaled)
    return right[int((size > 1e-9 * size[0]).sum()) :].T


def displace(state, move) -> None:
    """Move every body by a displacement and a rotation vector, `move` (6 n_bodies,), world axes."""
    for b, step in enumerate(move.reshape(-1, 6)):
        state.position[b] += step[:3]
        turn_quaternion(state.quaternion[b], step[3], step[4], step[5], state.quaternion[b])


def residual(mechanism, state, scratch, reaction) -> np.ndarray:
    """Return loads plus row reactions on every body at rest [N, N m], (6 n_bodies,)."""
    scratch.twist[:] = 0.0
    jacobian = locked_jacobian(mechanism, state, scratch)
    apply_loads(mechanism, state, scratch)
    return scratch.load[:-1].ravel() + jacobian[: len(reaction)].T @ reaction


def tangent_stiffness(mechanism, state, scratch, reaction) -> np.ndarray:
    """Return minus the derivative of `residual` to the displacements of the bodies at fixed row reactions, (6
    n_bodies, 6 n_bodies).
    """
    n = 6 * (len(mechanism.bodies) - 1)
    stiffness, position, quaternion = np.zeros((n, n)), state.position.copy(), state.quaternion.copy()
    for k in range(n):
        for sign in (1.0, -1.0):
            displace(state, sign * PROBE * np.eye(n)[k])
            stiffness[:, k] -= sign * residual(mechanism, state, scratch, reaction) / (2.0 * PROBE)
            state.position[:], state.quaternion[:] = position, quaternion
    return stiffness


def tangent_damping(mechanism, state, scratch) -> np.ndarray:
    """Return minus the derivative of the loads to the velocities at rest, (6 n_bodies, 6 n_bodies)."""
    n = 6 * (len(mechanism.bodies) - 1)
    damping = np.zeros((n, n))
    scratch.twist[:] = 0.0
    for k in range(n):
        for sign in (1.0, -1.0):
            scratch.twist[k // 6, k % 6] = sign * PROBE
            apply_loads(mechanism, state, scratch)
            damping[:, k] -= sign * scratch.load[:-1].ravel() / (2.0 * PROBE)
        scratch.twist[k // 6, k % 6] = 0.0
    return damping


def mass_matrix(mechanism, scratch) -> np.ndarray:
    """Return masses and inertias about the mass centres at the present pose, (6 n_bodies, 6 n_bodies), world
    axes.
    """
    n = len(mechanism.bodies) - 1
    mass = np.zeros((6 * n, 6 * n))
    for b in range(n):
        mass[6 * b : 6 * b + 3, 6 * b : 6 * b + 3] = mechanism.bodies[b].mass * np.eye(3)
        mass[6 * b + 3 : 6 * b + 6, 6 * b + 3 : 6 * b + 6] = scratch.inertia[b]
    return mass
