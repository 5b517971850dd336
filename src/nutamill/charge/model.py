"""A charge as arrays: constants (`ChargeModel`), all that changes (`ChargeState`), work space
(`ChargeScratch`).

The id of a particle never changes.  Its *slot* is its present index in the arrays, which follows a Morton
curve. Slots are cut into chunks: a chunk is the unit of work, of locality and of summation, so that sums have
the same bits at any number of threads.  ``M`` is the number of slots (particles, and padding to whole
chunks), ``C`` of chunks, ``S`` of surfaces, ``B`` of bodies, ``T`` of threads.  *real* stands for float32
(``precision="single"``) or float64,
*point* for int32 or int64.

Time is staggered (docs/conventions.md): velocities belong to the end of a substep, positions to half a
substep later.
"""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from nutamill.base.kernel import kernel
from nutamill.charge.laws.composition import ContactLaw
from nutamill.charge.walls.mesh_model import MeshWalls
from nutamill.charge.walls.patches import PatchTable
from nutamill.charge.walls.wall_list import NearMeshes

PADDING = 64
"""Entries behind the last candidate of a chunk that the vector filter may read [1]."""


class Status(IntEnum):
    """First number of `ChargeState.status`."""

    OK = 0
    PAIR_OVERLAP = 1
    """Two particles overlap beyond ``overlap_stop``."""
    WALL_OVERLAP = 2
    """A particle overlaps a surface beyond ``overlap_stop``."""
    OUTSIDE = 3
    """A particle left the domain, or its position is not a number."""
    LISTS_FULL = 4
    """Neighbour lists are too small.  After `grow`, the window called again goes on where it stopped."""


class Ledger(IntEnum):
    """Indices of `ChargeState.ledger`."""

    PAIR_NORMAL = 0
    PAIR_TANGENTIAL = 1
    PAIR_ROLLING = 2
    WALL_NORMAL = 3
    WALL_TANGENTIAL = 4
    WALL_ROLLING = 5
    INTERFACE = 6
    GRAVITY = 7
    SCHEME = 8
    """What contact forces do on the mean velocities of a substep beyond what they do on the predicted ones
    that their law saw.
    """
    PAIR_FILM = 9
    WALL_FILM = 10


class Clock(IntEnum):
    """Indices of `ChargeState.clock`."""

    STEP = 0
    """Substeps since the start."""
    PUBLISHED = 1
    """Which of the two published buffers is current."""
    LIST = 2
    """Which of the two neighbour lists is current."""
    LISTED = 3
    """1 once a list exists."""
    SINCE_SORT = 4
    """Rebuilds of the list since the slots were last sorted."""
    REBUILDS = 5
    """Rebuilds of the list since the start."""
    REBUILD = 6
    """1: rebuild before the next substep."""
    SAVED = 7
    """1: `ChargeState.saved` holds the contact memory until the next list is made."""
    DONE = 8
    """Substeps already done of a window that stopped with LISTS_FULL."""
    CROWDED = 9
    """1: a list is more than three quarters full; `grow` when convenient."""


@kernel(inline="always")
def stamp_of(step):
    """Return the mark in the memory of a contact alive in substep `step` [1]: whole, from 1, exact in single
    precision.
    """
    return (step & 0xFFFFFF) + 1


