"""The progress of a run in a notebook: a bar, the time left and the readings, under the cell that runs it."""

import math
import sys
from types import TracebackType
from typing import Any, Self

from nutamill.base.durations import duration
from nutamill.notebook.html import escaped, table
from nutamill.simulation.progress_report import Progress

BAR = "#0072B2"
"""Colour of the bar."""
PHASES = {"settle": "the charge comes to rest", "ramp": "ramp", "steady": "at speed"}
"""Phases of a run, in words."""


def in_notebook() -> bool:
    """Return whether this process is the kernel of a notebook, which shows HTML."""
    ipython = sys.modules.get("IPython")
    shell = None if ipython is None else ipython.get_ipython()
    return shell is not None and getattr(shell, "kernel", None) is not None


class LiveProgress:
    """Shows the progress of a run below the cell. A context manager that is called with each report."""

    def __init__(self, title: str):
        self._title = title
        self._message = ""
        self._last: Progress | None = None
        self._handle: Any = None

    def __enter__(self) -> Self:
        from IPython.display import display  # there, where `in_notebook` is true

        self._handle = display(self._html(), display_id=True)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._message = "" if kind is None else "stopped"
        self._handle.update(self._html(ended=True))

    def __call__(self, progress: Progress) -> None:
        """Show `progress` in place of the earlier one."""
        self._last, self._message = progress, ""
        self._handle.update(self._html())

    def message(self, text: str) -> None:
        """Show one line of text, until the next report."""
        self._message = text
        self._handle.update(self._html())

    def _html(self, ended: bool = False) -> Any:
        from IPython.display import HTML

        return HTML(progress_html(self._title, self._last, self._message, ended))


def progress_html(title: str, progress: Progress | None, message: str = "", ended: bool = False) -> str:
    """Return the bar and the readings of a run.

    Parameters
    ----------
    title : what runs
    progress : its last report; None before the first
    message : a line of text, such as that kernels are compiled
    ended : the run is over, so that no time is left
    """
    text = f"<b>{escaped(title)}</b>" + (f"<div>{escaped(message)}</div>" if message else "")
    if progress is None:
        return text
    share = 100.0 * progress.fraction
    width = f'<div style="width:{share:.1f}%;background:{BAR};height:8px"></div>'
    text += f'<div style="width:24em;background:#ddd">{width}</div>'
    rows = [(PHASES[progress.phase], f"{share:.0f} %" + _left(progress, ended))]
    if progress.phase != "settle":
        rows.append(("time", f"{progress.time:.3f} of {progress.end_time:g} s"))
    if math.isfinite(progress.crank_pin_force):
        rows.append(("crank-pin force", _reading(progress.crank_pin_force, progress.mean_force, "N")))
    if math.isfinite(progress.shaft_torque):
        rows.append(("shaft torque", _reading(progress.shaft_torque, progress.mean_torque, "N m")))
    return text + table(rows)


def _left(progress: Progress, ended: bool) -> str:
    """Return the wall time to the end of the run, where it is known."""
    return "" if ended or not math.isfinite(progress.time_left) else f", left {duration(progress.time_left)}"


def _reading(now: float, mean: float, unit: str) -> str:
    """Return a reading and, once it is known, its mean at constant speed."""
    return f"{now:.4g} {unit}" + (f", mean {mean:.4g} {unit}" if math.isfinite(mean) else "")
