"""The case: what is read, changed, written back, and what follows from it."""

import math
from pathlib import Path

import numpy as np
import pytest

from nutamill.base.errors import CaseError
from nutamill.base.library import mount_sets
from nutamill.case import Case, case_of_text, library_names, load_case
from nutamill.case.starter import starter
from nutamill.simulation.setup.particles import particle_count

RPM = 2 * math.pi / 60


@pytest.fixture
def mill():
    return load_case("numill")


def case_of(folder, text, *overrides):
    file = folder / "mill.toml"
    file.write_text(text, encoding="utf-8")
    return load_case(file, overrides)


def test_a_case_holds_si_floats(mill):
    assert mill.drive.speed == pytest.approx(700 * RPM, rel=1e-15)
    assert (mill.chamber.inner_diameter, mill.mounts.shear_stiffness, mill.mounts.bending_damping) == (
        0.140,
        72200.0,
        30.0,
    )
    assert (mill.materials["steel"].density, mill.contact.pairs["steel-acrylic"].restitution) == (7863.7, 0.4)


def test_the_bare_name_of_a_mill_is_the_newest_of_them(mill):
    assert mill == load_case("numill-2026")


@pytest.mark.parametrize("name", library_names())
def test_a_machine_of_the_package_written_out_is_the_same_case(name):
    case = load_case(name)
    assert case_of_text(case.to_toml()) == case


@pytest.mark.parametrize("name", library_names())
def test_a_machine_of_the_package_written_out_again_is_the_same_text(name):
    text = load_case(name).to_toml()
    assert case_of_text(text).to_toml() == text


def test_a_case_with_sizes_profile_ribs_and_texts_round_trips_bit_for_bit(mill, tmp_path):
    (tmp_path / "speed.csv").write_text("time [s],speed [rpm]\n0,0\n0.1,13.37\n7,701.23\n")
    case = case_of(
        tmp_path,
        'base = "numill"\ntitle = "a \\"quoted\\" \\\\ title\\t"\n[chamber]\nribs = '
        '12\n[drive]\nprofile = "speed.csv"\n'
        '[charge]\nsizes = [["3.3333 mm", 0.3], ["5 mm", 0.7]]\n[run]\ndt = "3.1 us"\nthreads = 2\n'
        '[sensors."odd name"]\nbody = "chamber"\nat = ["1 mm", "-2.2 mm", "0 mm"]\n',
    )
    again = Case.from_toml(case.to_toml())
    assert again.model_dump() == case.model_dump()
    assert again.digest == case.digest != mill.digest


def test_keys_of_a_file_override_its_base_and_no_others(mill, tmp_path):
    case = case_of(tmp_path, 'base = "numill"\n[charge]\nmass = "1 kg"\n')
    assert case.charge.mass == 1.0
    assert case.with_(charge__mass=mill.charge.mass).digest == mill.digest


def test_a_base_may_be_a_file_beside_the_file(tmp_path):
    (tmp_path / "below.toml").write_text('base = "numill"\n[run]\nseed = 7\nwindow = 5\n')
    case = case_of(tmp_path, 'base = "below.toml"\n[run]\nwindow = 20\n')
    assert (case.run.seed, case.run.window) == (7, 20)


def test_overrides_win_over_the_file_and_may_leave_out_quotes(tmp_path):
    case = case_of(
        tmp_path,
        'base = "numill"\n[drive]\nspeed = "600 rpm"\n',
        "drive.speed=500 rpm",
        "chamber.ribs=8",
        'run.dt="3 us"',
    )
    assert (case.drive.speed, case.chamber.ribs, case.run.dt) == (
        pytest.approx(500 * RPM, rel=1e-15),
        8,
        3e-6,
    )


def test_a_change_in_python_is_an_si_float_or_text_with_a_unit(mill):
    assert mill.with_(drive__speed=50.0).drive.speed == 50.0
    assert (
        mill.with_("drive.speed", "500 rpm")
        == mill.with_(drive__speed="500 rpm")
        == mill.with_(drive__speed=500 * RPM)
    )
    assert mill.drive.speed == pytest.approx(700 * RPM, rel=1e-15)


def test_a_wrong_change_in_python_is_refused_by_its_key(mill):
    with pytest.raises(CaseError) as error:
        mill.with_(drive__sped=50.0, charge__diameter="5 kg", chamber__nutation_angle="nan deg")
    assert [fault.where for fault in error.value.faults] == [
        "chamber.nutation_angle",
        "drive.sped",
        "charge.diameter",
    ]


def test_the_same_case_in_other_units_has_the_same_digest(mill):
    turns = "11.666666666666666 rev/s"
    assert mill.with_(chamber__height="22.8 cm", drive__speed=turns).digest == mill.digest
    assert mill.with_(chamber__height="22.81 cm").digest != mill.digest