class ChargeModel(NamedTuple):
    """Constants of a charge; never changes."""

    n_particles: int
    """Number of spheres, pebbles of clumps counted each [1]."""
    chunk: int
    """Slots in a chunk [1]."""
    n_bodies: int
    """Bodies that may carry surfaces [1]."""
    law: ContactLaw
    """The law of all contacts; None for kernels that read none, see `without_law`."""
    laws: np.ndarray
    """Numbers of each pair law, real (n_laws, 13), as `LawColumn`.  Of a wet charge (n_laws, 16): there
    follow those of its film, as `viscous_film.numbers`; with bridges (n_laws, 20), behind these the four of
    its bridge, as `capillary.numbers`.
    """
    film_reach: float
    """Largest gap across which a film acts [m]; 0 in a dry charge."""
    law_of: np.ndarray
    """Row of `laws` [1] for (material of the particle, material of the other), int32 (n_materials,
    n_materials).
    """
    surface_kind: np.ndarray
    """`SurfaceKind` [1], int64 (S,)."""
    surface_body: np.ndarray
    """Carrying body [1], int64 (S,)."""
    surface_material: np.ndarray
    """Material [1], int64 (S,)."""
    surface_origin: np.ndarray
    """Origin [m] (S, 3), body axes, from the body's mass centre."""
    surface_rotation: np.ndarray
    """From surface axes to body axes [1] (S, 3, 3)."""
    surface_size: np.ndarray
    """Sizes [m], angles [rad] (S, 3), by `SurfaceKind`."""
    mesh: MeshWalls
    """Meshed surfaces (empty arrays where there are none), surface axes."""
    patches: PatchTable
    """How the surfaces are cut into patches, on which impacts are counted."""
    per_cut: float
    """Small units of `ImpactBook.cut` in 1 J [1/J]."""
    gravity: np.ndarray
    """Acceleration of gravity [m/s^2] (3,), world axes."""
    centre: np.ndarray
    """Centre of the domain [m] (3,), world."""
    reach: float
    """Half size of the cubic domain [m]."""
    scale: float
    """Fixed-point units in a metre [1/m]."""
    skin: float
    """Gap up to which two particles are listed as candidates [m], with that across which a film acts."""
    largest_radius: float
    """Largest radius [m]."""
    class_radius: np.ndarray
    """Largest radius of each class of sizes [m] (n_classes,), rising; in a class they differ by less than a
    factor of two.
    """


@kernel(inline="always")
def without_law(model):
    """Return the constants without the law, for kernels that read none: they are compiled once for all laws.

    A kernel is compiled for the types of its arguments, and the law is a type.
    """
    return ChargeModel(
        model.n_particles,
        model.chunk,
        model.n_bodies,
        None,  # type: ignore[arg-type]
        model.laws,
        model.film_reach,
        model.law_of,
        model.surface_kind,
        model.surface_body,
        model.surface_material,
        model.surface_origin,
        model.surface_rotation,
        model.surface_size,
        model.mesh,
        model.patches,
        model.per_cut,
        model.gravity,
        model.centre,
        model.reach,
        model.scale,
        model.skin,
        model.largest_radius,
        model.class_radius,
    )


class PairLists(NamedTuple):
    """Two lists of candidate pairs by chunk: the current one, and the one made next."""

    partners: np.ndarray
    """Slot of the second particle of each candidate pair [1], uint32 (2, C, capacity)."""
    owners: np.ndarray
    """Position within the chunk of the first particle of each candidate pair [1], uint32 (2, C, capacity)."""
    memory: np.ndarray
    """Tangential spring [m] (StoredForce: [N]) (3), rolling spring [rad] (3), `stamp_of` the last substep in
    contact (negative while sliding, 0 where there is none), history of the normal law [m], with the deepest
    overlap that has been booked, or minus the separation where there is a film and no contact, and a negative
    stamp with a bridge; real (2, C, capacity, 8), world axes.
    """
    counts: np.ndarray
    """Number of candidate pairs of each chunk in both lists, and its first slot [1], int64 (3, C + 1)."""


class SavedContacts(NamedTuple):
    """Contact memory by particle while a list is remade."""

    memory: np.ndarray
    """Memory of each contact, real (C, room, 8), as `PairLists.memory`; those of a particle are neighbours,
    in the chunk it was in.
    """
    partners: np.ndarray
    """Id of the other particle of each contact [1], int32 (C, room)."""
    starts: np.ndarray
    """Where the contacts of each particle begin, by its id: chunk times room + place in the chunk [1], int64
    (M,).
    """
    counts: np.ndarray
    """Number of contacts of each particle, by its id [1], int32 (M,)."""


class ImpactBook(NamedTuple):
    """Contacts begun since the start, and their loading, by thread; the sum over threads is the same for any
    number of them.
    """

    on: np.ndarray
    """1: book contacts, 0: book nothing [1], int64 (1,).  The march has the same bits either way."""

    spectra: np.ndarray
    """Number, and energy in `FINE` parts of the bin's lower edge, by type, part and bin, int64 (T, types,
    PARTS, BINS, 2).

    Types are numbered by materials: a pair of particles ``a n_materials + b``, a particle a on a surface of
    material b the same behind all pairs."""
    cut: np.ndarray
    """Cutting energy of the impacts on each patch, in small units, int64 (T, P)."""


