"""The runs that the page has started: children of this process, which end with it."""

import contextlib
import json
import signal
import subprocess
import threading
from collections import deque
from typing import Any, NamedTuple

from nutamill.base.child import start_child
from nutamill.base.errors import CaseError, ExitCode, Fault
from nutamill.simulation.setup.threads import usable_cores
from nutamill.ui.runner import PROGRAM, RunTask

MOST_POINTS = 4000
"""Readings of a run that the page shows while it goes on; a run of half an hour [1]."""
MOST_LINES = 40
"""Messages of a run that are shown [1]."""
PATIENCE = 60.0
"""Longest wait for a run to save and end [s]."""
READINGS = ("time", "crank_pin_force", "shaft_torque")
"""What is drawn while a run goes on, of its progress."""
OUTCOMES: dict[int, str] = {
    ExitCode.DONE: "complete",
    ExitCode.NOT_STEADY: "not steady",
    ExitCode.INTERRUPTED: "stopped, saved",
}
"""How a run ends, by the exit code of its child."""


class Shown(NamedTuple):
    """A run as the page shows it."""

    number: int
    """Its number, by which the page addresses it."""
    title: str
    """Title of its case."""
    file: str
    """Its result file."""
    state: str
    """``running``, ``stopping``, or how it has ended."""
    progress: dict[str, Any]
    """The last report, as `nutamill.simulation.progress_report.Progress` names it; empty before the first."""
    points: list[list[float]]
    """Readings over time, as `READINGS` lists them."""
    lines: list[str]
    """Messages."""


class Run:
    """One child and what it has reported.

    Parameters
    ----------
    number : its number
    title : title of its case
    file : name of its result file for the page
    task : what the child does
    """

    def __init__(self, number: int, title: str, file: str, task: RunTask):
        self._number, self._title, self._file = number, title, file
        self._state = "running"
        self._progress: dict[str, Any] = {}
        self._points: deque[list[float]] = deque(maxlen=MOST_POINTS)
        self._lines: deque[str] = deque(maxlen=MOST_LINES)
        self._lock = threading.Lock()
        self._child = start_child(PROGRAM, task, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self._listener = threading.Thread(target=self._listen, daemon=True)
        self._listener.start()

    @property
    def goes_on(self) -> bool:
        """Whether its child has not ended yet."""
        return self._listener.is_alive()

    def shown(self) -> Shown:
        """Return what the page shows of it."""
        with self._lock:
            return Shown(
                self._number,
                self._title,
                self._file,
                self._state,
                dict(self._progress),
                list(self._points),
                list(self._lines),
            )

    def stop(self) -> None:
        """Stop it. It saves what it has."""
        with self._lock:
            if self._child.poll() is None:
                self._state = "stopping"
                self._child.terminate()

    def wait(self) -> None:
        """Wait until it has ended, and kill it after a minute."""
        self._listener.join(PATIENCE)
        if self.goes_on:
            self._child.kill()
            self._listener.join()

    def _listen(self) -> None:
        """Take the reports of the child until it ends."""
        assert self._child.stdout is not None and self._child.stdin is not None  # pipes
        for line in self._child.stdout:
            with self._lock:
                self._take(line)
        code = self._child.wait()
        with contextlib.suppress(BrokenPipeError):
            self._child.stdin.close()
        self._child.stdout.close()
        with self._lock:
            stopped = self._state == "stopping" and code == -signal.SIGTERM
            self._state = OUTCOMES.get(ExitCode.INTERRUPTED if stopped else code, "failed")

    def _take(self, line: str) -> None:
        """Take one line of the child: a report, or words of a library."""
        try:
            report = json.loads(line)
        except ValueError:
            report = {"message": line.rstrip()}
        if not isinstance(report, dict):
            report = {"message": report}
        if "progress" not in report:
            self._lines.append(str(report.get("message", line.rstrip())))
            return
        self._progress = report["progress"]
        if all(name in self._progress for name in READINGS):
            self._points.append([self._progress[name] for name in READINGS])


class Runs:
    """All runs of a page, the newest first."""

    def __init__(self) -> None:
        self._runs: dict[int, Run] = {}
        self._lock = threading.Lock()

    def start(self, title: str, file: str, task: RunTask) -> int:
        """Start a run, and return its number.

        Raises
        ------
        CaseError : as many runs as there are cores go on already, or one of this case
        """
        with self._lock:
            going = [run for run in self._runs.values() if run.goes_on]
            if any(run.shown().file == file for run in going):
                raise CaseError(Fault(file, "is being run already", "Its card is among the runs"))
            if len(going) >= usable_cores():
                what = f"{len(going)} runs go on already, as many as this machine has cores"
                raise CaseError(Fault("run", what, "Stop one, or wait"))
            number = len(self._runs) + 1
            self._runs[number] = Run(number, title, file, task)
            return number

    def stop(self, number: object) -> None:
        """Stop a run. Raise CaseError where there is none of this number."""
        run = self._runs.get(number) if isinstance(number, int) else None
        if run is None:
            raise CaseError(Fault("run", f"there is no run {number}", "Reload the page"))
        run.stop()

    def shown(self) -> list[Shown]:
        """Return what the page shows of every run, the newest first."""
        with self._lock:
            return [run.shown() for run in reversed(self._runs.values())]

    def end(self) -> None:
        """Stop all runs and wait until they have saved."""
        for run in self._runs.values():
            run.stop()
        for run in self._runs.values():
            run.wait()
