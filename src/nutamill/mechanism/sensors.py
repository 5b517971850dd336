"""Sensors: their description, their table of columns, and one call that fills a row."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from nutamill.base.errors import CaseError, Fault
from nutamill.base.frames import turn_vector_back
from nutamill.base.kernel import kernel
from nutamill.mechanism.dynamics import OK, drift, finish
from nutamill.mechanism.model import NAME_WIDTH, Mechanism, MechanismState, SensorTable
from nutamill.mechanism.parts import GROUND, Vector
from nutamill.mechanism.probes import (
    bushing_travel,
    bushing_wrench,
    drive_angle_speed,
    drive_torque,
    gear_torque,
    joint_reaction,
    point_acceleration,
    point_position,
    point_velocity_of,
    spring_length_pull,
    stop_force_gap,
)
from nutamill.mechanism.rows import matrix_of


class SensorKind(IntEnum):
    """Quantity that a sensor reads."""

    JOINT_REACTION = 0
    """Force and moment on body b about the joint's point on b."""
    BUSHING_WRENCH = 1
    """Force and moment on body b about the bushing's point on b, bushing axes."""
    BUSHING_TRAVEL = 2
    """Displacement and rotation vector of b relative to a, bushing axes."""
    DRIVE = 3
    """Torque, angle and speed of a drive."""
    POINT_ACCELERATION = 4
    """Acceleration of a point of a body, without gravity."""
    POINT_POSITION = 5
    """World coordinates of a point of a body."""
    POINT_VELOCITY = 6
    """Velocity of a point of a body."""
    BODY_ATTITUDE = 7
    """Quaternion of a body."""
    LINEAR_DRIVE = 8
    """Force, travel and speed of a drive along the axis of its joint."""
    SPRING = 9
    """Length and tension of a spring."""
    GEAR = 10
    """Torque of a gear on body b of its output."""
    STOP = 11
    """Force and gap of a stop."""


FORCE_COLUMNS = ("force_x", "force_y", "force_z", "moment_x", "moment_y", "moment_z")

COLUMNS = {
    SensorKind.JOINT_REACTION: FORCE_COLUMNS,
    SensorKind.BUSHING_WRENCH: FORCE_COLUMNS,
    SensorKind.BUSHING_TRAVEL: ("x", "y", "z", "turn_x", "turn_y", "turn_z"),
    SensorKind.DRIVE: ("torque", "angle", "speed"),
    SensorKind.POINT_ACCELERATION: ("ax", "ay", "az"),
    SensorKind.POINT_POSITION: ("x", "y", "z"),
    SensorKind.POINT_VELOCITY: ("vx", "vy", "vz"),
    SensorKind.BODY_ATTITUDE: ("qw", "qx", "qy", "qz"),
    SensorKind.LINEAR_DRIVE: ("force", "travel", "speed"),
    SensorKind.SPRING: ("length", "force"),
    SensorKind.GEAR: ("torque",),
    SensorKind.STOP: ("force", "gap"),
}
"""Suffixes of the columns of each kind."""

WITH_AXES = (SensorKind.JOINT_REACTION, SensorKind.POINT_ACCELERATION, SensorKind.POINT_VELOCITY)
"""Kinds whose vectors can be written in the axes of a body."""

JOINT_REACTION, BUSHING_WRENCH = int(SensorKind.JOINT_REACTION), int(SensorKind.BUSHING_WRENCH)
BUSHING_TRAVEL, DRIVE = int(SensorKind.BUSHING_TRAVEL), int(SensorKind.DRIVE)
POINT_ACCELERATION, POINT_POSITION = int(SensorKind.POINT_ACCELERATION), int(SensorKind.POINT_POSITION)
POINT_VELOCITY = int(SensorKind.POINT_VELOCITY)
LINEAR_DRIVE, SPRING = int(SensorKind.LINEAR_DRIVE), int(SensorKind.SPRING)
GEAR, STOP = int(SensorKind.GEAR), int(SensorKind.STOP)


@dataclass(frozen=True, slots=True)
class Sensor:
    """A quantity to read at every row."""

    name: str
    """Prefix of its columns."""
    kind: SensorKind
    """Quantity to read."""
    target: str
    """Name of the joint, bushing, spring, drive, gear, stop or body."""
    point: Vector | None = None
    """POINT kinds: the point [m], (3,), world, as assembled; the body's mass centre if not given."""
    axes_body: str | None = None
    """Body in whose axes the vectors are written; world axes if not given. Only for joint reactions,
    velocities and accelerations.
    """


def names_of(mechanism: Mechanism) -> dict[str, list[str]]:
    """Return the names of each kind of part, "body" (ground last), "joint", "bushing", "spring", "drive",
    "torque", "force", "gear" and "stop", in the order of their numbers.
    """
    tables = {
        "body": mechanism.bodies,
        "joint": mechanism.joints,
        "bushing": mechanism.bushings,
        "spring": mechanism.springs,
        "drive": mechanism.drives,
        "torque": mechanism.torques,
        "force": mechanism.forces,
        "gear": mechanism.gears,
        "stop": mechanism.stops,
    }
    groups = np.split(mechanism.names, np.cumsum([len(table) for table in tables.values()])[:-1])
    return {kind: [str(name) for name in group] for kind, group in zip(tables, groups, strict=True)}


