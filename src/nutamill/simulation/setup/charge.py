"""The inputs of the charge engine: the inside of a chamber as surfaces, materials as pair laws."""

import math
from typing import NamedTuple

import numpy as np

from nutamill.base.frames import quaternion_product, rotation_matrix
from nutamill.case import Case
from nutamill.case.materials import ContactPair
from nutamill.case.touching import wall_keys
from nutamill.charge.assembly import charge_of
from nutamill.charge.kernels.dynamics import start
from nutamill.charge.laws.composition import ContactLaw, contact_law
from nutamill.charge.laws.impact import impact
from nutamill.charge.laws.oscillator import Impact, damping_ratio_from_restitution
from nutamill.charge.laws.pair import PairLaw
from nutamill.charge.model import ChargeModel, ChargeScratch, ChargeState
from nutamill.charge.particles.particles import Particles
from nutamill.charge.walls.patches import PatchTable
from nutamill.charge.walls.surface import Surface, SurfaceKind
from nutamill.simulation.setup.particles import charge_particles, quickest_pebble
from nutamill.simulation.setup.rigid_parts import whole_chamber
from nutamill.simulation.setup.walls import chamber_mesh, meshes_surfaces, room_box

CHAMBER_CARRIER = 0
"""Index of the chamber among the bodies that carry surfaces [1]."""


def material_order(case: Case) -> list[str]:
    """Return the names of the materials of the charge, then of the walls it touches, in the order of their
    numbers in the engine.
    """
    return list(dict.fromkeys([*case.charge.materials, *wall_keys(case).values()]))


def chamber_surfaces(case: Case) -> list[Surface]:
    """Return bore, floor and ceiling, or the chamber's mesh, then ribs and meshed walls, in chamber axes from
    the mass centre of the whole chamber.
    """
    chamber, materials = case.chamber, material_order(case)
    mass_centre = whole_chamber(chamber).mass_centre
    wall = materials.index(chamber.material)
    floor = np.array([0.0, 0.0, -chamber.floor_depth]) - mass_centre
    ceiling = np.array([0.0, 0.0, -chamber.ceiling_depth]) - mass_centre
    radius = chamber.inner_diameter / 2
    upside_down = np.diag([1.0, -1.0, -1.0])
    meshed = meshes_surfaces(case, CHAMBER_CARRIER, materials, mass_centre)
    drawn = [
        Surface("bore", SurfaceKind.CYLINDER, CHAMBER_CARRIER, wall, floor, np.eye(3), (radius, 0.0, 0.0)),
        Surface("floor", SurfaceKind.PLANE, CHAMBER_CARRIER, wall, floor, np.eye(3), (0.0, 0.0, 0.0)),
        Surface("ceiling", SurfaceKind.PLANE, CHAMBER_CARRIER, wall, ceiling, upside_down, (0.0, 0.0, 0.0)),
    ]
    ribs = [_rib_surface(case, number, floor) for number in range(chamber.ribs)]
    return [*(drawn if chamber.mesh is None else []), *ribs, *meshed]


def _rib_surface(case: Case, number: int, floor: np.ndarray) -> Surface:
    """Return rib `number` as a box, which reaches as far into wall and floor as into the charge, so that
    there is no gap.
    """
    chamber, rib = case.chamber, case.chamber.rib
    rotation = rib_rotation(case, number)
    height = min(rib.length, chamber.height)
    centre = floor + rotation @ np.array([chamber.inner_diameter / 2, 0.0, (height - rib.depth) / 2])
    size = (rib.depth, rib.width / 2, (height + rib.depth) / 2)
    material = material_order(case).index(rib.material)
    return Surface(f"rib {number + 1}", SurfaceKind.BOX, CHAMBER_CARRIER, material, centre, rotation, size)


