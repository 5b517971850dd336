"""The inputs of the charge engine: particles in their beds among the walls of a machine, materials as pair
laws.
"""

import dataclasses
from typing import NamedTuple

import numpy as np

from nutamill.base.frames import quaternion_product, rotation_matrix
from nutamill.base.required import required
from nutamill.case.machine import Machine
from nutamill.case.materials import ContactPair
from nutamill.charge.assembly import charge_of
from nutamill.charge.kernels.dynamics import start
from nutamill.charge.laws.composition import ContactLaw, contact_law
from nutamill.charge.laws.impact import impact
from nutamill.charge.laws.oscillator import Impact, damping_ratio_from_restitution
from nutamill.charge.laws.pair import PairLaw
from nutamill.charge.model import ChargeModel, ChargeScratch, ChargeState
from nutamill.charge.particles.particles import Particles
from nutamill.charge.walls.patches import PatchTable
from nutamill.simulation.setup.carriers import carriers_of
from nutamill.simulation.setup.kinds import particle_kinds
from nutamill.simulation.setup.particles import charge_particles, quickest_pebble, region_bodies
from nutamill.simulation.setup.walls import material_order, region_corners, wall_surfaces

ROOM_TO_MOVE = 2.0
"""Half size of the domain, over the largest distance of any part of the machine from its middle [1]."""


def pair_laws(machine: Machine) -> dict[tuple[int, int], PairLaw]:
    """Return the laws of the charge with itself and with every wall, by the numbers of `particle_kinds`."""
    kinds = particle_kinds(machine)
    numbers = {
        tuple(sorted((a, b)))
        for pair in machine.touching
        for a in kinds.numbers(pair.first)
        for b in kinds.numbers(pair.second)
    }
    names = [kind.material for kind in kinds.kinds]
    return {(a, b): pair_law(machine, names[a], names[b]) for a, b in sorted(numbers)}


def contact_law_of(machine: Machine) -> ContactLaw:
    """Return the contact law that a machine names in its contact table."""
    contact = machine.contact
    return contact_law(contact.normal, contact.tangential, contact.rolling, contact.cohesion, contact.film)


def pair_law(machine: Machine, first: str, second: str) -> PairLaw:
    """Return the numbers of the law of two materials from the machine's contact table."""
    contact, pair = machine.contact, machine.contact.pair(first, second)
    direct, hysteretic = contact.stiffness == "direct", contact.normal == "hysteretic"
    softened = [contact.softening * machine.materials[name].young_modulus for name in (first, second)]
    modulus, shear = contact_moduli(
        softened, [machine.materials[name].poisson_ratio for name in (first, second)]
    )
    return PairLaw(
        stiffness_direct=required(pair.normal_stiffness) if direct else 0.0,
        stiffness_per_diameter_a=0.0 if direct else softened[0],
        stiffness_per_diameter_b=0.0 if direct else softened[1],
        tangential_ratio=pair.tangential_ratio,
        damping_ratio=0.0 if hysteretic else damping_ratio(machine, pair),
        tension_cut=contact.tension == "cut",
        static_friction=pair.sliding_friction,
        dynamic_friction=pair.sliding_friction,
        rolling_friction=pair.rolling_friction,
        overlap_warn=pair.overlap_warn,
        overlap_stop=pair.overlap_stop,
        unloading_ratio=required(pair.restitution) ** -2 if hysteretic else 1.0,
        contact_modulus=modulus,
        contact_shear_modulus=shear,
        cohesive_pressure=pair.cohesive_pressure or 0.0,
        tangential_damping=pair.tangential_damping or 0.0,
        rolling_stiffness=pair.rolling_stiffness or 0.0,
        liquid_viscosity=pair.liquid_viscosity or 0.0,
        film_thickness=pair.film_thickness or 0.0,
        film_roughness=pair.film_roughness or 0.0,
        bridge_volume=pair.bridge_volume or 0.0,
        surface_tension=pair.surface_tension or 0.0,
        contact_angle=pair.contact_angle or 0.0,
    )


def loading_share(machine: Machine, first: str, second: str, diameters: tuple[float, float]) -> float:
    """Return the share of the work of loading that the first of two bodies takes [1]: of two springs in
    series ``k_second/(k_first + k_second)``, half where one stiffness is given for both.

    Parameters
    ----------
    first, second : their materials
    diameters : of the two [m]; a wall takes the particle's
    """
    if machine.contact.normal == "hertz":
        softness = [
            (1.0 - machine.materials[name].poisson_ratio ** 2) / machine.materials[name].young_modulus
            for name in (first, second)
        ]
        return softness[0] / sum(softness)
    if machine.contact.stiffness == "direct":
        return 0.5
    stiffness = [
        machine.materials[name].young_modulus * d for name, d in zip((first, second), diameters, strict=True)
    ]
    return stiffness[1] / sum(stiffness)


def contact_moduli(young: list[float], poisson: list[float]) -> tuple[float, float]:
    """Return contact modulus E* and contact shear modulus G* [Pa] of two solids with these moduli [Pa] and
    Poisson's ratios [1].

    ``1/E* = sum (1 - nu^2)/E`` and ``1/G* = sum 2 (2 - nu)(1 + nu)/E``.  Source: K. L. Johnson, "Contact
    Mechanics", 1985, 4.2 and 7.2.
    """
    modulus = 1.0 / sum((1.0 - nu * nu) / e for e, nu in zip(young, poisson, strict=True))
    return modulus, 1.0 / sum(2.0 * (2.0 - nu) * (1.0 + nu) / e for e, nu in zip(young, poisson, strict=True))