def sensor_table(mechanism: Mechanism, state: MechanismState, sensors: list[Sensor]) -> SensorTable:
    """Turn sensors into a table for `read_sensors`.

    `state` is the state as assembled, to which the points refer.

    Raises
    ------
    CaseError
        with every sensor of an unknown part, or with axes that its kind does not have
    """
    names, faults, rows = names_of(mechanism), [], []
    parts = {
        JOINT_REACTION: "joint",
        BUSHING_WRENCH: "bushing",
        BUSHING_TRAVEL: "bushing",
        SPRING: "spring",
        DRIVE: "drive",
        LINEAR_DRIVE: "drive",
        GEAR: "gear",
        STOP: "stop",
    }
    for sensor in sensors:
        where, part = f"sensor {sensor.name!r}", parts.get(int(sensor.kind), "body")
        if sensor.target not in names[part]:
            faults.append(
                Fault(
                    where,
                    f"unknown {part}, got {sensor.target!r}",
                    f"Known are {', '.join(names[part])}",
                )
            )
            continue
        axes = GROUND if sensor.axes_body is None else sensor.axes_body
        if axes not in names["body"]:
            faults.append(
                Fault(
                    where,
                    f"unknown axes_body, got {axes!r}",
                    f"Known are {', '.join(names['body'])}",
                )
            )
            continue
        if sensor.axes_body is not None and sensor.kind not in WITH_AXES:
            faults.append(
                Fault(
                    where,
                    f"a {sensor.kind.name} sensor has axes of its own and no axes_body, got {axes!r}",
                )
            )
        target, point = names[part].index(sensor.target), np.zeros(3)
        if sensor.point is not None:
            point = matrix_of(state.quaternion[target]).T @ (
                np.asarray(sensor.point, float) - state.position[target]
            )
        rows.append((int(sensor.kind), target, point, names["body"].index(axes)))
    if faults:
        raise CaseError(*faults)
    columns = [f"{sensor.name}_{ending}" for sensor in sensors for ending in COLUMNS[sensor.kind]]
    return SensorTable(
        kind=np.array([row[0] for row in rows], np.int64),
        target=np.array([row[1] for row in rows], np.int64),
        first_column=np.cumsum([0, *(len(COLUMNS[sensor.kind]) for sensor in sensors)]),
        point=np.array([row[2] for row in rows], float).reshape(-1, 3),
        axes_body=np.array([row[3] for row in rows], np.int64),
        column=np.array(columns, dtype=f"<U{2 * NAME_WIDTH}"),
    )


def column_names(table: SensorTable) -> list[str]:
    """Return the names of the columns that `read_sensors` fills."""
    return [str(name) for name in table.column]


@kernel
def rotate_into_axes(quaternion, at, row_out):
    """Rotate the 3-vector ``row_out[at:at + 3]`` from world axes into the axes of `quaternion` (4,)."""
    row_out[at], row_out[at + 1], row_out[at + 2] = turn_vector_back(
        quaternion, row_out[at], row_out[at + 1], row_out[at + 2]
    )


@kernel
def read_sensors(mechanism, state, scratch, table, row_out):
    """Write the present readings of the sensors of `table` into `row_out` (n_columns,) [SI]."""
    for s in range(table.kind.shape[0]):
        kind, target, at = table.kind[s], table.target[s], table.first_column[s]
        axes = state.quaternion[table.axes_body[s]]
        if kind == JOINT_REACTION:
            joint_reaction(mechanism, state, target, row_out[at : at + 6])
            rotate_into_axes(axes, at, row_out)
            rotate_into_axes(axes, at + 3, row_out)
        elif kind == BUSHING_WRENCH:
            bushing_wrench(mechanism, state, scratch, target, row_out[at : at + 6])
        elif kind == BUSHING_TRAVEL:
            bushing_travel(mechanism, state, target, row_out[at : at + 6])
        elif kind in (DRIVE, LINEAR_DRIVE):
            row_out[at] = drive_torque(mechanism, state, target)
            row_out[at + 1], row_out[at + 2] = drive_angle_speed(state, target)
        elif kind == SPRING:
            row_out[at], row_out[at + 1] = spring_length_pull(mechanism, state, scratch, target)
        elif kind == GEAR:
            row_out[at] = gear_torque(mechanism, state, target)
        elif kind == STOP:
            row_out[at], row_out[at + 1] = stop_force_gap(mechanism, state, scratch, target)
        elif kind == POINT_ACCELERATION:
            row_out[at], row_out[at + 1], row_out[at + 2] = point_acceleration(state, target, table.point[s])
            rotate_into_axes(axes, at, row_out)
        elif kind == POINT_POSITION:
            row_out[at], row_out[at + 1], row_out[at + 2] = point_position(state, target, table.point[s])
        elif kind == POINT_VELOCITY:
            row_out[at], row_out[at + 1], row_out[at + 2] = point_velocity_of(state, target, table.point[s])
            rotate_into_axes(axes, at, row_out)
        else:
            for k in range(4):
                row_out[at + k] = state.quaternion[target, k]


@kernel
def march_recording(mechanism, state, scratch, table, dt, every, rows_out):
    """March and record time [s] and sensors into `rows_out` (n_rows, 1 + n_columns), `every` steps of `dt`
    [s] apart. The first row is the present state.

    Returns
    -------
    status : OK, or the status that stopped the march
    """
    for n in range(rows_out.shape[0]):
        if n > 0:
            for _ in range(every):
                drift(mechanism, state, scratch, dt)
                status = finish(mechanism, state, scratch, dt)
                if status != OK:
                    return status
        rows_out[n, 0] = state.time[0]
        read_sensors(mechanism, state, scratch, table, rows_out[n, 1:])
    return OK
