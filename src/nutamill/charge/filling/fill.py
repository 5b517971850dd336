"""Seeded random placement of particles in a chamber, and settling under gravity.

Stacked layers of a lattice would not move at low speed.  Particles are placed at random in a column from the
floor up, and pushed apart until none overlap (`relax`): a loose random packing that then settles.
"""

import math
from collections.abc import Callable, Sequence

import numpy as np

from nutamill.base.errors import CaseError, StepError
from nutamill.charge.face import Charge
from nutamill.charge.filling.relax import MARGIN, relaxed
from nutamill.charge.filling.room import cylinder_room, fill_faults, is_crowded
from nutamill.charge.model import Clock
from nutamill.charge.particles.particles import LOOSE_PACKING, Particles

COLUMN_PACKING = 0.40
"""Share that the column of a fresh fill has, where the chamber is high enough [1]."""

FEWEST_ENERGIES = 4
"""Fewest energies from which it is foreseen when a charge is at rest [1]."""

SUBSTEPS = 500
"""Substeps of settling after which the charge is observed [1]."""


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

    return relaxed(x, r, push, is_crowded(radii, room))


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
    progress : called with the share of the settling that is done [1], by `time_of_rest`

    Returns
    -------
    time it took [s]

    Raises
    ------
    StepError : an overlap beyond its limit, or a particle that left
    """
    mass = float(charge.state.mass_props[1, : charge.model.n_particles].sum())
    begin = int(charge.state.clock[Clock.STEP])
    elapsed, share = 0.0, 0.0
    times: list[float] = []
    energies_per_mass: list[float] = []
    while elapsed < longest:
        try:
            charge.step(SUBSTEPS)
        except StepError as stop:
            raise StepError(f"settling: {stop}") from stop
        elapsed = (int(charge.state.clock[Clock.STEP]) - begin) * charge.dt
        energies = charge.energies
        times.append(elapsed)
        energies_per_mass.append((energies["translation"] + energies["rotation"]) / mass)
        if progress is not None:
            share = max(share, elapsed / time_of_rest(times, energies_per_mass, still, longest))
            progress(min(share, 1.0))
        if elapsed > 0.02 and energies_per_mass[-1] < still:
            break
    return elapsed


def time_of_rest(times: Sequence[float], energies: Sequence[float], still: float, longest: float) -> float:
    """Return when a settling charge is expected to be at rest [s], at most `longest`.

    Its kinetic energy falls about exponentially once it has fallen down: a line through the logarithm of
    the later half of what came after the peak is drawn on to `still`.

    Parameters
    ----------
    times, energies : times so far [s] and kinetic energies per mass [J/kg]
    still : energy per mass that counts as rest [J/kg]
    longest : when settling is given up [s]
    """
    peak = int(np.argmax(energies))
    first = (peak + len(times)) // 2
    if len(times) - first < FEWEST_ENERGIES:
        return longest
    heights = np.log(np.maximum(energies[first:], 1e-300))
    slope, _ = np.polyfit(times[first:], heights, 1)
    if slope >= 0.0:
        return longest
    return float(np.clip(times[-1] + (math.log(still) - heights[-1]) / slope, times[-1], longest))
