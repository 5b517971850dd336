"""Joints and drives as scalar constraint rows, in body axes."""

from typing import NamedTuple

import numpy as np

from nutamill.base.errors import Fault
from nutamill.base.units import in_unit, shown
from nutamill.mechanism.model import AXIS, GEAR, GEAR_PAIR, GEAR_ROW, JOINT, PAIR, POINT, ROW, SIDE
from nutamill.mechanism.parts import GROUND, JOINTS, Joint

# Absolute, and only for a refusal before the first step: no number of a result depends on it.
LARGEST_GAP = 1e-5
"""Largest distance [m] between the two points of a joint as assembled."""


class RowLabel(NamedTuple):
    """The part and the direction of a row, for messages."""

    part: str
    """Joint or drive, as messages name it."""
    direction: str
    """Kind and world direction of the constraint."""
    unit: str
    """Unit of its gap: m or rad."""


def matrix_of(q) -> np.ndarray:
    """Return the rotation matrix (3, 3) of a unit quaternion (w, x, y, z)."""
    w, v = q[0], np.asarray(q[1:], float)
    skew = np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
    return np.eye(3) + 2.0 * w * skew + 2.0 * skew @ skew


def quaternion_of(R) -> np.ndarray:
    """Return the unit quaternion (w, x, y, z) of a rotation matrix (3, 3).

    Source: Shepperd, J. Guidance and Control 1(3), 223-224, 1978 (divide by the largest component).
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
    """Return a right-handed frame (3, 3), columns in world axes, third along `axis`.

    The other two are the world's x and y after the shortest rotation that brings z to `axis`.
    """
    z = np.asarray(axis, float) / np.linalg.norm(axis)
    if z[2] < -1.0 + 1e-12:
        return np.diag([1.0, -1.0, -1.0])
    v = np.array([-z[1], z[0], 0.0])  # e_z x z
    skew = np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
    return np.eye(3) + skew + skew @ skew / (1.0 + z[2])


class Placement:
    """Positions and attitudes of the bodies as assembled, and world vectors in their axes."""

    def __init__(self, bodies):
        self.bodies = tuple(bodies)
        self.index = {body.name: i for i, body in enumerate(bodies)} | {GROUND: len(bodies)}
        self.position = np.array([*(body.position for body in bodies), (0.0, 0.0, 0.0)], float)
        self.quaternion = np.array([*(body.quaternion for body in bodies), (1.0, 0.0, 0.0, 0.0)], float)
        self.quaternion /= np.linalg.norm(self.quaternion, axis=1, keepdims=True)
        self.rotation = np.array([matrix_of(q) for q in self.quaternion])

    def local_point(self, body: str, point) -> np.ndarray:
        """Return a world point from the body's mass centre in its axes [m]."""
        return self.rotation[self.index[body]].T @ (
            np.asarray(point, float) - self.position[self.index[body]]
        )

    def local_axis(self, body: str, direction) -> np.ndarray:
        """Return a world direction in the body's axes [1]."""
        return self.rotation[self.index[body]].T @ np.asarray(direction, float)

    def inertia_about(self, body: str, point, axis) -> float:
        """Return the moment of inertia [kg m^2] of a body about a world axis through a world point as
        assembled. Without an axis it is the mean over all directions. That of the ground is infinite.
        """
        if body == GROUND:
            return np.inf
        part, arm = self.bodies[self.index[body]], np.subtract(point, self.position[self.index[body]])
        if axis is None:
            return (np.trace(part.inertia) + 2.0 * part.mass * (arm @ arm)) / 3.0
        z, across = unit(axis), np.cross(unit(axis), arm)
        local = self.local_axis(body, z)
        return local @ np.asarray(part.inertia, float) @ local + part.mass * (across @ across)

    def attitude_in(self, body: str, frame) -> np.ndarray:
        """Return the quaternion from a frame (3, 3), columns in world axes, to the body's axes."""
        return quaternion_of(self.rotation[self.index[body]].T @ frame)


def joint_rows(joint: Joint) -> tuple[list, list]:
    """Return the directions in which a joint holds its points together, and the pairs of axes (of a, of b)
    that it keeps square, world axes as assembled (`JOINTS`).
    """
    rows = JOINTS[joint.kind]
    x, y, z = np.eye(3) if joint.axis is None or rows.axes == 1 else frame_along(joint.axis).T
    if rows.axes == 1:
        axes = [(unit(joint.axis), unit(joint.second_axis))]
    else:
        axes = {0: [], 2: [(x, z), (y, z)], 3: [(x, y), (y, z), (z, x)]}[rows.axes]
    return [x, y, z][: rows.points], axes