def test_a_case_cannot_be_changed_in_place(mill):
    with pytest.raises(ValueError, match="frozen"):
        mill.drive.speed = 1.0


def test_sizes_take_the_place_of_the_base_s_diameter(tmp_path):
    case = case_of(tmp_path, 'base = "numill"\n[charge]\nsizes = [["4 mm", 0.3], ["5 mm", 0.7]]\n')
    assert case.charge.diameter is None
    assert case.charge.sizes == ((0.004, 0.3), (0.005, 0.7))


def test_a_profile_takes_the_place_of_the_base_s_ramp_and_back(mill):
    profiled = mill.with_(drive__profile=[(0.0, 0.0), (1.0, 10.0)])
    assert profiled.drive.ramp is None
    assert profiled.with_(drive__ramp=7.0).drive.profile is None


def test_the_pellets_are_as_many_as_the_paper_counts(mill):
    # MCA 2026 Table 5: 2618 pellets of 5 mm, 7863.7 kg/m^3 make 1.347 kg
    assert particle_count(mill.machine) == 2618


def test_a_mass_of_whole_pellets_is_that_many_pellets(mill):
    pellet = 7863.7 * math.pi / 6 * 0.005**3
    assert [particle_count(mill.with_(charge__mass=n * pellet).machine) for n in (1, 3, 1000)] == [1, 3, 1000]


def test_an_empty_chamber_needs_neither_spheres_nor_their_pairs(mill):
    empty = mill.with_(charge__kind="none", charge__material="unobtainium")
    assert (particle_count(empty.machine), empty.charge.parts) == (0, ())


def test_the_frame_weighs_what_the_other_parts_leave(mill):
    # 84.54 - 5.29 (chamber) - 0.63 (carriage) - 5.71 (driveshaft) - 0.5 (bearing cross); the intermediate
    # shaft stands on the ground
    assert mill.frame_mass == pytest.approx(72.41, rel=1e-12)


def test_twelve_ribs_weigh_the_published_difference(mill):
    # MCA 2026: 86.60 kg ribbed less 84.54 kg unribbed, printed to 0.01 kg each
    assert mill.with_(chamber__ribs=12).chamber.ribs_mass == pytest.approx(86.60 - 84.54, abs=0.01)


def test_a_rib_takes_room_only_up_to_the_ceiling(mill):
    ribbed = mill.with_(chamber__ribs=12).chamber
    assert ribbed.free_volume == pytest.approx(
        math.pi / 4 * 0.14**2 * 0.228 - 12 * 0.01 * 0.01 * 0.228, rel=1e-12
    )


def test_four_mounts_stand_at_plus_and_minus_the_half_spacing(mill):
    a = mill.mounts.half_spacing
    assert np.allclose(mill.mounts.points, [(a, a), (-a, a), (-a, -a), (a, -a)], rtol=0, atol=1e-15)


@pytest.mark.parametrize("name", mount_sets())
def test_a_named_set_of_mounts_gives_its_values_unless_a_key_beside_it_does(name, tmp_path):
    case = case_of(tmp_path, f'base = "numill"\n[mounts]\nset = "{name}"\naxial_damping = "1 N s/m"\n')
    expected = {
        "printed": (72200.0, 30.0, 0.145),
        "bending-0.030": (72200.0, 0.03, 0.145),
        "343": (72250.0, 0.0, 0.164),
    }
    assert (case.mounts.shear_stiffness, case.mounts.bending_damping, case.mounts.half_spacing) == expected[
        name
    ]
    assert case.mounts.axial_damping == 1.0
    assert load_case("numill", [f"mounts.set={name}"]).mounts.set == name


def test_the_2025_mill_takes_its_contacts_from_its_own_paper():
    case = load_case("numill-2025")
    # SAIMM 2025 Table 3: 499 and 333 kN/m, critical damping ratios 0.22 and 0.28
    values = {
        name: (pair.normal_stiffness, pair.damping_ratio, pair.restitution)
        for name, pair in case.contact.pairs.items()
    }
    assert values == {
        "steel-steel": (499e3, 0.22, None),
        "steel-acrylic": (499e3, 0.28, None),
        "sand-sand": (500e3, 0.212, None),
        "sand-acrylic": (500e3, 0.212, None),
    }
    assert case.contact.pair("acrylic", "steel") is case.contact.pairs["steel-acrylic"]
    assert 499 * case.contact.pair("steel", "steel").tangential_ratio == pytest.approx(333, abs=0.5)
    assert (case.mechanism.mounting, case.charge.diameter) == ("rigid", 0.00499)


def test_a_ramp_is_two_points(mill):
    times, speeds = mill.drive.breakpoints()
    assert np.allclose(times, [0, 10], rtol=1e-15)
    assert np.allclose(speeds, [0, 700 * RPM], rtol=1e-15)


