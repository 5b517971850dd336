"""Forecasts of time, memory and disk, and warnings where they are too large."""

import itertools
from types import SimpleNamespace

import numpy as np
import pytest

from nutamill.base.host import free_disk, total_memory
from nutamill.case import load_case
from nutamill.charge.filling.fill import time_of_rest
from nutamill.cli.screen import line
from nutamill.design.charge_facts import charge_facts
from nutamill.design.forecast import Forecast
from nutamill.design.machine_sheet import machine_sheet
from nutamill.design.preflight import preflight
from nutamill.simulation import progress, trial
from nutamill.simulation.setup.threads import usable_cores

RIGID = "mechanism.mounting=rigid"
DAY = 86400.0


@pytest.mark.parametrize(
    ("wall_time", "memory", "file_size", "warned"),
    [
        (DAY, 4e9, 50e9, []),
        (DAY + 1.0, 4e9, 50e9, ["the run takes about 24.0 h, more than a day. Key T brings it down"]),
        (
            DAY,
            4.1e9,
            50e9,
            ["the memory takes about 4100 MB, more than half of the 8000 MB of memory. Key M brings it down"],
        ),
        (
            DAY,
            4e9,
            51e9,
            [
                "the file takes about 51 GB, more than half of the 100 GB free on the disk. Key F "
                "brings it down"
            ],
        ),
    ],
)
def test_more_than_a_day_or_half_of_the_memory_or_disk_is_warned_of(wall_time, memory, file_size, warned):
    forecast = Forecast(wall_time, memory, file_size, "Key T", "Key M", "Key F")
    assert [str(warning) for warning in forecast.warnings(8e9, 100e9)] == [
        f"forecast: {text}" for text in warned
    ]
    # a system that does not say what it has
    assert all("more than a day" in str(warning) for warning in forecast.warnings(None, None))


def test_the_sheet_warns_of_a_hundred_to_one_in_size_with_its_cost():
    ore = {"kind": "spheres", "material": "steel"}
    parts = [ore | {"diameter": "0.1 mm", "count": 5000}, ore | {"diameter": "10 mm", "count": 1}]
    with_grains = load_case("numill", [RIGID]).with_("charge", {"part": parts})
    (warning,) = charge_facts(with_grains.machine).warnings
    # grains of diameter d on the sphere of their centres, (D + d)/2, a hexagon of area d^2 sqrt(3)/2 each
    assert str(warning) == (
        "charge: the largest sphere is 100 times as wide as the smallest, 0.1 mm, and may touch 3.7e+04 of "
        "them at once. All 5001 spheres march with the substep of the smallest. A larger smallest size makes "
        "the run shorter"
    )
    assert charge_facts(load_case("numill", [RIGID, "charge.count=50"]).machine).warnings == []


def test_the_sheet_warns_of_a_run_of_months_and_of_threads_that_are_not_there():
    cores = usable_cores()
    case = load_case(
        "numill",
        [
            RIGID,
            "charge.count=2000",
            "run.until=20000 s",
            f"run.threads={cores + 1}",
            "run.series_rate=10 Hz",
        ],
    )
    sheet = preflight(case)
    assert [warning.where for warning in sheet.warnings] == ["run.threads", "forecast"]
    lines = sheet.lines()
    assert lines[0].endswith(": ok, 2 warnings")
    assert f"asks for {cores + 1} threads on a machine with {cores} core" in lines[1]
    assert lines[2].endswith(
        "Coarser particles (charge.diameter), softer contacts or an earlier run.until brings it down"
    )


def test_a_small_run_on_the_cores_there_are_is_not_warned_of():
    case = load_case(
        "numill",
        [RIGID, "charge.count=20", "run.until=1 s", f"run.threads={usable_cores()}", "drive.ramp=7000 rpm/s"],
    )
    assert preflight(case).warnings == []


def test_the_machine_has_memory_and_room(tmp_path):
    assert total_memory() is None or total_memory() > 1e8
    # a folder that is still to be made is on the disk of the one it will be made in
    assert free_disk(tmp_path / "not" / "there" / "yet.h5") == pytest.approx(free_disk(tmp_path), rel=0.1)


# trials -----------------------------------------------------------------------------------------------------

EMPTY = load_case("numill", [RIGID, "charge.kind=none", "run.until=10 s"])


