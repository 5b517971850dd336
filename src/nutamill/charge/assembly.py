"""From descriptions of particles, surfaces and laws to the arrays of a charge; all checks of input are
here.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from nutamill.base.errors import CaseError, Fault
from nutamill.charge.checks import NAMED, extent, mesh_faults, named, surface_faults, wall_faults
from nutamill.charge.kernels.clump_integration import LANE_ROWS
from nutamill.charge.kernels.clumps import CLUMP, COLUMNS, OFFSET, ClumpColumn, cut_chunks
from nutamill.charge.kernels.columns import ROWS
from nutamill.charge.kernels.impacts import impact_book
from nutamill.charge.kernels.neighbours import morton_bits
from nutamill.charge.kernels.team import MOST_THREADS
from nutamill.charge.laws.lanes import BATCH
from nutamill.charge.laws.numbers import law_faults, law_numbers
from nutamill.charge.laws.pair import PairLaw
from nutamill.charge.laws.tags import STANDARD_LAW, ContactLaw
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
from nutamill.charge.particles.particles import Particles, check_particles, motion_faults
from nutamill.charge.pebbles import Pebbles, pebbles, rotation_matrices
from nutamill.charge.walls.mesh_patches import mesh_walls
from nutamill.charge.walls.patches import ANGLE_HEIGHT, PatchTable, patch_table
from nutamill.charge.walls.surface import Surface

SMALLEST_CHUNK, LARGEST_CHUNK, CHUNKS = 64, 672, 4
"""Slots in a chunk, at least and at most, and the number of chunks that there should be between [1].

