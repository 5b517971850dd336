"""The FMUs of a run and what they exchange with it at every window."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np

from nutamill.base.errors import CaseError, Fault, ResultError
from nutamill.case.machine import Machine
from nutamill.mechanism.drives import drive_motion
from nutamill.mechanism.model import Mechanism, MechanismState
from nutamill.simulation.fmus.mapping import BodyPlan, FmuPlan, fmu_plans
from nutamill.simulation.fmus.mobility import wrong_mobility
from nutamill.simulation.fmus.pose import MOTION, motion_of, put_wrench
from nutamill.simulation.fmus.session import FmuSession

SAME_PLACE = 1e-6
"""Largest distance [m] and rotation [rad] between a body as assembled and where its FMU starts it."""
GROUP = "fmu_{}"
"""Group of a checkpoint with the state of an FMU."""


class Exchange:
    """The started FMUs of a machine.

    Parameters
    ----------
    plans : the FMUs and their mappings

    Raises
    ------
    CaseError : an FMU puts a body elsewhere than the case, or answers forces like no machine
    StepError : an FMU cannot be started
    """

    def __init__(self, plans: Sequence[FmuPlan]):
        self._sessions: list[FmuSession] = []
        try:
            for plan in plans:
                self._sessions.append(FmuSession(plan))
            # the last of inputs and outputs stands for what an FMU does not have
            self._inputs = [np.zeros(len(plan.inputs) + 1) for plan in plans]
            self._outputs = [np.zeros(len(plan.outputs) + 1) for plan in plans]
            back = any(link.fmu > number for number, plan in enumerate(plans) for link in plan.links)
            for _ in range(1 + back):  # what one further down gives is known the second time
                for number, session in enumerate(self._sessions):
                    self._link(number)
                    self._outputs[number][:-1] = session.read(self._inputs[number][:-1])
        except BaseException:
            self.close()
            raise
        self.moves = [plan.body for _, plan in self._bodies()]
        """Indices of the bodies that FMUs move."""
        self.window_start = np.zeros((len(self.moves), 19))
        """Motions of these bodies at the start of the present window."""

    @property
    def plans(self) -> list[FmuPlan]:
        """The FMUs and their mappings."""
        return [session.plan for session in self._sessions]

    def close(self) -> None:
        """Close all FMUs."""
        for session in self._sessions:
            session.close()

    def prepare(self, mechanism: Mechanism, state: MechanismState, step: float, prescribed: bool) -> None:
        """Put the bodies where the FMUs start them, without mass, so that the mechanism leaves them alone.

        Parameters
        ----------
        mechanism, state : of the machine, changed in place
        step : window [s]
        prescribed : whether the wrench of the charge is withheld from the FMUs

        Raises
        ------
        CaseError : as the class
        """
        faults: list[Fault] = []
        for number, plan in self._bodies():
            where = f"{self._sessions[number].plan.where}.bodies.{plan.carrier}"
            motion = motion_of(plan, self._outputs[number], np.zeros(19), 0.0)
            faults += _elsewhere(plan, motion, where)
            _put_motion(state, plan.body, motion)
            for name in ("mass", "inverse_mass", "inertia", "inverse_inertia"):
                mechanism.bodies[name][plan.body] = 0.0
        for session, inputs in zip(self._sessions, self._inputs, strict=True):
            bodies = [] if prescribed else session.plan.bodies
            if session.plan.description.can_roll_back:
                faults += wrong_mobility(session, bodies, inputs, step)
        if faults:
            raise CaseError(*faults)

    def drive(self, mechanism: Mechanism, state: MechanismState, step: float) -> None:
        """March the FMUs that move no body over the window that begins, and set the torques of their drives.

        They get the mean speed and angle of the window as the mechanism's last accelerations predict them:
        of second order in the window, as its own step.
        """
        time = float(state.time[0])
        for number, session in enumerate(self._sessions):
            if session.plan.bodies:
                continue
            inputs = self._inputs[number]
            for plan in session.plan.drives:
                angle, speed, acceleration = state.drive_motion[plan.drive]
                inputs[plan.angle] = angle + step * (speed / 2.0 + step * acceleration / 6.0)
                inputs[plan.speed] = speed + step * acceleration / 2.0
                if plan.set_speed >= 0:
                    record = mechanism.drives[plan.drive]
                    inputs[plan.set_speed] = drive_motion(record, mechanism.knots, time + step / 2.0)[1]
            self._link(number)
            self._outputs[number][:-1] = session.step(time, step, inputs[:-1])
            self._put_torques(number, state)

    def move(self, state: MechanismState, start: np.ndarray, time: float, step: float) -> None:
        """March the FMU that moves bodies over a window with the mean wrenches of the charge, and put the
        bodies where it moves them.

        Parameters
        ----------
        state : of the mechanism at the end of the window
        start : motions of these bodies at the start of the window (n, 19), by `motions`
        time, step : start and length of the window [s]
        """
        bodies = self._bodies()
        for k, (number, plan) in enumerate(bodies):
            put_wrench(plan, state.wrench[plan.body], start[k, MOTION["quaternion"]], self._inputs[number])
        for number in dict.fromkeys(number for number, _ in bodies):
            self._link(number)
            outputs = self._sessions[number].step(time, step, self._inputs[number][:-1])
            self._outputs[number][:-1] = outputs
        for k, (number, plan) in enumerate(bodies):
            _put_motion(state, plan.body, motion_of(plan, self._outputs[number], start[k], step))

    def motions(self, state: MechanismState) -> np.ndarray:
        """Return the present motions (n, 19) of the bodies that FMUs move."""
        return np.array([_motion(state, body) for body in self.moves]).reshape(-1, 19)

    def mark(self, time: float) -> None:
        """Store the states of the FMUs that move bodies, in place of those stored before."""
        for number in dict.fromkeys(number for number, _ in self._bodies()):
            self._sessions[number].mark(time)

    def back(self, time: float) -> None:
        """Put the FMUs back to the stored states."""
        for number in dict.fromkeys(number for number, _ in self._bodies()):
            self._sessions[number].back(time)

    def groups(self, time: float) -> dict[str, dict[str, np.ndarray]]:
        """Return groups of a checkpoint with inputs, outputs and, where an FMU can give it, its state."""
        groups = {}
        for session, inputs, outputs in zip(self._sessions, self._inputs, self._outputs, strict=True):
            state = session.stored(time) if session.plan.description.can_serialise else np.zeros(0, np.uint8)
            groups[GROUP.format(session.plan.name)] = {
                "state": state,
                "inputs": inputs.copy(),
                "outputs": outputs.copy(),
            }
        return groups

    def restore(self, groups: dict[str, dict[str, np.ndarray]], time: float) -> None:
        """Put the FMUs into the states of a checkpoint at `time` [s].

        Raises
        ------
        ResultError : an FMU that cannot store its state
        """
        refuse_resume(self.plans)
        for session, inputs, outputs in zip(self._sessions, self._inputs, self._outputs, strict=True):
            group = groups[GROUP.format(session.plan.name)]
            session.load(time, group["state"])
            inputs[:], outputs[:] = group["inputs"], group["outputs"]

    def _bodies(self) -> list[tuple[int, BodyPlan]]:
        """Return the bodies that FMUs move, each with the index of its FMU."""
        return [(n, plan) for n, session in enumerate(self._sessions) for plan in session.plan.bodies]

    def _link(self, number: int) -> None:
        """Set the inputs of an FMU that come from others."""
        for link in self._sessions[number].plan.links:
            self._inputs[number][link.input] = self._outputs[link.fmu][link.output]

    def _put_torques(self, number: int, state: MechanismState) -> None:
        for plan in self._sessions[number].plan.drives:
            if plan.torque < 0:
                continue
            state.motor_integral[plan.drive] = self._outputs[number][plan.torque]


def refuse_resume(plans: Sequence[FmuPlan]) -> None:
    """Raise ResultError if an FMU cannot store its state."""
    unable = [plan for plan in plans if not plan.description.can_serialise]
    if unable:
        names = ", ".join(f'"{plan.name}"' for plan in unable)
        raise ResultError(
            f"fmus: {names} cannot store the state of the model (canSerializeFMUstate is false), so the run "
            "cannot go on from a checkpoint. Run the case again."
        )


@contextmanager
def started(machine: Machine) -> Iterator[Exchange | None]:
    """Start the FMUs of a machine and close them with the block. It is None for a machine without any.

    Raises
    ------
    CaseError : every fault of the FMUs and of their mapping
    StepError : an FMU cannot be started
    """
    if not machine.fmus:
        yield None
        return
    exchange = Exchange(fmu_plans(machine))
    try:
        yield exchange
    finally:
        exchange.close()


def _motion(state: MechanismState, body: int) -> np.ndarray:
    """Return the motion (19,) of a body."""
    return np.concatenate(
        [
            state.position[body],
            state.quaternion[body],
            state.velocity[body],
            state.angular_velocity[body],
            state.acceleration[body],
        ]
    )


def _put_motion(state: MechanismState, body: int, motion: np.ndarray) -> None:
    """Write the motion (19,) of a body into the state."""
    state.position[body] = motion[MOTION["position"]]
    state.quaternion[body] = motion[MOTION["quaternion"]]
    state.velocity[body] = motion[MOTION["velocity"]]
    state.angular_velocity[body] = motion[MOTION["angular_velocity"]]
    state.acceleration[body, :3] = motion[MOTION["acceleration"]]
    state.acceleration[body, 3:] = motion[MOTION["angular_acceleration"]]


def _elsewhere(plan: BodyPlan, motion: np.ndarray, where: str) -> Iterator[Fault]:
    """Yield a fault if an FMU starts a body elsewhere than the case has it."""
    if not np.isfinite(motion).all():
        yield Fault(where, "the FMU starts it without a finite pose", "Look at the names of its attitude")
        return
    gap = float(np.linalg.norm(motion[:3] - plan.start[:3]))
    half = min(1.0, abs(float(motion[3:7] @ plan.start[3:])))  # the cosine of half the angle between them
    turned = 4.0 * float(np.arcsin(np.sqrt(0.5 * (1.0 - half))))
    if gap > SAME_PLACE:
        at = ", ".join(f"{value:.6g}" for value in motion[:3])
        what = f"the FMU starts it at ({at}) m, {gap:.3g} m from its place in the case"
        yield Fault(f"{where}.position", what, "Correct origin, turn, point or units")
    if turned > SAME_PLACE:
        what = f"the FMU starts it turned by {turned:.3g} rad from its attitude in the case"
        yield Fault(f"{where}.attitude", what, "Correct turn, attitude_as or the order of the names")
