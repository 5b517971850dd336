"""The state of a charge as the few arrays of a checkpoint, and back, bit for bit.

A checkpoint holds what moves and what touches.  Sizes, masses and materials follow from the case, and the
neighbour lists from the positions at which they were made (`nutamill.charge.kernels.neighbours.make_lists`).
Arrays are in the order of the slots, since sums and lists depend on it.
"""

from collections.abc import Mapping

import numpy as np

from nutamill.charge.arrays import grow
from nutamill.charge.kernels.chunks import cut_chunks
from nutamill.charge.kernels.clumps import CLUMP, OFFSET, POSE, ClumpColumn
from nutamill.charge.kernels.neighbours import make_lists
from nutamill.charge.model import ChargeModel, ChargeScratch, ChargeState, Clock, stamp_of
from nutamill.charge.pebbles import rotation_matrices
from nutamill.charge.readout import clump_spins

WHOLE = (
    "list_angle",
    "last_dt",
    "poses",
    "impulse",
    "ledger",
    "largest_overlap",
    "halt_speeds",
    "status",
    "clock",
)
"""Arrays of the state that a checkpoint holds as they are: none grows with the number of particles."""

MOVING = [
    *range(int(ClumpColumn.CENTRE), int(ClumpColumn.MASS)),
    int(ClumpColumn.SPIN_ENERGY),
    *range(int(ClumpColumn.AT_VELOCITY), int(ClumpColumn.AT_VELOCITY) + 4),
]
"""Columns of a clump that change from substep to substep."""

CENTRE_AND_ATTITUDE = [MOVING.index(column) for column in POSE]
"""Places of the pose among them."""

STAMP = 6
"""Place of the stamp in the memory of a contact."""


def saved_arrays(model: ChargeModel, state: ChargeState) -> dict[str, np.ndarray]:
    """Return the arrays from which `put_back` makes this state again.

    Impacts are left out: `nutamill.charge.measures.totals.gathered` sums them over the threads.
    """
    n, spheres = model.n_particles, len(state.clumps) == 0
    current = state.clock[Clock.PUBLISHED]
    rows = state.published_rows[current, :n]
    arrays = {name: getattr(state, name).copy() for name in WHOLE}
    arrays["clock"][Clock.CROWDED] = 0  # about the room in the lists, which are made anew
    arrays["ids"] = state.ids[:n].astype(np.int32)
    arrays["x"] = state.x[:, :n]
    arrays["seen_velocity"] = rows[:, 0:3]
    if spheres:
        arrays |= {"v": state.v[:, :n], "w": state.w[:, :n], "seen_spin": rows[:, 4:7]}
    else:
        arrays["clumps"] = state.clumps[:, MOVING]
        arrays["clump_ids"] = state.clumps[:, ClumpColumn.ID].astype(np.int32)
        arrays["seen_spin"] = rows[_first_pebbles(state.mass_props[CLUMP, :n]), 4:7]
    # how a position is rounded depends on the instructions of the machine: in one of 10^7 it differs
    arrays["rounding"] = state.published_points[current, :n] - _points(model, state)
    if state.clock[Clock.LISTED]:
        arrays["listed_x"] = state.listed_x[:, :n]
        arrays |= _pair_contacts(state)
    return arrays | _wall_contacts(model, state)


def put_back(
    model: ChargeModel,
    state: ChargeState,
    scratch: ChargeScratch,
    saved: Mapping[str, np.ndarray],
    reference: np.ndarray,
) -> tuple[ChargeModel, ChargeState, ChargeScratch]:
    """Return the charge in the state of `saved_arrays`, with the neighbour lists made anew.

    Parameters
    ----------
    model, state, scratch : the charge as it was built at the start of the run; changed in place
    saved : by `saved_arrays`
    reference : point [m] (3) and axis [1] (3) of the frame of the list, as `window` takes it
    """
    n, ids = model.n_particles, saved["ids"]
    state.ids[:n] = ids
    state.mass_props[:, :n] = state.mass_props[:, ids]
    state.material[:n] = state.material[ids]
    for name in (*WHOLE, "v", "w"):
        if name in saved:
            getattr(state, name)[..., : saved[name].shape[-1]] = saved[name]
    state.x[:, :n] = saved["x"]
    spin = saved["seen_spin"]
    if len(state.clumps):
        state.clumps[:] = state.clumps[saved["clump_ids"]]
        state.clumps[:, MOVING] = saved["clumps"]
        first = _first_pebbles(state.mass_props[CLUMP, :n])
        state.mass_props[CLUMP, :n] = np.repeat(np.arange(len(first)), np.diff([*first, n]))
        _move_pebbles(state, n)
        spin = spin[state.mass_props[CLUMP, :n].astype(int)]
    cut_chunks(model, state)
    current = state.clock[Clock.PUBLISHED]
    rows = state.published_rows[current, :n]
    rows[:, 0:3], rows[:, 4:7] = saved["seen_velocity"], spin
    rows[:, 3], rows[:, 7] = state.mass_props[1, :n], state.mass_props[0, :n]
    state.published_points[current, :n] = _points(model, state) + saved["rounding"]
    state.wall_memory[:] = 0.0
    state.wall_memory[saved["wall_slots"] * len(model.surface_kind) + saved["wall_surfaces"]] = saved[
        "wall_memory"
    ]
    if not state.clock[Clock.LISTED]:
        return model, state, scratch
    state.listed_x[:, :n] = saved["listed_x"]
    return _with_lists(model, state, scratch, saved, reference)


