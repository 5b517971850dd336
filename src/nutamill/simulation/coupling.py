"""The coupled step: mechanism and charge on one clock, many windows in one compiled call.

A window is one mechanism step of length ``dt`` and ``n`` charge substeps of ``dt/n``:

1. the motion of every body that carries surfaces (pose, twist and accelerations at the start of the window)
   is stored, and the mechanism drifts to the end of the window under just these accelerations;
2. the charge marches ``n`` substeps inside that motion and sums the impulse and the angular impulse about the
   moving mass centre that it gives each carrier;
3. impulse over ``dt`` is the mean wrench with which the mechanism finishes its step.

``PRESCRIBED``
    The wrench is recorded but not applied: the motion is that of the empty mill (SAIMM 2025, one-way).
``STAGGERED``
    One pass; the drift uses the wrench of the window before.  Second order in the window.
``ITERATED``
    The window is repeated with the wrench it produced, until the mass centres of the carriers end at the same
    positions.

Every thread of the team runs `march_coupled` with its own `tid`.  Thread 0 alone touches the mechanism and
the record.
"""

from nutamill.base.frames import rotate, shift_moment
from nutamill.base.kernel import copy_arrays, kernel
from nutamill.charge.kernels.copying import copy_state
from nutamill.charge.kernels.dynamics import window
from nutamill.charge.kernels.team import barrier
from nutamill.charge.measures.observe import observe
from nutamill.charge.measures.sampling import sample
from nutamill.charge.model import Status
from nutamill.mechanism.dynamics import OK, body_motion, drift, finish, solve_again
from nutamill.simulation.coupling_model import Outcome, Scheme
from nutamill.simulation.row import charge_row, mechanism_row

CHARGE_OK, CHARGE_LISTS_FULL = int(Status.OK), int(Status.LISTS_FULL)
PRESCRIBED, ITERATED = int(Scheme.PRESCRIBED), int(Scheme.ITERATED)
RUNNING, CHARGE_FAILED, LISTS_FULL = int(Outcome.RUNNING), int(Outcome.CHARGE_FAILED), int(Outcome.LISTS_FULL)
NOT_CONVERGED, NOT_FINITE = int(Outcome.NOT_CONVERGED), int(Outcome.NOT_FINITE)

MAX_PASSES = 12
"""Largest number of passes over a window of `ITERATED` [1]."""

# An absolute length: the number of passes of a scaled case may differ, its positions by less than this alone.
PASS_TOLERANCE = 1e-12
"""Change of the walls' end position between passes at which a window has converged [m]; overlaps are far
larger.
"""


@kernel
def march_mechanism(mechanism, state, scratch, coupling_state, sensors, plan, starts, n_windows, rows_out):
    """March a mechanism without charge through `n_windows` windows, and return the number of rows written."""
    row = 0
    for _ in range(n_windows):
        drift(mechanism, state, scratch, plan.dt)
        if finish(mechanism, state, scratch, plan.dt) != OK:
            coupling_state.outcome[0] = NOT_FINITE
            break
        coupling_state.windows[0] += 1
        if coupling_state.windows[0] % plan.windows_per_row == 0:
            mechanism_row(mechanism, state, scratch, sensors, starts, rows_out[row])
            row += 1
    return row