class ChargeState(NamedTuple):
    """All that changes from substep to substep: a copy of it repeats a march bit for bit."""

    x: np.ndarray
    """Positions [m] (3, M), world, half a substep ahead of the velocities."""
    v: np.ndarray
    """Velocities [m/s] (3, M), world axes."""
    w: np.ndarray
    """Spins [rad/s] (3, M), world axes; unused for pebbles, which have the spin of their clump."""
    mass_props: np.ndarray
    """Radius [m], mass [kg], 1/mass [1/kg], 1/inertia [1/(kg m^2)] (4, M).  Where there are clumps (8, M):
    mass is the clump's, its inverses are unused, and there follow the centre in the clump's axes [m] (3) and
    the index of the clump [1].
    """
    clumps: np.ndarray
    """A row for each clump, as `charge.clumps.ClumpColumn` (n_clumps, 24); no rows where all particles are
    spheres.
    """
    material: np.ndarray
    """Material [1], int32 (M,)."""
    ids: np.ndarray
    """Id of the particle in each slot [1], int64 (M,)."""
    published_points: np.ndarray
    """Published positions and radius (with half the reach of the films), fixed point [1/scale], point
    (2, M, 4), from the domain's centre, world axes.
    """
    published_rows: np.ndarray
    """Published mid-substep velocity [m/s], mass [kg], spin [rad/s], radius [m], real (2, M, 8), world
    axes.
    """
    pairs: PairLists
    """Candidate pairs and the memory of their contacts."""
    saved: SavedContacts
    """Contact memory while a list is remade."""
    wall_memory: np.ndarray
    """As `PairLists.memory`, of slot i and surface s in row i S + s, real (M S + 1, 8); the last row is
    spare.
    """
    listed_x: np.ndarray
    """Positions when the lists were made [m] (3, M), world: `make_lists` makes the same lists from them
    again.
    """
    listed_at: np.ndarray
    """The same positions [m] (3, M), from the reference point, world axes."""
    list_angle: np.ndarray
    """Angle of the reference when the list was made [rad] (1,)."""
    last_dt: np.ndarray
    """Substep of the last window [s] (1,)."""
    poses: np.ndarray
    """Mass centre [m] (3) and rotation matrix [1] (9) of each body at the end of the last window (B, 12),
    world.
    """
    impulse: np.ndarray
    """Impulse [N s] (3) and angular impulse [N m s] (3) the charge gave each body in the last window, about
    the body's moving mass centre, world axes (B, 6)."""
    ledger: np.ndarray
    """Cumulative work [J] (11,), as `Ledger`: of contact forces on the relative motion (negative: taken out),
    of the surfaces' motion on the charge, of gravity."""
    largest_overlap: np.ndarray
    """Largest overlap since last set to zero, of pairs and of walls, and that of the contact named in
    `status` [diameter] (3,).
    """
    impacts: ImpactBook
    """Contacts begun since the start, and their loading."""
    halt_speeds: np.ndarray
    """Speeds of what `status` names: of the particle and of the other particle or of the surface where they
    touch, at mid-substep, and how fast they close (positive) along the normal [m/s] (3,).
    """
    status: np.ndarray
    """`Status`, id of the particle, id of the other particle or index of the surface, substep [1], int64
    (4,).
    """
    clock: np.ndarray
    """Counters and switches [1], int64 (10,), as `Clock`."""


