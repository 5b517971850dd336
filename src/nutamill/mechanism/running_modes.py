"""Small vibrations of a mechanism about its motion while its drives run.

The reference is the motion in which the free coordinates have constant rates and everything else follows the
drives.  About it the mechanism is linear with periodic coefficients.  `running_modes` takes their mean over a
period, the first approximation of the method of averaging.  Parametric excitation and the whirl of the free
coordinates themselves are left out.

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
"""Limit of Newton rounds [1], and last move [m or rad] that counts as none, for bodies that follow drives."""


def running_modes(
    mechanism: Mechanism,
    state: MechanismState,
    scratch: MechanismScratch,
    free: np.ndarray,
    rate: np.ndarray,
    times: np.ndarray,
) -> tuple[Modes, np.ndarray]:
    """Compute the vibrations about the running mechanism from the mean of its linear coefficients at `times`.

    Parameters
    ----------
    state : a pose on the constraints at drive angle zero, as from `static_equilibrium`; it moves to the
        last time
    free : indices ``6 body + component`` of the free coordinates, (m,); with them fixed, the constraints
        leave no motion
    rate : their rates in the reference motion [m/s, rad/s], (m,)
    times : rising times of the drives [s], evenly spread over a whole number of periods, without the end of
        the last, (n_times,)

    Returns
    -------
    modes, and the matrix (6 n_bodies, m) from free coordinates to the bodies at the last time

    Raises
    ------
    StepError
        if the free coordinates and the drives do not determine the motion
    """
    dependent = np.setdiff1d(np.arange(6 * (len(mechanism.bodies) - 1)), free)
    stiffness, damping = np.zeros((len(free), len(free))), np.zeros((len(free), len(free)))
    for time in times:
        advance(mechanism, state, scratch, free, dependent, rate, time)
        k, c = coefficients(mechanism, state, scratch, free, dependent, rate)
        stiffness += k / len(times)
        damping += c / len(times)
    directions = np.zeros((6 * (len(mechanism.bodies) - 1), len(free)))
    directions[free] = np.eye(len(free))
    jacobian = dense_jacobian(mechanism, state, scratch)
    directions[dependent] = -solve(jacobian[:, dependent], jacobian[:, free])
    return modes_of(stiffness, damping, directions), directions


def advance(mechanism, state, scratch, free, dependent, rate, time, step=0.05) -> None:
    """Move the reference motion to `time` [s], in rotations of at most `step` [rad] after which gaps are
    closed.
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
        move[dependent] = solve(jacobian[:, dependent], -scratch.gap)
        displace(state, move)
        if np.abs(move).max() < TOLERANCE:
            return


def follow_velocity(mechanism, state, scratch, dependent, free, rate) -> None:
    """Compute the velocities of all bodies from the drives and the `rate` [m/s, rad/s] of the `free`
    coordinates.
    """
    jacobian = dense_jacobian(mechanism, state, scratch)
    twist = np.zeros(jacobian.shape[1])
    twist[free] = rate
    twist[dependent] = solve(jacobian[:, dependent], -scratch.gap_rate - jacobian @ twist)
    state.velocity[:-1], state.angular_velocity[:-1] = (
        twist.reshape(-1, 6)[:, :3],
        twist.reshape(-1, 6)[:, 3:],
    )


def solve(matrix, right) -> np.ndarray:
    """Solve the square system in which the free coordinates are known."""
    try:
        return np.linalg.solve(matrix, right)
    except np.linalg.LinAlgError:
        raise StepError(
            f"running modes: {matrix.shape[0]} constraints do not determine {matrix.shape[1]} coordinates. "
            "Check that every body is supported and that the free coordinates are free."
        ) from None


def coefficients(mechanism, state, scratch, free, dependent, rate) -> tuple[np.ndarray, np.ndarray]:
    """Return minus the derivatives of the accelerations of the free coordinates to their displacements and to
    their rates, (m, m) each.
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
    """Return the accelerations of the free coordinates at the present pose and velocities [m/s^2, rad/s^2],
    (m,).
    """
    solve_again(mechanism, state, scratch)
    return state.acceleration[:-1].ravel()[free]