def unit(vector) -> np.ndarray:
    """Return the vector divided by its length [1]."""
    vector = np.asarray(vector, float)
    return vector / np.linalg.norm(vector)


def text(vector, digits=4) -> str:
    """Format a vector for messages."""
    return "(" + ", ".join(f"{x:.{digits}g}" for x in vector + 0.0) + ")"


def records(dtype, rows) -> np.recarray:
    """Make a table of records from a list of tuples."""
    return np.array([tuple(row) for row in rows], dtype).view(np.recarray)


def constraint_tables(placement: Placement, joints, drives, gears=()):
    """Return the tables of joints, of rows (joints, gears, drives) and of pairs of rows, a label per row, and
    the gaps that are too large as faults.
    """
    rows: list[tuple] = []
    labels: list[RowLabel] = []
    faults: list[Fault] = []
    table: list[tuple] = []
    zero = np.zeros(3)
    for joint in joints:
        a, b, first = placement.index[joint.body_a], placement.index[joint.body_b], len(rows)
        on_b = joint.point if joint.point_b is None else joint.point_b
        points, axes = joint_rows(joint)
        gap = sum(((np.subtract(on_b, joint.point) @ e) * e for e in points), zero)
        if np.linalg.norm(gap) > LARGEST_GAP:
            met = text(in_unit(np.asarray(on_b) - gap, "mm"), 7)
            faults.append(
                Fault(
                    f"joint {joint.name!r}",
                    f"the points on {joint.body_a!r} and {joint.body_b!r} are not the same, got a gap of "
                    f"{shown(float(np.linalg.norm(gap)), 'mm')}, largest {shown(LARGEST_GAP, 'mm', 'g')}",
                    f"Put the point on {joint.body_b!r} at {met} mm",
                )
            )
        for e in points:
            arms = placement.local_point(joint.body_a, joint.point), placement.local_point(joint.body_b, on_b)
            rows.append((POINT, a, b, -1, *arms, placement.local_axis(joint.body_a, e), zero, zero))
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
                    placement.local_axis(joint.body_a, u),
                    placement.local_axis(joint.body_b, z),
                    zero,
                )
            )
            labels.append(
                RowLabel(f"joint {joint.name!r}", f"the rotation about {text(np.cross(z, u))}", "rad")
            )
        table.append(joint_record(placement, joint, on_b, first, len(rows)))
    by_name = {joint.name: joint for joint in joints}
    for gear in gears:
        output = by_name[gear.output]
        bodies = placement.index[output.body_a], placement.index[output.body_b]
        rows.append((GEAR_ROW, *bodies, -1, *(zero,) * 5))
        way = f"the rotation of joint {gear.output!r} with joint {gear.input!r}"
        labels.append(RowLabel(f"gear {gear.name!r}", way, "rad"))
    for d, drive in enumerate(drives):
        joint = by_name[drive.joint]
        x, y, z = frame_along(joint.axis).T
        if drive.motor is not None:
            continue
        if JOINTS[joint.kind].slides:
            on_b = joint.point if joint.point_b is None else joint.point_b
            arms = placement.local_point(joint.body_a, joint.point), placement.local_point(joint.body_b, on_b)
            bodies = placement.index[joint.body_a], placement.index[joint.body_b]
            rows.append((POINT, *bodies, d, *arms, placement.local_axis(joint.body_a, z), zero, zero))
            labels.append(RowLabel(f"drive {drive.name!r}", f"the position along {text(z)}", "m"))
            continue
        # y rotated by the drive's angle stays square to b's x; a rotation by 90 deg brings y to -x
        square = (
            placement.local_axis(joint.body_a, y),
            placement.local_axis(joint.body_b, x),
            placement.local_axis(joint.body_a, -x),
        )
        rows.append(
            (AXIS, placement.index[joint.body_a], placement.index[joint.body_b], d, zero, zero, *square)
        )
        labels.append(RowLabel(f"drive {drive.name!r}", f"the rotation about {text(z)}", "rad"))
    pairs = sharing_pairs(rows, len(placement.position) - 1)
    return records(JOINT, table), records(ROW, rows), records(PAIR, pairs), labels, faults


