"""Steady means, intervals and the power split, on records whose answers are known."""

import math

import numpy as np
import pytest

from nutamill.analysis.measured_comparison import series_in_window
from nutamill.analysis.orders import sensor_orders
from nutamill.analysis.power import power_split
from nutamill.analysis.summary import summary_lines
from nutamill.analysis.values import reading_of
from nutamill.analysis.windows import ramp_end, steady_mean, steady_window
from nutamill.base.errors import CaseError, ResultError
from nutamill.result import Recorder, open_result

RATE = 1000.0
SPEED = 2.0 * math.pi * 10.0  # ten turns a second


def record(path, end: float, ramp: float = 1.0, **series):
    """A result with a ramp of `ramp` seconds to ten turns a second; `series` are functions of time and crank
    angle.
    """
    time = np.arange(round(end * RATE) + 1) / RATE
    speed = SPEED * np.minimum(time / ramp, 1.0) if ramp else np.full_like(time, SPEED)
    angle = SPEED * (np.where(time < ramp, 0.5 * time**2 / ramp, time - 0.5 * ramp) if ramp else time)
    columns = {"time": time, "crank_angle": angle, "driveshaft_speed": speed}
    columns |= {name: function(time, angle) for name, function in series.items()}
    recorder = Recorder.create(path, "", {}, list(columns), RATE)
    recorder.append(np.stack(list(columns.values()), axis=1))
    recorder.state("complete")
    recorder.close()
    return open_result(path)


def test_ramp_ends_where_the_speed_is_reached(tmp_path):
    assert ramp_end(record(tmp_path / "a.h5", 3.0)) == 1.0
    assert ramp_end(record(tmp_path / "b.h5", 3.0, ramp=0.0)) == 0.0


def test_mean_over_whole_turns_leaves_no_part_of_the_ripple(tmp_path):
    # 0.987 s hold 9.87 turns. Trapezoids over whole turns are exact for a sine but for the two broken samples
    # at the turn
    # that begins between samples: below ripple x (phase step)^2 / turns = 50 (2 pi / 100)^2 / 9 = 0.022.
    result = record(
        tmp_path / "a.h5", 4.0037, crank_pin_force_resultant=lambda t, a: 700.0 + 50.0 * np.sin(a)
    )
    force = steady_mean(result, "crank_pin_force_resultant", last=0.987)
    assert len(steady_window(result, last=0.987).turns) == 10
    assert abs(force.mean - 700.0) < 0.022
    assert abs(force.plain_mean - 700.0) > 0.3  # the plain mean depends on the cut


def test_window_of_the_papers_is_the_plain_mean_of_the_last_three_seconds(tmp_path):
    with record(tmp_path / "a.h5", 6.0, driveshaft_torque=lambda t, a: t) as result:
        for options in ({}, {"last": "3 s"}):
            window = steady_window(result, **options)
            assert (window.start, window.end) == (3.0, 6.0)
            torque = steady_mean(result, "driveshaft_torque", **options)
            assert torque.plain_mean == pytest.approx(4.5, rel=1e-12)


def test_window_is_cut_where_the_speed_still_changed(tmp_path):
    result = record(tmp_path / "a.h5", 3.0)
    assert steady_window(result).start == 1.0
    assert steady_mean(result, "driveshaft_speed").mean == pytest.approx(SPEED, rel=1e-12)
    assert math.tau * steady_window(result).turn_rate == pytest.approx(SPEED, rel=1e-12)


def test_one_turn_gives_a_mean_without_interval(tmp_path):
    result = record(tmp_path / "a.h5", 1.15, driveshaft_torque=lambda t, a: np.ones_like(t))
    torque = steady_mean(result, "driveshaft_torque")
    assert (torque.mean, torque.turns) == (pytest.approx(1.0), 1)
    assert math.isnan(torque.half_width) and not torque.steady


def test_root_mean_square_and_swing_of_a_sine_are_known(tmp_path):
    # 100 samples a turn: the largest sample is within cos(pi/100) of the crest
    result = record(tmp_path / "a.h5", 2.0, ramp=0.0, driveshaft_torque=lambda t, a: 3.0 * np.sin(a))
    assert steady_mean(result, "driveshaft_torque", "rms").mean == pytest.approx(
        3.0 / math.sqrt(2.0), rel=1e-3
    )
    assert steady_mean(result, "driveshaft_torque", "swing").mean == pytest.approx(3.0, rel=5e-4)


def test_a_series_that_the_result_does_not_hold_is_refused(tmp_path):
    with pytest.raises(ResultError, match="has no series motor_speed"):
        steady_mean(record(tmp_path / "a.h5", 3.0), "motor_speed")


@pytest.mark.parametrize("end", [0.4, 1.05])
def test_run_that_has_not_turned_at_its_last_speed_has_no_steady_mean(tmp_path, end):
    crank = {"crank_pin_force_resultant": np.multiply, "driveshaft_torque": np.multiply}
    result = record(tmp_path / "a.h5", end, **crank)
    with pytest.raises(ResultError, match="whole turn at constant speed"):
        steady_window(result)
    assert summary_lines(result)[0].startswith("no steady means")


