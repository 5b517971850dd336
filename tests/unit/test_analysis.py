"""Steady means, intervals and the power split, on records whose answers are known."""

import math

import numpy as np
import pytest

from nutamill.analysis.windows import power_split, ramp_end, steady_window, summary_lines
from nutamill.base.errors import ResultError
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
    steady = steady_window(result, last=0.987)
    force = steady.values["crank_pin_force_resultant"]
    assert len(steady.turns) == 10
    assert abs(force.mean - 700.0) < 0.022
    assert abs(force.window_mean - 700.0) > 0.3  # the plain mean depends on the cut


def test_window_of_the_papers_is_the_plain_mean_of_the_last_three_seconds(tmp_path):
    with record(tmp_path / "a.h5", 6.0, driveshaft_torque=lambda t, a: t) as result:
        for steady in (steady_window(result), steady_window(result, last="3 s")):
            assert (steady.start, steady.end) == (3.0, 6.0)
            assert steady.values["driveshaft_torque"].window_mean == pytest.approx(4.5, rel=1e-12)


def test_window_is_cut_where_the_speed_still_changed(tmp_path):
    steady = steady_window(record(tmp_path / "a.h5", 3.0), names=["driveshaft_speed"])
    assert steady.start == 1.0
    assert steady.values["driveshaft_speed"].mean == pytest.approx(SPEED, rel=1e-12)


def test_interval_is_that_of_student_for_the_scatter_of_the_turns(tmp_path):
    # 20 turns, each with its own constant level: ten batches of two. Levels jump between two samples, so that
    # a trapezoid
    # smears a jump over one sample of a hundred: 1 % of a jump at most.
    levels = np.random.default_rng(5).normal(10.0, 1.0, 100)
    result = record(
        tmp_path / "a.h5",
        2.0,
        ramp=0.0,
        driveshaft_torque=lambda t, a: levels[(a / math.tau + 1e-9).astype(int)],
    )
    found = steady_window(result, last=2.0).values["driveshaft_torque"]
    batches = levels[:20].reshape(10, 2).mean(axis=1)
    student = 2.262157  # two-sided 95 %, 9 degrees of freedom (tables)
    assert found.mean == pytest.approx(levels[:20].mean(), abs=0.01)
    assert found.half_width == pytest.approx(student * batches.std(ddof=1) / math.sqrt(10.0), rel=0.05)


def test_one_turn_gives_a_mean_without_interval(tmp_path):
    found = steady_window(record(tmp_path / "a.h5", 1.15, driveshaft_torque=lambda t, a: np.ones_like(t)))
    assert found.values["driveshaft_torque"].mean == pytest.approx(1.0)
    assert math.isnan(found.values["driveshaft_torque"].half_width)


@pytest.mark.parametrize("end", [0.4, 1.05])
def test_run_that_has_not_turned_at_its_last_speed_has_no_steady_mean(tmp_path, end):
    result = record(tmp_path / "a.h5", end)
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
    assert lines[0] == "steady since t = 1.00 s (stationarity test), 40 of 40 turns at this speed kept"
    assert lines[1] == "crank-pin force 981 N   shaft torque 9.05 N m   power 663 W"
    assert lines[2] == "last 3 s (30 whole turns), plain mean: 981 N, 9.05 N m"
    assert lines[-1] == "where the power goes: pellet-pellet 75 %  pellet-wall 25 %  | closes to 0.02 %"