def joint_record(placement, joint, on_b, first_row, end_row) -> tuple:
    """Return the record of a joint in body axes.

    The rank check decides later whether its reaction is unique.
    """
    rows, law = JOINTS[joint.kind], joint.friction
    return (
        placement.index[joint.body_a],
        placement.index[joint.body_b],
        first_row,
        end_row,
        rows.points,
        int(rows.turns),
        int(rows.slides),
        1,
        placement.local_point(joint.body_b, on_b),
        placement.local_axis(joint.body_a, unit(joint.axis)) if rows.needs_axis else np.zeros(3),
        *((0.0,) * 4 if law is None else friction_numbers(law, rows.slides)),
        braked_mass(placement, joint) if rows.slides else braked_inertia(placement, joint, rows.turns),
    )


def friction_numbers(law, slides) -> tuple[float, float, float, float]:
    """Return coefficient, radius, constant and viscous part of the friction of a joint, as in a `JOINT`
    record.
    """
    if slides:
        return law.coefficient, 1.0, law.constant_force, law.viscous_force
    return law.coefficient, law.radius, law.constant, law.viscous


def braked_inertia(placement, joint, about_axis) -> float:
    """Return the moment of inertia [kg m^2] that the friction of a joint brakes: those of its two bodies
    about the joint, in series.
    """
    axis = joint.axis if about_axis else None
    bodies = joint.body_a, joint.body_b
    return 1.0 / sum(1.0 / placement.inertia_about(body, joint.point, axis) for body in bodies)


def braked_mass(placement, joint) -> float:
    """Return the mass that the friction of a joint that slides brakes, over a length of its bodies [kg/m]:
    their masses in series, and the radius of gyration of the lighter.
    """
    moving = [name for name in (joint.body_a, joint.body_b) if name != GROUND]
    bodies = [placement.bodies[placement.index[name]] for name in moving]
    lighter = min(bodies, key=lambda body: body.mass)
    length = np.sqrt(np.trace(lighter.inertia) / (2.0 * lighter.mass))
    return 1.0 / (sum(1.0 / body.mass for body in bodies) * length)


def sharing_pairs(rows, ground) -> list[tuple]:
    """Return the pairs of rows that share a moving body. `ground` does not move."""
    return [
        (i, j, p, q)
        for i, row in enumerate(rows)
        for j in range(i + 1)
        for p, body in ((0, row[1]), (6, row[2]))
        for q, other in ((0, rows[j][1]), (6, rows[j][2]))
        if body == other != ground
    ]


def gear_tables(placement: Placement, joints, gears, rows):
    """Return the tables of gears, of their sides and of the pairs of their second Jacobians.

    `rows` is the table of rows.
    """
    by_name = {joint.name: joint for joint in joints}
    own = iter(np.flatnonzero(rows.kind == GEAR_ROW))
    table, sides = [], []
    for gear in gears:
        inputs, outputs = (side_record(placement, by_name[name]) for name in (gear.input, gear.output))
        table.append((next(own), *inputs[:2], gear.ratio))
        sides += [inputs, outputs]
    ground = len(placement.position) - 1
    return records(GEAR, table), records(SIDE, sides), records(GEAR_PAIR, gear_pairs(rows, table, ground))


def side_record(placement, joint) -> tuple:
    """Return the record of a joint on one side of a gear, its angle zero as assembled."""
    x, _, z = frame_along(joint.axis).T
    a, b = joint.body_a, joint.body_b
    axes = placement.local_axis(a, z), placement.local_axis(a, x), placement.local_axis(b, x)
    return placement.index[a], placement.index[b], *axes


def gear_pairs(rows, gears, ground) -> list[tuple]:
    """Return the pairs of Jacobians that share a moving body, at least one of them the second of a gear."""
    jacobians = [(i, i, (row.body_a, row.body_b)) for i, row in enumerate(rows)]
    jacobians += [(gear[0], len(rows) + g, gear[1:3]) for g, gear in enumerate(gears)]
    return [
        (i, j, m, n, p, q)
        for i, m, bodies in jacobians
        for j, n, others in jacobians
        if i >= j and max(m, n) >= len(rows)
        for p, body in zip((0, 6), bodies, strict=True)
        for q, other in zip((0, 6), others, strict=True)
        if body == other != ground
    ]
