"""Answers that run the empty mill: run-up, isolation, balancing, against closed forms and physical facts."""

import math
from pathlib import Path

import numpy as np
import pytest
import tomlkit
from mill_bench import SMOOTH

from nutamill.analysis.mounts import floor_series
from nutamill.analysis.orders import peaks
from nutamill.base.errors import CaseError
from nutamill.case import load_case
from nutamill.design.balancing import balance_mill, permissible_unbalance
from nutamill.design.empty import once_per_turn, steady_series
from nutamill.design.isolation import isolation, shaking_unbalance, transmissibility
from nutamill.design.modes import machine_modes
from nutamill.design.runup import run_up
from nutamill.design.sticks import sticks
from nutamill.design.weights import Weight, weighted

SPEED = 40.0
MECHANISMS = Path(__file__).parents[2] / "examples" / "mechanisms"


@pytest.fixture(scope="module")
def rigid():
    """The empty mill bolted to the floor."""
    return load_case("numill", ["charge.kind=none", "mechanism.mounting=rigid", *SMOOTH])


def test_amplitude_once_per_turn_is_that_of_the_signal():
    angle = 0.3 + np.arange(1000) * 0.0314
    signal = 2.0 * np.cos(angle + 0.4) + 0.7 * np.sin(2 * angle) + 5.0
    assert once_per_turn(angle, signal[:, None])[0] == pytest.approx(2.0 * np.exp(0.4j), abs=1e-9)


def test_shaking_unbalance_of_the_mill_is_the_sum_of_its_moments_of_mass(rigid):
    # all that moves has its mass centre on the side of the pin: chamber at 0.24 m below the point, and
    # carriage at the pin
    angle = math.atan2(0.039, 0.366)
    expected = 5.29 * 0.24 * math.sin(angle) + 0.63 * 0.039
    # the ripple of the universal joint takes a part in 10^4
    assert shaking_unbalance(rigid.machine, SPEED) == pytest.approx(expected, rel=1e-3, abs=1e-5)


def test_two_planes_take_all_of_a_bolted_mills_shaking(rigid):
    balancing = balance_mill(rigid, [(0.08, 0.42), (0.08, 0.6)], SPEED)
    moments = sum(weight.mass * weight.radius * np.exp(1j * weight.azimuth) for weight in balancing.weights)
    # force and moment are two conditions for two planes: the weights' own unbalance is minus the mill's
    assert moments == pytest.approx(-balancing.unbalance, rel=1e-3)
    assert balancing.after < 2e-3 * balancing.before and abs(balancing.residual) < 2e-3 * abs(
        balancing.unbalance
    )


def test_balance_mass_changes_the_unbalance_by_its_moment(rigid):
    weight = Weight(0.6, 0.08, 0.42, 2.0)
    change = shaking_unbalance(weighted(rigid, [weight]), SPEED) - shaking_unbalance(rigid.machine, SPEED)
    assert change == pytest.approx(weight.mass * weight.radius * np.exp(1j * weight.azimuth), rel=1e-3)


def test_permissible_unbalance_is_that_of_the_standards_example():
    # ISO 21940-11: e_per = 9549 G / n um; G 6.3 at 3000 rpm is 20 um, of 10 kg 200 g mm
    assert permissible_unbalance(6.3, 3000 * math.pi / 30, 10.0) == pytest.approx(
        10.0 * 9549 * 6.3 / 3000 * 1e-6, rel=1e-4
    )


@pytest.mark.parametrize(
    ("planes", "message"),
    [
        ([], "needs one or two planes, got 0"),
        ([(0.08, 0.4)] * 2, "the depths of two planes must differ, got 80 mm, 400 mm and 80 mm, 400 mm"),
        ([(0.0, 0.4)], "radius and depth must be positive, got 0 mm, 400 mm"),
    ],
)
def test_planes_that_make_no_sense_are_refused(rigid, planes, message):
    with pytest.raises(CaseError, match=message):
        balance_mill(rigid, planes)


def test_one_mass_passes_on_all_at_rest_and_at_root_two():
    assert transmissibility(np.array([0.0, math.sqrt(2.0)]), 0.05) == pytest.approx([1.0, 1.0])
    assert transmissibility(np.array([1.0]), 0.05)[0] == pytest.approx(math.sqrt(1 + 0.01) / 0.1)


def test_mounts_pass_on_slow_shaking_as_it_is():
    # 100 rpm is r = 0.21 of the sway and 0.07 of the rocking: between 1 and 1/(1 - r^2) = 1.046
    case = load_case("numill", ["charge.kind=none"])
    speed = 100 * math.pi / 30
    sizes = []
    for mounting in ("rigid", "flexible"):
        machine = case.with_("mechanism.mounting", mounting).machine
        series = steady_series(machine, speed)
        sizes.append(abs(once_per_turn(series["crank_angle"], floor_series(series, machine))[0]))
    assert 1.0 < sizes[1] / sizes[0] < 1.05


