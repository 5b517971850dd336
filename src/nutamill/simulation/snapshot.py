"""What a run records of its state beside the series: snapshots and the statistics of the charge."""

import numpy as np

from nutamill.base.frames import rotation_matrix_of
from nutamill.charge.measures.totals import gathered
from nutamill.charge.readout import attitudes, contact_forces, positions, spins, velocities
from nutamill.simulation.setup.model import Model, State
from nutamill.simulation.setup.particles import charge_particles
from nutamill.simulation.setup.statistics import recorded_sums


def snapshot(model: Model, state: State) -> dict[str, np.ndarray]:
    """Return the arrays of a snapshot of the present state (`nutamill.result.fields.SNAPSHOT`)."""
    arrays = {
        "body_positions": state.mechanism.position[:-1],
        "body_attitudes": state.mechanism.quaternion[:-1],
    }
    charge, moving, survey = model.charge, state.charge, model.survey
    if charge is None or moving is None or survey is None:
        return arrays
    substep, particles = model.clock.substep, charge_particles(model.machine)
    arrays["positions"] = positions(charge, moving, substep).astype(np.float32)
    arrays["velocities"] = velocities(charge, moving).astype(np.float32)
    clump_attitudes = attitudes(charge, moving)
    if clump_attitudes is not None:
        arrays["attitudes"] = clump_attitudes.astype(np.float32)
    arrays["spins"] = spins(charge, moving).astype(np.float32)
    arrays["radii"] = (0.5 * particles.diameter).astype(np.float32)
    forces = contact_forces(charge, moving, substep)
    if forces is not None:
        arrays["contact_forces"] = forces.astype(np.float32)
    arrays["materials"] = particles.material.astype(np.int16)
    body = model.plan.carriers[survey.body]
    rotation = rotation_matrix_of(state.mechanism.quaternion[body])
    arrays["chamber_floor"] = state.mechanism.position[body] + rotation @ survey.origin
    arrays["chamber_attitude"] = state.mechanism.quaternion[body]
    return arrays


def statistics(model: Model, state: State) -> dict[str, np.ndarray] | None:
    """Return the statistics of the charge so far, in SI (`nutamill.result.fields.STATISTICS`), or None if
    there are none.
    """
    charge, moving, survey = model.charge, state.charge, model.survey
    if charge is None or moving is None or survey is None or state.statistics is None or not survey.on:
        return None
    sums = gathered(state.statistics, moving.impacts)
    return recorded_sums(model.machine, survey, charge.per_cut, sums)
