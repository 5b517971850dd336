"""Joints and drives taken apart into scalar rows, in body axes."""

from typing import NamedTuple

import numpy as np

from nutamill.base.errors import Fault
from nutamill.mechanism.model import AXIS, JOINT, PAIR, POINT, ROW
from nutamill.mechanism.parts import GROUND, JointKind

LARGEST_GAP = 1e-5
"""Largest distance [m] between the two points of a joint as assembled."""


class RowLabel(NamedTuple):
    """What a row holds, for messages."""

    part: str
    """The joint or drive, as in messages."""
    direction: str
    """What it holds, and along which world direction."""
    unit: str
    """Unit of its gap: m or rad."""


def matrix_of(q) -> np.ndarray:
    """Rotation matrix (3, 3) of a unit quaternion (w, x, y, z)."""
    w, v = q[0], np.asarray(q[1:], float)
    skew = np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
    return np.eye(3) + 2.0 * w * skew + 2.0 * skew @ skew


def quaternion_of(R) -> np.ndarray:
    """Unit quaternion (w, x, y, z) of a rotation matrix (3, 3).

    Source: Shepperd, J. Guidance and Control 1(3), 223-224, 1978: the largest component is found first.
    """
    diagonal, trace = np.diag(R), np.trace(R)
    k = int(np.argmax([trace, *diagonal]))
    if k == 0:
        q = np.array([1.0 + trace, R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    else:
        i, j, m = k - 1, k % 3, (k + 1) % 3
        q = np.zeros(4)
        q[0] = R[m, j] - R[j, m]
        q[1 + i], q[1 + j], q[1 + m] = 1.0 + 2.0 * R[i, i] - trace, R[j, i] + R[i, j], R[m, i] + R[i, m]
    return q / np.linalg.norm(q)


def frame_along(axis) -> np.ndarray:
    """A right-handed frame (3, 3), columns in world axes, third along `axis`; the world's own for +z.

    The other two come from the world's x and y by the shortest turn from z, so they are as parallel to them
    as can be.
    """
    z = np.asarray(axis, float) / np.linalg.norm(axis)
    if z[2] < -1.0 + 1e-12:
        return np.diag([1.0, -1.0, -1.0])
    v = np.array([-z[1], z[0], 0.0])  # e_z x z
    skew = np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
    return np.eye(3) + skew + skew @ skew / (1.0 + z[2])


class Placement:
    """Where the bodies are as assembled, and world points and directions in their axes."""

    def __init__(self, bodies):
        self.index = {body.name: i for i, body in enumerate(bodies)} | {GROUND: len(bodies)}
        self.position = np.array([*(body.position for body in bodies), (0.0, 0.0, 0.0)], float)
        self.quaternion = np.array([*(body.quaternion for body in bodies), (1.0, 0.0, 0.0, 0.0)], float)
        self.quaternion /= np.linalg.norm(self.quaternion, axis=1, keepdims=True)
        self.rotation = np.array([matrix_of(q) for q in self.quaternion])

    def local_point(self, body: str, point) -> np.ndarray:
        """A world point from the body's mass centre in its axes [m]."""
        return self.rotation[self.index[body]].T @ (
            np.asarray(point, float) - self.position[self.index[body]]
        )

    def local_axis(self, body: str, direction) -> np.ndarray:
        """A world direction in the body's axes [1]."""
        return self.rotation[self.index[body]].T @ np.asarray(direction, float)

    def attitude_in(self, body: str, frame) -> np.ndarray:
        """Quaternion from a frame (3, 3), columns in world axes, to the body's axes."""
        return quaternion_of(self.rotation[self.index[body]].T @ frame)


def joint_rows(joint):
    """World axes a joint holds: POINT rows (axis of a), then AXIS rows (axis of a, axis of b)."""
    if joint.kind == JointKind.UNIVERSAL:
        return [*np.eye(3)], [(unit(joint.axis), unit(joint.second_axis))]
    x, y, z = np.eye(3) if joint.axis is None else frame_along(joint.axis).T
    points = {
        JointKind.FIXED: [x, y, z],
        JointKind.REVOLUTE: [x, y, z],
        JointKind.SPHERICAL: [x, y, z],
        JointKind.CYLINDRICAL: [x, y],
        JointKind.PRISMATIC: [x, y],
        JointKind.POINT_ON_LINE: [x, y],
    }[joint.kind]
    axes = {
        JointKind.FIXED: [(x, y), (y, z), (z, x)],
        JointKind.PRISMATIC: [(x, y), (y, z), (z, x)],
        JointKind.REVOLUTE: [(x, z), (y, z)],
        JointKind.CYLINDRICAL: [(x, z), (y, z)],
    }.get(joint.kind, [])
    return points, axes


def unit(vector) -> np.ndarray:
    """The vector divided by its length [1]."""
    vector = np.asarray(vector, float)
    return vector / np.linalg.norm(vector)


def text(vector, scale=1.0, digits=4) -> str:
    """A vector for messages."""
    return "(" + ", ".join(f"{scale * x:.{digits}g}" for x in vector + 0.0) + ")"


def records(dtype, rows) -> np.recarray:
    """A table of records from a list of tuples."""
    return np.array([tuple(row) for row in rows], dtype).view(np.recarray)


def constraint_tables(place: Placement, joints, drives):
    """Joints, rows of all joints and then of all drives, pairs of rows; a label per row; and the gaps that
    are too large.
    """
    rows, labels, faults, table = [], [], [], []
    zero = np.zeros(3)
    for joint in joints:
        a, b, first = place.index[joint.body_a], place.index[joint.body_b], len(rows)
        on_b = joint.point if joint.point_b is None else joint.point_b
        points, axes = joint_rows(joint)
        gap = sum(((np.subtract(on_b, joint.point) @ e) * e for e in points), zero)
        if np.linalg.norm(gap) > LARGEST_GAP:
            faults.append(
                Fault(
                    f"joint {joint.name!r}",
                    f"the points of {joint.body_a!r} and {joint.body_b!r} must meet within "
                    f"{LARGEST_GAP * 1e3:g} mm, "
                    f"got a gap of {np.linalg.norm(gap) * 1e3:.4g} mm",
                    f"Put the point of {joint.body_b!r} at {text(np.asarray(on_b) - gap, 1e3, 7)} mm",
                )
            )
        for e in points:
            arms = place.local_point(joint.body_a, joint.point), place.local_point(joint.body_b, on_b)
            rows.append((POINT, a, b, -1, *arms, place.local_axis(joint.body_a, e), zero, zero))
            labels.append(RowLabel(f"joint {joint.name!r}", f"the position along {text(e)}", "m"))
        for u, z in axes:
            rows.append(
                (
                    AXIS,
                    a,
                    b,
                    -1,
                    zero,
                    zero,
                    place.local_axis(joint.body_a, u),
                    place.local_axis(joint.body_b, z),
                    zero,
                )
            )
            labels.append(RowLabel(f"joint {joint.name!r}", f"the turn about {text(np.cross(z, u))}", "rad"))
        table.append(joint_record(place, joint, on_b, first, len(rows)))
    by_name = {joint.name: joint for joint in joints}
    for d, drive in enumerate(drives):
        joint = by_name[drive.joint]
        x, y, z = frame_along(joint.axis).T
        # y turned by the angle stays square to b's x: a quarter turn brings y to -x
        if drive.motor is not None:
            continue
        axes = (
            place.local_axis(joint.body_a, y),
            place.local_axis(joint.body_b, x),
            place.local_axis(joint.body_a, -x),
        )
        rows.append((AXIS, place.index[joint.body_a], place.index[joint.body_b], d, zero, zero, *axes))
        labels.append(RowLabel(f"drive {drive.name!r}", f"the turn about {text(z)}", "rad"))
    pairs = sharing_pairs(rows, len(place.position) - 1)
    return records(JOINT, table), records(ROW, rows), records(PAIR, pairs), labels, faults


def joint_record(place, joint, on_b, first_row, end_row) -> tuple:
    """A joint in body axes; whether its reaction is unique is found in the rank check."""
    law, has_axis = (
        joint.friction,
        joint.axis is not None and joint.kind not in (JointKind.FIXED, JointKind.SPHERICAL),
    )
    return (
        int(joint.kind),
        place.index[joint.body_a],
        place.index[joint.body_b],
        first_row,
        end_row,
        1,
        place.local_point(joint.body_b, on_b),
        place.local_axis(joint.body_a, unit(joint.axis)) if has_axis else np.zeros(3),
        *((0.0,) * 4 if law is None else (law.coefficient, law.radius, law.constant, law.viscous)),
    )


def sharing_pairs(rows, ground) -> list[tuple]:
    """Pairs of rows that share a body, the `ground` apart: it does not move."""
    return [
        (i, j, p, q)
        for i, row in enumerate(rows)
        for j in range(i + 1)
        for p, body in ((0, row[1]), (6, row[2]))
        for q, other in ((0, rows[j][1]), (6, rows[j][2]))
        if body == other != ground
    ]