def test_power_is_split_as_the_ledger_says(tmp_path):
    ledger = {
        "motor_work": lambda t, a: 100.0 * t,
        "pair_normal_loss": lambda t, a: 40.0 * t,
        "pair_rolling_loss": lambda t, a: 20.0 * t,
        "wall_tangential_loss": lambda t, a: 25.0 * t,
        "mount_1_loss": lambda t, a: 2.0 * t,
        "mount_3_loss": lambda t, a: 3.0 * t,
        "elastic_energy": lambda t, a: 1.5 * np.sin(a) + 8.0 * t,
        "ledger_residual": lambda t, a: -2.0 * t,
    }
    split = power_split(record(tmp_path / "a.h5", 5.0, **ledger))
    assert split.motor == pytest.approx(100.0, rel=1e-9)
    assert split.residual == pytest.approx(-2.0, rel=1e-9)
    expected = {"pellet-pellet": 60.0, "pellet-wall": 25.0, "mounts": 5.0, "stored": 8.0}
    assert split.sinks == pytest.approx(expected, rel=1e-6)
    assert sum(split.sinks.values()) - split.motor == pytest.approx(split.residual, rel=1e-6)


def test_few_turns_give_one_plain_mean_and_no_interval(tmp_path):
    # three turns at speed whose force rises: an interval from three numbers would say nothing, two different
    # means would puzzle
    series = {
        "crank_pin_force_resultant": lambda t, a: 800.0 + 100.0 * t,
        "driveshaft_torque": lambda t, a: 9.0 + 0.0 * t,
        "driveshaft_power": lambda t, a: 650.0 + 0.0 * t,
        "motor_work": lambda t, a: 650.0 * t,
        "ledger_residual": lambda t, a: 0.0 * t,
    }
    first, second, *_ = summary_lines(record(tmp_path / "a.h5", 1.305, **series))
    assert first == "too few turns at the last speed for a test of steadiness: 3, needs 5; their plain mean:"
    middle = 1.305 - 1.5 * math.tau / SPEED
    assert second.startswith(f"crank-pin force {800.0 + 100.0 * middle:.4g} N   shaft torque 9 N m")


def test_last_lines_of_a_run_give_force_torque_power_and_shares(tmp_path):
    series = {
        "crank_pin_force_resultant": lambda t, a: np.full_like(t, 981.0),
        "driveshaft_torque": lambda t, a: np.full_like(t, 9.05),
        "driveshaft_power": lambda t, a: np.full_like(t, 663.0),
        "motor_work": lambda t, a: 663.0 * t,
        "pair_normal_loss": lambda t, a: 0.75 * 663.0 * t,
        "wall_normal_loss": lambda t, a: 0.25 * 663.0 * t,
        "ledger_residual": lambda t, a: 0.0002 * 663.0 * t,
    }
    lines = summary_lines(record(tmp_path / "a.h5", 5.0, **series))
    assert lines[0] == "steady since t = 1.00 s (stationarity test), 40 of 40 turns at this speed used"
    assert lines[1] == "crank-pin force 981 N   shaft torque 9.05 N m   power 663 W"
    assert lines[2] == "last 3 s (30 whole turns), plain mean: 981 N, 9.05 N m"
    assert lines[-1] == "where the power goes: pellet-pellet 75 %  pellet-wall 25 %  | closes to 0.02 %"


@pytest.mark.parametrize("last", ["bogus", "3 mm", "3", "-3 s", "0 s", 0.0, math.nan])
def test_a_window_without_a_length_is_refused_in_one_sentence(tmp_path, last):
    with record(tmp_path / "a.h5", 3.0, driveshaft_torque=lambda t, a: t) as result:
        for answer in (
            lambda: steady_window(result, last),
            lambda: steady_mean(result, "driveshaft_torque", last=last),
        ):
            with pytest.raises(CaseError, match=r"^last: "):
                answer()


@pytest.mark.parametrize("text", ["", "  "])
def test_an_empty_reading_is_refused_in_one_sentence(text):
    with pytest.raises(CaseError, match=r'^reading: must be a series, or "rms" or "swing" and a series'):
        reading_of(text)


def test_a_record_without_a_sample_is_refused_in_one_sentence(tmp_path):
    names = ["time", "crank_angle", "driveshaft_speed", "driveshaft_torque"]
    Recorder.create(tmp_path / "a.h5", "", {}, names, RATE).close()
    with open_result(tmp_path / "a.h5") as result:
        with pytest.raises(ResultError, match="orders: the record is empty"):
            sensor_orders(result, "driveshaft_torque")
        with pytest.raises(CaseError, match="fewer than one whole turn"):
            series_in_window(result, "driveshaft_torque", 3.0, None)


def test_the_work_of_the_machine_of_an_fmu_is_power_put_in(tmp_path):
    # 7 W by the FMU, of which 2 W are lost in the contacts and the rest is stored
    works = {
        "fmu_shaker_work": lambda t, a: 7.0 * t,
        "pair_normal_loss": lambda t, a: 2.0 * t,
        "kinetic_energy_charge": lambda t, a: 5.0 * t,
        "ledger_residual": lambda t, a: 0.0 * t,
    }
    with record(tmp_path / "a.h5", 3.0, **works) as result:
        split = power_split(result)
    # rounding of sums of two numbers near 20 J over 2 s
    assert split.motor == pytest.approx(7.0, abs=1e-12)
    assert sum(split.sinks.values()) == pytest.approx(split.motor, abs=1e-12)
