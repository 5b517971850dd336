"""The coupled step: mechanism and charge on one clock, many windows in one compiled call.

A window is one mechanism step of length ``dt`` and ``n`` charge substeps of ``dt/n``:

1. the mechanism hands out the motion of every body that carries surfaces (pose, twist and accelerations at
  the start of
   the window) and drifts to the end of the window under just these accelerations;
2. the charge marches ``n`` substeps inside that motion and sums what it gives each body as impulse and
  angular impulse
   about the body's moving mass centre;
3. impulse over ``dt`` is the mean wrench with which the mechanism finishes its step.

``PRESCRIBED``  the wrench is recorded but not applied: the motion is that of the empty mill (SAIMM 2025,
one-way). ``STAGGERED``   one pass; the drift uses the wrench of the window before.  Second order in the
window. ``ITERATED``    the window is repeated with the wrench it has just produced, until the carriers' mass
                centres end at the same places.

Every thread of the team runs `march_coupled` with its own `tid`; thread 0 alone touches the mechanism and the
record.
"""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from nutamill.base.frames import MOTION_SIZE, rotate, shift_moment
from nutamill.base.kernel import copy_arrays, kernel
from nutamill.charge.kernels.copying import copy_state
from nutamill.charge.kernels.dynamics import window
from nutamill.charge.kernels.team import barrier
from nutamill.charge.measures.observe import observe
from nutamill.charge.measures.statistics import sample
from nutamill.charge.model import Status
from nutamill.mechanism.dynamics import OK, body_motion, drift, finish, solve_again
from nutamill.mechanism.energy import energies
from nutamill.mechanism.sensors import read_sensors

CHARGE_OK, CHARGE_LISTS_FULL = int(Status.OK), int(Status.LISTS_FULL)


class Scheme(IntEnum):
    """How charge and mechanism act on each other (module docstring)."""

    PRESCRIBED = 0
    STAGGERED = 1
    ITERATED = 2


PRESCRIBED = int(Scheme.PRESCRIBED)

RUNNING, CHARGE_FAILED, LISTS_FULL, NOT_CONVERGED, NOT_FINITE = 0, 1, 2, 3, 4
"""Outcome of a march: all windows done; the charge reports a fault; its lists must grow, then the march goes
on where it stopped; `ITERATED` met its limit of passes; the mechanism is no longer finite."""

MAX_PASSES = 12
"""Passes of one window after which `ITERATED` gives up [1]."""

PASS_TOLERANCE = 1e-12
"""Change of the walls' end position between passes at which `ITERATED` is content [m]: far below a contact's
overlap.
"""


class CouplingPlan(NamedTuple):
    """What is constant about a coupled march."""

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
    point_body: int
    """Mechanism body on which the nutation point is fixed [1]."""
    point: np.ndarray
    """Nutation point from that body's mass centre [m], (3,), its axes."""
    turn_drive: int
    """Drive whose angle the charge's neighbour list turns with [1]."""


class CouplingState(NamedTuple):
    """What a coupled march carries from window to window, beside the two engines' states."""

    windows: np.ndarray
    """Windows done since the start of the run [1], (1,)."""
    passes: np.ndarray
    """Passes over windows since the start [1], (1,): windows, and repetitions by `ITERATED`."""
    motions: np.ndarray
    """Motion of each carrier in the present window (n_carriers, 19), see
    `nutamill.base.frames.MOTION_SIZE`.
    """
    reference: np.ndarray
    """Axis the neighbour list turns about: point [m] (3), direction [1] (3), angle [rad] at the window's
    start, speed [rad/s], (8,).
    """
    again: np.ndarray
    """1 while the present window is to be repeated [1], (1,)."""
    row_impulse: np.ndarray
    """Impulse [N s] and angular impulse about the nutation point [N m s] on the carriers since the last row,
    (6,), world axes.
    """
    given: np.ndarray
    """Impulse the charge gave the carriers since the start [N s], (3,), world axes."""
    received: np.ndarray
    """Impulse of the wrenches the mechanism was given since the start [N s], (3,), world axes."""
    outcome: np.ndarray
    """`RUNNING` or why the march stopped [1], (1,)."""
    row_motions: np.ndarray
    """Motion of each carrier from the last row on (n_carriers, 19), for the statistics."""
    row_angle: np.ndarray
    """Crank angle at the last row [rad], (1,), for the statistics."""


