"""Keys and signals of a run on a real pseudo-terminal: while the charge settles, while the mill turns, and
when the terminal goes.
"""

import os
import re
import select
import signal
import subprocess
import sys
import time

import pytest

from nutamill.result import open_result

pty = pytest.importorskip("pty", reason="needs a system with pseudo-terminals")

PROGRAM = """
import sys, time
import nutamill.simulation.runs as runs
from nutamill.cli import app

def settle(case, progress):
    "Stands for a charge that takes long to settle: until the file `go` is there."
    import pathlib
    while not pathlib.Path("go").exists():
        time.sleep(0.05)
        progress(0.5)

runs.warm_up = lambda *args: None
runs.settled_bed = settle
app(["run", "numill", "-s", "charge.kind=none", "-s", "mechanism.mounting=rigid", "-s", "run.until=1000 s",
     "-s", "run.checkpoint=1000 s", "-s", "run.snapshots.rate=0.1 Hz", "--to", "a.h5"])
"""
LONGEST = 60.0
"""Wall time after which a text that does not appear is a fault [s]."""


class Terminal:
    """A run on a terminal of its own: a screen to read, and keys to press."""

    def __init__(self, folder):
        self._master, slave = pty.openpty()
        environment = {**os.environ, "TERM": "xterm", "COLUMNS": "100", "LINES": "40"}
        self.process = subprocess.Popen(
            [sys.executable, "-P", "-c", CONTROLLED, PROGRAM],
            stdin=slave,
            stdout=slave,
            stderr=slave,
            cwd=folder,
            env=environment,
            start_new_session=True,
        )
        os.close(slave)
        self.text = ""

    def wait_for(self, pattern):
        """Read the screen until `pattern` is on it; what was read before and with it is dropped."""
        end = time.monotonic() + LONGEST
        while not (match := re.search(pattern, self.text, re.DOTALL)):
            assert time.monotonic() < end, f"no {pattern!r} in {self.text[-2000:]}"
            if select.select([self._master], [], [], 0.1)[0]:
                self.text += re.sub(
                    r"\x1b\[[0-9;?]*[a-zA-Z]", "", os.read(self._master, 65536).decode(errors="replace")
                )
        before, self.text = self.text[: match.end()], self.text[match.end() :]
        return before

    def press(self, key):
        os.write(self._master, key.encode())

    def close(self):
        os.close(self._master)

    def end(self):
        """The exit code."""
        return self.process.wait(LONGEST)


CONTROLLED = """
import fcntl, sys, termios
fcntl.ioctl(0, termios.TIOCSCTTY, 0)
exec(sys.argv[1])
"""


@pytest.fixture
def terminal(tmp_path):
    """A run on a terminal that settles until it is let go; killed if the test leaves it."""
    started = Terminal(tmp_path)
    yield started
    if started.process.poll() is None:
        started.process.kill()
        started.process.wait()


def test_checkpoint_while_settling_does_no_harm_later_it_is_saved_and_a_closed_terminal_saves_all(
    terminal, tmp_path
):
    screen = terminal.wait_for(r"50 %.*nothing to save yet\)")
    assert "q stop (nothing to save yet)" in screen
    assert "c checkpoint" not in screen
    terminal.press("c")
    os.kill(terminal.process.pid, signal.SIGUSR1)
    terminal.text = ""
    terminal.wait_for("50 %")  # still there
    (tmp_path / "go").touch()
    terminal.wait_for("q stop and save   c checkpoint")
    terminal.press("c")
    terminal.wait_for("a checkpoint is saved after this step")
    terminal.wait_for(r"checkpoint saved at t = \S+ s")
    with open_result(tmp_path / "a.h5") as result:
        asked = result.checkpoint().time
    assert 0 < asked < 1000
    terminal.text = ""
    terminal.wait_for("q stop and save")  # drawn anew: the run has gone on since
    terminal.close()
    terminal.end()
    with open_result(tmp_path / "a.h5") as result:
        assert result.state == "interrupted"
        assert result.checkpoint().time == result.reached > asked


def test_stop_key_while_settling_ends_the_run_and_says_that_nothing_is_saved(terminal, tmp_path):
    terminal.wait_for(r"q stop \(nothing to save yet\)")
    terminal.press("q")
    terminal.wait_for("interrupted before the first step, there was nothing to save")
    assert terminal.end() == 130
    assert list(tmp_path.iterdir()) == []
