"""The carriers of a charge as its push moves them: contacts, particles and stiffness of each."""

from collections.abc import Sequence

import numpy as np

from nutamill.base.light_carriers import PushedCarrier
from nutamill.charge.laws.composition import normal_energy
from nutamill.charge.laws.pair import NORMAL_NUMBERS
from nutamill.charge.model import ChargeModel, ChargeState, Clock, stamp_of


def pushed_carriers(model: ChargeModel, state: ChargeState, masses: Sequence[float]) -> list[PushedCarrier]:
    """Return the carriers that have walls and give way, as they are touched at present.

    Parameters
    ----------
    masses : least effective mass of each carrier at its walls [kg] (n_carriers,); infinite where its motion
        is given

    Returns
    -------
    carriers; the stiffness is that of the largest particle at the largest overlap so far (hysteretic: of
    loading), and a carrier that nothing touches counts with one contact
    """
    n, surfaces = model.n_particles, len(model.surface_kind)
    radius, heaviest = model.largest_radius, float(state.mass_props[1, :n].max())
    overlap = 2.0 * radius * float(state.largest_overlap[1])
    last = stamp_of(int(state.clock[Clock.STEP]) - 1)
    touching = np.abs(state.wall_memory[: n * surfaces, 6].reshape(n, surfaces)) == last
    carriers = []
    for body in np.unique(model.surface_body):
        if not np.isfinite(masses[body]):
            continue
        walls = np.flatnonzero(model.surface_body == body)
        rows = np.unique(model.law_of[np.unique(state.material[:n])][:, model.surface_material[walls]])
        stiffness = [
            normal_energy(
                model.law.normal,
                tuple(model.laws[row, :NORMAL_NUMBERS].astype(float)),
                overlap,
                0.0,
                radius,
                (2.0 * radius, 2.0 * radius),
            )[1]
            for row in rows[rows >= 0]
        ]
        contacts = max(1, int(touching[:, walls].sum()))
        name = f"carrier {body}"
        carriers.append(PushedCarrier(name, float(masses[body]), heaviest, float(max(stiffness)), contacts))
    return carriers
