"""From the numbers of a pair of materials to those its laws compute with."""

import math

from nutamill.charge.laws.pair import PairLaw
from nutamill.charge.laws.tags import AreaCohesion, ContactLaw, HertzSpring, HystereticSpring

LEAST_FORCE = 0.001
"""Least force of a hysteretic contact over that of loading [1]. Source: Ansys Rocky, DEM Technical Manual."""

TINY = 1e-36
"""Added to a square whose root divides [SI]: compilers may take an estimate of such a root, which is infinite
below 1e-38.
"""


def law_numbers(law: ContactLaw, pair: PairLaw) -> list[float]:
    """The numbers of a pair for the laws of a charge, in the order of `LawColumn`."""
    floor = 0.0 if pair.tension_cut else -math.inf
    if isinstance(law.normal, HertzSpring):
        # Mindlin's 8 G* sqrt(R* d) over the tangent stiffness 2 E* sqrt(R* d)
        ratio = pair.tangential_ratio * 4.0 * pair.contact_shear_modulus / pair.contact_modulus
        normal = [
            pair.contact_modulus,
            0.0,
            0.0,
            ratio,
            2.0 * math.sqrt(5.0 / 6.0) * pair.damping_ratio,
            floor,
        ]
    else:
        direct = pair.stiffness_direct > 0.0
        compliance = [
            1.0 / pair.stiffness_direct if direct else 0.0,
            0.0 if direct else 1.0 / pair.stiffness_per_diameter_a,
            0.0 if direct else 1.0 / pair.stiffness_per_diameter_b,
        ]
        hysteretic = isinstance(law.normal, HystereticSpring)
        own = [1.0 / pair.unloading_ratio, LEAST_FORCE] if hysteretic else [2.0 * pair.damping_ratio, floor]
        normal = [*compliance, pair.tangential_ratio, *own]
    return [
        *normal,
        pair.static_friction,
        pair.dynamic_friction,
        pair.rolling_friction,
        1.0 / pair.overlap_stop,
        pair.cohesive_pressure,
    ]


def law_faults(law: ContactLaw, pair: PairLaw) -> list[tuple[str, str]]:
    """What a pair lacks for the laws of a charge, and what to write instead."""
    faults = []
    if isinstance(law.normal, HertzSpring):
        if not (pair.contact_modulus > 0.0 and pair.contact_shear_modulus > 0.0):
            got = f"{pair.contact_modulus:g} and {pair.contact_shear_modulus:g} Pa"
            hint = "Work them out from Young's modulus and Poisson's ratio of the two"
            faults.append((f"Hertz needs contact_modulus and contact_shear_modulus above 0, got {got}", hint))
    elif not (
        pair.stiffness_direct > 0.0 or min(pair.stiffness_per_diameter_a, pair.stiffness_per_diameter_b) > 0.0
    ):
        faults.append(
            (
                "the normal spring needs a stiffness above 0, got none",
                "Give stiffness_direct, or one for each body",
            )
        )
    if isinstance(law.normal, HystereticSpring) and not pair.unloading_ratio >= 1.0:
        what = f"unloading_ratio must be 1 or more, got {pair.unloading_ratio:g}"
        faults.append((what, "For a restitution e write 1/e^2"))
    if not isinstance(law.normal, HystereticSpring) and not pair.damping_ratio >= 0.0:
        faults.append((f"damping_ratio must be 0 or more, got {pair.damping_ratio:g}", ""))
    if not isinstance(law.cohesion, AreaCohesion) and pair.cohesive_pressure != 0.0:
        faults.append(
            (
                f"cohesive_pressure {pair.cohesive_pressure:g} Pa has no cohesive law",
                "Choose area cohesion, or write 0",
            )
        )
    return faults
