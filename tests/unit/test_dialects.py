"""The contacts of a case in the words of other programs: the numbers mean there what they mean here."""

import math
import re

import pytest

from nutamill.case import load_case
from nutamill.charge.laws.oscillator import damping_ratio_from_restitution
from nutamill.design.dialects import dialect_lines, lammps, liggghts, pfc, rocky, touches

MASS = 7863.7 * math.pi / 6 * 0.005**3
E, NU, E_WALL, NU_WALL = 2e8, 0.25, 3.2e6, 0.3
"""Softened moduli [Pa] and Poisson's ratios of the published mill's pellets and chamber."""


def touch(name="steel-steel", *overrides):
    return touches(load_case("numill", overrides).machine)[name]


def number(text, after):
    return float(re.search(rf"{after} ([-+.e\d]+)", text).group(1))


def test_lammps_line_has_the_stiffness_and_the_dashpot_of_the_pair():
    # hooke k e: eta = sqrt(4 m k/(1 + (pi/ln e)^2)) must be 2 zeta sqrt(m k); the spring of two steel pellets
    # is E d/2
    line = lammps(touch())[0]
    k, e = number(line, "hooke"), float(line.split()[line.split().index("hooke") + 2])
    assert k == pytest.approx(E * 0.005 / 2)
    zeta = damping_ratio_from_restitution(0.5, False)
    assert math.sqrt(4 * MASS / 2 * k / (1 + (math.pi / math.log(e)) ** 2)) == pytest.approx(
        2 * zeta * math.sqrt(MASS / 2 * k), rel=1e-5
    )
    assert line.endswith("tangential linear_history 500000 0 0.5 rolling sds 500000 0 0.01")


def test_cut_tension_takes_the_dashpot_along_and_says_so():
    # a program that takes e works out the dashpot of a full half period
    lines = lammps(touch("steel-steel", "contact.tension=cut"))
    zeta = damping_ratio_from_restitution(0.5, True)
    full = math.exp(-math.pi * zeta / math.sqrt(1 - zeta * zeta))
    assert float(lines[0].split()[lines[0].split().index("hooke") + 2]) == pytest.approx(full, rel=1e-5)
    assert lines[0].endswith("limit_damping")
    assert "the restitution is 0.5" in lines[1]
    assert number(liggghts(touch("steel-steel", "contact.tension=cut"))[1], "gamman") == pytest.approx(
        2 * zeta * math.sqrt(E * 0.005 / MASS), rel=1e-5
    )


def test_pfc_hertz_solids_have_the_contact_moduli_of_the_pair():
    # two equal solids: E* = G/(1 - nu), G* = G/(2 (2 - nu)); the wall's pair is of two unlike ones
    line = pfc(touch("steel-acrylic wall", "contact.normal=hertz"))[0]
    shear, nu = number(line, "hz_shear"), number(line, "hz_poiss")
    modulus = 1 / ((1 - NU**2) / E + (1 - NU_WALL**2) / E_WALL)
    shear_modulus = 1 / (2 * (2 - NU) * (1 + NU) / E + 2 * (2 - NU_WALL) * (1 + NU_WALL) / E_WALL)
    assert shear / (1 - nu) == pytest.approx(modulus, rel=1e-5)
    assert shear / (2 * (2 - nu)) == pytest.approx(shear_modulus, rel=1e-5)


def test_lammps_hertz_takes_four_thirds_and_eight_times_the_moduli():
    line = lammps(touch("steel-steel", "contact.normal=hertz", "contact.tangential=incremental"))[0]
    assert number(line, "hertz") == pytest.approx(4 / 3 * E / (2 * (1 - NU**2)), rel=1e-5)
    assert number(line, "mindlin/force") == pytest.approx(8 * E / (4 * (2 - NU) * (1 + NU)), rel=1e-5)


def test_liggghts_wall_takes_twice_the_cohesion():
    # its wall has the area 2 pi d R, a pair of spheres 2 pi d (2 R*)
    given = [f"contact.pairs.{name}.cohesive_pressure=0.1 MPa" for name in ("steel-steel", "steel-acrylic")]
    for name, wanted in (("steel-steel", 1e5), ("steel-acrylic wall", 2e5)):
        lines = liggghts(touch(name, "contact.cohesion=area", *given))
        assert "cohesion sjkr2 rolling_friction epsd2" in lines[0]
        assert number(lines[-1], "cohesionEnergyDensity") == wanted


def test_tangential_dashpot_and_rolling_stiffness_reach_the_programs_that_have_them():
    given = [
        f"contact.pairs.{pair}.{number}"
        for pair in ("steel-steel", "steel-acrylic")
        for number in ("tangential_damping=0.2", "rolling_stiffness=0.5 N m/rad")
    ]
    contact = touch(
        "steel-steel", "contact.tangential=incremental_dashpot", "contact.rolling=type_c_direct", *given
    )
    assert number(pfc(contact)[0], "dp_sratio") == 0.2
    assert "missing: a rolling stiffness by itself" in pfc(contact)
    assert "missing: a tangential dashpot" in "\n".join(rocky(contact))
    assert "tangential_damping on" in liggghts(contact)[0]
    # c = 2 ratio sqrt(m* k_t), given over m*
    gamma = number(liggghts(contact)[1], "gammat")
    assert gamma == pytest.approx(0.4 * (contact.touch.kt / contact.touch.mass) ** 0.5, rel=1e-5)
    # LAMMPS rolls over a length: k_r over the square of the reduced radius
    contact = touch("steel-steel", "contact.rolling=type_c_direct", *given)
    radius = 0.25 * contact.touch.diameters[0]
    assert number(lammps(contact)[0], "sds") == pytest.approx(0.5 / radius**2, rel=1e-5)


def test_rocky_takes_the_solid_and_the_softening_apart():
    text = "\n".join(rocky(touch()))
    assert "bulk Young's modulus 2e+11 and 2e+11 Pa, numerical softening factor 0.001" in text
    assert "restitution 0.5," in text
    assert "restitution 0.5," in "\n".join(rocky(touch("steel-steel", "contact.normal=hysteretic")))


@pytest.mark.parametrize("program", [pfc, lammps, liggghts])
def test_a_law_that_a_program_lacks_is_marked_as_missing(program):
    lines = program(touch("steel-steel", "contact.normal=hysteretic"))
    assert lines[0].startswith("missing: hysteretic linear spring")


def test_every_pair_is_in_the_terms_of_every_program_and_an_empty_mill_in_none():
    lines = dialect_lines(load_case("numill").machine)
    assert [line.split(":")[0] for line in lines if not line.startswith(" ")] == [
        "steel-steel",
        "steel-acrylic wall",
    ]
    assert [line.split()[0] for line in lines if re.match(r"  \w", line)] == [
        "Rocky",
        "PFC",
        "LAMMPS",
        "LIGGGHTS",
    ] * 2
    assert dialect_lines(load_case("numill", ["charge.kind=none"]).machine) == []
