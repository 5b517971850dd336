"""Lives of bearings and sections under loads whose lives are known in closed form."""

import math

import numpy as np
import pytest

from nutamill.analysis.bearings import basic_life, bearing_life, cycle_mean, static_load, swing_share
from nutamill.analysis.fatigue import cycles, goodman, miner, section_life
from nutamill.analysis.mounts import chamber_clearance, floor_force, mount_readings
from nutamill.analysis.ratings import Bearing, load_ratings
from nutamill.base.errors import CaseError
from nutamill.case import load_case
from nutamill.result import Recorder, open_result
from nutamill.result.fields import expand
from nutamill.view.figures.reading import draw_floor

RATE, SPEED, FORCE = 2000.0, 20.0 * math.pi, 500.0
RATINGS = """
schema = 1
[bearings.pin_joint]
kind = "ball"
dynamic_rating = "14 kN"
static_rating = "6 kN"
[bearings.yoke_pivot]
kind = "roller"
dynamic_rating = "8 kN"
swing = "9 deg"
[sections.neck]
joint = "pin_joint"
axes = "ground"
arm = ["0 mm", "0 mm", "100 mm"]
diameter = "20 mm"
ultimate_strength = "600 MPa"
fatigue_strength = "200 MPa"
exponent = 5.0
"""


@pytest.fixture
def ratings(tmp_path):
    (tmp_path / "ratings.toml").write_text(RATINGS)
    return load_ratings(tmp_path / "ratings.toml")


@pytest.fixture
def result(tmp_path):
    """Two seconds at ten turns a second: 500 N that turn with the crank at every pin; mounts that circle by 2
    mm about 1 mm.
    """
    names = expand(mounts=4, sensors=())
    time = np.arange(4001) / RATE
    angle = SPEED * time
    one = np.ones_like(time)
    known = {"time": time, "crank_angle": angle, "driveshaft_speed": SPEED * one}
    known |= {f"{body}_attitude_w": one for body in ("frame", "driveshaft")}
    tilt = math.radians(-5.0) / 2
    known |= {
        "chamber_attitude_w": math.cos(tilt) * one,
        "chamber_attitude_x": -math.sin(tilt) * np.sin(angle),
    }
    known |= {"chamber_attitude_y": math.sin(tilt) * np.cos(angle)}
    known |= {"driveshaft_attitude_w": np.cos(angle / 2), "driveshaft_attitude_z": np.sin(angle / 2)}
    for joint in ("pin_joint", "yoke_pivot"):
        known |= {
            f"{joint}_reaction_force_x": FORCE * np.cos(angle),
            f"{joint}_reaction_force_y": FORCE * np.sin(angle),
        }
    for number in range(1, 5):
        known |= {
            f"mount_{number}_travel_x": 1e-3 + 2e-3 * np.cos(angle),
            f"mount_{number}_travel_y": 2e-3 * np.sin(angle),
        }
        known |= {f"mount_{number}_force_x": 30 * np.cos(angle), f"mount_{number}_force_z": 200.0 * one}
    recorder = Recorder.create(tmp_path / "a.h5", load_case("numill").to_toml(), {}, names, RATE)
    recorder.append(np.stack([known.get(name, np.zeros_like(time)) for name in names], axis=1))
    recorder.close()
    with open_result(tmp_path / "a.h5") as opened:
        yield opened


def test_life_of_a_bearing_under_a_steady_turning_load(result, ratings):
    # C / P = 28 and p = 3; a force of steady size has itself as equivalent load. Samples 200 to a turn lie on
    # chords: 1.2e-4
    life = bearing_life(result, "pin_joint", ratings)
    assert life.equivalent == pytest.approx(FORCE, rel=2e-4)
    assert life.turns == pytest.approx(1e6 * 28.0**3, rel=6e-4)
    assert life.time == pytest.approx(life.turns / 10.0)
    assert life.static_safety == pytest.approx(12.0, rel=2e-4)


def test_static_safety_is_of_the_static_equivalent_load_of_the_standard():
    # ISO 76, deep-groove ball bearing: 0.6 Fr + 0.5 Fa, at least Fr; rollers without a contact angle: Fr
    radial, axial = np.array([100.0, 100.0]), np.array([400.0, 10.0])
    ball = Bearing(kind="ball", dynamic_rating=1e4)
    assert static_load(radial, axial, ball) == pytest.approx([260.0, 100.0])
    roller = Bearing(kind="roller", dynamic_rating=1e4)
    assert static_load(radial, axial, roller) == pytest.approx([100.0, 100.0])
    tapered = Bearing(kind="roller", dynamic_rating=1e4, static_radial_factor=0.5, static_axial_factor=0.9)
    assert static_load(radial, axial, tapered) == pytest.approx([410.0, 100.0])


def test_life_of_a_bearing_that_swings_is_counted_in_swings(result, ratings):
    # 9 deg either way is 36 deg of path, a tenth of a turn. At the yoke the axis is y: only x is radial,
    # |cos| to the 10/3 in the mean
    life = bearing_life(result, "yoke_pivot", ratings)
    assert swing_share(math.radians(9.0)) == pytest.approx(0.1)
    even = np.linspace(0.0, 2.0 * np.pi, 100001)[:-1]
    equivalent = FORCE * np.mean(np.abs(np.cos(even)) ** (10 / 3)) ** 0.3
    assert life.equivalent == pytest.approx(equivalent, rel=2e-4)
    assert life.turns == pytest.approx(10.0 * basic_life(8000.0, equivalent, "roller"), rel=1e-3)