def coupling_state(n_carriers: int) -> CouplingState:
    """A fresh state for `n_carriers` bodies with surfaces; nothing done."""
    windows, passes, again, outcome = (np.zeros(1, np.int64) for _ in range(4))
    motions = np.zeros((n_carriers, MOTION_SIZE))
    reference = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0])
    return CouplingState(
        windows,
        passes,
        motions,
        reference,
        again,
        np.zeros(6),
        np.zeros(3),
        np.zeros(3),
        outcome,
        motions.copy(),
        np.zeros(1),
    )


@kernel
def march_mechanism(mechanism, state, scratch, sensors, plan, coupling, n_windows, rows_out):
    """March a mechanism without charge through `n_windows` windows; returns the number of rows written.

    Rows: time, sensors, mechanism ledger (`mechanism_row`).
    """
    row = 0
    for _ in range(n_windows):
        drift(mechanism, state, scratch, plan.dt)
        if finish(mechanism, state, scratch, plan.dt) != OK:
            coupling.outcome[0] = NOT_FINITE
            break
        coupling.windows[0] += 1
        if coupling.windows[0] % plan.windows_per_row == 0:
            mechanism_row(mechanism, state, scratch, sensors, rows_out[row])
            row += 1
    return row


@kernel
def mechanism_row(mechanism, state, scratch, sensors, row_out):
    """One row: time, sensor columns, kinetic, potential and elastic energy, cumulative ledgers; returns its
    length.
    """
    row_out[0] = state.time[0]
    column = 1 + sensors.first_column[-1]
    read_sensors(mechanism, state, scratch, sensors, row_out[1:column])
    energies(mechanism, state, scratch, row_out[column : column + 3])
    column += 3
    for ledger in (
        state.drive_work,
        state.bushing_loss,
        state.spring_loss,
        state.joint_loss,
        state.torque_work,
    ):
        for value in ledger:
            row_out[column] = value
            column += 1
    return column


@kernel
def hand_out_motion(mechanism, mstate, mscratch, plan, coupling):
    """Motion of the carriers through the window, drift of the mechanism, and what the neighbour list turns
    with.
    """
    for c in range(plan.carriers.shape[0]):
        body_motion(mstate, plan.carriers[c], coupling.motions[c])
    angle, speed = mstate.drive_motion[plan.turn_drive, 0], mstate.drive_motion[plan.turn_drive, 1]
    coupling.reference[6], coupling.reference[7] = angle, speed
    drift(mechanism, mstate, mscratch, plan.dt)


@kernel
def take_in_impulse(mechanism, mstate, mscratch, cstate, plan, coupling):
    """The charge's impulse becomes the mechanism's mean wrench; the mechanism finishes its step; sums for the
    record.
    """
    given = cstate.impulse
    if plan.scheme != PRESCRIBED:
        for c in range(plan.carriers.shape[0]):
            for k in range(6):
                mstate.wrench[plan.carriers[c], k] = given[c, k] / plan.dt
    if finish(mechanism, mstate, mscratch, plan.dt) != OK:
        coupling.outcome[0] = NOT_FINITE
        return
    p0, p1, p2 = nutation_point(mstate, mscratch, plan)
    for c in range(plan.carriers.shape[0]):
        b = plan.carriers[c]
        arm0, arm1, arm2 = mstate.position[b, 0] - p0, mstate.position[b, 1] - p1, mstate.position[b, 2] - p2
        m0, m1, m2 = shift_moment(
            given[c, 3], given[c, 4], given[c, 5], given[c, 0], given[c, 1], given[c, 2], arm0, arm1, arm2
        )
        coupling.row_impulse[3] += m0
        coupling.row_impulse[4] += m1
        coupling.row_impulse[5] += m2
        for k in range(3):
            coupling.row_impulse[k] += given[c, k]
            coupling.given[k] += given[c, k]
            coupling.received[k] += mstate.wrench[b, k] * plan.dt
    coupling.windows[0] += 1
    coupling.passes[0] += 1


