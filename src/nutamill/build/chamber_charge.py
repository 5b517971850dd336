"""The inside of a chamber as surfaces, and a case's materials as pair laws: what the charge engine is built from."""

import math

import numpy as np

from nutamill.build.charge_mix import charge_particles, quickest_pebble
from nutamill.build.rigid_parts import whole_chamber
from nutamill.case import Case
from nutamill.charge.assembly import charge_of
from nutamill.charge.contact_terms import damping_ratio_from_restitution, series_stiffness
from nutamill.charge.dynamics import start
from nutamill.charge.model import ChargeModel, ChargeScratch, ChargeState, PairLaw, RollingLaw, Surface, SurfaceKind
from nutamill.charge.particles import Particles
from nutamill.frames import quaternion_product, rotation_matrix
from nutamill.materials import ContactPair

ROLLING = {"none": RollingLaw.NONE, "type_a": RollingLaw.TYPE_A, "type_c": RollingLaw.TYPE_C}
CHAMBER_CARRIER = 0
"""Number of the chamber among the bodies that carry surfaces."""


def material_order(case: Case) -> list[str]:
    """Names of the materials the charge touches, the charge's own first; their place is their number in the engine."""
    names = [*case.charge.materials, case.chamber.material]
    if case.chamber.ribs:
        names.append(case.chamber.rib.material)
    return list(dict.fromkeys(names))


def chamber_surfaces(case: Case) -> list[Surface]:
    """Bore, floor, ceiling and ribs, in chamber axes from the mass centre of the whole chamber."""
    chamber, materials = case.chamber, material_order(case)
    mass_centre = whole_chamber(chamber).mass_centre
    wall = materials.index(chamber.material)
    floor = np.array([0.0, 0.0, -chamber.floor_depth]) - mass_centre
    ceiling = np.array([0.0, 0.0, -chamber.ceiling_depth]) - mass_centre
    radius = chamber.inner_diameter / 2
    upside_down = np.diag([1.0, -1.0, -1.0])
    surfaces = [
        Surface("bore", SurfaceKind.CYLINDER, CHAMBER_CARRIER, wall, floor, np.eye(3), (radius, 0.0, 0.0)),
        Surface("floor", SurfaceKind.PLANE, CHAMBER_CARRIER, wall, floor, np.eye(3), (0.0, 0.0, 0.0)),
        Surface("ceiling", SurfaceKind.PLANE, CHAMBER_CARRIER, wall, ceiling, upside_down, (0.0, 0.0, 0.0)),
    ]
    for number in range(chamber.ribs):
        surfaces.append(_rib_surface(case, number, floor))
    return surfaces


def _rib_surface(case: Case, number: int, floor: np.ndarray) -> Surface:
    """Rib `number` as a box; it reaches as far into the wall and the floor as into the charge, so that no gap is left."""
    chamber, rib = case.chamber, case.chamber.rib
    rotation = rib_rotation(case, number)
    height = min(rib.length, chamber.height)
    centre = floor + rotation @ np.array([chamber.inner_diameter / 2, 0.0, (height - rib.depth) / 2])
    size = (rib.depth, rib.width / 2, (height + rib.depth) / 2)
    material = material_order(case).index(rib.material)
    return Surface(f"rib {number + 1}", SurfaceKind.BOX, CHAMBER_CARRIER, material, centre, rotation, size)


