"""The contact laws that a case may name, and which numbers of a pair each of them reads.

The laws themselves are the files of `nutamill.charge.laws`, which a case must not import, because they bring
the compiler along.  `tests/contracts/test_contact_laws_agree.py` compares the two.
"""

from typing import Literal

Normal = Literal["linear", "hysteretic", "hertz"]
Tangential = Literal["displacement", "incremental", "incremental_dashpot"]
Rolling = Literal["type_a", "type_c", "type_c_direct", "none"]
Cohesion = Literal["none", "area"]
Film = Literal["none", "viscous", "capillary"]

FILM_NUMBERS = frozenset({"liquid_viscosity", "film_thickness", "film_roughness"})
"""Numbers of a `ContactPair` that a viscous film reads; beside bridges they may be left out."""

READS: dict[str, dict[str, frozenset[str]]] = {
    "normal": {
        "linear": frozenset({"normal_stiffness", "restitution", "damping_ratio", "tangential_ratio"}),
        "hysteretic": frozenset({"normal_stiffness", "restitution", "tangential_ratio"}),
        "hertz": frozenset({"restitution", "damping_ratio", "tangential_ratio"}),
    },
    "tangential": {
        "displacement": frozenset({"sliding_friction"}),
        "incremental": frozenset({"sliding_friction"}),
        "incremental_dashpot": frozenset({"sliding_friction", "tangential_damping"}),
    },
    "rolling": {
        "none": frozenset(),
        "type_a": frozenset({"rolling_friction"}),
        "type_c": frozenset({"rolling_friction"}),
        "type_c_direct": frozenset({"rolling_friction", "rolling_stiffness"}),
    },
    "cohesion": {"none": frozenset(), "area": frozenset({"cohesive_pressure"})},
    "film": {
        "none": frozenset(),
        "viscous": FILM_NUMBERS,
        "capillary": FILM_NUMBERS | {"bridge_volume", "surface_tension", "contact_angle"},
    },
}
"""Numbers of a `ContactPair` that each law reads, by the key of ``[contact]`` and the name of the law."""

GIVEN_BY = {
    "normal_stiffness": ("stiffness", "direct"),
    "restitution": ("damping", "restitution"),
    "damping_ratio": ("damping", "ratio"),
}
"""The choice of ``[contact]`` that takes each of these numbers from the pair, if the normal law reads it."""

OTHERWISE = {"direct": "young", "ratio": "restitution", "restitution": "ratio"}
"""The other choice for each choice of `GIVEN_BY`."""

OPTIONAL = {
    **GIVEN_BY,
    "tangential_damping": ("tangential", "incremental_dashpot"),
    "rolling_stiffness": ("rolling", "type_c_direct"),
    "cohesive_pressure": ("cohesion", "area"),
    "liquid_viscosity": ("film", "viscous"),
    "film_thickness": ("film", "viscous"),
    "film_roughness": ("film", "viscous"),
    "bridge_volume": ("film", "capillary"),
    "surface_tension": ("film", "capillary"),
    "contact_angle": ("film", "capillary"),
}
"""The choice of ``[contact]`` that needs each of the numbers that a pair may leave out."""

NEEDS_A_LAW = {
    number: OPTIONAL[number] for number in ("cohesive_pressure", "liquid_viscosity", "bridge_volume")
}
"""Numbers that a case with no such law at all is refused for."""

INSTEAD = {
    "hertz": (
        "Hertz takes young_modulus and poisson_ratio of the materials; contact.softening makes them softer"
    ),
    "hysteretic": "It has no dashpot: its unloading stiffness follows from the restitution of each pair",
}
"""What a normal law takes in place of a number that it does not read."""


def is_read(number: str, law: str, chosen: str) -> bool:
    """Return whether a number of `OPTIONAL` is read where ``contact.<law>`` is `chosen`."""
    return number in READS[law][chosen] if law in READS else OPTIONAL[number] == (law, chosen)