class Meeting(NamedTuple):
    """A contact between two particles, or between a particle and a wall."""

    mass: float
    """Reduced mass [kg]."""
    radius: float
    """Reduced radius [m]."""
    diameter: float
    """Diameter of the first particle [m]."""
    other_diameter: float
    """Diameter of the second [m]; at a wall that of the first."""


def quickest_meeting(machine: Machine, first: str, second: str, wall: bool) -> Meeting:
    """Return the shortest contact of two materials."""
    one = quickest_pebble(machine, first)
    if wall:
        return Meeting(one.mass, one.diameter / 2, one.diameter, one.diameter)
    two = quickest_pebble(machine, second)
    mass, radius = 1 / (1 / one.mass + 1 / two.mass), 0.5 / (1 / one.diameter + 1 / two.diameter)
    return Meeting(mass, radius, one.diameter, two.diameter)


def impact_of(machine: Machine, first: str, second: str, wall: bool, v: float) -> Impact:
    """Return the head-on impact at `v` [m/s] of the particles of two materials with the shortest contact."""
    return impact(
        contact_law_of(machine),
        pair_law(machine, first, second),
        *quickest_meeting(machine, first, second, wall),
        v,
    )


def damping_ratio(machine: Machine, pair: ContactPair) -> float:
    """Return the damping ratio of a pair: as given, or from its restitution and the rule on tension."""
    if machine.contact.damping == "ratio":
        return required(pair.damping_ratio)
    return damping_ratio_from_restitution(required(pair.restitution), machine.contact.tension == "cut")


def machine_charge(
    machine: Machine,
    bed: np.ndarray,
    poses: np.ndarray,
    substep: float,
    patches: PatchTable | None = None,
) -> tuple[ChargeModel, ChargeState, ChargeScratch]:
    """Build the charge of a machine at rest in its beds: constants, state and work space.

    Parameters
    ----------
    bed : positions of the particles [m] (n, 3), or positions and attitudes (n, 7), each in the axes of the
        body of its region, from the mass centre
    poses : mass centre [m] and attitude of each carrier (n_carriers, 7), world
    substep : charge substep [s]
    patches : how the surfaces are cut, for the statistics; one patch each if None

    Raises
    ------
    CaseError : impossible particles, or particles that overlap each other or the walls
    """
    kinds, names = particle_kinds(machine), material_order(machine)
    built = charge_of(
        dataclasses.replace(placed_particles(machine, bed, poses), material=kinds.of_particles),
        [machine.materials[kind.material].density for kind in kinds.kinds],
        pair_laws(machine),
        [
            dataclasses.replace(surface, material=kinds.numbers(names[surface.material])[0])
            for surface in wall_surfaces(machine)
        ],
        len(poses),
        gravity=machine.gravity,
        law=contact_law_of(machine),
        domain=domain_of(machine),
        poses=poses,
        patches=patches,
        precision="single" if machine.charge.engine is None else "double",
    )
    start(*built, substep)
    return built


def placed_particles(machine: Machine, bed: np.ndarray, poses: np.ndarray) -> Particles:
    """Return the particles of a machine in their beds, world axes.

    Parameters
    ----------
    bed, poses : as `machine_charge`
    """
    positions, attitudes = np.empty((len(bed), 3)), None
    if bed.shape[1] > 3:
        attitudes = np.empty((len(bed), 4))
    for carrier, members in region_bodies(machine):
        pose, rotation = poses[carrier], np.empty((3, 3))
        rotation_matrix(pose[3:], rotation)
        positions[members] = pose[:3] + bed[members, :3] @ rotation.T
        if attitudes is not None:
            attitudes[members] = [quaternion_product(pose[3:], attitude) for attitude in bed[members, 3:]]
    return charge_particles(machine).placed(positions, attitudes)


def bed_in_carriers(
    machine: Machine, positions: np.ndarray, attitudes: np.ndarray | None, poses: np.ndarray
) -> np.ndarray:
    """Return a bed, as `machine_charge` takes it, of particles at positions [m] (n, 3) and with attitudes (n,
    4), world. It is the inverse of `placed_particles`.
    """
    bed = np.empty((len(positions), 3 if attitudes is None else 7))
    for carrier, members in region_bodies(machine):
        pose, rotation = poses[carrier], np.empty((3, 3))
        rotation_matrix(pose[3:], rotation)
        bed[members, :3] = (positions[members] - pose[:3]) @ rotation
        if attitudes is not None:
            back = pose[3:] * [1.0, -1.0, -1.0, -1.0]
            bed[members, 3:] = [quaternion_product(back, attitude) for attitude in attitudes[members]]
    return bed


def domain_of(machine: Machine) -> tuple[np.ndarray, float]:
    """Return middle [m] (3,) and half size [m] of a cube that the charge cannot leave while the machine holds
    together: `ROOM_TO_MOVE` times as far from the middle of the regions as its farthest part.
    """
    regions = np.concatenate([region_corners(machine, region) for region in machine.regions])
    middle = 0.5 * (regions.min(axis=0) + regions.max(axis=0))
    points = [*regions, *(carrier.position for carrier in carriers_of(machine) if carrier.name != "ground")]
    points += [joint.point for joint in machine.joints]
    reach = max(float(np.linalg.norm(np.asarray(point) - middle)) for point in points)
    return middle, ROOM_TO_MOVE * reach
