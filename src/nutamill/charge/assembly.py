"""From descriptions of particles, walls and laws to the arrays of a charge, with all checks of input."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from nutamill.base.errors import CaseError, Fault
from nutamill.charge.arrays import empty_state, scratch_for
from nutamill.charge.checks import (
    extent,
    mesh_faults,
    named,
    pair_faults,
    particle_faults,
    surface_faults,
    wall_faults,
)
from nutamill.charge.filling.relax import size_octaves
from nutamill.charge.kernels.chunks import cut_chunks
from nutamill.charge.kernels.clumps import CLUMP, COLUMNS, OFFSET, ClumpColumn
from nutamill.charge.laws.composition import (
    STANDARD_LAW,
    ContactLaw,
    film_gap,
    film_numbers,
    law_faults,
    law_numbers,
)
from nutamill.charge.laws.lanes import BATCH
from nutamill.charge.laws.pair import PairLaw
from nutamill.charge.model import (
    ChargeModel,
    ChargeScratch,
    ChargeState,
)
from nutamill.charge.particles.particles import Particles, check_particles, motion_faults
from nutamill.charge.pebbles import Pebbles, pebbles
from nutamill.charge.walls.mesh_patches import mesh_walls
from nutamill.charge.walls.patches import ANGLE_HEIGHT, PatchTable, patch_table
from nutamill.charge.walls.surface import Surface

SMALLEST_CHUNK, LARGEST_CHUNK, CHUNKS = 64, 672, 16
"""Slots in a chunk, at least and at most, and the number of chunks that there should be in between [1].

