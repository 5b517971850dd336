"""What a run shows: lines for a log, a table for a terminal, nothing if quiet."""

import io
import math
import os
import signal
import sys

import numpy as np
import pytest
from rich.console import Console

import nutamill as nm
from nutamill.base.durations import duration
from nutamill.cli import keys, screen
from nutamill.cli.screen import Screen, line, offers, panel
from nutamill.simulation.progress_report import COMPILING, Progress
from nutamill.simulation.running_mean import RunningMean

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
    mean_force=math.nan,
    mean_force_half_width=math.nan,
    mean_torque=math.nan,
    mean_torque_half_width=math.nan,
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
    for part in (
        "47 %",
        "0:01:52",
        "left 0:08:12",
        "512",
        "4.13",
        "6904 contacts",
        "41 ns",
        "41.0 MB",
        "dt = 3.60 µs",
    ):
        assert part in text
    assert "settle" not in text  # the bed was in the cache
    assert max(map(len, text.splitlines())) <= 80


ALONE = PROGRESS._replace(
    crank_pin_force=math.nan,
    shaft_torque=math.nan,
    largest_pair_overlap=math.nan,
    largest_wall_overlap=math.nan,
    ledger_residual=math.nan,
    contacts=0,
)
"""A machine without a crank and without a charge."""


def test_line_of_a_machine_holds_what_it_has():
    assert line(ALONE) == "ramp    47 %  t = 4.712 of 13 s  0.0146 s per s  left 0:08:12"
    filled = ALONE._replace(largest_pair_overlap=0.018, largest_wall_overlap=0.11)
    assert line(filled) == line(ALONE) + "  overlap 11.0 % wall, 1.8 % pellets"


def test_table_of_a_machine_holds_what_it_has():
    filled = ALONE._replace(largest_pair_overlap=0.018, largest_wall_overlap=0.11)
    shown = []
    for progress in (ALONE, filled):
        console = Console(width=80, record=True, file=io.StringIO())
        console.print(panel("piston", progress, {"ramp": 1.0}))
        shown.append(console.export_text())
    for word in ("crank-pin", "shaft torque", "ledger"):
        assert word not in shown[0] + shown[1]
    for word in ("overlap", "contacts", "per particle"):
        assert word not in shown[0]
        assert word in shown[1]


def test_machine_with_nothing_to_settle_shows_no_settling(tmp_path):
    machine = nm.load_case("piston", ["charge.kind=none", "run.until=20 ms"])
    phases = []
    nm.run(machine, to=tmp_path / "p.h5", progress=lambda now: phases.append(now.phase)).close()
    assert "settle" not in phases


def test_durations_are_hours_minutes_seconds():
    assert duration(3725.4) == "1:02:05"
    assert duration(math.nan) == "-"


KNOWN = PROGRESS._replace(
    phase="steady", mean_force=981.4, mean_force_half_width=6.2, mean_torque=9.05, mean_torque_half_width=0.21
)


def test_means_and_their_intervals_are_shown_once_they_are_known():
    assert "means" not in line(PROGRESS)
    assert "means 981.4 ± 6.2 N, 9.05 ± 0.21 N m" in line(KNOWN)
    console = Console(width=80, record=True, file=io.StringIO())
    console.print(panel("numill", KNOWN, {"ramp": 112.0, "steady": 3.0}, keys=True))
    text = console.export_text()
    for part in ("981.4", "6.2", "9.05", "0.21", "q stop and save"):
        assert part in text
    assert max(map(len, text.splitlines())) <= 80


def test_key_on_a_terminal_raises_the_signal_that_asks_the_same(monkeypatch):
    """A real pseudo-terminal: what is typed on one end arrives as a signal, and the terminal is as it was
    afterwards.
    """
    pty = pytest.importorskip("pty", reason="needs a system with pseudo-terminals")
    import termios

    master, slave = pty.openpty()
    heard = []
    with os.fdopen(slave, "r") as terminal:
        monkeypatch.setattr(keys.sys, "stdin", terminal)
        monkeypatch.setattr(keys.signal, "raise_signal", heard.append)
        before = termios.tcgetattr(terminal)
        with keys.single_keys() as listening:
            assert listening
            os.write(master, b"xcq")
            typed = keys.typed_keys()
            obeyed = [keys.obey_key(key, "cq") for key in typed]
        assert termios.tcgetattr(terminal) == before
    os.close(master)
    assert (typed, obeyed) == ("xcq", [False, True, True])
    assert heard == [signal.SIGUSR1, signal.SIGINT]


def test_system_without_terminal_keys_offers_none(monkeypatch):
    monkeypatch.setitem(sys.modules, "termios", None)
    with keys.single_keys() as listening:
        assert not listening


def test_screen_offers_what_works_in_the_phase_and_on_the_system(monkeypatch):
    assert offers(PROGRESS) == {"q": "stop and save", "c": "checkpoint"}
    assert offers(PROGRESS._replace(phase="settle")) == {"q": "stop (nothing to save yet)"}
    monkeypatch.delattr(signal, "SIGUSR1", raising=False)
    assert offers(PROGRESS) == {"q": "stop and save"}
    assert not keys.obey_key("c", ["c"])


def test_screen_whose_terminal_is_gone_goes_quiet_and_leaves_the_run_alone(monkeypatch):
    def gone(*args, **kwargs):
        raise OSError(5, "Input/output error")

    with Screen("numill") as show:
        monkeypatch.setattr("builtins.print", gone)
        show(PROGRESS)
        show.message(COMPILING)


def test_mean_while_running_is_that_of_the_whole_turns():
    """Sampled 400 times a turn, 5 + sin(2 angle) + turn number: turns 1 to 6 of a record that begins within
    turn 0 have the means 6 to 11, the trapezoidal rule being exact for a sine over whole turns; Student's t
    of 5 degrees is 2.5706.
    """
    angle = np.arange(150, 2801) * 2 * math.pi / 400
    values = np.stack(
        [5.0 + np.sin(2.0 * angle) + np.floor(angle / (2 * math.pi) + 1e-9), np.ones_like(angle)], axis=1
    )
    means = RunningMean(2)
    for part in np.array_split(np.arange(len(angle)), 17):
        means.add(0.01 * angle[part], angle[part] + 1e-9, values[part])
    assert means.turns == 6
    # at the end of each turn the next number is taken half a sample early: 1/2 of a step of one, in 400
    assert means.mean()[0] == pytest.approx(8.5, abs=1 / 800 + 1e-9)
    spread = np.std(np.arange(6.0, 12.0), ddof=1)
    assert means.half_width() == pytest.approx([2.5706 * spread / math.sqrt(6), 0.0], rel=1e-4, abs=1e-9)


def test_what_is_not_known_yet_is_a_dash_and_a_sign_moves():
    unknown = {name: math.nan for name, value in PROGRESS._asdict().items() if isinstance(value, float)}
    table = panel(
        "numill",
        PROGRESS._replace(**unknown)._replace(phase="settle", time=0.0, end_time=1.0, fraction=0.0),
        {"settle": 1.0},
    )
    drawn = []
    for moment in (0.0, 1.0):
        console = Console(width=100, record=True, file=io.StringIO(), get_time=lambda moment=moment: moment)
        console.print(table)
        drawn.append(console.export_text())
    assert "nan" not in drawn[0]
    assert "dt = - µs" in drawn[0]
    assert drawn[0] != drawn[1]
