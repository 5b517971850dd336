"""Orders, load paths and rods of signals that are known."""

import math

import numpy as np
import pytest

from nutamill.analysis.load_paths import joint_reaction, load_paths
from nutamill.analysis.orders import peaks, sensor_orders, spectra, track
from nutamill.analysis.rods import rod_tensions, yoke_rods
from nutamill.analysis.summary import hours_text
from nutamill.base.errors import CaseError, ResultError
from nutamill.case import load_case
from nutamill.result import Recorder, open_result
from nutamill.result.fields import expand

RATE = 2000.0


@pytest.fixture
def result(tmp_path):
    """Two seconds at ten turns a second: at every joint 100 N out along the crank and 20 N m about z, 7 N
    down, frame yawed by 30 deg.
    """
    names = expand(mounts=4, sensors=())
    time = np.arange(4001) / RATE
    angle = 62.832 * time
    half = np.radians(15.0)
    known = {"time": time, "crank_angle": angle, "driveshaft_speed": np.full_like(time, 62.832)}
    for joint in ("crank_pin_load_cell", "yoke_pivot"):
        known |= {
            f"{joint}_reaction_force_x": 100 * np.cos(angle),
            f"{joint}_reaction_force_y": 100 * np.sin(angle),
        }
        known |= {
            f"{joint}_reaction_force_z": np.full_like(time, -7.0),
            f"{joint}_reaction_moment_z": np.full_like(time, 20.0),
        }
    known |= {
        "frame_attitude_w": np.full_like(time, np.cos(half)),
        "frame_attitude_z": np.full_like(time, np.sin(half)),
    }
    known |= {
        "driveshaft_attitude_w": np.cos(angle / 2),
        "driveshaft_attitude_z": np.sin(angle / 2),
        "chamber_attitude_w": np.ones_like(time),
    }
    case = load_case("numill-2025", ["mechanism.mounting=flexible"])
    recorder = Recorder.create(tmp_path / "a.h5", case.to_toml(), {}, names, RATE)
    recorder.append(np.stack([known.get(name, np.zeros_like(time)) for name in names], axis=1))
    recorder.close()
    with open_result(tmp_path / "a.h5") as opened:
        yield opened


def test_orders_of_a_run_up_are_those_of_the_signal():
    # 3 cos(angle - 0.7) + 2 cos(2 angle + 1) + 5 while the speed rises from 2 to 20 turns a second: the
    # window is whole turns, so
    # that only linear interpolation between samples is left, (order x 20 turns x 2 pi / 4800 s)^2 / 12 < 3e-4
    # of 3
    time = np.arange(0.0, 8.0, 1 / 4800)
    angle = 2 * np.pi * (2.0 * time + 9.0 / 8.0 * time**2)
    value = 3.0 * np.cos(angle - 0.7) + 2.0 * np.cos(2 * angle + 1.0) + 5.0
    orders = track(time, angle, value)
    assert orders.amplitude[0] == pytest.approx(3.0, abs=1e-3) and orders.lag[0] == pytest.approx(
        0.7, abs=1e-3
    )
    assert orders.amplitude[1] == pytest.approx(2.0, abs=2e-3) and orders.lag[1] == pytest.approx(
        -1.0, abs=2e-3
    )
    assert orders.speed == pytest.approx(2 * np.pi * (2.0 + 2.25 * orders.time), rel=1e-3)


def test_peak_of_an_order_is_at_its_speed():
    # a bell over time: four turns at ten a second are 0.4 s, Hann-weighted 0.15 s wide, and flatten a bell of
    # 1 s by (0.07/1)^2 / 2
    time = np.arange(0.0, 10.0, 1 / 2000)
    angle = 2 * np.pi * time**2
    value = np.exp(-0.5 * (time - 5.0) ** 2) * np.cos(angle)
    peak = peaks(track(time, angle, value, (1.0,)))[0]
    assert peak.time == pytest.approx(5.0, abs=0.1) and peak.amplitude == pytest.approx(1.0, abs=0.01)
    assert peak.speed == pytest.approx(2 * np.pi * 10.0, rel=0.02)