def test_isolation_of_rigid_mounts_is_refused(rigid):
    with pytest.raises(CaseError, match="must stand on bushings, nothing else is between it and the ground"):
        isolation(rigid)


def test_quicker_ramp_passes_the_resonance_lower_and_later():
    # Lewis, Trans. ASME 54, 253-261, 1932: the peak falls and moves up with the rate of the ramp
    case = load_case("numill", ["charge.kind=none"])
    slow, quick = run_up(case, [40.0, 120.0])
    one, other = peaks(slow.orders)[0], peaks(quick.orders)[0]
    assert other.amplitude < 0.95 * one.amplitude
    assert 2 * np.pi * 7.9 < one.speed < other.speed


def test_run_up_of_a_series_that_is_not_there_is_refused(rigid):
    what = 'no series of this machine without its charge is called "mount_1_force_x". Known: frame_corner'
    with pytest.raises(CaseError, match=what):
        run_up(rigid, [500.0], "mount_1_force_x")
    with pytest.raises(CaseError, match="must be one or more positive rates, got"):
        run_up(rigid, [])


def test_modes_of_a_mechanism_are_about_the_place_where_it_hangs_at_rest():
    # the example begins with its arm of 1 m held level, and hangs along -y
    case = load_case(MECHANISMS / "pendulum.toml")
    vibrations = machine_modes(case)
    assert vibrations.frequency == pytest.approx([math.sqrt(9.81 / 1.0) / (2.0 * math.pi)], rel=1e-6)
    assert vibrations.label(0) == "bob moves"
    hanging = next(stick for stick in sticks(case) if stick.body == "bob")
    assert hanging.points == pytest.approx(np.array([[0.0, -1.0, 0.0], [0.0, 0.0, 0.0]]), abs=1e-9)


@pytest.mark.parametrize("gravity", [(0.0, -9.81, 0.0), (0.3, -9.0, 0.0), (-2.0, -0.7, 0.4)], ids=str)
@pytest.mark.parametrize("length", [0.2, 3.0])
def test_pendulum_held_square_to_gravity_comes_to_rest_hanging(tmp_path, gravity, length):
    # a rest is where the potential energy is least, not most: never inverted, however the arithmetic rounds
    # at the level
    pull = np.array(gravity)
    level = np.cross(pull, [0.0, 0.0, 1.0])
    level *= length / np.linalg.norm(level)
    text = (
        (MECHANISMS / "pendulum.toml")
        .read_text()
        .replace('["-1 m", "0 m", "0 m"]', str([f"{x!r} m" for x in level.tolist()]))
    )
    text = text.replace('["0 m/s^2", "-9.81 m/s^2", "0 m/s^2"]', str([f"{x!r} m/s^2" for x in gravity]))
    (tmp_path / "held.toml").write_text(text.replace("'", '"'))
    vibrations = machine_modes(load_case(tmp_path / "held.toml"))
    # the axis along z takes its share of gravity
    assert vibrations.frequency == pytest.approx(
        [math.sqrt(np.linalg.norm(pull[:2]) / length) / math.tau], rel=1e-6
    )


def on_springs(folder, stiffness):
    """A body of 5 kg on a rail along x, held by one bushing."""
    spring = {
        "name": "spring",
        "between": ["ground", "slider"],
        "point": ["0 m"] * 3,
        "axis": [0, 0, 1],
        **stiffness,
    }
    rail = {
        "name": "rail",
        "kind": "prismatic",
        "between": ["ground", "slider"],
        "point": ["0 m"] * 3,
        "axis": [1, 0, 0],
    }
    slider = {"name": "slider", "mass": "5 kg", "inertia": ["0.01 kg m^2"] * 3, "position": ["0 m"] * 3}
    parts = {
        "schema": 1,
        "bodies": [slider],
        "joints": [rail],
        "bushings": [spring],
        "run": {"until": "1 s", "step": "100 us"},
    }
    (folder / "springs.toml").write_text(tomlkit.dumps(parts))
    return load_case(folder / "springs.toml")


def test_mode_of_a_mass_on_springs_is_that_of_its_stiffness(tmp_path):
    vibrations = machine_modes(on_springs(tmp_path, {"shear_stiffness": "3000 N/m"}))
    assert vibrations.frequency == pytest.approx([math.sqrt(3000.0 / 5.0) / (2.0 * math.pi)], rel=1e-6)


def test_modes_of_a_mechanism_that_nothing_holds_are_refused(tmp_path):
    with pytest.raises(CaseError, match="no restoring force, got translation of body 'slider' along x"):
        machine_modes(on_springs(tmp_path, {"axial_stiffness": "1 N/m"}))
