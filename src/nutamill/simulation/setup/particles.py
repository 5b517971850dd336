"""The particles a case asks for: how many, of what size, shape and material; not yet where."""

import functools
from typing import NamedTuple

import numpy as np

from nutamill.base.errors import CaseError, Fault
from nutamill.case import Case
from nutamill.case.charge import Portion
from nutamill.charge.particles.particles import Particles, clumps, joined, spheres
from nutamill.charge.particles.shapes import ClumpShape, clump_shape
from nutamill.simulation.setup.walls import free_volume


class Pebble(NamedTuple):
    """One sphere of a particle, as a contact feels it."""

    mass: float
    """Mass with which it resists a push through its centre [kg]; less than the particle's where that makes
    the particle turn.
    """
    diameter: float
    """Its diameter [m]."""


@functools.lru_cache(maxsize=4)
def charge_parts(case: Case) -> tuple[Particles, ...]:
    """Particles of each part of the charge, not placed yet; their materials are numbered as in
    `Case.charge.materials`.
    """
    return tuple(_of_part(case, number, part) for number, part in enumerate(case.charge.parts))


@functools.lru_cache(maxsize=4)
def charge_particles(case: Case) -> Particles:
    """All particles of the charge, part after part, not placed yet; the charge must not be empty."""
    return joined(charge_parts(case))


def particle_count(case: Case) -> int:
    """Number of particles; 0 for an empty chamber [1]."""
    return sum(part.number for part in charge_parts(case))


def particle_masses(case: Case) -> np.ndarray:
    """Mass of each particle [kg] (n,)."""
    return charge_particles(case).mass([case.materials[name].density for name in case.charge.materials])


def charge_mass(case: Case) -> float:
    """Mass of all particles; 0 for an empty chamber [kg]."""
    return float(particle_masses(case).sum()) if case.charge.parts else 0.0


def with_charge_mass(case: Case) -> Case:
    """The case with the mass of its charge fixed to the chamber's base, where the rigid bars are."""
    if case.chamber.bars is None:
        raise CaseError(
            Fault(
                "chamber.bars",
                "is missing, and says where the charge's mass would be",
                "Give radius and depth of a ring",
            )
        )
    return case.with_("chamber.bars.mass", case.chamber.bars_mass + charge_mass(case))


def quickest_pebble(case: Case, material: str) -> Pebble:
    """The pebble of a material whose contacts are shortest.

    The duration grows with the root of mass over stiffness; the stiffness, where it comes from Young's
    modulus, with the diameter.
    """
    density, found = case.materials[material].density, []
    for part, particles in zip(case.charge.parts, charge_parts(case), strict=True):
        if part.material != material:
            continue
        for number, shape in enumerate(particles.shapes):
            scale = particles.scale[particles.shape_of == number]
            if len(scale):
                masses = shape.push_mass() * density * scale.min() ** 3
                found += [
                    Pebble(float(m), float(d))
                    for m, d in zip(masses, 2.0 * shape.radii * scale.min(), strict=True)
                ]
    by_diameter = case.contact.stiffness == "young"
    return min(found, key=lambda pebble: pebble.mass / (pebble.diameter if by_diameter else 1.0))


def _of_part(case: Case, number: int, part: Portion) -> Particles:
    """The particles of one part; the seed tells which shape goes with which size."""
    law, material = part.size_law(), case.charge.materials.index(part.material)
    if part.count is not None:
        diameters = law.of_number(part.count)
    else:
        diameters = law.of_volume(part.solid_volume(case.materials[part.material].density, free_volume(case)))
    if part.kind == "spheres":
        return spheres(diameters, material)
    return clumps(_shapes(part.shapes.clumps), diameters, material, case.run.seed + number)


@functools.lru_cache(maxsize=16)
def _shapes(rows: tuple[tuple[tuple[float, ...], ...], ...]) -> tuple[ClumpShape, ...]:
    """Shapes of a table of clumps, each a list of spheres (x, y, z, radius)."""
    return tuple(clump_shape([row[:3] for row in clump], [row[3] for row in clump]) for clump in rows)
