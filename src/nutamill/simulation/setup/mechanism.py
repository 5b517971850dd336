"""A `Machine` as parts of the engine, and as model, state and work space of a run."""

import math
from typing import NamedTuple

import numpy as np

from nutamill.base.errors import StepError
from nutamill.case import Machine
from nutamill.case.machine import BodyEntry, BushingEntry, JointEntry, Turn
from nutamill.mechanism.assembly import assemble
from nutamill.mechanism.dynamics import OK, start
from nutamill.mechanism.model import Mechanism, MechanismScratch, MechanismState
from nutamill.mechanism.modes import static_equilibrium
from nutamill.mechanism.parts import Body, Bushing, Drive, Joint, JointFriction, JointKind, Spring, Torque
from nutamill.mechanism.sensors import COLUMNS, Sensor, SensorKind, sensor_table
from nutamill.simulation.coupling_model import CouplingPlan, Scheme, coupling_state
from nutamill.simulation.row import RowTable, row_groups
from nutamill.simulation.setup.clock import Clock, refuse_endless
from nutamill.simulation.setup.model import Model, Scratch, State
from nutamill.simulation.setup.part_readout import PartReadout

KINDS = {
    "position": SensorKind.POINT_POSITION,
    "velocity": SensorKind.POINT_VELOCITY,
    "acceleration": SensorKind.POINT_ACCELERATION,
    "attitude": SensorKind.BODY_ATTITUDE,
    "reaction": SensorKind.JOINT_REACTION,
}
"""Kinds of sensors by their names in case files."""


class MechanismParts(NamedTuple):
    """The parts of a mechanism, in the order of the arguments of `nutamill.mechanism.assembly.assemble`."""

    bodies: list[Body]
    """The bodies."""
    joints: list[Joint]
    """The joints."""
    bushings: list[Bushing]
    """The bushings."""
    springs: list[Spring]
    """The springs."""
    torques: list[Torque]
    """Constant moments."""
    drives: list[Drive]
    """The drives."""


def mechanism_parts(case: Machine) -> MechanismParts:
    """Return the parts of a case as parts of the engine."""
    return MechanismParts(
        [_body(entry) for entry in case.bodies],
        [_joint(entry) for entry in case.joints],
        [_bushing(entry) for entry in case.bushings],
        [
            Spring(
                entry.name,
                *entry.between,
                entry.point_a,
                entry.point_b,
                entry.stiffness,
                entry.damping,
                entry.free_length,
            )
            for entry in case.springs
        ],
        [Torque(entry.name, entry.body, entry.moment) for entry in case.torques],
        [Drive(entry.name, entry.joint, *entry.breakpoints()) for entry in case.drives],
    )


def assemble_case(case: Machine) -> tuple[Mechanism, MechanismState, MechanismScratch]:
    """Assemble the mechanism of a case: constants, state as assembled, work space; raise CaseError with every
    fault.
    """
    return assemble(*mechanism_parts(case), gravity=case.gravity, redundant=case.redundant)


def case_sensors(case: Machine) -> list[tuple[Sensor, list[str]]]:
    """Return the sensors of every run of a case, each with the names of its series: all joints, all bushings,
    all drives, then the sensors of the file.
    """
    sensors = []

    def add(sensor, prefix, parts=None):
        sensors.append((sensor, [f"{prefix}_{part}" for part in parts or COLUMNS[sensor.kind]]))

    for joint in case.joints:
        name = f"joint_{joint.name}"
        add(Sensor(name, SensorKind.JOINT_REACTION, joint.name), name)
    for bushing in case.bushings:
        name = f"bushing_{bushing.name}"
        travel = (*(f"travel_{axis}" for axis in "xyz"), *(f"turn_{axis}" for axis in "xyz"))
        add(Sensor(name, SensorKind.BUSHING_WRENCH, bushing.name), name)
        add(Sensor(f"{name}_travel", SensorKind.BUSHING_TRAVEL, bushing.name), name, travel)
    for drive in case.drives:
        name = f"drive_{drive.name}"
        add(Sensor(name, SensorKind.DRIVE, drive.name), name)
    for entry in case.sensors:
        name, kind = f"{entry.name}_{entry.kind}", KINDS[entry.kind]
        # a column of a vector or a quaternion ends in the name of the component: x, vx, ax, qw
        parts = None if kind == SensorKind.JOINT_REACTION else tuple(part[-1] for part in COLUMNS[kind])
        add(Sensor(name, kind, entry.of, point=entry.at, axes_body=entry.axes), name, parts)
    return sensors


def build_mechanism(case: Machine) -> tuple[Model, State, Scratch]:
    """Build model, first state and work space of a mechanism.

    Raises
    ------
    CaseError : every fault of the mechanism
    StepError : no finite accelerations, or no equilibrium where the case starts from rest
    """
    mechanism, state, scratch = assemble_case(case)
    sensors = case_sensors(case)
    table = sensor_table(mechanism, state, [sensor for sensor, _ in sensors])
    if case.run.start == "rest":
        static_equilibrium(mechanism, state, scratch)
    elif start(mechanism, state, scratch) != OK:
        raise StepError(
            f"{case.name}: the first accelerations are not finite. Look at the masses and inertias of the "
            "bodies."
        )
    clock = mechanism_clock(case)
    no_carriers = np.zeros(0, np.int64)
    plan = CouplingPlan(
        int(Scheme.STAGGERED), 0, clock.window, clock.windows_per_row, no_carriers, 0, np.zeros(3), 0
    )
    series = [name for _, names in sensors for name in names]
    readout = PartReadout(case, RowTable(row_groups(mechanism, table, False)), series)
    model = Model(case, clock, mechanism, table, None, None, plan, readout)
    first = State(state, None, None, coupling_state(0), np.zeros(readout.n_columns))
    return model, first, Scratch(scratch, None)


def mechanism_clock(case: Machine) -> Clock:
    """Return step and row of a run: the longest step that is at most `run.dt` and divides the period of the
    series.
    """
    period = 1.0 / case.run.series_rate
    refuse_endless(case.run.until, min(period, case.run.dt))
    steps = max(1, math.ceil(period / case.run.dt * (1.0 - 1e-12)))
    return Clock(0, period / steps, steps, "run.dt")


def _quaternion(turn: Turn | None) -> tuple[float, float, float, float]:
    """Return the attitude (w, x, y, z) after a rotation about an axis."""
    if turn is None:
        return (1.0, 0.0, 0.0, 0.0)
    axis = np.asarray(turn.axis, float) / np.linalg.norm(turn.axis)
    return (math.cos(0.5 * turn.angle), *(math.sin(0.5 * turn.angle) * axis))


def _body(entry: BodyEntry) -> Body:
    inertia = np.diag(entry.inertia[:3])
    for (i, j), product in zip(((0, 1), (0, 2), (1, 2)), entry.inertia[3:], strict=False):
        inertia[i, j] = inertia[j, i] = product
    return Body(
        entry.name,
        entry.mass,
        inertia,
        entry.position,
        _quaternion(entry.turn),
        entry.velocity,
        entry.angular_velocity,
    )


def _joint(entry: JointEntry) -> Joint:
    law = entry.friction
    friction = None if law is None else JointFriction(law.coefficient, law.radius, law.constant, law.viscous)
    kind = JointKind[entry.kind.upper()]
    return Joint(
        entry.name, kind, *entry.between, entry.point, entry.axis, entry.second_axis, friction, entry.point_b
    )


def _bushing(entry: BushingEntry) -> Bushing:
    return Bushing(entry.name, *entry.between, entry.point, entry.axis, entry.stiffness, entry.damping)
