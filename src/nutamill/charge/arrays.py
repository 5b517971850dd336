"""The arrays of a charge: an empty state, the work space that fits it, and both with larger lists."""

import numpy as np

from nutamill.charge.kernels.chunks import MOST_GROUPS
from nutamill.charge.kernels.clump_integration import LANE_ROWS
from nutamill.charge.kernels.impacts import impact_book
from nutamill.charge.kernels.rows import ROWS
from nutamill.charge.kernels.sorting import BUCKETS, morton_bits
from nutamill.charge.kernels.team import MOST_THREADS
from nutamill.charge.laws.lanes import BATCH
from nutamill.charge.measures.observe import READINGS
from nutamill.charge.model import (
    PADDING,
    ChargeModel,
    ChargeScratch,
    ChargeState,
    Clock,
    Ledger,
    ListScratch,
    PairLists,
    SavedContacts,
    Status,
)
from nutamill.charge.walls.wall_list import near_meshes


def _aligned(shape, dtype) -> np.ndarray:
    """Return zeros that begin on a cache line."""
    size = int(np.prod(shape)) * np.dtype(dtype).itemsize
    raw = np.zeros(size + 64, np.uint8)
    offset = -raw.ctypes.data % 64
    return raw[offset : offset + size].view(dtype).reshape(shape)


