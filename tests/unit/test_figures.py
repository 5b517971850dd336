"""Figures of a small synthetic run: they say what they show, in SI, and mark the end of the ramp."""

import numpy as np
import pytest

from nutamill.base.errors import ResultError
from nutamill.case import load_case
from nutamill.design.campbell import Campbell
from nutamill.design.figures import draw_campbell
from nutamill.result import Recorder, open_result
from nutamill.result.fields import expand
from nutamill.simulation import runs
from nutamill.view.figures.named import figure_of
from nutamill.view.figures.run import draw_ledger, draw_run

RATE = 1000.0


@pytest.fixture
def result(tmp_path):
    """Seven seconds: ramp to ten turns a second in two, then steady; sensor ``drive_end``."""
    names = expand(mounts=1, sensors=("drive_end",))
    time = np.arange(7001) / RATE
    speed = 62.832 * np.minimum(time / 2.0, 1.0)
    angle = np.cumsum(speed) / RATE
    known = {
        "time": time,
        "crank_angle": angle,
        "driveshaft_speed": speed,
        "crank_pin_force_resultant": 0.1 * speed**2 * (1.0 + 0.2 * np.cos(2.0 * angle)),
        "driveshaft_torque": 5.0 + np.sin(2.0 * angle),
        "drive_end_acceleration_x": 3.0 * np.cos(angle),
        "motor_work": 300.0 * time,
        "pair_normal_loss": 200.0 * time,
        "mount_1_loss": 100.0 * time,
    }
    recorder = Recorder.create(tmp_path / "a.h5", "", {}, names, RATE)
    recorder.append(np.stack([known.get(name, np.zeros_like(time)) for name in names], axis=1))
    recorder.close()
    with open_result(tmp_path / "a.h5") as opened:
        yield opened


def test_picture_of_a_run_has_four_labelled_panels(result, tmp_path):
    figure = draw_run(result)
    units = ["force (N)", "torque (N m)", "acceleration (m/s$^2$)", "acceleration (m/s$^2$)"]
    assert [axes.get_ylabel() for axes in figure.axes] == units
    assert figure.axes[-1].get_xlabel() == "time (s)"
    figure.savefig(tmp_path / "a.png")
    assert 10_000 < (tmp_path / "a.png").stat().st_size < 1_000_000


def test_dashed_line_stands_at_the_end_of_the_ramp_in_every_panel(result):
    for axes in draw_run(result).axes:
        marks = [line for line in axes.lines if line.get_label() == "end of ramp"]
        assert [mark.get_xdata()[0] for mark in marks] == [2.0]