def rib_inside(case: Case, number: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the part of rib `number` inside the bore: centre [m] (3,), rotation (3, 3) and half sizes [m]
    (3,), in chamber axes from the nutation point.
    """
    chamber, rib = case.chamber, case.chamber.rib
    height = min(rib.length, chamber.height)
    rotation = rib_rotation(case, number)
    centre = rotation @ np.array(
        [chamber.inner_diameter / 2 - rib.depth / 2, 0.0, height / 2 - chamber.floor_depth]
    )
    return centre, rotation, np.array([rib.depth, rib.width, height]) / 2


def rib_rotation(case: Case, number: int) -> np.ndarray:
    """Return the rotation (3, 3) of the chamber's x axis to rib `number`."""
    angle = 2 * math.pi * number / case.chamber.ribs
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def pair_laws(case: Case) -> dict[tuple[int, int], PairLaw]:
    """Return the laws of the charge with itself and with every wall, by the numbers of `material_order`."""
    names = material_order(case)
    numbers = {tuple(sorted((names.index(pair.first), names.index(pair.second)))) for pair in case.touching}
    return {(a, b): pair_law(case, names[a], names[b]) for a, b in sorted(numbers)}


def contact_law_of(case: Case) -> ContactLaw:
    """Return the contact law that a case names in its contact table."""
    contact = case.contact
    return contact_law(contact.normal, contact.tangential, contact.rolling, contact.cohesion)


def pair_law(case: Case, first: str, second: str) -> PairLaw:
    """Return the numbers of the law of two materials from the case's contact table."""
    contact, pair = case.contact, case.contact.pair(first, second)
    direct, hysteretic = contact.stiffness == "direct", contact.normal == "hysteretic"
    softened = [contact.softening * case.materials[name].young_modulus for name in (first, second)]
    modulus, shear = contact_moduli(
        softened, [case.materials[name].poisson_ratio for name in (first, second)]
    )
    return PairLaw(
        stiffness_direct=pair.normal_stiffness if direct else 0.0,
        stiffness_per_diameter_a=0.0 if direct else softened[0],
        stiffness_per_diameter_b=0.0 if direct else softened[1],
        tangential_ratio=pair.tangential_ratio,
        damping_ratio=0.0 if hysteretic else damping_ratio(case, pair),
        tension_cut=contact.tension == "cut",
        static_friction=pair.sliding_friction,
        dynamic_friction=pair.sliding_friction,
        rolling_friction=pair.rolling_friction,
        overlap_warn=pair.overlap_warn,
        overlap_stop=pair.overlap_stop,
        unloading_ratio=pair.restitution**-2 if hysteretic else 1.0,
        contact_modulus=modulus,
        contact_shear_modulus=shear,
        cohesive_pressure=pair.cohesive_pressure or 0.0,
    )


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


def quickest_meeting(case: Case, first: str, second: str, wall: bool) -> Meeting:
    """Return the shortest contact of two materials."""
    one = quickest_pebble(case, first)
    if wall:
        return Meeting(one.mass, one.diameter / 2, one.diameter, one.diameter)
    two = quickest_pebble(case, second)
    mass, radius = 1 / (1 / one.mass + 1 / two.mass), 0.5 / (1 / one.diameter + 1 / two.diameter)
    return Meeting(mass, radius, one.diameter, two.diameter)


def impact_of(case: Case, first: str, second: str, wall: bool, v: float) -> Impact:
    """Return the head-on impact at `v` [m/s] of the particles of two materials with the shortest contact."""
    return impact(
        contact_law_of(case), pair_law(case, first, second), *quickest_meeting(case, first, second, wall), v
    )


def damping_ratio(case: Case, pair: ContactPair) -> float:
    """Return the damping ratio of a pair: as given, or from its restitution and the rule on tension."""
    if case.contact.damping == "ratio":
        return pair.damping_ratio
    return damping_ratio_from_restitution(pair.restitution, case.contact.tension == "cut")


def chamber_charge(
    case: Case,
    bed: np.ndarray,
    position: np.ndarray,
    quaternion: np.ndarray,
    substep: float,
    patches: PatchTable | None = None,
) -> tuple[ChargeModel, ChargeState, ChargeScratch]:
    """Build the charge of a case at rest in its chamber: constants, state and work space.

    Parameters
    ----------
    bed : positions of the particles [m] (n, 3), or positions and attitudes (n, 7), in chamber axes from the
        nutation point
    position, quaternion : mass centre [m] (3,) and attitude (4,) of the chamber, world
    substep : charge substep [s]
    patches : how the surfaces are cut, for the statistics; one patch each if None

    Raises
    ------
    CaseError : impossible particles, or particles that overlap each other or the chamber
    """
    names = material_order(case)
    densities = [case.materials[name].density for name in names]
    rotation = np.empty((3, 3))
    rotation_matrix(np.asarray(quaternion, float), rotation)
    particles = placed_particles(case, bed, position, np.asarray(quaternion, float))
    middle = position + rotation @ (chamber_middle(case) - whole_chamber(case.chamber).mass_centre)
    built = charge_of(
        particles,
        densities,
        pair_laws(case),
        chamber_surfaces(case),
        1,
        gravity=(0.0, 0.0, -case.mechanism.gravity),
        law=contact_law_of(case),
        domain=(middle, chamber_reach(case)),
        poses=np.concatenate([position, quaternion])[None, :],
        patches=patches,
    )
    start(*built, substep)
    return built


def placed_particles(case: Case, bed: np.ndarray, position: np.ndarray, quaternion: np.ndarray) -> Particles:
    """Return the particles of a case in their bed, world axes from the nutation point.

    Parameters
    ----------
    bed, position, quaternion : as `chamber_charge`
    """
    rotation = np.empty((3, 3))
    rotation_matrix(quaternion, rotation)
    positions = position + (bed[:, :3] - whole_chamber(case.chamber).mass_centre) @ rotation.T
    attitudes = None
    if bed.shape[1] > 3:
        attitudes = np.array([quaternion_product(quaternion, attitude) for attitude in bed[:, 3:]])
    return charge_particles(case).placed(positions, attitudes)


def chamber_middle(case: Case) -> np.ndarray:
    """Return the middle of the space inside [m] (3,), in chamber axes from the nutation point."""
    return room_box(case).mean(axis=0)


def chamber_reach(case: Case) -> float:
    """Return the half size [m] of a cube about the chamber's middle that the charge cannot leave.

    Half the diagonal of the chamber, the swing of its middle, and as much again for the sway on the mounts.
    """
    chamber = case.chamber
    swing = (
        2 * case.mechanism.crank_radius * -chamber_middle(case)[2] / case.mechanism.nutation_point_to_crank
    )
    half = math.hypot(chamber.inner_diameter, chamber.height) / 2
    if chamber.mesh is not None:
        half = float(
            np.linalg.norm(chamber_mesh(case).vertices + chamber.mesh.at - chamber_middle(case), axis=1).max()
        )
    return half + 2 * abs(swing)