def empty_state(model, poses, clumps, longest, real, point, per_particle) -> ChargeState:
    """Return an empty state with room for `per_particle` candidates of each sphere. Clumps have at most
    `longest` spheres.
    """
    chunks = -(-model.n_particles // (model.chunk - longest + 1))
    # behind the last chunk: vector moves of a chunk that does not begin at a whole number of lanes
    m = chunks * model.chunk + BATCH
    capacity = -(-(per_particle * model.chunk + 2 * PADDING) // 16) * 16
    n_surfaces = len(model.surface_kind)
    memory = _aligned((2, chunks, capacity, 8), real)
    wall_memory = _aligned((m * n_surfaces + 1, 8), real)
    return ChargeState(
        x=_aligned((3, m), float),
        v=_aligned((3, m), float),
        w=_aligned((3, m), float),
        mass_props=_aligned((4 if len(clumps) == 0 else 8, m), float),
        clumps=clumps.copy(),
        material=_aligned(m, np.int32),
        ids=np.arange(m),
        published_points=_aligned((2, m, 4), point),
        published_rows=_aligned((2, m, 8), real),
        pairs=PairLists(
            partners=_aligned((2, chunks, capacity), np.uint32),
            owners=_aligned((2, chunks, capacity), np.uint32),
            memory=memory,
            counts=np.zeros((3, chunks + 1), np.int64),
        ),
        saved=SavedContacts(
            memory=_aligned((chunks, capacity, 8), real),
            partners=np.zeros((chunks, capacity), np.int32),
            starts=np.zeros(m, np.int64),
            counts=np.zeros(m, np.int32),
        ),
        wall_memory=wall_memory,
        listed_x=_aligned((3, m), float),
        listed_at=_aligned((3, m), float),
        list_angle=np.zeros(1),
        last_dt=np.zeros(1),
        poses=poses,
        impulse=np.zeros((model.n_bodies, 6)),
        ledger=np.zeros(len(Ledger)),
        largest_overlap=np.zeros(3),
        impacts=impact_book(MOST_THREADS, model.law_of.shape[0], int(model.patches.first[-1])),
        halt_speeds=np.zeros(3),
        status=np.zeros(4, np.int64),
        clock=np.zeros(len(Clock), np.int64),
    )


def scratch_for(model, state) -> ChargeScratch:
    """Return work space that fits `state`."""
    chunks, capacity = state.pairs.partners.shape[1:]
    m, n_surfaces, chunk = state.x.shape[1], len(model.surface_kind), model.chunk
    real, point = state.published_rows.dtype, state.published_points.dtype
    threads = MOST_THREADS
    lanes = max(capacity, n_surfaces * chunk) + 2 * BATCH
    lists = ListScratch(
        counts=np.zeros(8 ** morton_bits(model.n_particles) + 2, np.int32),
        cell=np.zeros(m, np.int32),
        order=np.zeros(m, np.int32),
        sorted=_aligned((4, m), real),
        bucketed=np.zeros(m, np.int32),
        tallies=np.zeros((threads, BUCKETS), np.int64),
        places=np.zeros((threads, BUCKETS), np.int64),
        firsts=np.zeros((threads, BUCKETS + 1), np.int64),
        bounds=np.zeros((threads, 6)),
        votes=np.zeros(threads, np.int64),
        grid=np.zeros(6),
        sizes=np.zeros(len(model.class_radius)),
        cells=np.zeros((len(model.class_radius) + 1, 4), np.int64),
        source=np.zeros(m, np.int32),
        slot_of=np.zeros(m, np.int32),
        moved=np.zeros(m),
        moved_memory=_aligned(state.wall_memory.shape, real),
    )
    return ChargeScratch(
        lists=lists,
        near=near_meshes(model, m, threads),
        sums=np.zeros((chunks, model.n_bodies, 6)),
        work=np.zeros((chunks, len(Ledger))),
        alarms=np.zeros(chunks, np.int64),
        group_alarms=np.zeros(min(chunks, MOST_GROUPS), np.int64),
        group_work=np.zeros(min(chunks, MOST_GROUPS), np.int64),
        readings=np.zeros((chunks, READINGS)),
        motion=np.zeros((threads, model.n_bodies, 18)),
        twists=_aligned((threads, model.n_bodies + 1, 8), real),
        surface_poses=np.zeros((threads, n_surfaces, 12)),
        rotation=np.zeros((threads, 3, 3)),
        forces=_aligned((threads, chunk + 1, 8), real),
        local=_aligned((threads, chunk + 1, 4), point),
        lanes=_aligned((threads, 5, lanes), np.uint32),
        columns=_aligned((threads, 3, ROWS * BATCH), real),
        moving=_aligned((threads, LANE_ROWS * BATCH), float),
        fixed=_aligned((threads, 4 * BATCH), point),
        slots=np.arange(m, dtype=np.uint32),
        measured=_aligned((threads, 7, n_surfaces * chunk + BATCH), real),
        peaks=np.zeros((threads, 2)),
        test=_aligned((threads, chunk), real),
        barrier=np.zeros(32, np.int64),
    )


def grow(
    model: ChargeModel, state: ChargeState, scratch: ChargeScratch
) -> tuple[ChargeModel, ChargeState, ChargeScratch]:
    """Return the same charge with twice the room in its lists, ready to go on, with LISTS_FULL cleared.

    The arrays that need no more room are those of `state`.
    """
    pairs, saved = state.pairs, state.saved
    capacity = pairs.partners.shape[2]
    longest = model.chunk + 1 - -(-model.n_particles // (pairs.counts.shape[1] - 1))
    empty = empty_state(
        model,
        state.poses,
        state.clumps,
        longest,
        state.published_rows.dtype,
        state.published_points.dtype,
        2 * capacity // model.chunk,
    )
    # only what is filled: the rest of a long list may never have been touched, and takes no memory yet
    lst = state.clock[Clock.LIST]
    for c, count in enumerate(pairs.counts[lst, :-1] + PADDING):
        for name in ("partners", "owners", "memory"):
            getattr(empty.pairs, name)[lst, c, :count] = getattr(pairs, name)[lst, c, :count]
    chunk, place = np.divmod(saved.starts, saved.partners.shape[1])
    chunk = np.minimum(chunk, len(saved.partners) - 1)  # of a particle without contacts it may be any
    filled = np.zeros(len(saved.partners), np.int64)
    np.maximum.at(filled, chunk, place + saved.counts)
    for c, count in enumerate(filled):
        for name in ("partners", "memory"):
            getattr(empty.saved, name)[c, :count] = getattr(saved, name)[c, :count]
    starts = chunk * empty.saved.partners.shape[1] + place
    larger = state._replace(
        pairs=empty.pairs._replace(counts=pairs.counts),
        saved=empty.saved._replace(starts=starts, counts=saved.counts),
    )
    larger.clock[Clock.CROWDED] = 0
    if larger.status[0] == Status.LISTS_FULL:
        larger.status[:] = 0
    return model, larger, scratch_for(model, larger)
