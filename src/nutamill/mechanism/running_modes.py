"""Small motions of a mechanism about a turning one: what it does when it is nudged while its drives run.

The reference is the motion in which the free coordinates keep steady rates and everything else follows the
drives.  Seen from it the mechanism is linear with coefficients that repeat with the turn; `running_modes`
takes their mean over a turn, the first approximation of the method of averaging.  Parametric excitation and
the whirl of the free coordinates themselves are left out.

Source: Sanders, Verhulst and Murdock, Averaging Methods in Nonlinear Dynamical Systems, 2nd ed., 2007,
section 2.8 (averaging of periodic coefficients); Genta, Dynamics of Rotating Systems, 2005, chapter 6
(unsymmetric rotors).
"""

import numpy as np

from nutamill.base.errors import StepError
from nutamill.base.frames import turn_quaternion
from nutamill.mechanism.constraints import dense_jacobian
from nutamill.mechanism.dynamics import solve_again
from nutamill.mechanism.model import Mechanism, MechanismScratch, MechanismState
from nutamill.mechanism.modes import Modes, displace, modes_of

PROBE = 1e-5
"""Displacement [m or rad] and velocity [m/s or rad/s] of the central differences."""

ROUNDS, TOLERANCE = 12, 1e-13
"""Limit of Newton rounds [1] and last move [m or rad] that counts as none, when bodies follow the drives."""


def running_modes(
    mechanism: Mechanism,
    state: MechanismState,
    scratch: MechanismScratch,
    free: np.ndarray,
    rate: np.ndarray,
    times: np.ndarray,
) -> tuple[Modes, np.ndarray]:
    """Vibrations about the running mechanism, by the mean of its linear coefficients at `times`.

    Parameters
    ----------
    state : a pose on the constraints at the drives' angle zero, as `static_equilibrium` leaves it; moved
        along
    free : numbers of the free coordinates among ``6 body + component``, (m,); with them held, the constraints
        must leave nothing
    rate : their rates in the reference motion [m/s, rad/s], (m,)
    times : rising times of the drives [s], evenly spread over a whole number of turns without the last one,
        (n_times,)

    Returns
    -------
    modes, and the matrix (6 n_bodies, m) from free coordinates to the bodies at the last time

    Raises
    ------
    StepError
        where the free coordinates and the drives do not decide the motion
    """
    dependent = np.setdiff1d(np.arange(6 * (len(mechanism.bodies) - 1)), free)
    stiffness, damping = np.zeros((len(free), len(free))), np.zeros((len(free), len(free)))
    for time in times:
        travel(mechanism, state, scratch, free, dependent, rate, time)
        k, c = coefficients(mechanism, state, scratch, free, dependent, rate)
        stiffness += k / len(times)
        damping += c / len(times)
    directions = np.zeros((6 * (len(mechanism.bodies) - 1), len(free)))
    directions[free] = np.eye(len(free))
    jacobian = dense_jacobian(mechanism, state, scratch)
    directions[dependent] = -solved(jacobian[:, dependent], jacobian[:, free])
    return modes_of(stiffness, damping, directions), directions


def travel(mechanism, state, scratch, free, dependent, rate, time, step=0.05) -> None:
    """Bring the reference motion to `time` [s]: bodies turn by at most `step` [rad] at once, then close the
    gaps.
    """
    while True:
        follow_velocity(mechanism, state, scratch, dependent, free, rate)
        fastest = max(np.abs(state.angular_velocity).max(), 1e-9)
        dt = min(time - state.time[0], step / fastest)
        for b in range(len(mechanism.bodies) - 1):
            state.position[b] += dt * state.velocity[b]
            w = state.angular_velocity[b]
            turn_quaternion(state.quaternion[b], dt * w[0], dt * w[1], dt * w[2], state.quaternion[b])
        state.time[0] += dt
        follow_pose(mechanism, state, scratch, dependent)
        if state.time[0] >= time - 1e-15:
            return


def follow_pose(mechanism, state, scratch, dependent) -> None:
    """Move the `dependent` coordinates until the gaps are closed."""
    for _ in range(ROUNDS):
        jacobian = dense_jacobian(mechanism, state, scratch)
        move = np.zeros(jacobian.shape[1])
        move[dependent] = solved(jacobian[:, dependent], -scratch.gap)
        displace(state, move)
        if np.abs(move).max() < TOLERANCE:
            return


def follow_velocity(mechanism, state, scratch, dependent, free, rate) -> None:
    """Velocities of all bodies from the drives and the `rate` [m/s, rad/s] of the `free` coordinates."""
    jacobian = dense_jacobian(mechanism, state, scratch)
    twist = np.zeros(jacobian.shape[1])
    twist[free] = rate
    twist[dependent] = solved(jacobian[:, dependent], -scratch.gap_rate - jacobian @ twist)
    state.velocity[:-1], state.angular_velocity[:-1] = (
        twist.reshape(-1, 6)[:, :3],
        twist.reshape(-1, 6)[:, 3:],
    )


def solved(matrix, right) -> np.ndarray:
    """Solution of the square system in which the free coordinates are known."""
    try:
        return np.linalg.solve(matrix, right)
    except np.linalg.LinAlgError:
        raise StepError(
            f"running modes: {matrix.shape[0]} constraints must decide {matrix.shape[1]} "
            "coordinates, they do not. "
            "Check that every body is held, and that the free coordinates are"
        ) from None


def coefficients(mechanism, state, scratch, free, dependent, rate) -> tuple[np.ndarray, np.ndarray]:
    """Minus the slopes of the accelerations of the free coordinates, to their displacements and to their
    rates, (m, m) each.
    """
    m = len(free)
    stiffness, damping = np.zeros((m, m)), np.zeros((m, m))
    position, quaternion = state.position.copy(), state.quaternion.copy()
    unit = np.zeros(6 * (len(mechanism.bodies) - 1))
    for k in range(m):
        for sign in (1.0, -1.0):
            unit[free[k]] = sign * PROBE
            displace(state, unit)
            follow_pose(mechanism, state, scratch, dependent)
            follow_velocity(mechanism, state, scratch, dependent, free, rate)
            stiffness[:, k] -= sign * acceleration(mechanism, state, scratch, free) / (2.0 * PROBE)
            state.position[:], state.quaternion[:] = position, quaternion
            follow_velocity(mechanism, state, scratch, dependent, free, rate + sign * PROBE * np.eye(m)[k])
            damping[:, k] -= sign * acceleration(mechanism, state, scratch, free) / (2.0 * PROBE)
        unit[free[k]] = 0.0
    return stiffness, damping


def acceleration(mechanism, state, scratch, free) -> np.ndarray:
    """Accelerations of the free coordinates at the present pose and velocities [m/s^2, rad/s^2], (m,)."""
    solve_again(mechanism, state, scratch)
    return state.acceleration[:-1].ravel()[free]
