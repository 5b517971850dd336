"""Numbers of the contact of two materials, the row of them that the vector law reads, and the springs of the
two bodies in series.
"""

from dataclasses import dataclass
from enum import IntEnum

from nutamill.base.kernel import kernel


class LawColumn(IntEnum):
    """Columns of `ChargeModel.laws`: the numbers of a pair as the vector law reads them."""

    NORMAL = 0
    """First of the `NORMAL_NUMBERS` that the normal law reads, as its file declares them."""
    TANGENTIAL = 5
    """Tangential over normal stiffness [1]."""
    STATIC = 6
    DYNAMIC = 7
    ROLLING = 8
    LIMIT = 9
    """Inverse of overlap_stop [1]."""
    PRESSURE = 10
    """Cohesive pressure [Pa]."""
    TANGENTIAL_DASHPOT = 11
    """Twice the tangential damping ratio [1]."""
    ROLLING_STIFFNESS = 12
    """Stiffness of a rolling spring that is given by itself [N m/rad]."""


NORMAL_NUMBERS = 5
"""Numbers that a normal law may read [1]."""

LAW_NUMBERS = len(LawColumn) + NORMAL_NUMBERS - 1
"""Numbers of a pair [1]."""

FILM_NUMBERS = 3
"""Numbers of the film of a pair [1]: 6 pi times its viscosity [Pa s], its thickness and roughness [m]."""

BRIDGE_NUMBERS = 4
"""Numbers of the bridge of a pair behind those of its film [1], as `capillary.numbers`; with bridges only."""


@dataclass(frozen=True, slots=True)
class PairLaw:
    """Numbers of the contact of two materials, a and b (for a wall: a the particle, b the surface).

    Which of them a contact reads depends on the charge's `ContactLaw`.

    Attributes
    ----------
    stiffness_direct : normal (hysteretic: loading) stiffness [N/m]; 0 to take the series of the bodies' own
    stiffness_per_diameter_a, stiffness_per_diameter_b : own stiffness of each body over the particle's
        diameter [N/m^2]
    tangential_ratio : tangential over normal (hysteretic: loading) stiffness [1]; Hertz: over Mindlin's 8 G*
        sqrt(R* d)
    damping_ratio : of critical damping [1]; not for hysteretic
    tension_cut : True clips the normal force at zero on release; not for hysteretic, which never pulls
    static_friction, dynamic_friction : Coulomb coefficient before and while sliding [1]
    rolling_friction : lever of the rolling moment over the reduced radius [1]
    overlap_warn, overlap_stop : share of the (smaller) particle's diameter [1]
    unloading_ratio : hysteretic: unloading over loading stiffness [1]
    contact_modulus : Hertz: E*, 1/E* = (1 - nu_a^2)/E_a + (1 - nu_b^2)/E_b [Pa]
    contact_shear_modulus : Hertz: G*, 1/G* = (2 - nu_a)/G_a + (2 - nu_b)/G_b [Pa]
    cohesive_pressure : area cohesion: pull over contact area [Pa]
    tangential_damping : friction with a dashpot: dashpot over ``2 sqrt(m* k_t)``, m* the reduced mass [1]
    rolling_stiffness : type C direct: rolling moment over rolling angle [N m/rad]
    liquid_viscosity : viscous film: dynamic viscosity [Pa s]; 0 where the pair is dry
    film_thickness, film_roughness : viscous film: separation at which it begins, and at which the solids
        touch [m]
    bridge_volume : capillary: volume of the liquid of each bridge [m^3]; 0 where the pair has none
    surface_tension : capillary: of the liquid [N/m]
    contact_angle : capillary: of the liquid on the solids [rad]
    """

    stiffness_direct: float
    stiffness_per_diameter_a: float
    stiffness_per_diameter_b: float
    tangential_ratio: float
    damping_ratio: float
    tension_cut: bool
    static_friction: float
    dynamic_friction: float
    rolling_friction: float
    overlap_warn: float
    overlap_stop: float
    unloading_ratio: float = 1.0
    contact_modulus: float = 0.0
    contact_shear_modulus: float = 0.0
    cohesive_pressure: float = 0.0
    tangential_damping: float = 0.0
    rolling_stiffness: float = 0.0
    liquid_viscosity: float = 0.0
    film_thickness: float = 0.0
    film_roughness: float = 0.0
    bridge_volume: float = 0.0
    surface_tension: float = 0.0
    contact_angle: float = 0.0


@kernel(inline="always")
def pair_stiffness(compliance, compliance_a, compliance_b, diameters):
    """Return the normal stiffness k of a pair: given directly, or two springs in series whose stiffness grows
    with the diameter.

    ``1/k = compliance + compliance_a/diameter_a + compliance_b/diameter_b``

    Parameters
    ----------
    compliance : 1/k where k is given directly, else 0 [m/N]
    compliance_a, compliance_b : inverse of stiffness per diameter [m^2/N]; 0 where k is given directly
    diameters : of the two particles [m] (2); a wall takes the particle's

    Returns
    -------
    k [N/m]

    Source
    ------
    Ansys Rocky, DEM Solver SDK manual: K = E L of each entity, in series.
    """
    both = diameters[0] * diameters[1]
    return both / (compliance * both + compliance_a * diameters[1] + compliance_b * diameters[0])


def compliances(pair: PairLaw) -> list[float]:
    """Return the three compliances of `pair_stiffness`."""
    if pair.stiffness_direct > 0.0:
        return [1.0 / pair.stiffness_direct, 0.0, 0.0]
    return [0.0, 1.0 / pair.stiffness_per_diameter_a, 1.0 / pair.stiffness_per_diameter_b]


def spring_stiffness(pair: PairLaw, diameter_a: float, diameter_b: float) -> float:
    """Return the normal stiffness [N/m] of a linear or hysteretic pair. A wall has the particle's diameter
    [m].
    """
    if pair.stiffness_direct > 0.0:
        return pair.stiffness_direct
    return 1.0 / (
        1.0 / (pair.stiffness_per_diameter_a * diameter_a)
        + 1.0 / (pair.stiffness_per_diameter_b * diameter_b)
    )


def spring_faults(pair: PairLaw) -> list[tuple[str, str]]:
    """Return what a linear or hysteretic pair lacks of its spring, and what to write instead."""
    if pair.stiffness_direct > 0.0 or min(pair.stiffness_per_diameter_a, pair.stiffness_per_diameter_b) > 0.0:
        return []
    what = "the normal spring needs a stiffness above 0, got none"
    return [(what, "Give stiffness_direct, or one for each body")]


def dashpot_faults(pair: PairLaw) -> list[tuple[str, str]]:
    """Return what is wrong with the dashpot of a pair."""
    if pair.damping_ratio >= 0.0:
        return []
    return [(f"damping_ratio must be 0 or more, got {pair.damping_ratio:g}", "")]
