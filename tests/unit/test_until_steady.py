"""A run that ends when it is steady: where it ends, that it ends there however often it stops, and what it
says if it never does.
"""

import math
import os
import re
import signal

import numpy as np
import pytest

from nutamill.base.errors import CaseError, NotSteadyError
from nutamill.case import load_case
from nutamill.simulation import runs
from nutamill.simulation.record import Ending

OVERRIDES = [
    "mechanism.mounting=rigid",
    "charge.kind=none",
    "drive.ramp=10000 rpm/s",
    "run.until=steady",
    "run.max=2 s",
    "run.checkpoint=0.1 s",
    "run.snapshots.last=0.05 s",
]


@pytest.fixture
def case():
    """The empty mill on rigid mounts, at 700 rpm after 0.07 s: a turn lasts 86 ms, and five whole turns end
    before 0.5 s.
    """
    return load_case("numill", OVERRIDES)


def test_steady_mill_ends_soon_after_five_turns_and_the_time_of_its_snapshots(case, tmp_path):
    with runs.run(case, tmp_path / "a.h5") as result:
        assert result.state == "complete"
        # ramp 0.07 s and five turns of 0.0857 s: at the checkpoint of 0.5 s at the earliest; then snapshots
        # for 0.05 s
        end = result.series["time"].values[-1]
        assert 0.55 - 1e-9 <= end < 1.0
        assert 10.0 * (end - 0.05) == pytest.approx(round(10.0 * (end - 0.05)), abs=1e-6)
        assert result.snapshots.time[0] == pytest.approx(end - 0.05, abs=1e-9)


def test_run_that_stops_and_goes_on_ends_where_the_run_that_never_stopped_does(case, tmp_path, monkeypatch):
    monkeypatch.setattr("nutamill.simulation.progress.PAUSE", 0.0)
    runs.run(case, tmp_path / "whole.h5").close()

    def interrupt(progress):
        if progress.time > 0.31:
            os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        runs.run(case, tmp_path / "parts.h5", interrupt)
    runs.resume(tmp_path / "parts.h5").close()
    with runs.open_result(tmp_path / "whole.h5") as whole, runs.open_result(tmp_path / "parts.h5") as parts:
        assert whole.series.drop_attrs().identical(parts.series.drop_attrs())
        assert list(whole.snapshots.time) == list(parts.snapshots.time)


def test_a_run_that_is_never_steady_ends_with_a_message_and_can_go_on(case, tmp_path):
    short = case.with_(run__max=0.3)
    with pytest.raises(
        NotSteadyError,
        match=r"not steady after 0\.3 s: fewer than 5 whole turns at full speed\. Go on with: nutamill",
    ) as raised:
        runs.run(short, tmp_path / "a.h5")
    assert raised.value.exit_code == 3
    with runs.open_result(tmp_path / "a.h5") as result:
        assert result.state == "not steady: fewer than 5 whole turns at full speed"
    with runs.resume(tmp_path / "a.h5", until=2.0) as result, runs.run(case, tmp_path / "b.h5") as whole:
        assert result.state == "complete"
        assert np.array_equal(result.series["driveshaft_torque"], whole.series["driveshaft_torque"])


def test_a_steady_run_goes_on_to_a_later_end(case, tmp_path):
    runs.run(case, tmp_path / "a.h5").close()
    with runs.resume(tmp_path / "a.h5", until=0.7) as result:
        assert result.state == "complete"
        assert result.series["time"].values[-1] == pytest.approx(0.7, abs=1e-9)


def played(case, force, torque, end=2.0):
    """An ending that has seen a record of `end` seconds, looked at as a march does; `force` and `torque` are
    functions of time.
    """
    time = np.arange(round(end * case.run.series_rate) + 1) / case.run.series_rate
    angle = case.drive.speed * np.maximum(time - 0.5 * case.drive.ramp_end, 0.0)
    ending = Ending(case.machine, case.run.end)
    ending.replay(np.column_stack([time, angle, force(time), torque(time)]))
    return ending


def test_drifting_torque_keeps_a_run_from_ending_and_is_named(case):
    # 10 N m + 5 N m/s: over the half of the record that counts, about 1 s, it rises by 5 of some 17 N m
    ending = played(case, lambda t: np.full_like(t, 700.0), lambda t: 10.0 + 5.0 * t)
    assert not ending.steady
    # at the last look half of the record is cut off, and its mean is near 10 + 5 x 1.5 N m; a turn of 0.0857
    # s adds 0.43 N m, 2.4 %
    assert re.fullmatch(r"driveshaft torque still drifts \+2\.[2-5] % per turn", ending.missed)


def test_scatter_keeps_a_run_from_ending_until_the_mean_is_known_well_enough(case):
    # turns scatter by 5 %: a half width of 1 % needs (1.96 x 5)^2 ~ 96 of them, 8.2 s; 2 s hold 22
    levels = np.random.default_rng(5).normal(10.0, 0.5, 100)
    noisy = lambda t: levels[(case.drive.speed * t / math.tau).astype(int)]  # noqa: E731
    ending = played(case, lambda t: np.full_like(t, 700.0), noisy)
    assert not ending.steady
    assert (
        "driveshaft torque is known to ± " in ending.missed and "run.precision asks for 0.01" in ending.missed
    )
    assert played(case.with_(run__precision=0.1), lambda t: np.full_like(t, 700.0), noisy).steady


def test_torque_that_is_none_does_not_keep_a_run_from_ending(case):
    noise = np.random.default_rng(1)
    assert played(
        case, lambda t: np.full_like(t, 700.0), lambda t: 1e-9 * noise.standard_normal(len(t))
    ).steady


def test_record_is_looked_at_in_the_columns_it_was_written_in(case):
    ending = Ending(case.machine, 2.0)
    ending.recorded(("crank_angle", *ending.columns[2:], "time"), np.array([[1.0, 2.0, 3.0, 4.0]]))
    assert np.concatenate(ending._columns).tolist() == [[4.0, 1.0, 2.0, 3.0]]


def test_record_that_is_replayed_is_the_record_row_by_row(case):
    columns = np.random.default_rng(2).standard_normal((1100, 5))  # two checkpoints of 480 rows, and more
    ending = Ending(case.machine, case.run.end)
    ending.replay(columns)
    assert np.array_equal(np.concatenate(ending._columns), columns)


def test_longest_time_and_precision_stand_in_the_case_of_a_steady_run_only():
    steady = load_case("numill", ["run.until=steady"])
    assert (steady.run.max, steady.run.precision, steady.run.end) == (30.0, 0.01, 30.0)
    assert 'until       = "steady"' in steady.to_toml()
    fixed = load_case("numill")
    assert (fixed.run.max, fixed.run.end) == (None, fixed.run.until)


def test_word_that_is_neither_time_nor_steady_is_refused():
    with pytest.raises(CaseError, match=r'run\.until: .*got "stedy".*or "steady"'):
        load_case("numill", ["run.until=stedy"])
