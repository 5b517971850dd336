"""Seeded random placement of particles in a chamber, and settling under gravity.

Stacked layers of a lattice would not move at low speed.  Particles are placed at random
in a column from the floor up, and pushed apart until none overlap (Jodrey and Tory's relaxation): a loose
random packing that then settles.

Source: W. S. Jodrey and E. M. Tory, "Computer simulation of close random packing of equal spheres", Phys.
Rev. A 32 (1985).
"""

import math
from collections.abc import Callable, Sequence

import numpy as np
from scipy.spatial import cKDTree

from nutamill.base.errors import CaseError, Fault, StepError
from nutamill.charge.face import Charge
from nutamill.charge.filling.room import cylinder_room, fill_faults
from nutamill.charge.model import Clock
from nutamill.charge.particles.particles import LOOSE_PACKING, Particles

COLUMN_PACKING = 0.40
"""Share that the column of a fresh fill has, where the chamber is high enough [1]."""

SWEEPS = 3000
"""Sweeps of the relaxation before it goes on with momentum, and then before a fill is given up [1]."""

STEP, MOMENTUM_STEP, MOMENTUM = 0.55, 0.3, 0.9
"""Share of an overlap by which each of two particles is pushed in a sweep, without and with momentum, and the
share of a particle's last move that it repeats with momentum [1]: a crowded fill is relaxed in a tenth of the
sweeps.
"""

SUBSTEPS = 500
"""Substeps of settling after which the charge is observed [1]."""

MARGIN = 1.002
"""Particles are relaxed this much too large, so that they end without touching [1]."""


def _way_out(x, local, r, rotation, half, radius, floor, ceiling):
    """Return unit vector and distance [m] by which a centre inside a box leaves it: the nearest face that
    does not lead into a wall.
    """
    ways = []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            away = np.zeros(3)
            away[axis] = sign
            step = half[axis] - sign * local[axis] + r
            end = x + rotation @ (away * step)
            blocked = (
                math.hypot(end[0], end[1]) + r > radius * (1.0 + 1e-9)
                or end[2] - r < floor
                or end[2] + r > ceiling
            )
            ways.append((blocked, step, 2 * axis + (sign > 0.0), away))
    _, step, _, away = min(ways)
    return away, step


def _push_from_walls(x, r, radius, floor, ceiling, boxes) -> float:
    """Move particles that overlap a wall to its surface, and return the deepest overlap [m]."""
    out = np.hypot(x[:, 0], x[:, 1])
    deep = np.maximum(out + r - radius, 0.0)
    x[:, :2] -= x[:, :2] * (deep / np.maximum(out, 1e-300))[:, None]
    low, high = np.maximum(floor + r - x[:, 2], 0.0), np.maximum(x[:, 2] + r - ceiling, 0.0)
    x[:, 2] += low - high
    worst = max(float(deep.max()), float(low.max()), float(high.max()))
    for centre, rotation, half in boxes:
        local = (x - centre) @ rotation
        nearest = np.clip(local, -half, half)
        gap = np.linalg.norm(local - nearest, axis=1)
        for i in np.flatnonzero(gap < r):
            away = local[i] - nearest[i]
            if gap[i] == 0.0:
                away, step = _way_out(x[i], local[i], r[i], rotation, half, radius, floor, ceiling)
            else:
                away /= gap[i]
                step = r[i] - gap[i]
            x[i] += rotation @ (away * step)
            worst = max(worst, step)
    return worst


def size_octaves(radii: np.ndarray) -> list[tuple[np.ndarray, float]]:
    """Return the particles sorted by size into classes of a factor of two: ids [1] and largest radius [m] of
    each class.
    """
    number = np.floor(np.log2(radii / radii.min()) + 1e-9).astype(int)
    return [
        (ids, float(radii[ids].max())) for k in np.unique(number) if len(ids := np.flatnonzero(number == k))
    ]


def near_pairs(x: np.ndarray, octaves: list[tuple[np.ndarray, float]]) -> tuple[np.ndarray, np.ndarray]:
    """Return the ids (i, j) of all pairs that may overlap, and of few others.

    Classes of like size are searched one against the other, so that a few large particles do not make every
    pair of small ones near.

    Parameters
    ----------
    x : centres [m] (n, 3)
    octaves : by `size_octaves`
    """
    trees = [cKDTree(x[ids]) for ids, _ in octaves]
    first, second = [], []
    for a, (ids, r) in enumerate(octaves):
        pairs = trees[a].query_pairs(2.0 * r, output_type="ndarray")
        first.append(ids[pairs[:, 0]])
        second.append(ids[pairs[:, 1]])
        for b in range(a):
            near = trees[a].sparse_distance_matrix(trees[b], r + octaves[b][1], output_type="ndarray")
            first.append(ids[near["i"]])
            second.append(octaves[b][0][near["j"]])
    return np.concatenate(first), np.concatenate(second)


def random_attitudes(number: int, seed: int = 1) -> np.ndarray:
    """Return uniformly distributed random attitudes as quaternions (number, 4).

    Source: K. Shoemake, "Uniform random rotations", Graphics Gems III (1992): directions in four dimensions.
    """
    four = np.random.default_rng([seed, 1]).normal(size=(number, 4))
    return four / np.linalg.norm(four, axis=1)[:, None]