Pairs across two chunks are computed twice, so large chunks do less work; few chunks share badly among
threads.  The number of threads plays no part, so that results have the same bits on any.
"""

CANDIDATES_PER_PARTICLE = 14
"""Room in a list for each particle [1]; `grow` makes more."""


def chunk_size(n: int, longest: int) -> int:
    """Return the slots in a chunk [1] of a charge of `n` spheres in clumps of at most `longest`: a multiple
    of `BATCH`, with room for two clumps.
    """
    least = max(SMALLEST_CHUNK, -(-2 * longest // BATCH) * BATCH)
    return max(least, min(LARGEST_CHUNK, n // (CHUNKS * BATCH) * BATCH))


def mirrored(law: PairLaw) -> PairLaw:
    """Return the law of materials (b, a) from that of (a, b)."""
    return replace(
        law,
        stiffness_per_diameter_a=law.stiffness_per_diameter_b,
        stiffness_per_diameter_b=law.stiffness_per_diameter_a,
    )


def law_rows(contact_law: ContactLaw, pairs: Sequence[PairLaw]) -> list[list[float]]:
    """Return the rows of `ChargeModel.laws` of these pairs."""
    return [[*law_numbers(contact_law, pair), *film_numbers(contact_law, pair)] for pair in pairs]


def _law_table(
    contact_law, pair_laws, materials, surfaces, n_materials, radius
) -> tuple[list, np.ndarray, float, list[Fault]]:
    """Return the rows of numbers, the row of each pair, the largest gap across which a film acts [m] between
    particles of at least `radius` [m], and what is wrong with the pairs.
    """
    faults = []
    table = np.zeros((n_materials, n_materials), np.int32)
    present = sorted({int(m) for m in materials})
    needed = {(a, b) for a in present for b in present} | {(a, s.material) for a in present for s in surfaces}
    rows: dict[PairLaw, int] = {}
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
    if faults:
        return [], table, 0.0, faults
    reach = max((film_gap(contact_law, law, radius) for law in rows), default=0.0)
    return law_rows(contact_law, list(rows)), table, reach, faults


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
    """Build a charge of placed particles, spheres or clumps. `start` it before the first `window`.

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
    assert particles.centre is not None  # checked
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
    """Build a charge of spheres, free ones or the pebbles of clumps. `start` it before the first `window`.

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
    skin : gap up to which pairs are candidates [m], beyond the film if there is one; a quarter of the mean
        diameter if None
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
    faults = particle_faults(positions, radii, materials, densities) + motion_faults(
        len(positions), velocities, spins
    )
    if faults:
        raise CaseError(*faults)
    n = len(positions)
    n_materials = max([len(densities)] + [s.material + 1 for s in surfaces])
    smallest = float(radii.min())
    rows, law_of, gap, faults = _law_table(law, pair_laws, materials, surfaces, n_materials, smallest)
    faults += surface_faults(surfaces, n_bodies)
    if precision not in ("single", "double"):
        faults.append(Fault("precision", f'must be "single" or "double", got {precision!r}'))
    if faults:
        raise CaseError(*faults)
    if spheres is None:
        mass = np.array(densities, float)[materials] * 4.0 / 3.0 * math.pi * radii**3
    else:
        mass = spheres.clumps[spheres.clump_of, ClumpColumn.MASS]
    longest = 1 if spheres is None else int(np.bincount(spheres.clump_of).max())
    single = precision == "single"
    real, point = (np.float32, np.int32) if single else (np.float64, np.int64)
    centre, reach = (
        _default_domain(positions, radii, surfaces)
        if domain is None
        else (np.array(domain[0], float), float(domain[1]))
    )
    laws = np.array(rows, real)
    gap = float(real(gap))
    model = ChargeModel(
        n_particles=n,
        chunk=chunk_size(n, longest),
        n_bodies=n_bodies,
        law=law,
        laws=laws,
        film_reach=gap,
        law_of=law_of,
        surface_kind=np.array([int(s.kind) for s in surfaces], np.int64),
        surface_body=np.array([s.body for s in surfaces], np.int64),
        surface_material=np.array([s.material for s in surfaces], np.int64),
        surface_origin=np.array([s.origin for s in surfaces], float).reshape(-1, 3),
        surface_rotation=np.array([np.array(s.rotation, float) for s in surfaces], float).reshape(-1, 3, 3),
        surface_size=np.array([s.size for s in surfaces], float).reshape(-1, 3),
        mesh=mesh_walls(surfaces, float(radii.max()) + gap),
        patches=patch_table([(ANGLE_HEIGHT, 1, 1, 0.0, 1.0)] * len(surfaces)) if patches is None else patches,
        per_cut=2.0**30 / float(mass.mean()),
        gravity=np.array(gravity, float),
        centre=centre,
        reach=reach,
        # one bit is spare, so that rounding at the edge of the domain cannot wrap
        scale=2.0 ** (30 if single else 60) / reach,
        skin=gap + (0.5 * float(radii.mean()) if skin is None else float(skin)),
        largest_radius=float(radii.max()),
        class_radius=np.array([radius for _, radius in size_octaves(radii)]),
    )
    poses = body_poses(n_bodies, poses)
    owner = np.arange(n) if spheres is None else spheres.clump_of
    faults = pair_faults(positions, radii, materials, model, owner)
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
    clumps = np.zeros((0, COLUMNS)) if spheres is None else spheres.clumps
    state = empty_state(
        model,
        poses,
        clumps,
        longest,
        real,
        point,
        int(CANDIDATES_PER_PARTICLE * min(ratio, 3.0)),
    )
    if spheres is None:
        state.mass_props[:, :n] = radii, mass, 1.0 / mass, 1.0 / (0.4 * mass * radii**2)
    else:
        state.mass_props[:2, :n] = radii, mass
        state.mass_props[OFFSET : OFFSET + 3, :n], state.mass_props[CLUMP, :n] = (
            spheres.offset.T,
            spheres.clump_of,
        )
    cut_chunks(model, state)
    state.x[:, :n] = positions.T
    state.v[:, :n] = 0.0 if velocities is None else np.asarray(velocities, float).T
    state.w[:, :n] = 0.0 if spins is None else np.asarray(spins, float).T
    state.material[:n] = materials
    return model, state, scratch_for(model, state)