def saved_poses(saved: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return the positions [m] (n, 3) of the spheres, or positions and attitudes (n, 7) of the clumps, by id,
    world, half a substep ahead of the velocities.
    """
    if "clumps" in saved:
        moving, ids = saved["clumps"][:, CENTRE_AND_ATTITUDE], saved["clump_ids"]
    else:
        moving, ids = saved["x"].T, saved["ids"]
    poses = np.empty_like(moving)
    poses[ids] = moving
    return poses


def _with_lists(model, state, scratch, saved, reference):
    """Return the charge with the current neighbour list, in which the saved contacts have their memory."""
    bounds = state.pairs.counts[2]
    owners, partners, memory = _both_sides(bounds, saved)
    chunk = np.searchsorted(bounds[1:], owners, side="right")
    first = np.searchsorted(owners, bounds[:-1])
    place = np.arange(len(owners)) - first[chunk]
    while len(place) and place.max() >= state.saved.partners.shape[1]:
        model, state, scratch = grow(model, state, scratch)
    state.saved.counts[saved["ids"]] = np.bincount(owners, minlength=model.n_particles)
    state.saved.starts[saved["ids"][owners[::-1]]] = (chunk * state.saved.partners.shape[1] + place)[::-1]
    state.saved.partners[chunk, place] = saved["ids"][partners]
    state.saved.memory[chunk, place] = memory
    while make_lists(model._replace(law=None), state, scratch, reference, int(state.clock[Clock.LIST]), 0, 1):
        model, state, scratch = grow(model, state, scratch)
    return model, state, scratch


def _both_sides(bounds, saved):
    """Return owner, partner (slots) and memory of all contacts, ascending by owner: a pair within a chunk
    twice, as each of the two sees it. `bounds` are the first slots of the chunks.
    """
    owners, partners = saved["contact_owners"], saved["contact_partners"]
    memory = saved["contact_memory"]
    chunk_a, chunk_b = (np.searchsorted(bounds[1:], slots, side="right") for slots in (owners, partners))
    within = chunk_a == chunk_b
    turned = memory[within].copy()
    turned[:, :STAMP] *= -1.0
    both = np.concatenate([owners, partners[within]]), np.concatenate([partners, owners[within]])
    order = np.argsort(both[0], kind="stable")
    return both[0][order], both[1][order], np.concatenate([memory, turned])[order]


def _pair_contacts(state):
    """Return owner and partner (slots, ascending owners) and memory of the pairs that touched in the last
    substep. A pair across two chunks is in the list of both.
    """
    lst, last = state.clock[Clock.LIST], _last_stamp(state)
    owners, partners, memories = [], [], []
    for c, count in enumerate(state.pairs.counts[lst, :-1]):
        alive = np.flatnonzero(np.abs(state.pairs.memory[lst, c, :count, STAMP]) == last)
        owners.append(state.pairs.counts[2, c] + state.pairs.owners[lst, c, alive].astype(np.int64))
        partners.append(state.pairs.partners[lst, c, alive])
        memories.append(state.pairs.memory[lst, c, alive])
    return {
        "contact_owners": np.concatenate(owners).astype(np.int32),
        "contact_partners": np.concatenate(partners).astype(np.int32),
        "contact_memory": np.concatenate(memories),
    }


def _wall_contacts(model, state):
    """Return slot, surface and memory of the wall contacts of the last substep."""
    surfaces = len(model.surface_kind)
    alive = np.flatnonzero(
        np.abs(state.wall_memory[: model.n_particles * surfaces, STAMP]) == _last_stamp(state)
    )
    return {
        "wall_slots": (alive // max(surfaces, 1)).astype(np.int32),
        "wall_surfaces": (alive % max(surfaces, 1)).astype(np.int32),
        "wall_memory": state.wall_memory[alive],
    }


def _last_stamp(state):
    return stamp_of(int(state.clock[Clock.STEP]) - 1)


def _points(model, state):
    """Return positions and radii of the particles in fixed point [1/scale] (n, 4), as the state has them."""
    n = model.n_particles
    numbers = np.column_stack(
        [
            state.x[:, :n].T - model.centre,
            state.mass_props[0, :n] + 0.5 * model.film_reach,
        ]
    )
    return np.floor(numbers * model.scale + 0.5).astype(state.published_points.dtype)


def _first_pebbles(clump_of):
    """Return the first slot of each clump. `clump_of` has the clump of each slot."""
    return np.flatnonzero(np.diff(clump_of, prepend=-1.0))


def _move_pebbles(state, n):
    """Give the pebbles the velocities of their clumps, which are read until a substep sets them."""
    clump_of = state.mass_props[CLUMP, :n].astype(int)
    rotation = rotation_matrices(state.clumps[:, ClumpColumn.AT_VELOCITY :][:, :4])
    arms = np.einsum("nij,jn->ni", rotation[clump_of], state.mass_props[OFFSET : OFFSET + 3, :n])
    velocity = state.clumps[clump_of, ClumpColumn.VELOCITY : ClumpColumn.VELOCITY + 3]
    state.v[:, :n] = (velocity + np.cross(clump_spins(state.clumps)[clump_of], arms)).T