@kernel
def march_coupled(model, state, scratch, n_windows, rows_out, tid, n_threads):
    """March mechanism and charge through `n_windows` windows. Every thread of a team calls it.

    Parameters
    ----------
    model, state, scratch : `nutamill.simulation.coupling_model`
    rows_out : rows of the record (n_rows, n_columns), written by thread 0

    Returns
    -------
    rows written; ``state.coupling.outcome`` is the `Outcome`.  After `LISTS_FULL` a second call finishes the
    window; with `ITERATED` the states are then, and after `NOT_CONVERGED`, those of the start of the window.
    """
    plan, coupling, gate = model.plan, state.coupling, scratch.charge.barrier
    row = 0
    begun = coupling.outcome[0] == LISTS_FULL and plan.scheme != ITERATED
    barrier(gate, n_threads)
    for _ in range(n_windows):
        if plan.scheme == ITERATED:
            copy_state(state.charge, scratch.start_charge, tid, n_threads)
        if tid == 0:
            coupling.outcome[0] = RUNNING
            if plan.scheme == ITERATED:
                copy_arrays(state.mechanism, scratch.start_mechanism)
            if not begun:
                start_window(model, state, scratch)
        begun = False
        barrier(gate, n_threads)
        march_charge(model, state, scratch, tid, n_threads)
        if tid == 0 and coupling.outcome[0] == RUNNING:
            finish_window(model, state, scratch)
        barrier(gate, n_threads)
        if coupling.outcome[0] != RUNNING:
            restore_window(plan, state, scratch, tid, n_threads)
            break
        if coupling.windows[0] % plan.windows_per_row == 0:
            observe(model.charge, state.charge, scratch.charge, scratch.reading, tid, n_threads)
            if tid == 0:
                write_row(model, state, scratch, rows_out[row])
            barrier(gate, n_threads)
            row += 1
            if model.survey.on == 1:
                sample(
                    model.charge,
                    state.charge,
                    scratch.charge,
                    model.survey,
                    coupling.row_motions,
                    coupling.row_angle[0],
                    state.statistics,
                    tid,
                    n_threads,
                )
    return row


@kernel
def march_charge(model, state, scratch, tid, n_threads):
    """March the charge through the present window, with `ITERATED` until the motion of the carriers
    converges.
    """
    plan, coupling = model.plan, state.coupling
    for number in range(MAX_PASSES):
        window(
            model.charge,
            state.charge,
            scratch.charge,
            coupling.motions,
            coupling.reference,
            plan.substeps,
            plan.dt / plan.substeps,
            tid,
            n_threads,
        )
        if tid == 0:
            read_charge_status(state)
        if plan.scheme != ITERATED:
            return
        if tid == 0:
            coupling.repeat[0] = 0
            if coupling.outcome[0] == RUNNING:
                check_convergence(model, state, scratch, number)
        barrier(scratch.charge.barrier, n_threads)
        if coupling.repeat[0] == 0:
            return
        copy_state(scratch.start_charge, state.charge, tid, n_threads)


@kernel
def restore_window(plan, state, scratch, tid, n_threads):
    """Return to the start of the window where `ITERATED` stopped within it, unless the charge has a fault to
    report. Called by all threads.
    """
    outcome = state.coupling.outcome[0]
    if plan.scheme != ITERATED or (outcome != LISTS_FULL and outcome != NOT_CONVERGED):
        return
    copy_state(scratch.start_charge, state.charge, tid, n_threads)
    if tid == 0:
        copy_arrays(scratch.start_mechanism, state.mechanism)


@kernel
def start_window(model, state, scratch):
    """Store the motion of the carriers through the window and the rotation of the neighbour list, and drift
    the mechanism.
    """
    plan, coupling, mechanism = model.plan, state.coupling, state.mechanism
    for c in range(plan.carriers.shape[0]):
        body_motion(mechanism, plan.carriers[c], coupling.motions[c])
    if plan.reference_drive >= 0:
        coupling.reference[6] = mechanism.drive_motion[plan.reference_drive, 0]
        coupling.reference[7] = mechanism.drive_motion[plan.reference_drive, 1]
    drift(model.mechanism, mechanism, scratch.mechanism, plan.dt)


