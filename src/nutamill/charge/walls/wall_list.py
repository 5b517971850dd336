"""The wall list as arrays: which patches of meshes are near each particle."""

from typing import NamedTuple

import numpy as np

from nutamill.charge.walls.mesh_model import rows_on_lines

MOST_NEAR = 6
"""Patches that are listed for a particle [1]; where there are more, it tests all of them in every substep."""

HELD = 8
"""Numbers of `NearMeshes.held` [1], a line of the cache."""

NEVER = 1e30
"""A coordinate at which nothing has been listed [m]."""


class NearMeshes(NamedTuple):
    """Patches near each particle, and the contacts of a chunk with them.

    ``D`` is the number of bodies that carry meshes, ``K`` is `MOST_NEAR`.
    """

    bodies: np.ndarray
    """Bodies that carry meshes [1], int64 (D,)."""
    at: np.ndarray
    """Place where `clear` holds [m] (D, 3, M), body axes."""
    clear: np.ndarray
    """A distance that all patches have at least from there [m] (D, M)."""
    listed_at: np.ndarray
    """Place where the patches were listed [m] (D, M, 3), body axes."""
    limit: np.ndarray
    """A distance that all patches which are not listed have at least from there [m] (D, M)."""
    listed: np.ndarray
    """Number of listed patches [1], int32 (D, M); -1 where there are too many."""
    surface: np.ndarray
    """Surface of each listed patch [1], int32 (D, M, K)."""
    face: np.ndarray
    """Triangle the next search begins at [1], int32 (D, M, K)."""
    tested: np.ndarray
    """Place of the last test [m] (3), body axes, and distance the patch had there at least [m] (D, M, K,
    4).
    """
    decider: np.ndarray
    """Where one patch alone was near at the last test, its surface, else -1; and the triangle that `held` is
    of, -1 at first [1].  int32 (D, M, 2).
    """
    held: np.ndarray
    """Plane of that triangle as in `MeshFaces.rows`, normal [1] (3) and height over the origin [m], surface
    axes; place of the particle at the test [m] (3), body axes; square of what it may move from there while
    the triangle decides alone, if it touches [m^2].  (D, M, 8).
    """
    place: np.ndarray
    """Of each thread: places of the chunk's particles [m] (T, 3, chunk), body axes."""
    due: np.ndarray
    """Of each thread and particle of the chunk: positive where a patch may touch it [m^2] (T, chunk)."""
    head: np.ndarray
    """Of each thread and surface: its first contact in `contact`, or -1 [1], int32 (T, S)."""
    link: np.ndarray
    """Of each thread and contact: the next one with the same surface, or -1, and the position in the chunk of
    its particle [1], int32 (T, 2, contacts).
    """
    contact: np.ndarray
    """Of each thread: normal [1] (3), world axes, and overlap [m] of each contact (T, contacts, 4)."""


def near_meshes(model, slots: int, threads: int) -> NearMeshes:
    """Return an empty wall list.

    Parameters
    ----------
    model : of the charge
    slots : number of slots
    threads : size of the largest team
    """
    bodies = np.unique(model.mesh.places.body)
    d, k = len(bodies), MOST_NEAR
    meshed = int((model.mesh.patch_of >= 0).sum())
    contacts = meshed * model.chunk
    return NearMeshes(
        bodies=bodies,
        at=np.full((d, 3, slots), NEVER),
        clear=np.zeros((d, slots)),
        listed_at=np.full((d, slots, 3), NEVER),
        limit=np.zeros((d, slots)),
        listed=np.zeros((d, slots), np.int32),
        surface=np.zeros((d, slots, k), np.int32),
        face=np.zeros((d, slots, k), np.int32),
        tested=np.full((d, slots, k, 4), NEVER),
        decider=np.full((d, slots, 2), -1, np.int32),
        held=rows_on_lines(d * slots, HELD).reshape(d, slots, HELD),
        place=np.zeros((threads, 3, model.chunk)),
        due=np.zeros((threads, model.chunk)),
        head=np.full((threads, len(model.surface_kind)), -1, np.int32),
        link=np.zeros((threads, 2, contacts), np.int32),
        contact=np.zeros((threads, contacts, 4)),
    )