def test_varying_load_counts_by_the_cube_of_its_size():
    assert cycle_mean(np.array([100.0, 200.0]), "ball") == pytest.approx((0.5 * (1e6 + 8e6)) ** (1 / 3))


def test_bearing_without_a_rating_is_refused(result, ratings):
    with pytest.raises(CaseError, match="bearing chamber_pivot: must have a rating, the file has none"):
        bearing_life(result, "chamber_pivot", ratings)
    with pytest.raises(CaseError, match="must be a joint that turns"):
        bearing_life(result, "crank_pin_load_cell", ratings)


@pytest.mark.parametrize(
    ("was", "now", "message"),
    [
        ('dynamic_rating = "14 kN"\n', "", "dynamic_rating"),
        ('"14 kN"', '"14 kg"', "is a mass"),
        (
            "[bearings.pin_joint]",
            "[bearings.crankpin]",
            "bearings.crankpin: no such joint of the machine, got .crankpin.. Known are",
        ),
        (
            "[bearings.pin_joint]",
            "[bearings.crank_pin]",
            "no such joint of the machine, got .crank_pin.. The joint crank_pin is now called pin_joint",
        ),
        (
            'joint = "pin_joint"',
            'joint = "load_cell"',
            "got 'load_cell'. The joint load_cell is now called crank_pin_load_cell",
        ),
        ('"20 mm"', '"20 mm"\nbore = "30 mm"', "bore must be less"),
    ],
)
def test_ratings_that_make_no_sense_are_refused(tmp_path, was, now, message):
    (tmp_path / "bad.toml").write_text(RATINGS.replace(was, now, 1))
    with pytest.raises(CaseError, match=message):
        load_ratings(tmp_path / "bad.toml")


def test_rainflow_counts_the_example_of_the_standard():
    # ASTM E1049-85, figure 6: -2 1 -3 5 -1 3 -4 4 -2
    pytest.importorskip("rainflow")
    counted = cycles(np.array([-2.0, 1.0, -3.0, 5.0, -1.0, 3.0, -4.0, 4.0, -2.0]))
    counts = {size: counted[counted[:, 0] == size, 2].sum() for size in np.unique(counted[:, 0])}
    assert counts == {3.0: 0.5, 4.0: 1.5, 6.0: 0.5, 8.0: 1.0, 9.0: 0.5}


def test_goodman_halves_what_may_be_borne_at_half_the_ultimate_strength():
    assert goodman(np.array([100.0, 100.0]), np.array([300.0, -300.0]), 600.0) == pytest.approx(
        [200.0, 100.0]
    )
    assert np.isinf(goodman(np.array([1.0]), np.array([600.0]), 600.0))


def test_miner_adds_cycles_by_the_power_of_their_stress(ratings):
    # N = 1e6 (200/S)^5: one cycle of amplitude 400 does 32e-6, half of one of 200 does 0.5e-6
    section = ratings.sections["neck"]
    assert miner(np.array([[800e6, 0.0, 1.0], [400e6, 0.0, 0.5]]), section) == pytest.approx(32.5e-6)


def test_section_around_which_a_force_runs_is_bent_once_a_turn(result, ratings):
    # 500 N at 0.1 m bend a rod of 20 mm by 32 F a / pi d^3 = 63.7 MPa, once to and fro per turn
    pytest.importorskip("rainflow")
    life = section_life(result, "neck", ratings)
    stress = 32 * FORCE * 0.1 / (math.pi * 0.02**3)
    assert life.amplitude == pytest.approx(stress, rel=1e-3)
    # to the power of five, five times the error of the stress
    assert life.damage == pytest.approx(1e-6 * (stress / 200e6) ** 5, rel=5e-3)
    assert life.time == pytest.approx(0.1 / life.damage)


def test_mounts_have_swing_mean_and_transmitted_force(result):
    mount = mount_readings(result)[0]
    assert mount.swing == pytest.approx([2e-3, 2e-3, 0.0], rel=1e-6, abs=1e-9)
    assert mount.mean_travel == pytest.approx([1e-3, 0.0, 0.0], abs=1e-8)
    assert mount.largest_travel == pytest.approx(3e-3)
    floor = floor_force(result)
    assert floor.mean == pytest.approx([0.0, 0.0, -800.0], abs=1e-3) and floor.once[0] == pytest.approx(
        120.0, rel=1e-3
    )


def test_clearance_of_a_nutating_ring_is_its_farthest_reach(result):
    # a ring of radius r at depth d, tilted by t, reaches r cos t + d sin t; on the ground the frame's 3 mm
    # are added. Two degrees
    # between points of the ring and of the turn: r (1 - cos 1 deg) = 0.02 mm
    tilt = math.radians(5.0)
    reach = 0.08 * math.cos(tilt) + 0.33 * math.sin(tilt)
    assert chamber_clearance(result, (0.08, 0.33), 0.12).room == pytest.approx(0.12 - reach, abs=5e-5)
    assert chamber_clearance(result, (0.08, 0.33), 0.12, "ground").room == pytest.approx(
        0.12 - reach - 3e-3, abs=5e-5
    )


def test_clearance_from_the_moon_is_refused(result):
    with pytest.raises(CaseError, match="frame"):
        chamber_clearance(result, (0.08, 0.33), 0.12, "moon")


def test_the_path_on_the_floor_is_drawn_over_the_window_that_is_asked_for(result):
    # 2000 samples a second
    assert [len(axes.lines[0].get_xdata()) for axes in draw_floor(result, "0.25 s").axes] == [501, 501]
