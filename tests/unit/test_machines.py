"""The mills that come with the package."""

import pytest

from nutamill.case import library_names, load_case

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
