"""The contact laws that a case may name are those of the engine, and read what the case says they read."""

import typing

import numpy as np
import pytest

from nutamill.case import load_case
from nutamill.case.contact_laws import GIVEN_BY, READS, Cohesion, Film, Normal, Rolling, Tangential
from nutamill.case.materials import ContactPair
from nutamill.charge.laws.composition import FAMILIES, film_numbers, law_numbers
from nutamill.charge.laws.meeting import meeting
from nutamill.simulation.setup.charge import contact_law_of, pair_law

OTHER_VALUES = {
    "normal_stiffness": 2e5,
    "restitution": 0.6,
    "damping_ratio": 0.3,
    "tangential_ratio": 0.5,
    "sliding_friction": 0.4,
    "rolling_friction": 0.02,
    "tangential_damping": 0.4,
    "rolling_stiffness": 0.2,
    "cohesive_pressure": 2e5,
    "liquid_viscosity": 0.05,
    "film_thickness": 6e-5,
    "film_roughness": 2e-6,
    "bridge_volume": 2e-12,
    "surface_tension": 0.05,
    "contact_angle": 0.1,
}
"""Values for the numbers of a pair, none of which is that of `numill` or of `GIVEN`."""

GIVEN = {
    "normal_stiffness": 1e5,
    "restitution": 0.5,
    "damping_ratio": 0.2,
    "tangential_damping": 0.3,
    "rolling_stiffness": 0.1,
    "cohesive_pressure": 1e5,
    "liquid_viscosity": 0.1,
    "film_thickness": 5e-5,
    "film_roughness": 1e-6,
    "bridge_volume": 1e-12,
    "surface_tension": 0.07,
    "contact_angle": 0.3,
}
"""Values for the numbers that a pair may leave out."""


def test_a_case_names_the_laws_of_the_engine():
    for literal, family, key in zip(
        (Normal, Tangential, Rolling, Cohesion, Film), FAMILIES, READS, strict=True
    ):
        assert set(typing.get_args(literal)) == set(family) == set(READS[key])


def test_every_number_of_a_pair_is_read_by_a_law():
    read = frozenset().union(*(numbers for family in READS.values() for numbers in family.values()))
    assert read == set(ContactPair.model_fields) - {"overlap_warn", "overlap_stop"}


def force_and_moment(case):
    """What two contacts of the case do, one that sticks and one that slides and rolls, at an overlap of a
    hundredth of the diameter, unloading; and what pairs do 30 micrometres apart, one that comes near for the
    first time and one that has touched.
    """
    law, pair = contact_law_of(case), pair_law(case, "steel", "steel")
    numbers, liquid, parts = tuple(law_numbers(law, pair)), tuple(film_numbers(law, pair)), []
    rest = 2e-4, 1.25e-3, (5e-3, 5e-3), numbers, liquid, 1e-6
    up, none = (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)
    for slip, spin, old in ((1e-3, 1e-3, 1e-8), (2.0, 50.0, 1e3)):
        state = (slip, 0.0, 1.0), (0.0, spin, 0.0), (old, 0.0, 0.0), (0.0, old, 0.0), 0.0, 4.5e-5, 1.0
        out = meeting(law.film, law, up, 5e-5, *state, *rest)
        parts += [out[0], out[2]]
    if liquid:
        out = meeting(law.film, law, up, -3e-5, (0.0, 0.0, 30.0), none, none, none, 0.0, 0.0, 0.0, *rest)
        parts += [out[0]]
        out = meeting(law.film, law, up, -3e-5, none, none, none, none, 1.0, -2e-6, 1.0, *rest)
        parts += [out[0]]
    return np.hstack(parts)


def case_of(laws, **numbers):
    """The published mill with these choices of ``[contact]`` and numbers of its pair of pellets."""
    case = load_case("numill")
    pair = case.contact.pairs["steel-steel"].model_copy(update=numbers)
    return case.model_copy(
        update={"contact": case.contact.model_copy(update=laws | {"pairs": {"steel-steel": pair}})}
    )


@pytest.mark.parametrize(("key", "name"), [(key, name) for key, family in READS.items() for name in family])
def test_a_law_reads_the_numbers_that_the_case_declares(key, name):
    laws = {
        "normal": "linear",
        "tangential": "displacement",
        "rolling": "type_c",
        "cohesion": "none",
        "film": "none",
    }
    laws[key] = name
    declared = frozenset().union(*(READS[family][law] for family, law in laws.items()))
    read = set()
    # every way in which the normal law takes its numbers
    ways = [number for number in GIVEN_BY if number in declared]
    for way in ways:
        choices = laws | {"stiffness": "young", "damping": "restitution"} | dict([GIVEN_BY[way]])
        given = {number: value for number, value in GIVEN.items() if number in declared}
        before = force_and_moment(case_of(choices, **given))
        for number, value in OTHER_VALUES.items():
            if number in declared or number not in GIVEN:
                after = force_and_moment(case_of(choices, **given | {number: value}))
                read |= {number} if (after != before).any() else set()
    assert read == declared