def test_too_few_turns_for_an_order_are_refused():
    time = np.arange(0.0, 1.0, 1e-3)
    with pytest.raises(ResultError, match="must have 4 turns of the drive, got 2"):
        track(time, 4 * np.pi * time, time)


def test_spectra_have_the_amplitude_of_a_sine():
    time = np.arange(0.0, 4.0, 1 / 1000)
    lines = spectra(time, 60 * time, 2.5 * np.sin(2 * np.pi * 12.0 * time))
    line = lines.amplitude[np.argmin(np.abs(lines.frequency - 12.0))]
    assert line == pytest.approx(2.5, rel=1e-6)  # a whole number of periods in each window


def test_series_that_is_not_recorded_is_refused(result):
    with pytest.raises(CaseError, match="must be recorded"):
        sensor_orders(result, "frame_corner_acceleration_x")


def test_reaction_that_turns_with_the_crank_stands_still_in_crank_axes(result):
    assert joint_reaction(result, "crank_pin_load_cell", "crank") == pytest.approx(
        np.tile([100, 0, -7, 0, 0, 20], (4001, 1)), abs=1e-9
    )
    yawed = joint_reaction(result, "crank_pin_load_cell", "frame")[0, :2]
    assert yawed == pytest.approx([100 * np.cos(np.radians(30)), -100 * np.sin(np.radians(30))])


def test_statistics_of_a_turning_force(result):
    # interpolation between samples of a turn of 200: (pi / 200)^2 / 2 = 1.2e-4
    paths = load_paths(result)
    x = paths.sel(joint="crank_pin_load_cell", axes="ground", part="force_x")
    assert x.sel(statistic="mean") == pytest.approx(0.0, abs=0.02) and x.sel(statistic="1x") == pytest.approx(
        100.0, rel=2e-4
    )
    assert x.sel(statistic="rms") == pytest.approx(100 / np.sqrt(2), rel=2e-4) and x.sel(
        statistic="2x"
    ) == pytest.approx(0.0, abs=0.02)
    crank = paths.sel(joint="crank_pin_load_cell", axes="crank", part="force_x")
    assert crank.sel(statistic="mean") == pytest.approx(100.0, rel=2e-4) and crank.sel(
        statistic="1x"
    ) == pytest.approx(0.0, abs=0.02)
    assert paths.sel(
        joint="crank_pin_load_cell", axes="frame", part="force", statistic="peak"
    ) == pytest.approx(np.hypot(100, 7), rel=2e-4)


@pytest.mark.parametrize(("joint", "axes"), [("crankpin", "frame"), ("pin_joint", "moon")])
def test_unknown_joint_or_axes_are_refused(result, joint, axes):
    with pytest.raises(CaseError, match=r"Recorded are|Known are"):
        joint_reaction(result, joint, axes)


def test_rods_share_a_load_as_the_laws_of_the_lever_say(result):
    # 100 N along x at the nutation point goes into the rod along x alone; 20 N m about z into the pair along
    # y, 0.3 m apart; a
    # pull of 7 N up is shared by the three upright rods, whose centre is the point
    rods = yoke_rods(result)
    along_x = rods.tension[:, rods.names.index("along_x")]
    frame_x = 100 * np.cos(rods.angle - np.radians(30))
    assert along_x == pytest.approx(frame_x, abs=0.05)
    upright = rods.tension[:, :3]
    assert upright == pytest.approx(np.full_like(upright, -7.0 / 3.0), abs=1e-6)
    pair = rods.tension[:, 3] - rods.tension[:, 4]
    assert pair == pytest.approx(np.full_like(pair, 2 * 20.0 / 0.3), rel=1e-6)


def test_rods_that_leave_the_yoke_free_are_refused():
    points, along = np.zeros((6, 3)), np.vstack([np.eye(3), np.eye(3)])
    with pytest.raises(CaseError, match="must hold all six motions"):
        rod_tensions(points, along, np.zeros((1, 3)), np.zeros((1, 3)))


def test_life_beyond_any_use_is_not_printed_to_the_hour():
    assert hours_text(250 * 3600.0).strip() == "250"
    assert hours_text(1e38).strip() == hours_text(math.inf).strip() == "> 1e+07"
