"""Seeded random placement of particles among walls of any kind: inside a meshed chamber, outside of solids
that stand in it.

As `random_fill` does in a cylinder, with the contacts of the engine itself pushing out of the walls.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from nutamill.base.errors import CaseError, Fault
from nutamill.base.kernel import kernel
from nutamill.charge.filling.fill import COLUMN_PACKING
from nutamill.charge.filling.relax import MARGIN, relaxed
from nutamill.charge.filling.room import Room, fill_faults, is_crowded
from nutamill.charge.walls.mesh import on_charge_side
from nutamill.charge.walls.mesh_model import MeshWalls
from nutamill.charge.walls.mesh_patches import mesh_walls
from nutamill.charge.walls.surface import Surface, SurfaceKind
from nutamill.charge.walls.surfaces import place_surfaces
from nutamill.charge.walls.walls import wall_overlap, wall_overlaps

TRIES = 200
"""Draws of places for the particles that do not have one yet [1]."""

STUCK = 0.2
"""Share of its radius by which a particle overlaps a wall that walls cannot push out: one in a gap narrower
than itself [1].
"""

PATIENCE = 100
"""Sweeps after which those are thrown anew [1]."""


class FillWalls(NamedTuple):
    """Surfaces in the axes of the chamber that carries them, named as in `ChargeModel`."""

    surface_kind: np.ndarray
    """`SurfaceKind` [1], int64 (S,)."""
    surface_body: np.ndarray
    """Zero for all [1], int64 (S,)."""
    surface_origin: np.ndarray
    """Origin [m] (S, 3), chamber axes."""
    surface_rotation: np.ndarray
    """From surface axes to chamber axes [1] (S, 3, 3)."""
    surface_size: np.ndarray
    """Sizes [m], angles [rad] (S, 3), by `SurfaceKind`."""
    mesh: MeshWalls
    """Meshed surfaces."""


@kernel
def push_out(walls, surface_poses, r, top, x_out):
    """Move particles `x_out` [m] (n, 3) of radii `r` [m] (n,) out of all walls, and below the height `top`
    [m], and return the deepest overlap [m].
    """
    worst = 0.0
    for i in range(len(r)):
        for s in range(walls.surface_kind.shape[0]):
            overlap, a, b, c = wall_overlap(
                walls.surface_kind[s], walls, surface_poses, s, x_out[i, 0], x_out[i, 1], x_out[i, 2], r[i]
            )
            if overlap > 0.0:
                x_out[i, 0], x_out[i, 1], x_out[i, 2] = (
                    x_out[i, 0] - overlap * a,
                    x_out[i, 1] - overlap * b,
                    x_out[i, 2] - overlap * c,
                )
                worst = max(worst, overlap)
        over = x_out[i, 2] + r[i] - top
        if over > 0.0:
            x_out[i, 2] -= over
            worst = max(worst, over)
    return worst


def fill_between(
    radii: np.ndarray,
    surfaces: Sequence[Surface],
    low: Sequence[float],
    high: Sequence[float],
    room: Room,
    seed: int = 1,
) -> np.ndarray:
    """Return random positions without overlaps among the walls of an upright chamber, from the floor up.

    Parameters
    ----------
    radii : of the particles, or of spheres that hold them [m] (n,)
    surfaces : all walls, carried by the chamber
    low, high : corners of a box that holds the room between them [m] (3,), chamber axes from the point
        `surfaces` are given from
    room : its volume and its walls
    seed : of the random numbers; the same seed gives the same fill

    Returns
    -------
    positions [m] (n, 3), in the axes of `low`

    Raises
    ------
    CaseError : more than a loose bed holds, or particles that cannot be placed
    """
    r = np.asarray(radii, float) * MARGIN
    solid = float((4.0 / 3.0 * np.pi * np.asarray(radii, float) ** 3).sum())
    if faults := fill_faults(radii, room):
        raise CaseError(*faults)
    walls = FillWalls(
        np.array([int(s.kind) for s in surfaces], np.int64),
        np.zeros(len(surfaces), np.int64),
        np.array([s.origin for s in surfaces], float),
        np.array([s.rotation for s in surfaces], float),
        np.array([s.size for s in surfaces], float),
        mesh_walls(surfaces, float(r.max())),
    )
    surface_poses = np.zeros((len(surfaces), 12))
    place_surfaces(walls, np.array([[0.0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1]]), surface_poses)
    share = min(1.0, solid / (COLUMN_PACKING * room.volume) + 4.0 * float(r.max()) / (high[2] - low[2]))
    rng = np.random.default_rng(seed)
    x, top = _scattered(rng, len(r), surfaces, low, high, share)

    before = x.copy()

    def push(x, sweep):
        x[:] = _no_leap(before, x, r)
        # a crowded column grows upwards
        worst = push_out(
            walls, surface_poses, r, min(high[2], top + 0.1 * (high[2] - low[2]) * ((sweep + 1) // 100)), x
        )
        if sweep % PATIENCE == PATIENCE - 1:
            stuck = _deepest(walls, surface_poses, x, r) > STUCK * r
            x[stuck] = _scattered(rng, int(stuck.sum()), surfaces, low, high, share)[0]
        before[:] = x
        return worst

    x = relaxed(x, r, push, is_crowded(radii, room))
    if not in_room(surfaces, x).all():
        raise CaseError(
            Fault(
                "charge",
                "a particle was pushed through a wall while it was placed",
                "Take less charge or another seed",
            )
        )
    return x


def _deepest(walls, surface_poses, x, r) -> np.ndarray:
    """Return the largest overlap [m] (n,) of each particle with any wall."""
    deepest, overlaps = np.zeros(len(r)), np.empty(len(r))
    for s in range(len(surface_poses)):
        wall_overlaps(walls, surface_poses, s, x, r, overlaps)
        np.maximum(deepest, overlaps, out=deepest)
    return deepest


def _no_leap(before, x, r) -> np.ndarray:
    """Return positions from `before` towards `x` [m] (n, 3), by half a radius at most: a centre cannot jump
    over the depth in which a wall detects it.
    """
    step = x - before
    return (
        before + step * np.minimum(1.0, 0.5 * r / np.maximum(np.linalg.norm(step, axis=1), 1e-300))[:, None]
    )


def _scattered(rng, n, surfaces, low, high, share) -> tuple[np.ndarray, float]:
    """Return random points in the lowest `share` of the room, and the height [m] this reaches to."""
    trial = rng.uniform(low, high, (4000, 3))
    heights = np.sort(trial[in_room(surfaces, trial), 2])
    top = float(heights[min(len(heights) - 1, int(share * len(heights)))]) if len(heights) else high[2]
    inside = np.empty((0, 3))
    for _ in range(TRIES):
        drawn = rng.uniform(low, (high[0], high[1], top), (n, 3))
        inside = np.concatenate([inside, drawn[in_room(surfaces, drawn)]])
        if len(inside) >= n:
            return inside[:n], top
    raise CaseError(Fault("charge", "no room among the walls", "Check the position and unit of the meshes"))


def in_room(surfaces: Sequence[Surface], x: np.ndarray) -> np.ndarray:
    """Return whether each of the points `x` [m] (n, 3), chamber axes, is on the charge's side of all walls
    (n,).

    A wall that ends bounds the room at its own heights only: a disc above and below itself, a tube and a cone
    between their ends, a cap below its rim.
    """
    free = np.ones(len(x), bool)
    for surface in surfaces:
        local = (x - np.asarray(surface.origin)) @ np.asarray(surface.rotation, float)
        across, up = np.hypot(local[:, 0], local[:, 1]), local[:, 2]
        a, b, c = surface.size
        if surface.kind == SurfaceKind.PLANE:
            free &= up > 0.0
        elif surface.kind == SurfaceKind.CYLINDER:
            free &= across < a
        elif surface.kind == SurfaceKind.BOX:
            free &= (np.abs(local) > surface.size).any(axis=1)
        elif surface.kind == SurfaceKind.CONE:
            free &= (up < 0.0) | (up >= c) | (across < a + (b - a) * up / c)
        elif surface.kind == SurfaceKind.SPHERE_CAP:
            free &= (up > -a * np.cos(b)) | (np.hypot(across, up) < a)
        elif surface.kind == SurfaceKind.DISC:
            free &= (across > a) | (up > 0.0)
        elif surface.kind == SurfaceKind.TUBE:
            free &= (up < 0.0) | (up >= b) | (across < a)
        elif surface.kind == SurfaceKind.ROD:
            free &= (across > a) | (np.abs(up) > b)
        elif surface.kind == SurfaceKind.BALL:
            free &= np.hypot(across, up) > a
        elif surface.mesh is not None and surface.kind == SurfaceKind.MESH_PATCH and surface.patch == 0:
            free &= on_charge_side(surface.mesh, local)
    return free
