"""The machines that come with the package."""

import json
from pathlib import Path

import pytest

from nutamill.case import Machine, library_names, load_case
from nutamill.case.toml.keys import held
from nutamill.simulation.setup.wall_checks import refuse_walls

RESULTS = Path(__file__).parents[2] / "validation" / "results"
SCALE = 500 / 140
"""Size of the illustrative industrial mill over that of the laboratory mill."""
LAWS = {
    "mechanism.crank_radius": 1,
    "mechanism.nutation_point_to_crank": 1,
    "mechanism.total_mass": 3,
    "chamber.height": 1,
    "chamber.floor_depth": 1,
    "chamber.mass": 3,
    "chamber.inertia_transverse": 5,
    "chamber.inertia_axial": 5,
    "carriage.mass": 3,
    "carriage.inertia": 5,
    "driveshaft.mass": 3,
    "driveshaft.inertia_axial": 5,
    "intermediate_shaft.inertia_axial": 5,
    "frame.gyration_rocking": 1,
    "frame.mass_centre_height": 1,
    "mounts.half_spacing": 1,
    "mounts.depth": 1,
    "mounts.shear_stiffness": 2,
    "mounts.axial_stiffness": 2,
    "mounts.bending_stiffness": 4,
    "mounts.shear_damping": 2.5,
    "mounts.axial_damping": 2.5,
    "mounts.bending_damping": 4.5,
    "shaft_coupling.torsion_stiffness": 4,
    "shaft_coupling.torsion_damping": 4.5,
    "drive.speed": -0.5,
    "drive.ramp": -1,
    "charge.mass": 3,
    "charge.diameter": 1,
}
"""Powers of the size at equal acceleration of the charge: time goes with the root of the size, force with its
cube.
"""


def value(case, key):
    for part in key.split("."):
        case = getattr(case, part)
    return case


@pytest.mark.parametrize("key, power", LAWS.items())
def test_the_industrial_mill_is_the_laboratory_mill_scaled_at_equal_g(key, power):
    # the file has five digits, speeds and charge three
    assert value(load_case("industrial"), key) / value(load_case("numill"), key) == pytest.approx(
        SCALE**power, rel=1e-2
    )


def test_the_industrial_mill_says_that_it_is_no_real_machine():
    case = load_case("industrial")
    assert "no real machine" in case.title
    assert "industrial" in library_names()
    assert [str(warning) for warning in case.warnings] == [
        str(warning) for warning in load_case("numill").warnings
    ]


def test_the_identified_mill_has_the_mode_of_its_identification_and_is_not_the_default():
    stored = json.loads((RESULTS / "identify" / "numill" / "identify.json").read_text(encoding="utf-8"))
    modes = {one["name"]: one["mode"] for one in stored["unknowns"] if one["campaign"] != "2025"}
    keys = {one["name"]: one["keys"] for one in stored["unknowns"]}
    modes["floor_above_bars"] += modes["bars_depth"]
    case = load_case("numill-identified")
    for name in modes:
        for key in keys[name]:
            assert held(case, key) == pytest.approx(modes[name], rel=1e-3), key
    assert load_case("numill").digest == load_case("numill-2026").digest != case.digest


def test_only_a_year_or_a_size_is_left_out_of_a_name():
    names = library_names()
    assert {"numill", "numill-2025", "industrial", "piston", "particle-damper"} <= set(names)
    assert not {"", "particle", "tumbling", "vibratory"} & set(names)


@pytest.mark.parametrize(
    "name", ["piston", "particle-damper", "tumbling-mill", "vibratory-mill", "planetary-mill"]
)
def test_a_machine_part_by_part_of_the_package_has_walls_that_hold_its_charge(name):
    case = load_case(name)
    assert isinstance(case, Machine) and case.charge.parts
    refuse_walls(case)
