"""Checks of the particles and walls of a charge at the start: valid numbers, no deep overlap, no particle in
or behind a wall.
"""

import math

import numpy as np

from nutamill.base.errors import Fault
from nutamill.charge.filling.relax import near_pairs, size_octaves
from nutamill.charge.laws.pair import LawColumn
from nutamill.charge.walls.mesh import on_charge_side
from nutamill.charge.walls.surface import SurfaceKind
from nutamill.charge.walls.surfaces import place_surfaces
from nutamill.charge.walls.walls import wall_overlaps

LIMIT = int(LawColumn.LIMIT)

ONE_RADIUS = (SurfaceKind.CYLINDER, SurfaceKind.DISC, SurfaceKind.BALL)
"""Kinds of surfaces whose only size is a radius."""

RADIUS_AND_LENGTH = {SurfaceKind.TUBE: "height", SurfaceKind.ROD: "half height"}
"""Kinds of surfaces with a radius and a second size, by the name of that size."""

NAMED = 5
"""Worst offenders that a message names [1]."""


def named(ids) -> str:
    """Format numbers for a message: the first few, and how many more."""
    shown = ", ".join(str(int(i)) for i in ids[:NAMED])
    return shown + (f" and {len(ids) - NAMED} more" if len(ids) > NAMED else "")


def particle_faults(positions, radii, materials, densities) -> list[Fault]:
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


def pair_faults(positions, radii, materials, model, owner) -> list[Fault]:
    """Return particles that overlap beyond their limit at the start. The worst are named, by the `owner` of
    each sphere.
    """
    i, j = near_pairs(positions, size_octaves(radii))
    others = owner[i] != owner[j]
    i, j = i[others], j[others]
    if len(i) == 0:
        return []
    overlap = radii[i] + radii[j] - np.linalg.norm(positions[i] - positions[j], axis=1)
    share = overlap / (2.0 * np.minimum(radii[i], radii[j]))
    excess = share * model.laws[model.law_of[materials[i], materials[j]], LIMIT]
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


def wall_faults(positions, radii, materials, model, surfaces, poses, owner) -> list[Fault]:
    """Return particles that start inside or behind a surface. `owner` is the particle each sphere belongs to
    [1] (n,).
    """
    faults = []
    surface_poses = np.zeros((len(surfaces), 12))
    place_surfaces(model, poses, surface_poses)
    for s, surface in enumerate(surfaces):
        deep = np.empty(len(radii))
        wall_overlaps(model, surface_poses, s, positions, radii, deep)
        excess = deep / (2.0 * radii) * model.laws[model.law_of[materials, surface.material], LIMIT]
        bad = np.flatnonzero(excess > 1.0)
        if len(bad):
            bad = bad[np.argsort(-excess[bad])]
            what = (
                "particles must start inside, these overlap it beyond overlap_stop or lie behind it: "
                f"{named(owner[bad])}"
            )
            faults.append(Fault(f'surface "{surface.name}"', what, "Check the chamber's sizes and the fill"))
    return faults


def mesh_faults(positions, model, surfaces, poses, owner) -> list[Fault]:
    """Return particles that start behind a mesh at any distance. `owner` is that of `wall_faults`."""
    faults = []
    surface_poses = np.zeros((len(surfaces), 12))
    place_surfaces(model, poses, surface_poses)
    for s, surface in enumerate(surfaces):
        # the first patch of a mesh stands for all
        if surface.kind == SurfaceKind.MESH_PATCH and surface.patch == 0:
            rotation = surface_poses[s, 3:].reshape(3, 3)
            behind = np.flatnonzero(
                ~on_charge_side(surface.mesh, (positions - surface_poses[s, :3]) @ rotation)
            )
            if len(behind):
                what = f"particles must start {surface.mesh.keep} of it, these do not: {named(owner[behind])}"
                faults.append(
                    Fault(f'mesh "{surface.mesh.name}"', what, "Check its unit and place, and the fill")
                )
    return faults


def surface_faults(surfaces, n_bodies) -> list[Fault]:
    """Return surfaces with a missing body or with sizes out of range."""
    faults = []
    for surface in surfaces:
        where, (a, b, c), kind = f'surface "{surface.name}"', surface.size, surface.kind
        if not 0 <= surface.body < n_bodies:
            faults.append(Fault(where, f"body must be from 0 to {n_bodies - 1}, got {surface.body}"))
        if kind in ONE_RADIUS and not 0.0 < a < math.inf:
            faults.append(Fault(where, f"radius must be positive, got {a} m"))
        if kind in RADIUS_AND_LENGTH and not (0.0 < a < math.inf and 0.0 < b < math.inf):
            what = f"must have a positive radius and a positive {RADIUS_AND_LENGTH[kind]}, got {a} and {b} m"
            faults.append(Fault(where, what))
        if kind == SurfaceKind.BOX and not all(0.0 < half < math.inf for half in surface.size):
            faults.append(Fault(where, f"half sizes must be positive, got {surface.size} m"))
        if kind == SurfaceKind.CONE and not (
            0.0 <= a < math.inf and 0.0 <= b < math.inf and a + b > 0.0 and 0.0 < c < math.inf
        ):
            what = (
                f"must have two radii of at least 0, not both 0, and a positive height, got {a}, {b} and "
                f"{c} m"
            )
            faults.append(Fault(where, what, "A flat ring is a PLANE"))
        if kind == SurfaceKind.SPHERE_CAP and not (0.0 < a < math.inf and 0.0 < b <= math.pi):
            faults.append(
                Fault(
                    where, f"must have a positive radius and an angle from 0 to pi rad, got {a} m and {b} rad"
                )
            )
        if kind == SurfaceKind.MESH_PATCH and (
            surface.mesh is None or not 0 <= surface.patch < surface.mesh.n_patches
        ):
            faults.append(
                Fault(
                    where,
                    "must have a mesh and the number of one of its patches",
                    "Make it with mesh_surfaces",
                )
            )
    return faults


def extent(surface) -> float:
    """Return the largest size of a surface [m]."""
    if surface.kind == SurfaceKind.MESH_PATCH:
        return float(np.ptp(surface.mesh.vertices, axis=0).max())
    return surface.size[0] if surface.kind == SurfaceKind.SPHERE_CAP else max(surface.size)
