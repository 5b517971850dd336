"""Figures by name, and the spectra behind them."""

import math

import numpy as np
import pytest
from scipy.integrate import trapezoid

from nutamill.analysis.spectra import spectrum
from nutamill.base.errors import CaseError, ResultError
from nutamill.result import Recorder, open_result
from nutamill.view.figures.named import figure_of, write_figures

RATE = 1000.0
TIME = np.arange(4000) / RATE


def test_area_under_a_spectrum_is_the_variance():
    """A sine of amplitude 3 has variance 4.5 wherever its mean is; noise of variance 4 adds to it, itself
    within 4 sqrt(2/4000).
    """
    noise = 2.0 * np.random.default_rng(2).standard_normal(4000)
    power = spectrum(7.0 + 3.0 * np.sin(math.tau * 50.0 * TIME) + noise, RATE)
    assert trapezoid(power.density, power.frequency) == pytest.approx(8.5, abs=4 * 4 * math.sqrt(2 / 4000))
    assert power.frequency[power.density.argmax()] == pytest.approx(50.0, abs=1.0)


def test_orbit_points_to_the_mean_of_the_mass_centre_behind_the_crank(filmed):
    """The film's mass centre goes round at 50 mm, 0.7 rad behind the crank."""
    axes = figure_of(filmed, "orbit").axes[0]
    mean = next(line for line in axes.lines if line.get_label() == "mean")
    assert (mean.get_xdata()[1], mean.get_ydata()[1]) == pytest.approx(
        (50 * math.cos(0.7), -50 * math.sin(0.7)), rel=1e-3
    )


def test_orbit_has_the_bore_and_the_crank_pin(filmed):
    """Crank radius 39 mm; the chamber's axis leans by 39 mm on 366 mm, and the charge is 280 mm below the
    nutation point, so that the bore of 140 mm is 29.84 mm off the shaft's axis there.
    """
    lines = {line.get_label(): line for line in figure_of(filmed, "orbit").axes[0].lines}
    assert (lines["crank pin"].get_xdata()[0], lines["crank pin"].get_ydata()[0]) == pytest.approx(
        (39.0, 0.0)
    )
    x = lines["bore"].get_xdata()
    assert (x.min(), x.max()) == pytest.approx((29.836 - 70.0, 29.836 + 70.0), abs=1e-3)


def test_a_spectrum_names_its_quantity(filmed):
    label = figure_of(filmed, "spectrum:driveshaft_torque").axes[0].get_ylabel()
    assert " ".join(label.split()) == "power spectral density ((N m)²/Hz)"


def test_figures_are_written_beside_each_other_with_their_names(filmed, tmp_path):
    wanted = [
        "run",
        "power",
        "orbit",
        "history:driveshaft_torque,crank_angle",
        "spectrum:driveshaft_torque",
        "orders:driveshaft_torque",
    ]
    files = write_figures(filmed, wanted, tmp_path / "here")
    assert [file.name for file in files][3] == "filmed-history-driveshaft_torque-crank_angle.png"
    assert all(5_000 < file.stat().st_size < 1_000_000 for file in files)


def test_torque_of_the_film_repeats_twice_a_turn(filmed):
    axes = figure_of(filmed, "spectrum:driveshaft_torque").axes[0]
    frequency, density = axes.lines[0].get_data()
    assert frequency[np.nanargmax(density)] == pytest.approx(
        2 * 60.0 / math.tau, abs=4.0
    )  # a quarter of 0.5 s: lines every 8 Hz


def test_orders_are_drawn_over_time_where_the_speed_stays_and_over_speed_where_it_changes(filmed, tmp_path):
    assert figure_of(filmed, "orders:driveshaft_torque").axes[0].get_xlabel() == "time (s)"
    names = ["time", "crank_angle", "driveshaft_speed", "driveshaft_torque"]
    recorder = Recorder.create(tmp_path / "a.h5", "", {}, names, RATE)
    recorder.append(np.stack([TIME, 10.0 * TIME**2, 20.0 * TIME, np.cos(10.0 * TIME**2)], axis=1))
    recorder.close()
    with open_result(tmp_path / "a.h5") as run_up:
        axes = figure_of(run_up, "orders:driveshaft_torque").axes[0]
    assert axes.get_xlabel() == "speed (rpm)"
    assert axes.get_xlim()[1] == pytest.approx(
        20.0 * 4.0 * 30.0 / math.pi, rel=0.2
    )  # the last window ends at 80 rad/s


@pytest.mark.parametrize(
    "what", ["runn", "spectrum", "run:driveshaft_torque", "spectrum:torque", "history:mount_1_force_x"]
)
def test_figure_or_series_that_is_not_there_is_named(filmed, what):
    with pytest.raises(CaseError, match="must be"):
        figure_of(filmed, what)


def test_orbit_of_an_empty_chamber_is_refused(tmp_path):
    recorder = Recorder.create(tmp_path / "a.h5", "", {}, ["time", "crank_angle", "driveshaft_speed"], RATE)
    recorder.append(np.stack([TIME, 60.0 * TIME, np.full_like(TIME, 60.0)], axis=1))
    recorder.close()
    with open_result(tmp_path / "a.h5") as result, pytest.raises(ResultError, match="must hold a charge"):
        figure_of(result, "orbit")