def fill_cylinder(
    particles: Particles, radius: float, floor: float, ceiling: float, boxes: Sequence = (), seed: int = 1
) -> Particles:
    """Return the particles, placed by `random_fill` so that their bounding spheres do not overlap, clumps in
    random attitudes.

    Parameters
    ----------
    radius, floor, ceiling, boxes, seed : as `random_fill`

    Raises
    ------
    CaseError : more than a loose bed of bounding spheres holds, or particles that cannot be placed
    """
    centres = random_fill(particles.bounding_radius, radius, floor, ceiling, boxes, seed)
    return particles.placed(
        centres, None if particles.spheres_only else random_attitudes(particles.number, seed)
    )


def random_fill(
    radii: np.ndarray, radius: float, floor: float, ceiling: float, boxes: Sequence = (), seed: int = 1
) -> np.ndarray:  # fmt: skip
    """Return random positions without overlaps in an upright cylinder, a loose column from the floor up.

    Parameters
    ----------
    radii : of the particles, or of spheres that hold them [m] (n,); any sizes
    radius, floor, ceiling : of the cylinder about z, and heights of its ends [m], chamber axes
    boxes : (centre [m] (3,), rotation to chamber axes (3, 3), half sizes [m] (3,)) of what stands in it
    seed : of the random numbers; the same seed gives the same fill

    Returns
    -------
    positions [m] (n, 3), chamber axes

    Raises
    ------
    CaseError : more than a loose bed holds, or particles that cannot be placed
    """
    r = np.asarray(radii, float) * MARGIN
    boxes = [(np.asarray(c, float), np.asarray(q, float), np.asarray(h, float)) for c, q, h in boxes]
    solid = float((4.0 / 3.0 * math.pi * np.asarray(radii, float) ** 3).sum())
    room = cylinder_room(radius, floor, ceiling, boxes)
    if faults := fill_faults(radii, room):
        raise CaseError(*faults)
    capacity = LOOSE_PACKING * room.volume
    rng = np.random.default_rng(seed)
    height = (ceiling - floor) * min(
        1.0, solid / capacity * LOOSE_PACKING / COLUMN_PACKING + 4.0 * r.max() / (ceiling - floor)
    )
    n = len(r)
    angle, out = rng.uniform(0.0, 2.0 * math.pi, n), (radius - r) * np.sqrt(rng.random(n))
    x = np.column_stack(
        [
            out * np.cos(angle),
            out * np.sin(angle),
            floor + r + rng.random(n) * np.maximum(height - 2.0 * r, 0.0),
        ]
    )
    top = floor + height

    def push(x, sweep):
        # a crowded column grows upwards
        grown = min(ceiling, top + 0.1 * (ceiling - floor) * ((sweep + 1) // 100))
        return _push_from_walls(x, r, radius, floor, grown, boxes)

    return relaxed(x, r, push, crowded=solid > capacity)


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
    crowded : whether particles have momentum from the first sweep on, and not only where `SWEEPS` did not
        suffice

    Raises
    ------
    CaseError : particles that cannot be placed
    """
    n, octaves = len(r), size_octaves(r)
    moved = np.zeros_like(x)
    for sweep in range(2 * SWEEPS):
        momentum, step = (MOMENTUM, MOMENTUM_STEP) if crowded or sweep >= SWEEPS else (0.0, STEP)
        before = x.copy()
        i, j = near_pairs(x, octaves)
        gap = x[j] - x[i]
        distance = np.linalg.norm(gap, axis=1)
        overlap = r[i] + r[j] - distance
        near = overlap > 0.0
        i, j, gap, distance, overlap = i[near], j[near], gap[near], distance[near], overlap[near]
        worst = float((overlap / np.minimum(r[i], r[j])).max()) if len(i) else 0.0
        shift = gap * (step * overlap / np.maximum(distance, 1e-300))[:, None]
        for k in range(3):
            x[:, k] += np.bincount(j, shift[:, k], n) - np.bincount(i, shift[:, k], n)
        if momentum:
            x += momentum * moved
        wall = push(x, sweep)
        moved = x - before
        if worst < 2.0 * (1.0 - 1.0 / MARGIN) and wall < (MARGIN - 1.0) * r.min():
            return x
    raise CaseError(
        Fault(
            "charge",
            f"no random packing after {2 * SWEEPS} sweeps",
            "Take less charge or a larger chamber",
        )
    )


def settle(
    charge: Charge,
    longest: float = 1.0,
    still: float = 1e-9,
    progress: Callable[[float], None] | None = None,
) -> float:
    """March a charge among walls at rest until it is at rest too.

    Parameters
    ----------
    longest : give up after this time [s]
    still : kinetic energy per mass [J/kg] that counts as rest; 1e-9 is a mean speed of 0.04 mm/s
    progress : called with the share of `longest` that has passed [1]

    Returns
    -------
    time it took [s]

    Raises
    ------
    StepError : an overlap beyond its limit, or a particle that left
    """
    mass = float(charge.state.mass_props[1, : charge.model.n_particles].sum())
    begin = int(charge.state.clock[Clock.STEP])
    elapsed = 0.0
    while elapsed < longest:
        try:
            charge.step(SUBSTEPS)
        except StepError as stop:
            raise StepError(f"settling: {stop}") from stop
        elapsed = (int(charge.state.clock[Clock.STEP]) - begin) * charge.dt
        if progress is not None:
            progress(elapsed / longest)
        energies = charge.energies
        if elapsed > 0.02 and energies["translation"] + energies["rotation"] < still * mass:
            break
    return elapsed
