"""The particles of a case: number, size, shape and material, without positions."""

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
    """One sphere of a particle, as in a contact."""

    mass: float
    """Effective mass against a force through its centre [kg]; less than the particle's if that rotates it."""
    diameter: float
    """Diameter [m]."""


@functools.lru_cache(maxsize=4)
def charge_parts(case: Case) -> tuple[Particles, ...]:
    """Return the particles of each part of the charge, without positions, materials by their index in
    `Case.charge.materials`.
    """
    return tuple(_of_part(case, number, part) for number, part in enumerate(case.charge.parts))


@functools.lru_cache(maxsize=4)
def charge_particles(case: Case) -> Particles:
    """Return all particles of a charge that is not empty, part after part, without positions."""
    return joined(charge_parts(case))


def particle_count(case: Case) -> int:
    """Return the number of particles; 0 for an empty chamber [1]."""
    return sum(part.number for part in charge_parts(case))


def particle_masses(case: Case) -> np.ndarray:
    """Return the mass of each particle [kg] (n,)."""
    return charge_particles(case).mass([case.materials[name].density for name in case.charge.materials])


def charge_mass(case: Case) -> float:
    """Return the mass of all particles; 0 for an empty chamber [kg]."""
    return float(particle_masses(case).sum()) if case.charge.parts else 0.0


def with_charge_mass(case: Case) -> Case:
    """Return the case with the mass of its charge fixed to the chamber's base, where the rigid bars are."""
    if case.chamber.bars is None:
        raise CaseError(
            Fault(
                "chamber.bars",
                "is missing, so that the mass of the charge has no position",
                "Give radius and depth of a ring",
            )
        )
    return case.with_("chamber.bars.mass", case.chamber.bars_mass + charge_mass(case))


def quickest_pebble(case: Case, material: str) -> Pebble:
    """Return the pebble of a material with the shortest contacts.

    The duration grows with the root of mass over stiffness, and stiffness from Young's modulus grows with the
    diameter.
    """
    density, pebbles = case.materials[material].density, []
    for part, particles in zip(case.charge.parts, charge_parts(case), strict=True):
        if part.material != material:
            continue
        for number, shape in enumerate(particles.shapes):
            scale = particles.scale[particles.shape_of == number]
            if len(scale):
                masses = shape.push_mass() * density * scale.min() ** 3
                pebbles += [
                    Pebble(float(m), float(d))
                    for m, d in zip(masses, 2.0 * shape.radii * scale.min(), strict=True)
                ]
    by_diameter = case.contact.stiffness == "young"
    return min(pebbles, key=lambda pebble: pebble.mass / (pebble.diameter if by_diameter else 1.0))


def _of_part(case: Case, number: int, part: Portion) -> Particles:
    """Return the particles of one part; the seed decides which shape goes with which size."""
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
    """Return the shapes of a table of clumps, each a list of spheres (x, y, z, radius)."""
    return tuple(clump_shape([row[:3] for row in clump], [row[3] for row in clump]) for clump in rows)