def test_a_profile_stays_at_the_cap_while_it_exceeds_it(mill):
    profiled = mill.with_(
        drive__speed=60.0, drive__profile=[(0.0, 0.0), (10.0, 80.0), (14.0, 80.0), (18.0, 40.0), (20.0, 60.0)]
    )
    times, speeds = profiled.drive.breakpoints()
    # crosses the cap 60 on the way up at 10 x 60/80 = 7.5 s and on the way down halfway between 14 and 18 s
    assert times.tolist() == [0.0, 7.5, 10.0, 14.0, 16.0, 18.0, 20.0]
    assert speeds.tolist() == [0.0, 60.0, 60.0, 60.0, 60.0, 40.0, 60.0]
    assert profiled.drive.ramp_end == 20.0


def test_a_run_that_ends_before_its_speed_is_reached_is_warned_of(mill):
    (warning,) = [str(one) for one in mill.with_(run__until=2.0).warnings if one.where == "run.until"]
    assert (
        warning
        == "run.until: the run ends at 2 s, before the speed is reached at 10 s. There will be no steady mean"
    )
    assert not [one for one in mill.warnings if one.where == "run.until"]


@pytest.mark.parametrize(
    ("written", "agrees"),
    [("6 deg", True), ("6.1 deg", True), ("6.08 deg", True), ("6.04 deg", False), ("5.5 deg", False)],
)
def test_a_nutation_angle_is_warned_of_unless_it_is_the_rounded_angle_of_the_crank(mill, written, agrees):
    # atan(39/366) = 6.0823 deg, which the papers print as 6 deg
    warnings = mill.with_(chamber__nutation_angle=written).warnings
    assert (
        [str(one) for one in warnings] == []
        if agrees
        else [
            f"chamber.nutation_angle: {written} is not used: crank_radius and "
            "nutation_point_to_crank give 6.082 deg."
            ' Write nutation_angle = "6.082 deg", or change the lengths'
        ]
    )


def test_no_machine_of_the_package_warns_of_itself():
    assert [str(one) for name in library_names() for one in load_case(name).warnings] == []


def test_number_of_a_pair_that_the_chosen_law_does_not_read_is_warned_of(mill):
    stiff = mill.with_("contact.pairs.steel-acrylic.normal_stiffness", "500 kN/m")
    (warning,) = [str(one) for one in stiff.warnings if one.where.startswith("contact")]
    assert (
        warning
        == 'contact.pairs.steel-acrylic.normal_stiffness: is not used with contact.stiffness = "young"'
    )
    both = stiff.with_("contact.pairs.steel-steel.normal_stiffness", "500 kN/m").with_(
        "contact.stiffness", "direct"
    )
    assert not [one for one in both.warnings if one.where.startswith("contact")]


def test_the_starter_file_is_the_case_it_starts_from(mill, tmp_path):
    text = starter("numill", tmp_path / "mill.toml")
    assert 25 <= len(text.splitlines()) <= 40
    assert case_of(tmp_path, text).with_(title=mill.title) == mill


def test_the_result_file_of_a_case_is_named_by_its_content(mill):
    changed = mill.with_("run.seed", 99)
    assert mill.file_in("there") == Path("there") / f"numill-{mill.digest[:12]}.h5"
    assert mill.file_in().parent == Path("results")
    assert changed.file_in() != mill.file_in() and changed.file_in().name.startswith("numill-")


@pytest.mark.parametrize(
    ("key", "value", "text"),
    [
        ("drive.speed", 500, "drive.speed: a plain number is SI, and 500 rad/s is 4775 rpm. "),
        ("chamber.inner_diameter", 140.0, "a plain number is SI, and 140 m is 1.4e+05 mm. "),
        ("materials.steel.density", 7.85, 'Write "7.85 g/cm^3" if that is meant, or "7.85 kg/m^3"'),
    ],
)
def test_a_plain_number_that_no_machine_has_in_si_is_warned_of(key, value, text):
    from nutamill.case.doubts import doubt

    assert text in str(doubt(key, value))
    assert doubt(key, f"{value} m") is None


def test_a_changed_case_warns_where_it_was_changed(mill):
    with pytest.warns(UserWarning, match="500 rad/s is 4775 rpm") as caught:
        assert mill.with_("drive.speed", 500).drive.speed == 500.0
    assert caught[0].filename == __file__


def test_a_changed_case_is_silent_about_plain_numbers_that_a_machine_may_have(mill, recwarn):
    mill.with_({"drive.speed": 52.36, "chamber.inner_diameter": 0.14, "drive.ramp": 7.3})
    mill.with_("drive.speed", "500 rad/s")
    assert not recwarn.list
