"""Check whether the constraints of an assembled mechanism depend on each other or contradict each other."""

import numpy as np

from nutamill.base.errors import Fault
from nutamill.base.units import shown
from nutamill.mechanism.drives import evaluate_drives
from nutamill.mechanism.equations import update_kinematics
from nutamill.mechanism.solve import DEPENDENT

INVOLVED = 1e-6
"""Share [1] in a dependency above which a row takes part in it."""

LARGEST_MISMATCH = 1e-9
"""Largest contradiction [m/s or rad/s, relative to the largest prescribed rate] that still counts as
round-off.
"""


def dense_jacobian(mechanism, state, scratch) -> np.ndarray:
    """Return the Jacobian (n_rows, 6 n_bodies) at the present pose: columns are velocity and angular velocity
    of each body.
    """
    evaluate_drives(mechanism.drives, mechanism.knots, state.time[0], scratch.drive_motion)
    update_kinematics(mechanism, state, scratch)
    rows, n = mechanism.rows, len(mechanism.bodies)
    jacobian = np.zeros((len(rows), 6 * n))
    for i, bodies in enumerate(zip(rows.body_a, rows.body_b, strict=True)):
        for at, body in zip((0, 6), bodies, strict=True):
            jacobian[i, 6 * body : 6 * body + 6] += scratch.jacobian[i, at : at + 6]
    for g, gear in enumerate(mechanism.gears):
        for at, body in ((0, gear.body_a), (6, gear.body_b)):
            block = scratch.jacobian[len(rows) + g, at : at + 6]
            jacobian[gear.row, 6 * body : 6 * body + 6] += block
    return jacobian[:, : 6 * (n - 1)]


def dependencies(mechanism, state, scratch) -> tuple[np.ndarray, list[int]]:
    """Return the combinations of rows that vanish, as an orthonormal basis (n_rows, k) of rows scaled to unit
    size, and the k dependent rows.

    Rows are tested in order and on ``J M^-1/2``, as in the constraint solve.
    """
    jacobian = dense_jacobian(mechanism, state, scratch)
    scaled = jacobian.copy()
    for b in range(len(mechanism.bodies) - 1):
        scaled[:, 6 * b : 6 * b + 3] *= np.sqrt(mechanism.bodies[b].inverse_mass)
        scaled[:, 6 * b + 3 : 6 * b + 6] @= np.linalg.cholesky(scratch.inverse_inertia[b])
    scaled /= np.linalg.norm(scaled, axis=1, keepdims=True)
    basis, dependent = np.zeros((0, scaled.shape[1])), []
    for i, row in enumerate(scaled):
        rest = row - basis.T @ (basis @ row)
        rest -= basis.T @ (basis @ rest)
        if rest @ rest <= DEPENDENT:
            dependent.append(i)
        else:
            basis = np.vstack([basis, rest / np.linalg.norm(rest)])
    if not dependent:
        return np.zeros((len(scaled), 0)), []
    left, _, _ = np.linalg.svd(scaled)
    return left[:, -len(dependent) :], dependent


def check_constraints(mechanism, state, scratch, labels, redundant) -> list[Fault]:
    """Return the faults of constraints that depend on each other.

    Mark the reactions in `mechanism` that are not unique.
    """
    if not labels:
        return []
    null, dependent = dependencies(mechanism, state, scratch)
    if not dependent:
        return []
    faults = contradictions(mechanism, state, scratch, labels, dependent)
    if faults:
        return faults
    if redundant == "refuse":
        return [redundancy_fault(labels, null, i) for i in dependent]
    shared = np.linalg.norm(null, axis=1) > INVOLVED
    for joint in mechanism.joints:
        joint.reaction_unique = int(not shared[joint.first_row : joint.end_row].any())
    return []


def holders(labels, null, i) -> str:
    """Return the parts that already lock the direction of the dependent row `i`, as text."""
    weights = null @ null[i]
    others = dict.fromkeys(
        labels[k].part for k in np.flatnonzero(np.abs(weights) > INVOLVED) if labels[k].part != labels[i].part
    )
    return ", ".join(others) or "its other rows"


def redundancies(mechanism, state, scratch, labels) -> list[str]:
    """Return a line for every direction that is locked more than once: the part, the direction, and the parts
    that lock it already.
    """
    if not labels:
        return []
    null, dependent = dependencies(mechanism, state, scratch)
    return [
        f"{labels[i].part}: {labels[i].direction}, already locked by {holders(labels, null, i)}"
        for i in dependent
    ]


def redundancy_fault(labels, null, i) -> Fault:
    """Return the fault of the dependent row `i`: its direction, and the parts that lock it already."""
    return Fault(
        labels[i].part,
        f"{labels[i].direction} is already locked by {holders(labels, null, i)}",
        'Free that direction in one of these joints, or set redundant = "allow" (their reactions are '
        "then not unique)",
    )


def contradictions(mechanism, state, scratch, labels, dependent) -> list[Fault]:
    """Return a fault for every dependent row whose position or prescribed speed differs from that of the rows
    it depends on.
    """
    jacobian = dense_jacobian(mechanism, state, scratch)
    independent = [i for i in range(len(labels)) if i not in dependent]
    # row i = combination of independent rows; its right-hand side must be the same combination
    combination = np.linalg.lstsq(jacobian[independent].T, jacobian[dependent].T, rcond=None)[0].T
    faults = []
    for n, i in enumerate(dependent):
        gap = scratch.gap[i] - combination[n] @ scratch.gap[independent]
        size = shown(gap, "mm") if labels[i].unit == "m" else shown(gap, "rad")
        if abs(gap) > 1e-5:
            faults.append(
                contradiction_fault(labels, independent, combination[n], i, f"they differ by {size}")
            )
            continue
        mismatch = speed_mismatch(mechanism, combination[n], independent, i)
        if mismatch:
            faults.append(
                contradiction_fault(
                    labels,
                    independent,
                    combination[n],
                    i,
                    f"their speeds differ by {mismatch:.4g} {labels[i].unit}/s",
                )
            )
    return faults


def contradiction_fault(labels, independent, weights, i, what) -> Fault:
    """Return the fault of row `i` against the rows it depends on."""
    others = dict.fromkeys(
        labels[k].part for k, weight in zip(independent, weights, strict=True) if abs(weight) > INVOLVED
    )
    return Fault(
        labels[i].part,
        f"contradicts {', '.join(others)}: {labels[i].direction}, {what}",
        "Remove one of them",
    )


def speed_mismatch(mechanism, weights, independent, i) -> float:
    """Return the largest difference [rad/s or m/s] between the speeds that row `i` and its combination of
    independent rows prescribe, over all knots of all drives.
    """
    times, largest, scale = np.unique(mechanism.knots.time), 0.0, 0.0
    motion = np.zeros((len(mechanism.drives), 3))
    for t in times:
        evaluate_drives(mechanism.drives, mechanism.knots, t, motion)
        rate = np.zeros(len(mechanism.rows))
        prescribed = mechanism.drives.row >= 0
        rate[mechanism.drives.row[prescribed]] = motion[prescribed, 1]
        largest = max(largest, abs(rate[i] - weights @ rate[independent]))
        scale = max(scale, np.abs(motion[:, 1]).max())
    return largest if largest > LARGEST_MISMATCH * max(scale, 1.0) else 0.0