class ListScratch(NamedTuple):
    """Work space of neighbour lists and of sorting."""

    counts: np.ndarray
    """Counting sort: particles per cell, then first place of each cell [1], int32 (cells + 2,)."""
    cell: np.ndarray
    """Cell of each slot [1], int32 (M,)."""
    order: np.ndarray
    """Slots in the order of cells [1], int32 (M,)."""
    sorted: np.ndarray
    """Position [m] (3) and radius [m] in the order of cells, real (4, M), from the corner of the cells, world
    axes.
    """
    bucketed: np.ndarray
    """Slots in the order of buckets of cells [1], int32 (M,)."""
    tallies: np.ndarray
    """Slots that each thread has in each bucket [1], int64 (T, buckets)."""
    places: np.ndarray
    """Of each thread: next place in each bucket [1], int64 (T, buckets)."""
    firsts: np.ndarray
    """Of each thread: first place of each bucket [1], int64 (T, buckets + 1)."""
    bounds: np.ndarray
    """Of each thread: lowest and highest position of its particles [m] (T, 6), world axes."""
    votes: np.ndarray
    """Of each thread: a number for the others [1], int64 (T,)."""
    grid: np.ndarray
    """Corner of the cells [m] (3) and extents of the box they fill [m] (3), world axes (6,)."""
    sizes: np.ndarray
    """Size of the cells of each class of sizes [m] (n_classes,)."""
    cells: np.ndarray
    """Cells along each axis (3) and first cell of each class of sizes [1], int64 (n_classes + 1, 4)."""
    source: np.ndarray
    """Old slot of each new slot [1], int32 (M,)."""
    slot_of: np.ndarray
    """Slot of each id [1], int32 (M,)."""
    moved: np.ndarray
    """A column of the state while it is being reordered (unit of the column); between, radii with the reach
    of the films [m] (M,).
    """
    moved_memory: np.ndarray
    """The wall memory while it is being reordered, real (M S + 1, 8), as `ChargeState.wall_memory`."""


class ChargeScratch(NamedTuple):
    """Work space: no window needs what an earlier one left in it."""

    lists: ListScratch
    """For making neighbour lists."""
    near: NearMeshes
    """Patches of meshes near each particle.  It outlives windows, and decides no result."""
    sums: np.ndarray
    """Wrench of each chunk on each body [N, N m] (C, B, 6), about the body's mass centre, world axes."""
    work: np.ndarray
    """Power of each chunk by kind [W] (C, 11), as `Ledger`."""
    alarms: np.ndarray
    """Of each chunk, sum of: 1 moved out of the skin, 2 left the domain, 4 pair overlap, 8 wall overlap [1],
    int64 (C,).
    """
    group_alarms: np.ndarray
    """The alarms of all chunks of each group [1], int64 (groups,)."""
    group_work: np.ndarray
    """Cost of a substep of each group, in candidates [1], int64 (groups,)."""
    readings: np.ndarray
    """Sums over the particles of each chunk, as `nutamill.charge.measures.observe` (C, 17)."""
    motion: np.ndarray
    """Of each thread and body: mass centre [m] (3), rotation [1] (9), velocity [m/s] (3), spin [rad/s] (3)
    (T, B, 18), world axes.
    """
    twists: np.ndarray
    """Of each thread and body, and of no body: velocity [m/s] (3), spin [rad/s] (3), number of the body,
    spare, real (T, B + 1, 8).
    """
    surface_poses: np.ndarray
    """Of each thread and surface: origin [m] (3), rotation [1] (9) (T, S, 12), world axes."""
    rotation: np.ndarray
    """Of each thread: rotation of the reference since the list was made [1] (T, 3, 3), world axes."""
    forces: np.ndarray
    """Force [N] (3), spare, moment [N m] (3), spare, on each particle of the chunk, real (T, chunk + 1, 8),
    world axes.
    """
    local: np.ndarray
    """Published positions of the chunk with negative radius [1/scale], point (T, chunk + 1, 4)."""
    lanes: np.ndarray
    """Indices of touching pairs, or of touching walls [1], uint32 (T, 5, capacity)."""
    columns: np.ndarray
    """Columns of the vector loops over pairs, walls and particles, real (T, 3, ROWS * BATCH)."""
    moving: np.ndarray
    """Columns of position, velocity, spin, position when listed, mass and its inverses, or those of clumps as
    in `charge.clump_integration` (T, LANE_ROWS * BATCH), units as in the state."""
    fixed: np.ndarray
    """Columns of published positions and radius [1/scale], point (T, 4 * BATCH)."""
    slots: np.ndarray
    """Every slot in order, 0, 1, 2 ..., uint32 (M,)."""
    measured: np.ndarray
    """Normal [1] (3) and overlap [m] of the touching walls, and place from their body's mass centre [m] (3),
    real (T, 7, S * chunk + BATCH), world axes."""
    peaks: np.ndarray
    """Largest overlap of pairs and of walls that each thread saw in the window [diameter] (T, 2)."""
    test: np.ndarray
    """Of each thread and particle of the chunk: positive where it touches the present surface [m or m^2] (T,
    chunk).
    """
    barrier: np.ndarray
    """Arrivals and generation of the team's barrier [1], int64 (32,)."""