Pairs across two chunks are computed twice, so large chunks do less work; few chunks share badly among
threads.
"""

CANDIDATES_PER_PARTICLE = 14
"""Room in a list for each particle [1]; `grow` makes more."""


def _aligned(shape, dtype) -> np.ndarray:
    """Return zeros that begin on a cache line."""
    size = int(np.prod(shape)) * np.dtype(dtype).itemsize
    raw = np.zeros(size + 64, np.uint8)
    offset = -raw.ctypes.data % 64
    return raw[offset : offset + size].view(dtype).reshape(shape)


def mirrored(law: PairLaw) -> PairLaw:
    """Return the law of materials (b, a) from that of (a, b)."""
    return replace(
        law,
        stiffness_per_diameter_a=law.stiffness_per_diameter_b,
        stiffness_per_diameter_b=law.stiffness_per_diameter_a,
    )


def _law_table(
    contact_law, pair_laws, materials, surfaces, n_materials
) -> tuple[list, np.ndarray, list[Fault]]:
    """Return the rows of numbers, the row of each pair, and what is wrong with the pairs."""
    laws, faults = [], []
    table = np.zeros((n_materials, n_materials), np.int32)
    present = sorted({int(m) for m in materials})
    needed = {(a, b) for a in present for b in present} | {(a, s.material) for a in present for s in surfaces}
    rows = {}
    for a, b in sorted(needed):
        law = pair_laws.get((a, b)) or (mirrored(pair_laws[b, a]) if (b, a) in pair_laws else None)
        if law is None:
            if (b, a) not in needed or a <= b:
                faults.append(
                    Fault(
                        f"materials {a} and {b}",
                        "a pair law must be given, got none",
                        f"Add pair_laws[{a}, {b}]",
                    )
                )
            continue
        if a <= b or (b, a) not in needed:
            faults += [Fault(f"pair_laws[{a}, {b}]", *fault) for fault in law_faults(contact_law, law)]
        table[a, b] = rows.setdefault(law, len(rows))
    laws = [] if faults else [law_numbers(contact_law, law) for law in rows]
    return laws, table, faults


def _particle_faults(positions, radii, materials, densities) -> list[Fault]:
    """Return arrays of wrong size and numbers out of range."""
    faults = []
    if positions.ndim != 2 or positions.shape[1:] != (3,) or len(positions) == 0:
        return [
            Fault(
                "positions", f"must be an (n, 3) array of at least one particle, got shape {positions.shape}"
            )
        ]
    n = len(positions)
    if radii.shape != (n,) or materials.shape != (n,):
        return [Fault("radii, materials", f"must be ({n},) arrays, got {radii.shape} and {materials.shape}")]
    for name, bad, must in (
        ("positions", ~np.isfinite(positions).all(axis=1), "finite"),
        ("radii", ~(np.isfinite(radii) & (radii > 0.0)), "positive"),
        ("materials", (materials < 0) | (materials >= len(densities)), f"from 0 to {len(densities) - 1}"),
    ):
        if bad.any():
            faults.append(Fault(name, f"must be {must}, not so for particles {named(np.flatnonzero(bad))}"))
    for material in sorted(set(materials.tolist())):
        if 0 <= material < len(densities) and not (
            math.isfinite(densities[material]) and densities[material] > 0.0
        ):
            faults.append(
                Fault(
                    f"density of material {material}", f"must be positive, got {densities[material]} kg/m^3"
                )
            )
    return faults


def _pair_faults(positions, radii, materials, model, owner) -> list[Fault]:
    """Return particles that overlap beyond their limit at the start; the worst are named, by the `owner` of
    each sphere.
    """
    pairs = cKDTree(positions).query_pairs(2.0 * float(radii.max()), output_type="ndarray")
    pairs = pairs[owner[pairs[:, 0]] != owner[pairs[:, 1]]]
    if len(pairs) == 0:
        return []
    i, j = pairs.T
    overlap = radii[i] + radii[j] - np.linalg.norm(positions[i] - positions[j], axis=1)
    share = overlap / (2.0 * np.minimum(radii[i], radii[j]))
    excess = share * model.laws[model.law_of[materials[i], materials[j]], 9]
    bad = np.flatnonzero(excess > 1.0)
    worst = bad[np.argsort(-excess[bad])][:NAMED]
    if len(bad) == 0:
        return []
    listed = ", ".join(f"{owner[i[k]]}-{owner[j[k]]} ({100 * share[k]:.0f} %)" for k in worst)
    what = (
        f"particles must not overlap beyond overlap_stop, {len(bad)} pairs do; worst, with the share of "
        f"the diameter: {listed}"
    )
    return [Fault("positions", what, "Start from a looser packing")]


def body_poses(n_bodies: int, poses=None) -> np.ndarray:
    """Return mass centre [m] and rotation matrix [1] (n_bodies, 12), from positions and quaternions
    (n_bodies, 7), or at the origin.
    """
    out = np.zeros((n_bodies, 12))
    out[:, 3] = out[:, 7] = out[:, 11] = 1.0
    if poses is not None:
        for b, (px, py, pz, w, x, y, z) in enumerate(np.asarray(poses, float)):
            out[b] = [
                px,
                py,
                pz,
                1 - 2 * (y * y + z * z),
                2 * (x * y - w * z),
                2 * (x * z + w * y),
                2 * (x * y + w * z),
                1 - 2 * (x * x + z * z),
                2 * (y * z - w * x),
                2 * (x * z - w * y),
                2 * (y * z + w * x),
                1 - 2 * (x * x + y * y),
            ]
    return out


def _default_domain(positions, radii, surfaces) -> tuple[np.ndarray, float]:
    """Return centre and half size of a cube with room for everything to move."""
    low, high = positions.min(axis=0), positions.max(axis=0)
    reach = max([float((high - low).max()), 200.0 * float(radii.max())] + [2.0 * extent(s) for s in surfaces])
    return 0.5 * (low + high), reach


def charge_of(
    particles: Particles,
    densities: Sequence[float],
    pair_laws: Mapping[tuple[int, int], PairLaw],
    surfaces: Sequence[Surface],
    n_bodies: int,
    velocities: np.ndarray | None = None,
    spins: np.ndarray | None = None,
    **settings,
) -> tuple[ChargeModel, ChargeState, ChargeScratch]:
    """Build a charge of placed particles, spheres or clumps; `start` it before the first `window`.

    Parameters
    ----------
    particles : what they are and where they lie, world
    densities : by material [kg/m^3]
    pair_laws, surfaces, n_bodies : as `charge`
    velocities, spins : of the particles [m/s], [rad/s] (n, 3), world axes; zero if None
    settings : the other arguments of `charge`

    Raises
    ------
    CaseError : particles that cannot be, and as `charge`
    """
    check_particles(particles, densities)
    if particles.spheres_only:
        given = particles.centre, particles.bounding_radius, particles.material
        return charge(
            *given, densities, pair_laws, surfaces, n_bodies, velocities=velocities, spins=spins, **settings
        )
    faults = motion_faults(particles.number, velocities, spins)
    if faults:
        raise CaseError(*faults)
    spheres_of = pebbles(particles, densities, velocities, spins)
    return charge(
        spheres_of.centre,
        spheres_of.radius,
        spheres_of.material,
        densities,
        pair_laws,
        surfaces,
        n_bodies,
        spheres=spheres_of,
        **settings,
    )


def charge(
    positions: np.ndarray,
    radii: np.ndarray,
    materials: np.ndarray,
    densities: Sequence[float],
    pair_laws: Mapping[tuple[int, int], PairLaw],
    surfaces: Sequence[Surface],
    n_bodies: int,
    gravity: Sequence[float] = (0.0, 0.0, -9.81),
    law: ContactLaw = STANDARD_LAW,
    skin: float | None = None,
    velocities: np.ndarray | None = None,
    spins: np.ndarray | None = None,
    precision: str = "single",
    domain: tuple[Sequence[float], float] | None = None,
    poses: np.ndarray | None = None,
    spheres: Pebbles | None = None,
    patches: PatchTable | None = None,
) -> tuple[ChargeModel, ChargeState, ChargeScratch]:
    """Build a charge of spheres, free ones or the pebbles of clumps; `start` it before the first `window`.

    Parameters
    ----------
    positions : [m] (n, 3), world
    radii : [m] (n,); any sizes
    materials : material of each particle [1] (n,)
    densities : by material [kg/m^3]
    pair_laws : law of two materials (a, b), each pair once
    surfaces : wall pieces, each carried by a body
    n_bodies : bodies that may carry surfaces [1]
    gravity : [m/s^2] (3,), world axes
    law : the law of all contacts
    skin : gap up to which pairs are candidates [m]; a quarter of the mean diameter if None
    velocities, spins : [m/s], [rad/s] (n, 3), world axes; zero if None
    precision : "single", or "double" for verification
    domain : centre [m] (3,) and half size [m] of a cube nothing leaves; chosen from the positions if None
    poses : mass centre [m] (3) and quaternion (4) of each body at the start (n_bodies, 7), world; at the
        origin if None
    spheres : the clumps that the spheres are pebbles of; None where they are free
    patches : how the surfaces are cut into patches, on which impacts are counted; one patch each if None

    Raises
    ------
    CaseError : sizes and densities that cannot be, missing pair laws, particles that overlap or lie outside
        at the start
    """
    positions = np.array(positions, float)
    radii, materials = np.array(radii, float), np.array(materials, np.int32)
    faults = _particle_faults(positions, radii, materials, densities) + motion_faults(
        len(positions), velocities, spins
    )
    if faults:
        raise CaseError(*faults)
    n = len(positions)
    n_materials = max([len(densities)] + [s.material + 1 for s in surfaces])
    rows, law_of, faults = _law_table(law, pair_laws, materials, surfaces, n_materials)
    faults += surface_faults(surfaces, n_bodies)
    if precision not in ("single", "double"):
        faults.append(Fault("precision", f'must be "single" or "double", got {precision!r}'))
    if faults:
        raise CaseError(*faults)
    if spheres is None:
        mass = np.array(densities, float)[materials] * 4.0 / 3.0 * math.pi * radii**3
    else:
        mass = spheres.clumps[spheres.place, ClumpColumn.MASS]
    single = precision == "single"
    real, point = (np.float32, np.int32) if single else (np.float64, np.int64)
    centre, reach = (
        _default_domain(positions, radii, surfaces)
        if domain is None
        else (np.array(domain[0], float), float(domain[1]))
    )
    model = ChargeModel(
        n_particles=n,
        chunk=min(LARGEST_CHUNK, max(SMALLEST_CHUNK, -(-n // (CHUNKS * BATCH)) * BATCH)),
        n_bodies=n_bodies,
        law=law,
        laws=np.array(rows, real),
        law_of=law_of,
        surface_kind=np.array([int(s.kind) for s in surfaces], np.int64),
        surface_body=np.array([s.body for s in surfaces], np.int64),
        surface_material=np.array([s.material for s in surfaces], np.int64),
        surface_origin=np.array([s.origin for s in surfaces], float).reshape(-1, 3),
        surface_rotation=np.array([np.array(s.rotation, float) for s in surfaces], float).reshape(-1, 3, 3),
        surface_size=np.array([s.size for s in surfaces], float).reshape(-1, 3),
        mesh=mesh_walls(surfaces, float(radii.max())),
        patches=patch_table([(ANGLE_HEIGHT, 1, 1, 0.0, 1.0)] * len(surfaces)) if patches is None else patches,
        per_cut=2.0**30 / float(mass.mean()),
        gravity=np.array(gravity, float),
        centre=centre,
        reach=reach,
        # one bit is spare, so that rounding at the edge of the domain cannot wrap
        scale=2.0 ** (30 if single else 60) / reach,
        skin=0.5 * float(radii.mean()) if skin is None else float(skin),
        largest_radius=float(radii.max()),
    )
    poses = body_poses(n_bodies, poses)
    owner = np.arange(n) if spheres is None else spheres.place
    faults = _pair_faults(positions, radii, materials, model, owner)
    if surfaces:
        faults += wall_faults(positions, radii, materials, model, surfaces, poses, owner)
        faults += mesh_faults(positions, model, surfaces, poses, owner)
    outside = owner[(np.abs(positions - centre) >= reach).any(axis=1)]
    if len(outside):
        faults.append(
            Fault(
                "domain",
                f"all particles must start within, these do not: {named(outside)}",
                "Give a larger domain",
            )
        )
    if faults:
        raise CaseError(*faults)
    ratio = float(radii.max() / radii.min())
    longest = 1 if spheres is None else int(np.bincount(spheres.place).max())
    clumps = np.zeros((0, COLUMNS)) if spheres is None else spheres.clumps
    state = _state(
        model,
        poses,
        clumps,
        longest,
        real,
        point,
        int(CANDIDATES_PER_PARTICLE * min(ratio, 3.0)),
        int(16 * min(ratio, 3.0)),
    )
    if spheres is None:
        state.mass_props[:, :n] = radii, mass, 1.0 / mass, 1.0 / (0.4 * mass * radii**2)
    else:
        state.mass_props[:2, :n] = radii, mass
        state.mass_props[OFFSET : OFFSET + 3, :n], state.mass_props[CLUMP, :n] = (
            spheres.offset.T,
            spheres.place,
        )
    cut_chunks(model, state)
    state.x[:, :n] = positions.T
    state.v[:, :n] = 0.0 if velocities is None else np.asarray(velocities, float).T
    state.w[:, :n] = 0.0 if spins is None else np.asarray(spins, float).T
    state.material[:n] = materials
    return model, state, _scratch(model, state)


def _state(model, poses, clumps, longest, real, point, per_particle, saved) -> ChargeState:
    """Return an empty state with room for `per_particle` candidates and `saved` contacts of each sphere;
    clumps have at most `longest` spheres.
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
            memory=_aligned((m, saved, 8), real),
            partners=np.zeros((m, saved), np.int32),
            counts=np.zeros(m, np.int32),
        ),
        wall_memory=wall_memory,
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


