"""Push particles apart until none overlap.

Where there is room, each sweep pushes both particles of an overlap apart (Jodrey and Tory's relaxation).  In
a crowd these pushes cancel, and the last overlaps take thousands of sweeps: there, particles have inertia and
speed up as long as they go downhill (FIRE), and near pairs are searched only after particles have moved.

Sources: W. S. Jodrey and E. M. Tory, "Computer simulation of close random packing of equal spheres", Phys.
Rev. A 32 (1985); E. Bitzek, P. Koskinen, F. Gaehler, M. Moseler and P. Gumbsch, "Structural relaxation made
simple", Phys. Rev. Lett. 97, 170201 (2006).
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from nutamill.base.errors import CaseError, Fault

MARGIN = 1.002
"""Particles are relaxed this much too large, so that they end without touching [1]."""

STEP = 0.55
"""Share of an overlap by which each of two particles is pushed in a sweep without inertia [1]."""

SWEEPS, INERTIAL_SWEEPS = 3000, 6000
"""Sweeps without inertia before it goes on with inertia, and with inertia before a fill is given up [1]."""

SKIN = 0.6
"""Gap up to which pairs are listed, in radii of the smallest particle: no other pair can overlap before a
particle has moved by half of it [1].
"""

LONGEST_STEP, FASTER, SLOWER, SLOW_AFTER = 0.7, 1.1, 0.5, 5
"""Largest time step, for particles of mean size whose overlap of a metre accelerates them by 1 m/s^2 [s]; its
factors downhill and uphill [1]; steps downhill before it grows [1].
"""

STEER, STEER_DECAY = 0.1, 0.99
"""Share of the velocity that is turned into the direction of the pushes, and its factor downhill [1]."""


class Overlaps(NamedTuple):
    """The overlaps of a fill."""

    worst: float
    """Deepest overlap over the smaller radius [1]."""
    pushes: np.ndarray
    """Sum of the overlaps of each particle, each in the direction that ends it [m] (n, 3)."""


def relaxed(
    x: np.ndarray, r: np.ndarray, push: Callable[[np.ndarray, int], float], crowded: bool = False
) -> np.ndarray:  # fmt: skip
    """Return positions without overlaps, by pushing particles apart until none overlap.

    Parameters
    ----------
    x : positions to begin with [m] (n, 3), moved in place
    r : radii, `MARGIN` too large [m] (n,)
    push : moves particles out of the walls in place, given the number of the sweep; returns the deepest
        overlap [m]
    crowded : whether particles have inertia from the first sweep on, and not only where `SWEEPS` did not
        suffice

    Raises
    ------
    CaseError : particles that cannot be placed
    """
    first = 0 if crowded else SWEEPS
    if (not crowded and _relaxed(x, r, push)) or _relaxed_with_inertia(x, r, push, first):
        return x
    what = f"no random packing after {first + INERTIAL_SWEEPS} sweeps"
    raise CaseError(Fault("charge", what, "Take less charge or a larger chamber"))


def _relaxed(x, r, push) -> bool:
    """Return whether particles that are pushed apart in place no longer overlap within `SWEEPS`."""
    octaves = size_octaves(r)
    for sweep in range(SWEEPS):
        worst, pushes = overlaps(x, r, *near_pairs(x, octaves), STEP)
        x += pushes
        wall = push(x, sweep)
        if _apart(worst, wall, r):
            return True
    return False


def _relaxed_with_inertia(x, r, push, first: int) -> bool:
    """Return whether particles that their overlaps accelerate, in place, no longer overlap in the end.

    The first sweep has the number `first`.  The mass of a particle is as its surface, for so is the number of
    its contacts.
    """
    octaves, skin = size_octaves(r), SKIN * r.min()
    share = ((r.mean() / r) ** 2)[:, None]
    velocity, listed, wall = np.zeros_like(x), None, np.inf
    step, steer, downhill = LONGEST_STEP, STEER, 0
    for sweep in range(first, first + INERTIAL_SWEEPS):
        if listed is None or ((x - listed) ** 2).sum(axis=1).max() > (0.5 * skin) ** 2:
            pairs, listed = near_pairs(x, octaves, skin), x.copy()
        worst, pushes = overlaps(x, r, *pairs)
        if _apart(worst, wall, r):
            return True
        if (pushes * velocity).sum() > 0.0:
            downhill += 1
            if downhill > SLOW_AFTER:
                step, steer = min(FASTER * step, LONGEST_STEP), STEER_DECAY * steer
        else:
            velocity[:] = 0.0
            step, steer, downhill = SLOWER * step, STEER, 0
        acceleration = share * pushes
        velocity += step * acceleration
        # not the norm of a whole array: its bits depend on the number of threads
        turned = np.sqrt((velocity**2).sum() / max((acceleration**2).sum(), 1e-300))
        velocity += steer * (turned * acceleration - velocity)
        before = x.copy()
        x += step * velocity
        wall = push(x, sweep)
        velocity = (x - before) / step
        velocity[(np.abs(x - before) > r[:, None]).any(axis=1)] = 0.0  # of one that was thrown anew
    return False


def _apart(worst: float, wall: float, r: np.ndarray) -> bool:
    """Return whether overlaps of particles [1] and with walls [m] are within the margin."""
    return worst < 2.0 * (1.0 - 1.0 / MARGIN) and wall < (MARGIN - 1.0) * r.min()


def overlaps(x: np.ndarray, r: np.ndarray, i: np.ndarray, j: np.ndarray, share: float = 1.0) -> Overlaps:
    """Return the overlaps among pairs (i, j) of particles of radii `r` at `x`, pushes times `share`."""
    n = len(r)
    gap = x[j] - x[i]
    distance = np.linalg.norm(gap, axis=1)
    overlap = r[i] + r[j] - distance
    near = overlap > 0.0
    i, j, gap, distance, overlap = i[near], j[near], gap[near], distance[near], overlap[near]
    worst = float((overlap / np.minimum(r[i], r[j])).max()) if len(i) else 0.0
    shift = gap * (share * overlap / np.maximum(distance, 1e-300))[:, None]
    pushes = np.empty((n, 3))
    for k in range(3):
        pushes[:, k] = np.bincount(j, shift[:, k], n) - np.bincount(i, shift[:, k], n)
    return Overlaps(worst, pushes)


def size_octaves(radii: np.ndarray) -> list[tuple[np.ndarray, float]]:
    """Return the particles sorted by size into classes of a factor of two: ids [1] and largest radius [m] of
    each class.
    """
    number = np.floor(np.log2(radii / radii.min()) + 1e-9).astype(int)
    return [
        (ids, float(radii[ids].max())) for k in np.unique(number) if len(ids := np.flatnonzero(number == k))
    ]


def near_pairs(
    x: np.ndarray, octaves: list[tuple[np.ndarray, float]], skin: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """Return the ids (i, j) of all pairs that may overlap or are nearer than `skin` [m], and of few others.

    Classes of like size are searched one against the other, so that a few large particles do not make every
    pair of small ones near.

    Parameters
    ----------
    x : centres [m] (n, 3)
    octaves : by `size_octaves`
    skin : gap between particles up to which a pair is near [m]
    """
    trees = [cKDTree(x[ids]) for ids, _ in octaves]
    first, second = [], []
    for a, (ids, r) in enumerate(octaves):
        pairs = trees[a].query_pairs(2.0 * r + skin, output_type="ndarray")
        first.append(ids[pairs[:, 0]])
        second.append(ids[pairs[:, 1]])
        for b in range(a):
            near = trees[a].sparse_distance_matrix(trees[b], r + octaves[b][1] + skin, output_type="ndarray")
            first.append(ids[near["i"]])
            second.append(octaves[b][0][near["j"]])
    return np.concatenate(first), np.concatenate(second)
