"""The deepest overlap of two particles, which LAMMPS does not watch: looked up between two entries of the
march.
"""

import numpy as np
from scipy.spatial import cKDTree

from nutamill.charge.laws.pair import LawColumn
from nutamill.charge.model import ChargeModel, ChargeState


def deepest_pair(model: ChargeModel, state: ChargeState) -> tuple[float, str]:
    """Return the largest overlap of two particles, share of the smaller diameter [1], and a sentence about
    the pair that exceeds its limit most, or no text.
    """
    n = model.n_particles
    places, radius, material = state.x[:, :n].T, state.mass_props[0, :n], state.material[:n]
    pairs = cKDTree(places).query_pairs(2.0 * float(radius.max()), output_type="ndarray")
    if not len(pairs):
        return 0.0, ""
    i, j = pairs.T
    overlap = radius[i] + radius[j] - np.linalg.norm(places[i] - places[j], axis=1)
    share = overlap / (2.0 * np.minimum(radius[i], radius[j]))
    excess = share * model.laws[model.law_of[material[i], material[j]], LawColumn.LIMIT]
    worst = int(np.argmax(excess))
    text = ""
    if excess[worst] > 1.0:
        a, b = sorted((int(state.ids[i[worst]]), int(state.ids[j[worst]])))
        text = (
            f"particles {a} and {b} overlap by {100 * share[worst]:.1f} % of the diameter, more than the "
            'pair\'s overlap_stop. Try run.dt = "auto" or a shorter one, or stiffer contacts.'
        )
    return max(0.0, float(share.max())), text