def rib_inside(case: Case, number: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The part of rib `number` that stands inside the bore: centre [m] (3,), rotation (3, 3) and half sizes [m] (3,), in chamber
    axes from the nutation point."""
    chamber, rib = case.chamber, case.chamber.rib
    height = min(rib.length, chamber.height)
    rotation = rib_rotation(case, number)
    centre = rotation @ np.array([chamber.inner_diameter / 2 - rib.depth / 2, 0.0, height / 2 - chamber.floor_depth])
    return centre, rotation, np.array([rib.depth, rib.width, height]) / 2


def rib_rotation(case: Case, number: int) -> np.ndarray:
    """Rotation (3, 3) that turns the chamber's x axis to rib `number`."""
    angle = 2 * math.pi * number / case.chamber.ribs
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def pair_laws(case: Case) -> dict[tuple[int, int], PairLaw]:
    """Laws of the charge with itself and with every wall, by the numbers of `material_order`."""
    names, own = material_order(case), len(case.charge.materials)
    return {(a, b): pair_law(case, names[a], names[b]) for a in range(own) for b in range(a, len(names))}


def pair_law(case: Case, first: str, second: str) -> PairLaw:
    """Law of two materials from the case's contact table."""
    contact, pair = case.contact, case.contact.pair(first, second)
    direct = contact.stiffness == "direct"
    softened = [0.0 if direct else contact.softening * case.materials[name].young_modulus for name in (first, second)]
    return PairLaw(
        stiffness_direct=pair.normal_stiffness if direct else 0.0,
        stiffness_per_diameter_a=softened[0],
        stiffness_per_diameter_b=softened[1],
        tangential_ratio=pair.tangential_ratio,
        damping_ratio=damping_ratio(case, pair),
        tension_cut=contact.tension == "cut",
        static_friction=pair.sliding_friction,
        dynamic_friction=pair.sliding_friction,
        rolling_friction=pair.rolling_friction,
        overlap_warn=pair.overlap_warn,
        overlap_stop=pair.overlap_stop,
    )


def pair_stiffness_of(case: Case, first: str, second: str) -> float:
    """Normal stiffness [N/m] of a material of the charge and another, for the particles with the shortest contacts.

    A material that only walls are of counts with the particle's diameter.
    """
    own = quickest_pebble(case, first).diameter
    other = quickest_pebble(case, second).diameter if second in case.charge.materials else own
    law = pair_law(case, first, second)
    return law.stiffness_direct or series_stiffness(law.stiffness_per_diameter_a, law.stiffness_per_diameter_b, own, other)


def damping_ratio(case: Case, pair: ContactPair) -> float:
    """Dashpot over its critical value: as given, or from the restitution for the case's rule on tension."""
    if case.contact.damping == "ratio":
        return pair.damping_ratio
    return damping_ratio_from_restitution(pair.restitution, case.contact.tension == "cut")


def chamber_charge(
    case: Case, bed: np.ndarray, position: np.ndarray, quaternion: np.ndarray, substep: float
) -> tuple[ChargeModel, ChargeState, ChargeScratch]:
    """The charge of a case at rest in its chamber, ready to march.

    Parameters
    ----------
    bed : places of the particles [m] (n, 3), or places and attitudes (n, 7), in chamber axes from the nutation point
    position, quaternion : mass centre [m] (3,) and attitude (4,) of the chamber, world
    substep : charge substep [s]

    Raises
    ------
    CaseError : particles that cannot be, or that overlap each other or the chamber
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
        rolling=ROLLING[case.contact.rolling],
        domain=(middle, chamber_reach(case)),
        poses=np.concatenate([position, quaternion])[None, :],
    )
    start(*built, substep)
    return built


def placed_particles(case: Case, bed: np.ndarray, position: np.ndarray, quaternion: np.ndarray) -> Particles:
    """The particles of a case in their bed, world axes from the nutation point.

    Parameters
    ----------
    bed, position, quaternion : as `chamber_charge`
    """
    rotation = np.empty((3, 3))
    rotation_matrix(quaternion, rotation)
    places = position + (bed[:, :3] - whole_chamber(case.chamber).mass_centre) @ rotation.T
    turned = None if bed.shape[1] == 3 else np.array([quaternion_product(quaternion, own) for own in bed[:, 3:]])
    return charge_particles(case).placed(places, turned)


def chamber_middle(case: Case) -> np.ndarray:
    """Middle of the space inside [m] (3,), in chamber axes from the nutation point."""
    return np.array([0.0, 0.0, -case.chamber.floor_depth + case.chamber.height / 2])


def chamber_reach(case: Case) -> float:
    """Half size [m] of a cube about the chamber's middle that the charge cannot leave as long as the walls hold.

    Half the diagonal of the chamber, the swing of its middle, and as much again for the sway on the mounts.
    """
    chamber = case.chamber
    swing = 2 * case.mechanism.crank_radius * (chamber.floor_depth - chamber.height / 2) / case.mechanism.nutation_point_to_crank
    return math.hypot(chamber.inner_diameter, chamber.height) / 2 + 2 * swing