def test_band_holds_every_sample_and_line_is_the_mean_over_a_turn(result):
    axes = draw_run(result).axes[1]
    band = axes.collections[0].get_paths()[0].get_extents()
    assert band.y0 == pytest.approx(result.series["driveshaft_torque"].values.min())
    assert band.y1 == pytest.approx(result.series["driveshaft_torque"].values.max())
    mean = next(line for line in axes.lines if line.get_label() == "mean over a turn").get_ydata()
    # at ten turns a second 100 samples make a turn: a linear interpolation of the integral is wrong by
    # (0.063)^2 / 8 at most
    assert np.abs(mean[len(mean) // 2 :] - 5.0).max() < 5e-4


def test_rigid_machine_without_sensor_gives_two_panels(tmp_path):
    names = ["time", "crank_angle", "driveshaft_speed", "crank_pin_force_resultant", "driveshaft_torque"]
    time = np.arange(500) / RATE
    recorder = Recorder.create(tmp_path / "b.h5", "", {}, names, RATE)
    recorder.append(np.stack([time, 60.0 * time, np.full_like(time, 60.0), time, time], axis=1))
    recorder.close()
    with open_result(tmp_path / "b.h5") as result:
        figure = draw_run(result)
    assert len(figure.axes) == 2
    assert not [line for line in figure.axes[0].lines if line.get_label() == "end of ramp"]


def test_stack_of_losses_reaches_the_power_of_the_motor(result):
    axes = draw_ledger(result).axes[0]
    top = max(path.get_paths()[0].get_extents().y1 for path in axes.collections)
    motor = next(line for line in axes.lines if line.get_label() == "motor").get_ydata()
    assert top == pytest.approx(300.0, rel=1e-6)
    assert motor == pytest.approx(300.0, rel=1e-6)
    assert axes.get_ylabel() == "power (W)"


@pytest.fixture
def short(tmp_path):
    """Two and a half seconds, 24 turns: the torque steps at 1 s, the motor gives 300 W, 200 W are lost, and
    0.2 W elsewhere.
    """
    names = ["time", "crank_angle", "driveshaft_speed", "driveshaft_torque", "crank_pin_force_resultant"]
    names += ["motor_work", "pair_normal_loss", "coupling_loss"]
    time = np.arange(2501) / RATE
    works = [power * time for power in (300.0, 200.0, 0.2)]
    columns = [time, 60.0 * time, np.full_like(time, 60.0), 1.0 * (time > 1.0), time, *works]
    recorder = Recorder.create(tmp_path / "short.h5", "", {}, names, RATE)
    recorder.append(np.stack(columns, axis=1))
    recorder.close()
    with open_result(tmp_path / "short.h5") as opened:
        yield opened


def test_of_few_turns_every_sample_is_drawn_and_no_step_is_widened(short):
    axes = draw_run(short).axes[1]
    samples = next(line for line in axes.lines if line.get_label() == "samples")
    assert np.array_equal(samples.get_ydata(), short.series["driveshaft_torque"].values)
    assert not axes.collections


def test_power_that_is_stored_is_named_and_losses_that_are_none_are_not(short):
    axes = draw_ledger(short).axes[0]
    areas = {str(area.get_label()): area.get_paths()[0].get_extents() for area in axes.collections}
    assert sorted(areas) == ["pellet-pellet", "stored or returned"]
    gap = areas["stored or returned"]
    assert (gap.y0, gap.y1) == pytest.approx((200.2, 300.0), rel=1e-9)


def test_losses_that_are_none_beside_what_is_stored_leave_the_line_alone(tmp_path):
    # the bearings of a drum take less than a thousandth of what the motor puts into it in its first 40 ms
    drum = load_case("tumbling-mill", ["charge.kind=none", "run.until=40 ms"])
    with runs.run(drum, tmp_path / "ramp.h5") as result:
        axes = draw_ledger(result).axes[0]
    assert [str(area.get_label()) for area in axes.collections] == ["stored or returned"]


def test_every_named_figure_names_its_run(filmed):
    from nutamill.view.figures.named import figure_of

    for what in ("run", "history:driveshaft_torque"):
        title = figure_of(filmed, what).get_suptitle()
        assert " ".join(title.split()) == (
            "numill-2026 with mechanism.mounting = rigid 573 rpm, 1.347 kg of steel 5 mm"
        )


def test_a_campbell_diagram_marks_the_working_speed():
    speeds = np.linspace(0.0, 90.0, 3)
    diagram = Campbell(speeds, np.full((3, 1), 8.0), np.full((3, 1), 0.05), ("sway",), (), 70.0 * np.pi / 3)
    axes = draw_campbell(diagram).axes[0]
    (line,) = (line for line in axes.lines if str(line.get_label()).startswith("working speed"))
    assert line.get_label() == "working speed, 700 rpm"
    assert line.get_xdata()[0] == pytest.approx(700.0)


@pytest.mark.parametrize("what", ["run", "power", "history:time"])
@pytest.mark.parametrize(("samples", "held"), [(0, "no sample"), (1, "one sample")])
def test_a_curve_needs_two_samples(what, samples, held, tmp_path):
    recorder = Recorder.create(tmp_path / "a.h5", "", {}, ["time", "driveshaft_torque"], RATE)
    recorder.append(np.zeros((samples, 2)))
    recorder.close()
    with open_result(tmp_path / "a.h5") as result, pytest.raises(ResultError, match=f"holds {held} to draw"):
        figure_of(result, what)