@kernel
def finish_window(model, state, scratch):
    """Finish the mechanism's step with the mean wrench of the charge, and add to the sums of the record."""
    plan, coupling, mechanism, impulse = model.plan, state.coupling, state.mechanism, state.charge.impulse
    if plan.scheme != PRESCRIBED:
        apply_impulse(plan, impulse, mechanism.wrench)
    if finish(model.mechanism, mechanism, scratch.mechanism, plan.dt) != OK:
        coupling.outcome[0] = NOT_FINITE
        return
    for c in range(plan.carriers.shape[0]):
        b, given = plan.carriers[c], impulse[c]
        p0, p1, p2 = recorded_point(scratch.mechanism, plan, c)
        m0, m1, m2 = shift_moment(
            given[3],
            given[4],
            given[5],
            given[0],
            given[1],
            given[2],
            -p0,
            -p1,
            -p2,
        )
        coupling.row_impulse[c, 3] += m0
        coupling.row_impulse[c, 4] += m1
        coupling.row_impulse[c, 5] += m2
        for k in range(3):
            coupling.row_impulse[c, k] += given[k]
            coupling.charge_impulse[k] += given[k]
            coupling.mechanism_impulse[k] += mechanism.wrench[b, k] * plan.dt
    coupling.windows[0] += 1
    coupling.passes[0] += 1


@kernel
def apply_impulse(plan, impulse, wrench_out):
    """Write the impulses of the charge (n_carriers, 6) over the window as mean wrenches of the carriers."""
    for c in range(plan.carriers.shape[0]):
        for k in range(6):
            wrench_out[plan.carriers[c], k] = impulse[c, k] / plan.dt


@kernel
def recorded_point(scratch, plan, c):
    """Return the present vector [m], world axes, as a 3-tuple, from the mass centre of carrier `c` to the
    point about which its moment is recorded, from the rotation matrices of `finish`.
    """
    return rotate(scratch.rotation[plan.carriers[c]], plan.points[c, 0], plan.points[c, 1], plan.points[c, 2])


@kernel
def read_charge_status(state):
    """Turn the status of the charge into an outcome."""
    if state.charge.status[0] == CHARGE_LISTS_FULL:
        state.coupling.outcome[0] = LISTS_FULL
    elif state.charge.status[0] != CHARGE_OK:
        state.coupling.outcome[0] = CHARGE_FAILED


@kernel
def check_convergence(model, state, scratch, number):
    """Decide whether the window must be repeated with the wrench it produced. If so, restore the start of
    the mechanism.

    The wrench moves the walls through the drift, by half its acceleration times dt^2.  `coupling.repeat` is 1
    until that end position changes by less than `PASS_TOLERANCE` from one pass to the next.
    """
    plan, coupling, mechanism = model.plan, state.coupling, state.mechanism
    copy_arrays(scratch.start_mechanism, mechanism)
    apply_impulse(plan, state.charge.impulse, mechanism.wrench)
    solve_again(model.mechanism, mechanism, scratch.mechanism)
    change = 0.0
    for c in range(plan.carriers.shape[0]):
        b = plan.carriers[c]
        for k in range(3):
            step = abs(mechanism.acceleration[b, k] - coupling.motions[c, 13 + k])
            change = max(change, 0.5 * plan.dt * plan.dt * step)
    if change > PASS_TOLERANCE and number == MAX_PASSES - 1:
        coupling.outcome[0] = NOT_CONVERGED
        return
    start_window(model, state, scratch)
    if change > PASS_TOLERANCE:
        coupling.repeat[0] = 1
        coupling.passes[0] += 1


@kernel
def write_row(model, state, scratch, row_out):
    """Write a row of the record, store the motion of the carriers for a sample of the statistics, and count
    the sample.
    """
    plan, coupling = model.plan, state.coupling
    mechanism_row(model.mechanism, state.mechanism, scratch.mechanism, model.sensors, model.row, row_out)
    charge_row(state.charge, scratch.reading, coupling, plan.dt * plan.windows_per_row, model.row, row_out)
    for c in range(plan.carriers.shape[0]):
        body_motion(state.mechanism, plan.carriers[c], coupling.row_motions[c])
    if plan.reference_drive >= 0:
        coupling.row_angle[0] = state.mechanism.drive_motion[plan.reference_drive, 0]
    state.statistics.samples[0] += 1
