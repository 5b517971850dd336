"""The rates of a population balance: what the impacts of a run do to an ore, per energy that the mill takes
up.

A state is a size and a condition.  Impacts that do not break a particle move it to worse conditions of its
size; fragments are unharmed particles of their sizes.
"""

from typing import NamedTuple

import numpy as np

from nutamill.analysis.breakage import laws
from nutamill.analysis.breakage.balance import Balance, middles, shares_of
from nutamill.analysis.breakage.conditions import CONDITIONS, response, unharmed
from nutamill.analysis.breakage.impacts import Impacts, captured_mass
from nutamill.analysis.breakage.ore import PERCENT, Ore

FINENESSES = 8
"""Values of t10 between 0 and its largest for which fragments are computed [1]."""


class Rates(NamedTuple):
    """A population balance of an ore in a mill."""

    edges: np.ndarray
    """Edges of the classes of size [m] (n_sizes + 1,), falling; finer is a class of its own."""
    balance: Balance
    """Rates between its states."""
    feed: np.ndarray
    """Mass of the feed in the classes, the finest last [1] (n_sizes + 1,)."""
    selection: np.ndarray
    """Rate at which unharmed particles of each size break [kg/J] (n_sizes,)."""


def rates_of(ore: Ore, impacts: Impacts, edges: np.ndarray) -> Rates:
    """Return the rates at which the impacts of a mill break an ore, in classes of size between `edges`
    [m].
    """
    law, sizes = ore.breakage, middles(edges)
    n, fresh = len(sizes), unharmed(law)
    within, births = np.zeros((n, CONDITIONS, CONDITIONS)), np.zeros((n, CONDITIONS, n + 1))
    selection = np.zeros(n)
    t10s = np.linspace(0.0, law.A / PERCENT, FINENESSES + 1)
    seen = impacts.rate > 0.0
    for i, size in enumerate(sizes):
        mass = np.broadcast_to(captured_mass(size, impacts.reduced_radius, ore.density), impacts.rate.shape)
        often, energy = (impacts.rate * mass)[seen], impacts.energy[seen] / mass[seen]
        does = response(law, size, energy)
        flow = does.broken * often
        births[i] = _by_fineness(does.t10 / t10s[1], flow) @ fragments(size, edges, ore.fineness, t10s)
        moved = does.moves @ often
        within[i] = moved.T - np.diag(births[i].sum(1) + moved.sum(1))
        selection[i] = fresh @ flow.sum(1)
    feed = shares_of(np.minimum((edges / ore.top_size) ** ore.feed_exponent, 1.0))
    return Rates(edges, Balance(within, births, fresh), feed, selection)


def _by_fineness(place: np.ndarray, flow: np.ndarray) -> np.ndarray:
    """Return the flow of broken mass by the fineness of its fragments, (n_conditions, FINENESSES + 1), each
    divided between the two nearest values of t10.

    Parameters
    ----------
    place : t10 over the step between two values [1] (n_conditions, n_impacts)
    flow : broken mass, of the same shape
    """
    place = np.clip(place, 0.0, FINENESSES)
    below = np.minimum(np.floor(place).astype(int), FINENESSES - 1)
    rows = np.indices(place.shape)[0]
    sums = np.zeros((len(place), FINENESSES + 1))
    np.add.at(sums, (rows, below), flow * (1.0 - (place - below)))
    np.add.at(sums, (rows, below + 1), flow * (place - below))
    return sums


def fragments(size: float, edges: np.ndarray, exponent: float, t10: np.ndarray) -> np.ndarray:
    """Return the mass of the fragments of a `size` [m] in each class, (n_t10, n_sizes + 1), for each t10 [1].

    `exponent` is that of `laws.finer_share`.
    """
    finer = laws.finer_share(t10[:, None], size / edges[None, :], exponent)
    return np.array([shares_of(passing) for passing in finer])
