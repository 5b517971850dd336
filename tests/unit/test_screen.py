"""What a run shows: lines for a log, a table for a terminal, nothing if quiet."""

import io
import math

import pytest
from rich.console import Console

from nutamill import screen
from nutamill.screen import COMPILING, Progress, Screen, duration, line, panel

PROGRESS = Progress(
    phase="ramp",
    time=4.712,
    end_time=13.0,
    fraction=0.47,
    rate=0.0146,
    nanoseconds=41.2,
    time_left=492.0,
    crank_pin_force=512.0,
    shaft_torque=4.13,
    largest_pair_overlap=0.018,
    largest_wall_overlap=0.11,
    ledger_residual=2e-4,
    contacts=6904,
    dt=3.6e-6,
    file_size=41_000_000,
)


@pytest.fixture
def wall(monkeypatch):
    """A wall clock that the test moves: ``wall[0]`` in seconds."""
    now = [100.0]
    monkeypatch.setattr(screen.clock, "monotonic", lambda: now[0])
    return now


def test_log_gets_one_line_in_ten_seconds_and_one_when_a_phase_begins(capsys, wall):
    with Screen("numill") as show:
        for second in range(25):
            wall[0] = 100.0 + second
            show(PROGRESS)
        show(PROGRESS._replace(phase="steady"))
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "numill"
    assert [text.split()[0] for text in lines[1:]] == ["ramp", "ramp", "ramp", "steady"]


def test_line_holds_phase_time_rate_time_left_force_and_torque():
    text = line(PROGRESS)
    for part in (
        "ramp",
        "47 %",
        "t = 4.712 of 13 s",
        "0.0146 s per s",
        "left 0:08:12",
        "512 N",
        "4.13 N m",
        "11.0 % wall",
        "ledger 0.020 %",
    ):
        assert part in text


def test_what_is_not_known_yet_is_a_dash():
    text = line(PROGRESS._replace(crank_pin_force=math.nan, time_left=math.inf))
    assert "crank-pin force - N" in text
    assert "left -" in text


def test_quiet_shows_nothing(capsys):
    with Screen("numill", quiet=True) as show:
        show.message(COMPILING)
        show(PROGRESS)
    assert capsys.readouterr().out == ""


def test_message_about_compiling_is_a_line_of_its_own(capsys):
    with Screen("numill") as show:
        show.message(COMPILING)
    assert capsys.readouterr().out.splitlines() == ["numill", COMPILING]


def test_table_shows_phases_and_readings_within_80_columns():
    console = Console(width=80, record=True, file=io.StringIO())
    console.print(panel("numill", PROGRESS, {"ramp": 112.0}))
    text = console.export_text()
    for part in ("settle", "done", "47 %", "0:01:52", "left 0:08:12", "512", "4.13", "6904 contacts", "41 ns", "41.0 MB", "dt = 3.60 µs"):
        assert part in text
    assert max(map(len, text.splitlines())) <= 80


def test_durations_are_hours_minutes_seconds():
    assert duration(3725.4) == "1:02:05"
    assert duration(math.nan) == "-"