@kernel
def nutation_point(mstate, mscratch, plan):
    """Present place of the nutation point [m], world, as a 3-tuple; after `finish`, whose rotation matrices
    it uses.
    """
    b = plan.point_body
    r0, r1, r2 = rotate(mscratch.rotation[b], plan.point[0], plan.point[1], plan.point[2])
    return mstate.position[b, 0] + r0, mstate.position[b, 1] + r1, mstate.position[b, 2] + r2


@kernel
def note_charge_status(cstate, coupling):
    """Turn the charge's status into an outcome."""
    if cstate.status[0] == CHARGE_LISTS_FULL:
        coupling.outcome[0] = LISTS_FULL
    elif cstate.status[0] != CHARGE_OK:
        coupling.outcome[0] = CHARGE_FAILED


@kernel
def charge_row(charge, cstate, cscratch, plan, coupling, reading, row_out):
    """Charge part of a row: what `observe` sees, the contact ledger, the mean wrench on the carriers since
    the last row about the nutation point, impulses given and received, and the largest overlaps since the
    last row, which start anew.
    """
    observe(charge, cstate, cscratch, reading)
    column = 0
    for values in (
        reading.energy,
        reading.contacts,
        reading.mass_centre,
        reading.momentum,
        reading.coordination,
        cstate.ledger,
    ):
        for value in values:
            row_out[column] = value
            column += 1
    for k in range(6):
        row_out[column + k] = coupling.row_impulse[k] / (plan.dt * plan.windows_per_row)
        coupling.row_impulse[k] = 0.0
    for k in range(3):
        row_out[column + 6 + k] = coupling.given[k]
        row_out[column + 9 + k] = coupling.received[k]
    for k in range(2):
        row_out[column + 12 + k] = cstate.largest_overlap[k]
        cstate.largest_overlap[k] = 0.0


@kernel
def note_motion(mstate, plan, coupling, sums):
    """Keep how the carriers move from this row on, for a sample by all threads, and count the sample."""
    for c in range(plan.carriers.shape[0]):
        body_motion(mstate, plan.carriers[c], coupling.row_motions[c])
    coupling.row_angle[0] = mstate.drive_motion[plan.turn_drive, 0]
    sums.samples[0] += 1


@kernel
def march_coupled(
    mechanism,
    mstate,
    mscratch,
    sensors,
    charge,
    cstate,
    cscratch,
    plan,
    coupling,
    reading,
    survey,
    sums,
    n_windows,
    rows_out,
    tid,
    n_threads,
):
    """March mechanism and charge through `n_windows` windows, `PRESCRIBED` or `STAGGERED`; called by every
    thread of a team.

    Parameters
    ----------
    reading : room for what `observe` sees
    survey, sums : plan and sums of the charge's statistics, sampled at every row
    rows_out : (n_rows, n_columns), written by thread 0: mechanism row, then charge row (`charge_row`)

    Returns
    -------
    rows written; `coupling.outcome` says how it ended. After `LISTS_FULL` a second call finishes the window
    begun.
    """
    row = 0
    begun = coupling.outcome[0] == LISTS_FULL
    barrier(cscratch.barrier, n_threads)
    for _ in range(n_windows):
        if tid == 0:
            coupling.outcome[0] = RUNNING
            if not begun:
                hand_out_motion(mechanism, mstate, mscratch, plan, coupling)
        begun = False
        barrier(cscratch.barrier, n_threads)
        window(
            charge,
            cstate,
            cscratch,
            coupling.motions,
            coupling.reference,
            plan.substeps,
            plan.dt / plan.substeps,
            tid,
            n_threads,
        )
        if tid == 0:
            note_charge_status(cstate, coupling)
            if coupling.outcome[0] == RUNNING:
                take_in_impulse(mechanism, mstate, mscratch, cstate, plan, coupling)
                if coupling.outcome[0] == RUNNING and coupling.windows[0] % plan.windows_per_row == 0:
                    column = mechanism_row(mechanism, mstate, mscratch, sensors, rows_out[row])
                    charge_row(charge, cstate, cscratch, plan, coupling, reading, rows_out[row, column:])
                    note_motion(mstate, plan, coupling, sums)
        barrier(cscratch.barrier, n_threads)
        if coupling.outcome[0] != RUNNING:
            break
        if coupling.windows[0] % plan.windows_per_row == 0:
            row += 1
            if survey.on == 1:
                sample(
                    charge,
                    cstate,
                    cscratch,
                    survey,
                    coupling.row_motions,
                    coupling.row_angle[0],
                    sums,
                    tid,
                    n_threads,
                )
    return row