@pytest.fixture
def slow_rows(monkeypatch):
    """A clock that only the march of rows moves, 2 ms for each: a function that returns the time [s]."""
    now, enter = [0.0], trial.enter

    def slow(model, state, scratch, count):
        now[0] += 2e-3 * count
        return enter(model, state, scratch, count)

    monkeypatch.setattr(trial, "enter", slow)
    monkeypatch.setattr(trial, "TRIAL_TIME", 2.0)
    monkeypatch.setattr(trial, "is_compiled", lambda law, engine: True)
    return lambda: now[0]


def test_a_trial_returns_the_time_of_a_simulated_second_and_stops_after_two_seconds(slow_rows):
    assert trial.trial_rate(EMPTY.machine, slow_rows) == pytest.approx(2e-3 * EMPTY.run.series_rate)
    assert trial.TRIAL_TIME < slow_rows() < 1.5 * trial.TRIAL_TIME


def test_a_trial_marches_at_the_largest_speed_of_the_drives(slow_rows):
    machine = trial.at_speed(EMPTY.with_("drive.speed", "500 rpm").machine)
    times, speeds = machine.drives[0].breakpoints()
    assert times[-1] == trial.JUMP
    assert speeds[-1] == pytest.approx(500 * 2 * np.pi / 60)


def test_nothing_is_tried_where_nothing_is_compiled(monkeypatch):
    monkeypatch.setattr(trial, "TRIAL_TIME", 2.0)
    monkeypatch.setattr(trial, "is_compiled", lambda law, engine: False)
    monkeypatch.setattr(trial, "build", None)  # not reached
    assert trial.trial_rate(EMPTY.machine) is None


@pytest.mark.parametrize("sheet", [preflight, machine_sheet])
def test_a_sheet_forecasts_by_its_trial(sheet):
    case = EMPTY if sheet is preflight else EMPTY.machine
    assert "(by a table)" in sheet(case).lines()[-1]
    asked = []
    timed = sheet(case, lambda machine: asked.append(machine) or 7.0)
    assert asked == [EMPTY.machine]
    assert "about 70 s (by a trial)" in timed.lines()[-1]


# while a run goes on ----------------------------------------------------------------------------------------


@pytest.fixture
def watched(monkeypatch):
    """A watch of a run of 10 s, the list of its reports, and its wall clock in a list."""
    now, reports = [0.0], []
    monkeypatch.setattr(progress.wall, "monotonic", lambda: now[0])
    return progress.Watch(EMPTY, reports.append), reports, now


def test_time_left_follows_the_pace_of_the_last_ten_seconds(watched):
    watch, reports, now = watched
    model = SimpleNamespace(clock=SimpleNamespace(substep=1e-3), charge=None)
    # 100 seconds at 0.02 s per second, then 20 seconds at half that pace
    paces = itertools.chain([0.02] * 100, [0.01] * 20)
    for simulated in np.cumsum(list(paces)):
        now[0] += 1.0
        watch.marched(model, ("time",), np.array([[simulated]]), 10.0, SimpleNamespace(size=0))
    assert reports[-1].rate == pytest.approx(0.01)
    assert reports[-1].time_left == pytest.approx((10.0 - 2.2) / 0.01)
    assert reports[90].time_left == pytest.approx((10.0 - reports[90].time) / 0.02)


def test_settling_reports_its_share_and_the_time_left(watched):
    watch, reports, now = watched
    watch.settling(0.0)
    now[0] = 30.0  # the particles are placed
    for share in (0.1, 0.2, 0.4):
        now[0] += 100.0 * (share - (reports[-1].fraction if reports else 0.0))
        watch.settling(share)
    assert reports[-1].time_left == pytest.approx(60.0)
    assert line(reports[-1]) == "settle  40 %  the charge comes to rest  left 0:01:00"


def test_a_bed_whose_energy_falls_exponentially_is_at_rest_when_foreseen():
    times = 0.002 * np.arange(1, 200)
    energies = np.where(times < 0.05, times, 0.05 * np.exp((0.05 - times) / 0.03))
    rest = 0.05 + 0.03 * np.log(0.05 / 1e-6)
    for count in (40, 100, 180):
        assert time_of_rest(times[:count], energies[:count], 1e-6, 1.0) == pytest.approx(rest)
    # a charge that still falls down, and one that never comes to rest
    assert time_of_rest(times[:20], energies[:20], 1e-6, 1.0) == 1.0
    assert time_of_rest(times, np.full(199, 0.01), 1e-6, 1.0) == 1.0
