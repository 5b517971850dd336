"""One entry of the compiled march, and the hand-work around it: first row, growing lists, restoring, wording
a failure.
"""

import dataclasses

import numpy as np

from nutamill.base.errors import ResultError, StepError
from nutamill.base.frames import quaternion_product, rotation_matrix
from nutamill.case import Case
from nutamill.case.machine import CHAMBER
from nutamill.charge.arrays import grow
from nutamill.charge.kernels.clumps import POSE, ClumpColumn
from nutamill.charge.kernels.copying import copied
from nutamill.charge.kernels.team import run_team
from nutamill.charge.measures.statistics import gathered, put_back
from nutamill.charge.messages import status_text, status_time
from nutamill.charge.model import Clock as ChargeClock
from nutamill.charge.readout import attitudes, contact_forces, positions, spins, velocities
from nutamill.simulation.coupling import (
    CHARGE_FAILED,
    LISTS_FULL,
    NOT_CONVERGED,
    RUNNING,
    Scheme,
    charge_row,
    march_coupled,
    march_iterated,
    march_mechanism,
    mechanism_row,
)
from nutamill.simulation.setup.charge import CHAMBER_CARRIER, chamber_surfaces
from nutamill.simulation.setup.model import Model, State
from nutamill.simulation.setup.particles import charge_particles, particle_count
from nutamill.simulation.setup.rigid_parts import whole_chamber
from nutamill.simulation.setup.statistics import recorded_sums
from nutamill.simulation.setup.threads import team_size

LARGEST_KEPT = 2**28
"""Largest state of which a run keeps a copy at every entry of the march [bytes]; a larger one falls back on
its newest checkpoint.
"""


def enter(model: Model, state: State, n_rows: int) -> tuple[Model, np.ndarray, StepError | None]:
    """One entry of the compiled march: `n_rows` rows, unless something stops it.

    Returns
    -------
    the model (with larger lists, if they had to grow), rows (n, n_columns) as written, and what stopped the
    march
    """
    rows = np.empty((n_rows, model.readout.n_columns))
    done, coupling = 0, state.coupling
    mechanism = (model.mechanism, state.mechanism, model.mechanism_scratch, model.sensors)
    while True:
        left = (n_rows - done) * model.plan.windows_per_row - int(
            coupling.windows[0]
        ) % model.plan.windows_per_row
        if model.charge is None:
            done += march_mechanism(*mechanism, model.plan, coupling, left, rows[done:])
        else:
            charge = (
                model.charge,
                state.charge,
                model.charge_scratch,
                model.plan,
                coupling,
                model.reading,
                model.survey,
                state.statistics,
            )
            before = coupling.windows[0]
            if model.plan.scheme == Scheme.ITERATED:
                kept = copy_of(state.mechanism), copied(state.charge)
                run_team(
                    march_iterated, (*mechanism, *charge, *kept, left, rows[done:]), team_size(model.case)
                )
            else:
                run_team(march_coupled, (*mechanism, *charge, left, rows[done:]), team_size(model.case))
            done += (
                int(coupling.windows[0]) // model.plan.windows_per_row
                - int(before) // model.plan.windows_per_row
            )
            if coupling.outcome[0] == LISTS_FULL or state.charge.clock[ChargeClock.CROWDED]:
                model = grown(model, state)
        if coupling.outcome[0] != LISTS_FULL:
            break
    fault = None if coupling.outcome[0] == RUNNING else StepError(failure(model, state))
    return model, rows[:done], fault


def grown(model: Model, state: State) -> Model:
    """The model with larger neighbour lists; `state` gets them too."""
    charge, state.charge, scratch = grow(model.charge, state.charge, model.charge_scratch)
    return dataclasses.replace(model, charge=charge, charge_scratch=scratch)


def copy_of(part):
    """A copy of a state of arrays, for a window's start."""
    return part._make(np.copy(array) for array in part)


def keep(state: State, kept: State | None) -> State | None:
    """A copy of `state` to fall back on, made in `kept` where that has room for it; None where it would be
    too large.

    Its statistics are those of `state`; `statistics_group` keeps them.
    """
    arrays = [array for group in state.arrays().values() for array in group.values()]
    if sum(array.nbytes for array in arrays) > LARGEST_KEPT:
        return None
    places = (
        [array for group in kept.arrays().values() for array in group.values()] if kept is not None else []
    )
    if [place.shape for place in places] != [array.shape for array in arrays]:
        charge = None if state.charge is None else copied(state.charge)
        return State(
            copy_of(state.mechanism),
            charge,
            state.statistics,
            copy_of(state.coupling),
            state.first_row.copy(),
        )
    for place, array in zip(places, arrays, strict=True):
        np.copyto(place, array)
    return kept


def record_first_row(model: Model, state: State) -> None:
    """Read the state at rest into `state.first_row`: ledgers count from there."""
    end = mechanism_row(
        model.mechanism, state.mechanism, model.mechanism_scratch, model.sensors, state.first_row
    )
    if model.charge is not None:
        charge_row(
            model.charge,
            state.charge,
            model.charge_scratch,
            model.plan,
            state.coupling,
            model.reading,
            state.first_row[end:],
        )


