"""What impacts do to particles of one size, by the condition in which earlier impacts have left them.

The condition of a particle is one of `CONDITIONS` classes, from unharmed to nearly broken.  Of an ore by its
drop-weight test it is the energy that its impacts have added up to, of an ore by its fracture energies the
fracture energy that is left.
"""

from typing import NamedTuple

import numpy as np

from nutamill.analysis.breakage import laws
from nutamill.analysis.breakage.ore import PERCENT, DropWeight, Tavares, steepness_of

CONDITIONS = 24
"""Classes of condition of a size [1]."""
LEAST_LOADED, MOST_LOADED = 0.02, 6.0
"""Added energy times weakness in the second and in the last class of an ore by its drop-weight test [1]: one
in 50 particles, and all but one in 400, have broken before.
"""
WEAKEST, STRONGEST = 0.01, 0.999
"""Fracture energy over the median down to which damage is followed [1]; share of the particles that are
weaker than the strongest class.
"""


class Response(NamedTuple):
    """What each impact does, by condition and impact (n_conditions, n_impacts)."""

    broken: np.ndarray
    """Share that breaks [1]."""
    t10: np.ndarray
    """Fineness of what breaks [1]."""
    lost: np.ndarray
    """Share of its stiffness that a particle loses that does not break [1]; 0 where the law has none."""
    moves: np.ndarray
    """Share that passes from a condition to another one [1] (n_conditions, n_conditions, n_impacts)."""


def unharmed(law: DropWeight | Tavares) -> np.ndarray:
    """Return the share of particles in each condition before the first impact [1] (n_conditions,)."""
    if isinstance(law, DropWeight):
        return np.append(1.0, np.zeros(CONDITIONS - 1))
    bounds = fracture_classes(law)
    between = np.sqrt(bounds[1:] * bounds[:-1])
    weaker = np.append(laws.fracture_share(between, 1.0, law.spread, law.largest), 0.0)
    return -np.diff(np.append(1.0, weaker))


def fracture_classes(law: Tavares) -> np.ndarray:
    """Return the fracture energy over the median of each condition [1] (n_conditions,), falling."""
    top = float(laws.fracture_energy_at(STRONGEST, 1.0, law.spread, law.largest))
    return np.geomspace(top, WEAKEST, CONDITIONS)


def response(law: DropWeight | Tavares, size: float, energy: np.ndarray) -> Response:
    """Return what impacts with a specific `energy` [J/kg] (n_impacts,) do to particles of a `size` [m]."""
    if isinstance(law, DropWeight):
        return _of_drop_weight(law, size, energy)
    return _of_fracture_energies(law, size, energy)


def _of_drop_weight(law: DropWeight, size: float, energy: np.ndarray) -> Response:
    """Return `response` of an ore that breaks by the energy that its impacts add up to."""
    weakness = steepness_of(law) * (size / law.size) ** law.size_exponent
    least = law.least_energy * law.size / size
    grid = np.append(0.0, np.geomspace(LEAST_LOADED, MOST_LOADED, CONDITIONS - 1))
    before = grid[:, None]
    added = weakness * np.maximum(energy - least, 0.0)
    broken = np.tile(laws.breakage_probability(energy, least, weakness), (CONDITIONS, 1))
    t10 = laws.fineness_of_impact(law.A / PERCENT, before + added, 0.0, 1.0)
    return Response(broken, t10, np.zeros_like(broken), moves_to(grid, before + added, 1.0 - broken))


def _of_fracture_energies(law: Tavares, size: float, energy: np.ndarray) -> Response:
    """Return `response` of an ore that breaks where the energy reaches what is left of its fracture
    energy.
    """
    bounds = fracture_classes(law)
    median = float(laws.median_fracture_energy(size, law.fracture_energy, law.half_size, law.size_exponent))
    ratio = energy / (bounds[:, None] * median)
    share = laws.fracture_share(energy, median, law.spread, law.largest)
    half = laws.fracture_energy_at(np.maximum(0.5 * share, 1e-12), median, law.spread, law.largest)
    t10 = laws.fineness_of_fracture(law.A / PERCENT, law.steepness, energy, half)
    breaks = ratio >= 1.0
    lost = np.where(breaks, 0.0, laws.damage(np.where(breaks, 0.0, ratio), law.damage_exponent))
    grid = -np.log(bounds)
    after = grid[:, None] - np.log(np.maximum(laws.weakened(1.0, lost), WEAKEST))
    moves = moves_to(grid, after, 1.0 - breaks)
    return Response(breaks.astype(float), np.tile(t10, (CONDITIONS, 1)), lost, moves)


def moves_to(grid: np.ndarray, after: np.ndarray, survive: np.ndarray) -> np.ndarray:
    """Return the moves of surviving particles between conditions, each divided between two of them so that
    the mean is exact.

    Beyond the last condition particles stay in it.

    Parameters
    ----------
    grid : a number of each condition, rising (n_conditions,)
    after : that of particles of each condition after each impact (n_conditions, n_impacts)
    survive : share that survives [1], of the same shape
    """
    n, impacts = after.shape
    after = np.minimum(after, grid[-1])
    first = np.clip(np.searchsorted(grid, after, side="right") - 1, 0, n - 2)
    part = (after - grid[first]) / (grid[first + 1] - grid[first])
    moves = np.zeros((n, n, impacts))
    rows, columns = np.indices(after.shape)
    np.add.at(moves, (rows, first, columns), survive * (1.0 - part))
    np.add.at(moves, (rows, first + 1, columns), survive * part)
    moves[np.arange(n), np.arange(n)] = 0.0
    return moves
