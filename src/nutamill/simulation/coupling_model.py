"""Arrays of the coupled step: constants, state and work space of mechanism, charge and coupling."""

from collections.abc import Sequence
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from nutamill.base.frames import MOTION_SIZE
from nutamill.charge.kernels.copying import copied
from nutamill.charge.measures.observe import ChargeReading, charge_reading
from nutamill.charge.measures.statistics import ChargeStatistics, StatisticsPlan
from nutamill.charge.model import ChargeModel, ChargeScratch, ChargeState
from nutamill.mechanism.model import Mechanism, MechanismScratch, MechanismState, SensorTable
from nutamill.simulation.row import RowStarts


class Scheme(IntEnum):
    """How charge and mechanism act on each other (`nutamill.simulation.coupling`)."""

    PRESCRIBED = 0
    """The wrench of the charge is recorded and not applied."""
    STAGGERED = 1
    """One pass over each window."""
    ITERATED = 2
    """Passes over each window until the motion of the walls converges."""


class Outcome(IntEnum):
    """How a coupled march ended."""

    RUNNING = 0
    """All windows are done."""
    CHARGE_FAILED = 1
    """The status of the charge is a fault."""
    LISTS_FULL = 2
    """The lists of the charge must grow; the march then goes on from where it stopped."""
    NOT_CONVERGED = 3
    """`ITERATED` reached its largest number of passes."""
    NOT_FINITE = 4
    """The motion of the mechanism is not finite."""


class CouplingPlan(NamedTuple):
    """Constants of a coupled march."""

    scheme: int
    """`Scheme` [1]."""
    substeps: int
    """Charge substeps in a window [1]."""
    dt: float
    """Window [s]."""
    windows_per_row: int
    """Windows between two rows of the record [1]."""
    carriers: np.ndarray
    """Mechanism body that carries the surfaces of each body of the charge [1], (n_carriers,)."""
    points: np.ndarray
    """Point of each carrier about which the moment of the charge is recorded [m], (n_carriers, 3), axes of
    the body from its mass centre.
    """
    reference_drive: int
    """Drive with whose angle the charge's neighbour list and fields rotate [1]; -1 where they do not."""


class CouplingState(NamedTuple):
    """State of the coupling, beside the states of the two engines."""

    windows: np.ndarray
    """Windows done since the start of the run [1], (1,)."""
    passes: np.ndarray
    """Passes over windows since the start [1], (1,): windows, and repetitions by `ITERATED`."""
    motions: np.ndarray
    """Motion of each carrier in the present window (n_carriers, 19), see
    `nutamill.base.frames.MOTION_SIZE`.
    """
    reference: np.ndarray
    """Axis about which the neighbour list rotates: point [m] (3), direction [1] (3), angle [rad] at the start
    of the window, speed [rad/s], (8,).
    """
    repeat: np.ndarray
    """1 if the present window must be repeated [1], (1,)."""
    row_impulse: np.ndarray
    """Impulse [N s] and angular impulse about its recorded point [N m s] on each carrier since the last row,
    (n_carriers, 6), world axes.
    """
    charge_impulse: np.ndarray
    """Impulse of the charge on the carriers since the start [N s], (3,), world axes."""
    mechanism_impulse: np.ndarray
    """Impulse of the wrenches that the mechanism received since the start [N s], (3,), world axes."""
    outcome: np.ndarray
    """`Outcome` [1], (1,)."""
    row_motions: np.ndarray
    """Motion of each carrier at the last row (n_carriers, 19), for the statistics."""
    row_angle: np.ndarray
    """Angle of the reference drive at the last row [rad], (1,), for the statistics."""


class CoupledModel(NamedTuple):
    """Constants of mechanism, charge and coupling."""

    mechanism: Mechanism
    """Bodies, joints, loads."""
    sensors: SensorTable
    """Sensors of the mechanism."""
    charge: ChargeModel
    """The charge."""
    survey: StatisticsPlan
    """Grid and patches of the charge's statistics."""
    plan: CouplingPlan
    """How the two are coupled."""
    row: RowStarts
    """Layout of a row of the record."""


class CoupledState(NamedTuple):
    """States of mechanism, charge and coupling."""

    mechanism: MechanismState
    """Motion, reactions and ledgers of the mechanism."""
    charge: ChargeState
    """Motion, contact memory and ledgers of the charge."""
    statistics: ChargeStatistics
    """Sums of the charge's statistics."""
    coupling: CouplingState
    """Counters and sums of the coupling."""


class CoupledScratch(NamedTuple):
    """Work space of a coupled march."""

    mechanism: MechanismScratch
    """Work space of the mechanism."""
    charge: ChargeScratch
    """Work space of the charge."""
    reading: ChargeReading
    """Work space of `nutamill.charge.measures.observe.observe`."""
    start_mechanism: MechanismState
    """State at the start of the window; empty arrays unless the scheme is `ITERATED`."""
    start_charge: ChargeState
    """The same of the charge."""


def coupling_state(
    n_carriers: int,
    axis: tuple[Sequence[float] | np.ndarray, Sequence[float] | np.ndarray] = (
        (0.0, 0.0, 0.0),
        (0.0, 0.0, 1.0),
    ),
) -> CouplingState:
    """Return the state before the first window, for `n_carriers` bodies with surfaces. `axis` is point [m]
    and direction of the axis about which the neighbour list rotates, world.
    """
    windows, passes, repeat, outcome = (np.zeros(1, np.int64) for _ in range(4))
    motions = np.zeros((n_carriers, MOTION_SIZE))
    return CouplingState(
        windows,
        passes,
        motions,
        np.array([*axis[0], *axis[1], 0.0, 0.0]),
        repeat,
        np.zeros((n_carriers, 6)),
        np.zeros(3),
        np.zeros(3),
        outcome,
        motions.copy(),
        np.zeros(1),
    )


def coupled_scratch(
    state: CoupledState, mechanism: MechanismScratch, charge: ChargeScratch, scheme: int
) -> CoupledScratch:
    """Return the work space of a march of `state`, around the work space of the two engines."""

    def room(part):
        if scheme == Scheme.ITERATED:
            return copied(part)
        return part._make(
            room(field) if isinstance(field, tuple) else np.empty((0,) * field.ndim, field.dtype)
            for field in part
        )

    return CoupledScratch(mechanism, charge, charge_reading(), room(state.mechanism), room(state.charge))