def snapshot(model: Model, state: State) -> dict[str, np.ndarray]:
    """What is kept of the present state for looking at; see `nutamill.result.fields.SNAPSHOT`."""
    kept = {
        "body_positions": state.mechanism.position[:-1],
        "body_attitudes": state.mechanism.quaternion[:-1],
    }
    if model.charge is not None:
        kept["positions"] = positions(model.charge, state.charge, model.clock.substep).astype(np.float32)
        kept["velocities"] = velocities(model.charge, state.charge).astype(np.float32)
        turned = attitudes(model.charge, state.charge)
        if turned is not None:
            kept["attitudes"] = turned.astype(np.float32)
        kept["spins"] = spins(model.charge, state.charge).astype(np.float32)
        kept["radii"] = (0.5 * charge_particles(model.case).diameter).astype(np.float32)
        pushed = contact_forces(model.charge, state.charge, model.clock.substep)
        if pushed is not None:
            kept["contact_forces"] = pushed.astype(np.float32)
        kept["materials"] = charge_particles(model.case).material.astype(np.int16)
        chamber = model.plan.carriers[CHAMBER_CARRIER]
        rotation = np.empty((3, 3))
        rotation_matrix(state.mechanism.quaternion[chamber], rotation)
        kept["chamber_floor"] = state.mechanism.position[chamber] + rotation @ model.survey.origin
        kept["chamber_attitude"] = state.mechanism.quaternion[chamber]
    return kept


def statistics_group(model: Model, state: State) -> dict[str, dict[str, np.ndarray]]:
    """The group of a checkpoint with the present statistics; no group for an empty chamber."""
    return {} if model.charge is None else {"statistics": gathered(state.statistics, state.charge.impacts)}


def checkpoint_groups(model: Model, state: State) -> dict[str, dict[str, np.ndarray]]:
    """Everything a run needs to go on from here bit for bit, in groups of arrays."""
    return state.arrays() | statistics_group(model, state)


def statistics(model: Model, state: State) -> dict[str, np.ndarray] | None:
    """What the charge has done so far, in SI; see `nutamill.result.fields.STATISTICS`. None if nothing is
    summed.
    """
    if model.charge is None or not model.survey.on:
        return None
    sums = gathered(state.statistics, state.charge.impacts)
    return recorded_sums(model.case, model.survey, model.charge.per_cut, sums)


def restore(model: Model, state: State, groups: dict[str, dict[str, np.ndarray]]) -> Model:
    """Put the arrays of a checkpoint into `state`, in place; lists grow to the size they had."""
    if model.charge is not None:
        while state.charge.pairs.partners.shape != groups["charge"]["pairs_partners"].shape:
            if state.charge.pairs.partners.size > groups["charge"]["pairs_partners"].size:
                raise ResultError(
                    "checkpoint: its neighbour lists are of no size this version makes. Run the case again."
                )
            model = grown(model, state)
    for part, arrays in state.arrays().items():
        for name, array in arrays.items():
            array[...] = groups[part][name]
    if model.charge is not None:
        put_back(state.statistics, state.charge.impacts, groups["statistics"])
    return model


def bed_from_checkpoint(
    case: Case, mill_bodies: list[str], groups: dict[str, dict[str, np.ndarray]]
) -> np.ndarray | None:
    """Places [m] (n, 3) of a checkpoint's particles, with attitudes (n, 7) of clumps, in chamber axes from
    the nutation point.

    None for an empty chamber.

    Something sound to build the model around before `restore` puts the true state in.
    """
    if "charge" not in groups:
        return None
    x, ids, clumps = (groups["charge"][name] for name in ("x", "ids", "clumps"))
    n = particle_count(case)
    poses = np.empty((n, 7 if len(clumps) else 3))
    if len(clumps):
        poses[clumps[:, ClumpColumn.ID].astype(int)] = clumps[:, POSE]
    else:
        poses[ids[:n]] = x[:, :n].T
    chamber = mill_bodies.index(CHAMBER)
    rotation = np.empty((3, 3))
    rotation_matrix(groups["mechanism"]["quaternion"][chamber], rotation)
    poses[:, :3] = (poses[:, :3] - groups["mechanism"]["position"][chamber]) @ rotation + whole_chamber(
        case.chamber
    ).mass_centre
    back = groups["mechanism"]["quaternion"][chamber] * [1.0, -1.0, -1.0, -1.0]
    for pose in poses if len(clumps) else ():
        pose[3:] = quaternion_product(back, pose[3:])
    return poses


def failure(model: Model, state: State) -> str:
    """Words for what stopped a march: when, which particle or part, and what to do."""
    if state.coupling.outcome[0] == CHARGE_FAILED:
        return f"t = {status_time(state.charge, model.clock.substep):.9g} s: {charge_fault(model, state)}"
    when = f"t = {state.mechanism.time[0]:.6g} s"
    if state.coupling.outcome[0] == NOT_CONVERGED:
        return (
            f"{when}: a window must settle under its own wrench, it did not. Shorten it (run.window), or "
            'use run.coupling = "staggered".'
        )
    return (
        f"{when}: the motion of the mechanism must be finite, it is not. Shorten the window "
        "(run.window) and look at stiffnesses"
        " and small inertias."
    )


def charge_fault(model: Model, state: State) -> str:
    """Words for the charge's status, and what to do."""
    said = status_text(state.charge, [surface.name for surface in chamber_surfaces(model.case)])
    return (
        f'{said}. The charge substep is {model.clock.substep:.3g} s; try run.dt = "auto" or a '
        "shorter one, stiffer contacts, or, where"
        " so soft a contact is meant, a larger overlap_stop of the pair."
    )
