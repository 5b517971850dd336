"""A `MechanismCase` as the engine's descriptions, and as a model and state to march."""

import math
from typing import NamedTuple

import numpy as np

from nutamill.base.errors import StepError
from nutamill.case import MechanismCase
from nutamill.case.mechanism import BodyEntry, BushingEntry, JointEntry, Turn
from nutamill.charge.measures.observe import charge_reading
from nutamill.mechanism.assembly import assemble
from nutamill.mechanism.dynamics import OK, start
from nutamill.mechanism.model import Mechanism, MechanismScratch, MechanismState
from nutamill.mechanism.modes import static_equilibrium
from nutamill.mechanism.parts import Body, Bushing, Drive, Joint, JointFriction, JointKind, Spring, Torque
from nutamill.mechanism.sensors import Sensor, SensorKind, column_names, sensor_table
from nutamill.simulation.coupling import CouplingPlan, Scheme, coupling_state
from nutamill.simulation.setup.clock import Clock, refuse_endless
from nutamill.simulation.setup.model import Model, State
from nutamill.simulation.setup.part_readout import PartReadout

KINDS = {
    "position": SensorKind.POINT_POSITION,
    "velocity": SensorKind.POINT_VELOCITY,
    "acceleration": SensorKind.POINT_ACCELERATION,
    "attitude": SensorKind.BODY_ATTITUDE,
    "reaction": SensorKind.JOINT_REACTION,
}
"""Kinds of sensors by their name in the file."""


class MechanismParts(NamedTuple):
    """The descriptions that `nutamill.mechanism.assembly.assemble` turns into arrays, in the order of its
    arguments.
    """

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


def mechanism_parts(case: MechanismCase) -> MechanismParts:
    """The parts of a case as descriptions of the engine."""
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


def assemble_case(case: MechanismCase) -> tuple[Mechanism, MechanismState, MechanismScratch]:
    """Constants, state as assembled and work space of a case; raises CaseError with every fault of the
    engine's own checks.
    """
    return assemble(*mechanism_parts(case), gravity=case.gravity, redundant=case.redundant)


def case_sensors(case: MechanismCase) -> list[Sensor]:
    """What every run of a case reads: all joints, all bushings, all drives, then the sensors of the file."""
    sensors = [Sensor(f"joint_{joint.name}", SensorKind.JOINT_REACTION, joint.name) for joint in case.joints]
    for bushing in case.bushings:
        sensors.append(Sensor(f"bushing_{bushing.name}", SensorKind.BUSHING_WRENCH, bushing.name))
        sensors.append(Sensor(f"bushing_{bushing.name} travel", SensorKind.BUSHING_TRAVEL, bushing.name))
    sensors += [Sensor(f"drive_{drive.name}", SensorKind.DRIVE, drive.name) for drive in case.drives]
    for entry in case.sensors:
        sensors.append(
            Sensor(
                f"{entry.name} {entry.kind}",
                KINDS[entry.kind],
                entry.of,
                point=entry.at,
                axes_body=entry.axes,
            )
        )
    return sensors


def build_mechanism(case: MechanismCase) -> tuple[Model, State]:
    """Model and first state of a mechanism, ready to march.

    Raises
    ------
    CaseError : every fault of the mechanism
    StepError : no finite accelerations, or no rest where it is asked for
    """
    mechanism, state, scratch = assemble_case(case)
    sensors = sensor_table(mechanism, state, case_sensors(case))
    if case.run.start == "rest":
        static_equilibrium(mechanism, state, scratch)
    elif start(mechanism, state, scratch) != OK:
        raise StepError(
            f"{case.name}: the first accelerations must be finite, they are not. Look at masses and inertias."
        )
    clock = mechanism_clock(case)
    nowhere = np.zeros(0, np.int64)
    plan = CouplingPlan(
        int(Scheme.STAGGERED), 0, clock.window, clock.windows_per_row, nowhere, 0, np.zeros(3), 0
    )
    readout = PartReadout(case, column_names(sensors))
    model = Model(case, clock, mechanism, scratch, sensors, None, None, charge_reading(), None, plan, readout)
    return model, State(state, None, None, coupling_state(0), np.zeros(readout.n_columns))


def mechanism_clock(case: MechanismCase) -> Clock:
    """Step and row of a run: the longest step that is at most `run.dt` and divides the period of the
    series.
    """
    period = 1.0 / case.run.series_rate
    refuse_endless(case.run.until, min(period, case.run.dt))
    steps = max(1, math.ceil(period / case.run.dt * (1.0 - 1e-12)))
    return Clock(0, period / steps, steps, "run.dt")


def _quaternion(turn: Turn | None) -> tuple[float, float, float, float]:
    """Attitude (w, x, y, z) of a turn about an axis."""
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
    stiffness, damping = (
        tuple(getattr(entry, f"{way}_{what}") for way in ("shear", "axial", "bending", "torsion"))
        for what in ("stiffness", "damping")
    )
    return Bushing(entry.name, *entry.between, entry.point, entry.axis, stiffness, damping)