def _scratch(model, state) -> ChargeScratch:
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
        grid=np.zeros(8),
        cells=np.zeros(3, np.int64),
        source=np.zeros(m, np.int32),
        slot_of=np.zeros(m, np.int32),
        moved=np.zeros(m),
        moved_memory=_aligned(state.wall_memory.shape, real),
    )
    return ChargeScratch(
        lists=lists,
        sums=np.zeros((chunks, model.n_bodies, 6)),
        work=np.zeros((chunks, len(Ledger))),
        alarms=np.zeros(chunks, np.int64),
        motion=np.zeros((threads, model.n_bodies, 18)),
        twists=_aligned((threads, model.n_bodies + 1, 8), real),
        placed=np.zeros((threads, n_surfaces, 12)),
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
    capacity, contacts = pairs.partners.shape[2], saved.memory.shape[1]
    longest = model.chunk + 1 - -(-model.n_particles // (pairs.counts.shape[1] - 1))
    empty = _state(
        model,
        state.poses,
        state.clumps,
        longest,
        state.published_rows.dtype,
        state.published_points.dtype,
        2 * capacity // model.chunk,
        2 * contacts,
    )
    for name in ("partners", "owners", "memory"):
        getattr(empty.pairs, name)[:, :, :capacity] = getattr(pairs, name)
    for name in ("partners", "memory"):
        getattr(empty.saved, name)[:, :contacts] = getattr(saved, name)
    larger = state._replace(
        pairs=empty.pairs._replace(counts=pairs.counts), saved=empty.saved._replace(counts=saved.counts)
    )
    larger.clock[Clock.CROWDED] = 0
    if larger.status[0] == Status.LISTS_FULL:
        larger.status[:] = 0
    return model, larger, _scratch(model, larger)


def _by_id(state, columns) -> np.ndarray:
    n = columns.shape[1]
    out = np.empty((n, 3))
    out[state.ids[:n]] = columns.T
    return out


def positions(model: ChargeModel, state: ChargeState, dt: float) -> np.ndarray:
    """Return the mass centres [m] (n, 3) by particle id, world, at the time of the velocities; `dt` is the
    substep [s] of the last window.
    """
    if len(state.clumps):
        centre, velocity = (
            _clumps_by_id(state, column, 3) for column in (ClumpColumn.CENTRE, ClumpColumn.VELOCITY)
        )
        return centre - 0.5 * dt * velocity
    n = model.n_particles
    return _by_id(state, state.x[:, :n] - 0.5 * dt * state.v[:, :n])


def velocities(model: ChargeModel, state: ChargeState) -> np.ndarray:
    """Return the velocities [m/s] (n, 3) of the mass centres by particle id, world axes."""
    if len(state.clumps):
        return _clumps_by_id(state, ClumpColumn.VELOCITY, 3)
    return _by_id(state, state.v[:, : model.n_particles])


def spins(model: ChargeModel, state: ChargeState) -> np.ndarray:
    """Return the spins [rad/s] (n, 3) by particle id, world axes."""
    if len(state.clumps):
        momentum, inertia = (
            _clumps_by_id(state, column, 3) for column in (ClumpColumn.MOMENTUM, ClumpColumn.INERTIA)
        )
        rotation = rotation_matrices(_clumps_by_id(state, ClumpColumn.AT_VELOCITY, 4))
        return np.einsum("nij,nj->ni", rotation, np.einsum("nji,nj->ni", rotation, momentum) / inertia)
    return _by_id(state, state.w[:, : model.n_particles])


def attitudes(model: ChargeModel, state: ChargeState) -> np.ndarray | None:
    """Return quaternions (n, 4) by particle id, from the axes of a clump to world axes, at the time of the
    velocities; None for spheres.
    """
    return _clumps_by_id(state, ClumpColumn.AT_VELOCITY, 4) if len(state.clumps) else None


def _clumps_by_id(state, column, width) -> np.ndarray:
    out = np.empty((len(state.clumps), width))
    out[state.clumps[:, ClumpColumn.ID].astype(int)] = state.clumps[:, column : column + width]
    return out


def contact_forces(model: ChargeModel, state: ChargeState, dt: float) -> np.ndarray | None:
    """Return the resultant of the contact forces on each particle [N] (n,) by id in the last substep `dt`
    [s]; None of clumps.

    The published velocity is that of the middle of the coming substep, ``v* = v + dt a/2`` with the last
    acceleration, so that ``F = m (2 (v* - v)/dt - g)``; published in single precision, it is good to about
    1e-4 N for a pellet.
    """
    if len(state.clumps):
        return None
    n = model.n_particles
    middle = state.published_rows[state.clock[Clock.PUBLISHED], :n, :3].T
    acceleration = 2.0 * (middle - state.v[:, :n]) / dt - np.reshape(model.gravity, (3, 1))
    return np.linalg.norm(_by_id(state, state.mass_props[1, :n] * acceleration), axis=1)
