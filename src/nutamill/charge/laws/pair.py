"""Numbers of the contact law of a pair of materials, and the columns that the vector law reads."""

from dataclasses import dataclass
from enum import IntEnum


class LawColumn(IntEnum):
    """Columns of `ChargeModel.laws`: the numbers of a pair law as the vector law wants them."""

    COMPLIANCE = 0
    """Linear and hysteretic: 1/k of a stiffness given directly, else 0 [m/N].  Hertz: contact modulus E*
    [Pa].
    """
    COMPLIANCE_A = 1
    """Inverse of stiffness per diameter of the first material [m^2/N]."""
    COMPLIANCE_B = 2
    TANGENTIAL = 3
    """Tangential over normal stiffness [1]; Hertz: 4 G*/E*."""
    DAMPING = 4
    """Linear: twice the damping ratio [1].  Hysteretic: loading over unloading stiffness [1].  Hertz: 2
    sqrt(5/6) damping ratio [1].
    """
    FLOOR = 5
    """Least normal force [N]: 0, or minus infinity where tension is kept.  Hysteretic: least force over that
    of loading [1].
    """
    STATIC = 6
    DYNAMIC = 7
    ROLLING = 8
    LIMIT = 9
    """Inverse of overlap_stop [1]."""
    PRESSURE = 10
    """Cohesive pressure [Pa]."""


LAW_NUMBERS = len(LawColumn)
"""Numbers of a pair law [1]."""


@dataclass(frozen=True, slots=True)
class PairLaw:
    """Numbers of the contact of two materials, a and b (for a wall: a the particle, b the surface).

    Which of them count is for the charge's `ContactLaw` to say.

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
