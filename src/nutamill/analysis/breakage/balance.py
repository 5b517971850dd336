"""The population balance of a batch: how mass passes from coarse to fine while energy is put in.

Mass passes only from coarse to fine.  Within a size, particles are in conditions that impacts make worse; new
particles begin with a share in each.
"""

import math
from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_triangular

RATIO = 2.0**0.25
"""Upper over lower edge of a class of sizes [1]: the fourth root of two, as in a series of sieves."""
NODES = 32
"""Points on the contour of the inverse Laplace transform [1]; half are used, the others are conjugates."""


def size_edges(top: float, bottom: float) -> np.ndarray:
    """Return the edges of the classes [m], falling from `top` [m] by `RATIO` to `bottom` or less.

    All that is finer than the last is one class more.
    """
    count = max(1, math.ceil(math.log(top / bottom) / math.log(RATIO) - 1e-9))
    return top * RATIO ** -np.arange(count + 1.0)


def middles(edges: np.ndarray) -> np.ndarray:
    """Return the geometric middles of the classes between `edges` [m] (n,), without the finest."""
    return np.sqrt(edges[1:] * edges[:-1])


def shares_of(passing: np.ndarray) -> np.ndarray:
    """Return the mass in each class, the finest last (n + 1,), from the share that is finer than each edge
    (n + 1,), the first 1.
    """
    return np.append(-np.diff(passing), passing[-1])


class Balance(NamedTuple):
    """Rates of a population of n sizes, from coarse to fine, in k conditions each; all finer is one class
    more, which stays as it is.

    Mass is conserved where the rates of every state sum to zero.
    """

    within: np.ndarray
    """Rates from each condition to each other of a size, losses on the diagonal [kg/J] (n, k to, k from)."""
    births: np.ndarray
    """Rates at which each state makes new particles of each size, none coarser than itself [kg/J] (n, k,
    n + 1).
    """
    fresh: np.ndarray
    """Share of new particles in each condition [1] (k,)."""


def grind(balance: Balance, feed: np.ndarray, energies: np.ndarray) -> np.ndarray:
    """Return the mass of every size after each specific energy, (n_energies, n + 1): the solution of ``dw/dE
    = M w``.

    The Laplace transform of a size is that of its births times a function of its own rates, so that sizes
    follow one another from coarse to fine.

    Parameters
    ----------
    feed : mass of every size at the start, of new particles, the finest last [1] (n + 1,)
    energies : positive specific energies [J/kg] (n_energies,)

    Source
    ------
    L. N. Trefethen, J. A. C. Weideman and T. Schmelzer, BIT 46 (2006) 653-670: the inverse Laplace transform
    by the midpoint rule on Talbot's contour; all poles are on the negative axis
    """
    angle = math.pi * (2.0 * np.arange(NODES // 2) + 1.0) / NODES
    place = NODES * (0.5017 * angle / np.tan(0.6407 * angle) - 0.6122 + 0.2645j * angle)
    slope = NODES * (
        0.5017 / np.tan(0.6407 * angle) - 0.5017 * 0.6407 * angle / np.sin(0.6407 * angle) ** 2 + 0.2645j
    )
    weight = 2.0 / NODES * np.exp(place) * slope / 1j
    masses = np.zeros((len(energies), len(feed)))
    for k, energy in enumerate(energies):
        for z, part in zip(place / energy, weight / energy, strict=True):
            masses[k] += (part * _transform(balance, feed, z)).real
    return masses


def _transform(balance: Balance, feed: np.ndarray, z: complex) -> np.ndarray:
    """Return the Laplace transform of the mass of every size at `z` [kg/J], (n + 1,)."""
    n, k, _ = balance.within.shape
    own = balance.births[np.arange(n), :, np.arange(n)]
    left = z * np.eye(k) - balance.within - balance.fresh[:, None] * own[:, None, :]
    state = np.linalg.solve(left, np.broadcast_to(balance.fresh[:, None], (n, k, 1)).astype(complex))[..., 0]
    passes = np.zeros((n + 1, n + 1), complex)
    passes[:, :n] = -np.einsum("ik,ikj->ji", state, balance.births)
    passes[np.arange(n + 1), np.arange(n + 1)] = 1.0
    born = solve_triangular(passes, feed, lower=True, unit_diagonal=True, check_finite=False)
    return born * np.append(state.sum(axis=1), 1.0 / z)


def passing_of(masses: np.ndarray) -> np.ndarray:
    """Return the share that is finer than each edge, (..., n + 1), from the mass in each class, the finest
    last.
    """
    return np.flip(np.cumsum(np.flip(masses, -1), -1), -1)


def percentile(edges: np.ndarray, passing: np.ndarray, share: float = 0.8) -> float:
    """Return the size [m] than which a `share` is finer, on straight lines between the logarithms of sizes
    and shares. The finest edge where less is coarser.
    """
    if passing[-1] >= share:
        return float(edges[-1])
    rising, sizes = np.maximum(passing[::-1], 1e-300), edges[::-1]
    return float(np.exp(np.interp(math.log(share), np.log(rising), np.log(sizes))))