@kernel
def march_iterated(
    mechanism,
    mstate,
    mscratch,
    sensors,
    charge,
    cstate,
    cscratch,
    plan,
    coupling,
    reading,
    survey,
    sums,
    mkept,
    ckept,
    n_windows,
    rows_out,
    tid,
    n_threads,
):
    """As `march_coupled`, with each window repeated under the wrench it produced (`ITERATED`).

    Parameters
    ----------
    mkept, ckept : states of the same shapes, for the start of a window

    Returns
    -------
    rows written; after `LISTS_FULL` and `NOT_CONVERGED` the states are those of the last window's start
    """
    row = 0
    barrier(cscratch.barrier, n_threads)
    for _ in range(n_windows):
        if tid == 0:
            coupling.outcome[0] = RUNNING
            copy_arrays(mstate, mkept)
            copy_state(cstate, ckept)
            hand_out_motion(mechanism, mstate, mscratch, plan, coupling)
        barrier(cscratch.barrier, n_threads)
        for number in range(MAX_PASSES):
            window(
                charge,
                cstate,
                cscratch,
                coupling.motions,
                coupling.reference,
                plan.substeps,
                plan.dt / plan.substeps,
                tid,
                n_threads,
            )
            if tid == 0:
                note_charge_status(cstate, coupling)
                coupling.again[0] = 0
                if coupling.outcome[0] == RUNNING:
                    repeat_window(mechanism, mstate, mscratch, cstate, plan, coupling, mkept, ckept, number)
            barrier(cscratch.barrier, n_threads)
            if coupling.again[0] == 0:
                break
        if tid == 0:
            if coupling.outcome[0] == RUNNING:
                take_in_impulse(mechanism, mstate, mscratch, cstate, plan, coupling)
                if coupling.outcome[0] == RUNNING and coupling.windows[0] % plan.windows_per_row == 0:
                    column = mechanism_row(mechanism, mstate, mscratch, sensors, rows_out[row])
                    charge_row(charge, cstate, cscratch, plan, coupling, reading, rows_out[row, column:])
                    note_motion(mstate, plan, coupling, sums)
            elif coupling.outcome[0] != CHARGE_FAILED:
                copy_arrays(mkept, mstate)
                copy_state(ckept, cstate)
        barrier(cscratch.barrier, n_threads)
        if coupling.outcome[0] != RUNNING:
            break
        if coupling.windows[0] % plan.windows_per_row == 0:
            row += 1
            if survey.on == 1:
                sample(
                    charge,
                    cstate,
                    cscratch,
                    survey,
                    coupling.row_motions,
                    coupling.row_angle[0],
                    sums,
                    tid,
                    n_threads,
                )
    return row


@kernel
def repeat_window(mechanism, mstate, mscratch, cstate, plan, coupling, mkept, ckept, number):
    """Decide whether the window must be marched again with the wrench it produced; if so, set it back to its
    start.

    The wrench moves the walls through the drift, by half its acceleration times dt^2; `coupling.again` is 1
    until that end position changes by less than `PASS_TOLERANCE` from one pass to the next.
    """
    copy_arrays(mkept, mstate)
    for c in range(plan.carriers.shape[0]):
        for k in range(6):
            mstate.wrench[plan.carriers[c], k] = cstate.impulse[c, k] / plan.dt
    solve_again(mechanism, mstate, mscratch)
    change = 0.0
    for c in range(plan.carriers.shape[0]):
        b = plan.carriers[c]
        for k in range(3):
            change = max(
                change, 0.5 * plan.dt * plan.dt * abs(mstate.acceleration[b, k] - coupling.motions[c, 13 + k])
            )
    if change > PASS_TOLERANCE and number == MAX_PASSES - 1:
        coupling.outcome[0] = NOT_CONVERGED
        return
    hand_out_motion(mechanism, mstate, mscratch, plan, coupling)
    if change > PASS_TOLERANCE:
        copy_state(ckept, cstate)
        coupling.again[0] = 1
        coupling.passes[0] += 1
