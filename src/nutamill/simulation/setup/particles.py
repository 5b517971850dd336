"""The particles of a machine: number, size, shape and material, without positions."""

import functools
from typing import NamedTuple

import numpy as np

from nutamill.base.required import required
from nutamill.case.charge import Portion
from nutamill.case.machine import Machine
from nutamill.charge.particles.particles import Particles, clumps, joined, spheres
from nutamill.charge.particles.shapes import ClumpShape, clump_shape
from nutamill.simulation.setup.carriers import carrier_index
from nutamill.simulation.setup.regions import free_volume, region_of


class Pebble(NamedTuple):
    """One sphere of a particle, as in a contact."""

    mass: float
    """Effective mass against a force through its centre [kg]; less than the particle's if that rotates it."""
    diameter: float
    """Diameter [m]."""


@functools.lru_cache(maxsize=4)
def charge_parts(machine: Machine) -> tuple[Particles, ...]:
    """Return the particles of each part of the charge, without positions, materials by their index in
    `Machine.charge.materials`.
    """
    return tuple(_of_part(machine, number, part) for number, part in enumerate(machine.charge.parts))


@functools.lru_cache(maxsize=4)
def charge_particles(machine: Machine) -> Particles:
    """Return all particles of a charge that is not empty, part after part, without positions."""
    return joined(charge_parts(machine))


def particle_count(machine: Machine) -> int:
    """Return the number of particles, or 0 without a charge [1]."""
    return sum(part.number for part in charge_parts(machine))


def particle_masses(machine: Machine) -> np.ndarray:
    """Return the mass of each particle [kg] (n,)."""
    return charge_particles(machine).mass(
        [machine.materials[name].density for name in machine.charge.materials]
    )


def charge_mass(machine: Machine) -> float:
    """Return the mass of all particles, or 0 without a charge [kg]."""
    return float(particle_masses(machine).sum()) if machine.charge.parts else 0.0


def region_bodies(machine: Machine) -> list[tuple[int, slice]]:
    """Return the carrier on whose body each part of the charge is at the start, and the particles of the
    part, part after part.
    """
    bodies, first = [], 0
    for part, particles in zip(machine.charge.parts, charge_parts(machine), strict=True):
        carrier = carrier_index(machine, region_of(machine, part).body)
        bodies.append((carrier, slice(first, first + particles.number)))
        first += particles.number
    return bodies


def quickest_pebble(machine: Machine, material: str) -> Pebble:
    """Return the pebble of a material with the shortest contacts.

    The duration grows with the root of mass over stiffness, and stiffness from Young's modulus grows with the
    diameter.
    """
    density, pebbles = machine.materials[material].density, []
    for part, particles in zip(machine.charge.parts, charge_parts(machine), strict=True):
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
    by_diameter = machine.contact.stiffness == "young"
    return min(pebbles, key=lambda pebble: pebble.mass / (pebble.diameter if by_diameter else 1.0))


def _of_part(machine: Machine, number: int, part: Portion) -> Particles:
    """Return the particles of one part. The seed decides which shape goes with which size."""
    law, material = part.size_law(), machine.charge.materials.index(part.material)
    if part.count is not None:
        diameters = law.of_number(part.count)
    else:
        density, free = (
            machine.materials[required(part.material)].density,
            free_volume(machine, region_of(machine, part)),
        )
        diameters = law.of_volume(part.solid_volume(density, free))
    if part.kind == "spheres":
        return spheres(diameters, material)
    return clumps(_shapes(required(part.shapes).clumps), diameters, material, machine.run.seed + number)


@functools.lru_cache(maxsize=16)
def _shapes(rows: tuple[tuple[tuple[float, ...], ...], ...]) -> tuple[ClumpShape, ...]:
    """Return the shapes of a table of clumps, each a list of spheres (x, y, z, radius)."""
    return tuple(clump_shape([row[:3] for row in clump], [row[3] for row in clump]) for clump in rows)
