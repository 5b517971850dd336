"""What a run shows while it runs: a live table on a terminal, one line every ten seconds in a log, nothing if
quiet.
"""

import math
import sys
import time as clock
from contextlib import ExitStack, suppress
from types import TracebackType
from typing import TYPE_CHECKING, Self

from nutamill.base.atomic_file import megabytes
from nutamill.base.durations import duration
from nutamill.base.errors import printable
from nutamill.base.units import in_unit
from nutamill.cli.keys import key_signals, obey_key, single_keys, typed_keys
from nutamill.simulation.progress_report import Progress

if TYPE_CHECKING:
    from rich.live import Live
    from rich.panel import Panel

PHASES = ("settle", "ramp", "steady")
LINE_PAUSE = 10.0
"""Wall time between two plain lines [s]."""
REFRESH = 4
"""Redraws of the live table per second [1/s]."""
OFFERS = {"q": "stop and save", "c": "checkpoint"}
"""What each key does while a run marches."""
OFFERS_SETTLING = {"q": "stop (nothing to save yet)"}
"""What each key does before the first step."""
ANSWERS = {"q": "stopping; the run is saved after this step", "c": "a checkpoint is saved after this step"}
"""Lines on the screen after a key was pressed."""
SPINNER = "dots"
"""Form of the moving sign that the program is at work."""


class Screen:
    """Shows `Progress`; a context manager, called with each new one:
    ``with Screen("numill") as show: show(progress)``.

    Parameters
    ----------
    title : what runs, in the frame of the live table
    quiet : show nothing
    """

    def __init__(self, title: str, quiet: bool = False):
        self._title = title
        self._quiet = quiet
        self._live: Live | None = None
        self._phase = ""
        self._phase_began = 0.0
        self._spent: dict[str, float] = {}
        self._next_line = -math.inf
        self._keys = False
        self._open = ExitStack()

    def __enter__(self) -> Self:
        if not self._quiet and sys.stdout.isatty():
            from rich.live import Live  # rich is needed on a terminal only
            from rich.spinner import Spinner
            from rich.text import Text

            self._live = Live(Spinner(SPINNER, Text(printable(self._title))), refresh_per_second=REFRESH)
            self._live.start()
            self._open.callback(self._live.stop)
            self._keys = self._open.enter_context(single_keys())
        elif not self._quiet:
            print(self._title, flush=True)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        with suppress(OSError):  # a terminal that is gone
            self._open.close()

    def message(self, text: str) -> None:
        """Show one line, for instance `COMPILING`. On a terminal it stays above the table."""
        try:
            self._write(text)
        except OSError:
            self._go_quiet()

    def __call__(self, progress: Progress) -> None:
        """Show `progress`: in the live table at once, as a line if ten seconds have passed or a phase begins.

        A terminal that is gone, or a closed pipe, makes the screen quiet and leaves the run alone.
        """
        try:
            self._show(progress)
        except OSError:
            self._go_quiet()
        if self._keys:
            self._obey_keys(progress)

    def _write(self, text: str) -> None:
        if self._live is not None:
            self._live.console.print(text, highlight=False, markup=False)
        elif not self._quiet:
            print(text, flush=True)

    def _go_quiet(self) -> None:
        self._live, self._keys, self._quiet = None, False, True

    def _obey_keys(self, progress: Progress) -> None:
        """Do what the keys ask that were typed since the last call, and say so."""
        offered = offers(progress)
        for key in typed_keys():
            if key in offered and progress.phase != PHASES[0]:
                self.message(ANSWERS[key])
            obey_key(key, offered)

    def _show(self, progress: Progress) -> None:
        now = clock.monotonic()
        begins = progress.phase != self._phase
        if begins:
            self._phase, self._phase_began = progress.phase, now
        self._spent[progress.phase] = now - self._phase_began
        if self._live is not None:
            self._live.update(panel(self._title, progress, self._spent, self._keys))
        elif not self._quiet and (begins or now >= self._next_line):
            print(line(progress), flush=True)
            self._next_line = now + LINE_PAUSE


def offers(progress: Progress) -> dict[str, str]:
    """Return what the keys do at present: before the first step there is nothing to save."""
    if progress.phase == PHASES[0]:
        return OFFERS_SETTLING
    return {key: does for key, does in OFFERS.items() if key in key_signals()}


def line(progress: Progress) -> str:
    """Format `progress` as one line for a log."""
    if progress.phase == PHASES[0]:
        share = f"{progress.phase:6} {100.0 * progress.fraction:3.0f} %  the charge comes to rest"
        return f"{share}  left {duration(progress.time_left)}"
    shown = (
        f"{progress.phase:6} {100.0 * progress.fraction:3.0f} %  t = {progress.time:.3f} of "
        f"{progress.end_time:g} s  {_rate(progress)}  left {duration(progress.time_left)}"
    )
    if _of_mill(progress):
        shown += (
            f"  crank-pin force {_number(progress.crank_pin_force, '.0f')} N"
            f"  shaft torque {_number(progress.shaft_torque, '.2f')} N m{_means(progress)}"
        )
    if _has_charge(progress):
        shown += f"  {_overlaps(progress)}"
    if math.isfinite(progress.ledger_residual):
        shown += f"  ledger {_percent(progress.ledger_residual, '.3f')} %"
    return shown


def panel(title: str, progress: Progress, spent: dict[str, float], keys: bool = False) -> "Panel":
    """Build the live table: a bar for each phase, the readings now and their means, and a line of
    technicalities.

    `spent` is the wall time [s] of each phase that has begun; `keys` is true where single keys are read.
    """
    from rich import box
    from rich.console import Group
    from rich.panel import Panel
    from rich.progress_bar import ProgressBar
    from rich.spinner import Spinner
    from rich.table import Table
    from rich.text import Text

    named = Text(printable(title))  # not markup: a title may hold brackets
    bars = Table.grid(padding=(0, 2))
    present = PHASES.index(progress.phase)
    for k, phase in enumerate(PHASES):
        if k < present and phase not in spent:  # no charge to settle, no ramp, or before this part of the run
            continue
        fraction = 1.0 if k < present else progress.fraction if k == present else 0.0
        time = duration(spent[phase]) if phase in spent else ""
        left = f"left {duration(progress.time_left)}" if k == present else ""
        style = "bold" if k == present else "" if k < present else "dim"
        share = f"{100.0 * fraction:3.0f} %"
        sign = Spinner(SPINNER) if k == present else ""
        bars.add_row(
            phase, ProgressBar(total=1.0, completed=fraction, width=32), share, time, left, sign, style=style
        )

    heard = "   ".join(f"{key} {does}" for key, does in offers(progress).items()) if keys else None
    readings = Table.grid(padding=(0, 2))
    readings.add_column(min_width=16)
    times = (
        f"t = {progress.time:.3f} of {progress.end_time:g} s   {_rate(progress)}   dt = "
        f"{_number(in_unit(progress.dt, 'us'), '.2f')} µs"
    )
    for _ in range(3):
        readings.add_column(justify="right", min_width=8)
    if _of_mill(progress):
        readings.add_row("", "now", "mean", "±95 %", "", style="dim")
        means = (
            (progress.crank_pin_force, progress.mean_force, progress.mean_force_half_width, ".0f", ".1f"),
            (progress.shaft_torque, progress.mean_torque, progress.mean_torque_half_width, ".2f", ".2f"),
        )
        for name, unit, (now, mean, width, form, fine) in zip(
            ("crank-pin force", "shaft torque"), ("N", "N m"), means, strict=True
        ):
            readings.add_row(name, _number(now, form), _number(mean, fine), _number(width, fine), unit)
    if _has_charge(progress):
        wall, pair = progress.largest_wall_overlap, progress.largest_pair_overlap
        readings.add_row("largest overlap", _percent(wall, ".1f"), "", "", "% of d, wall")
        readings.add_row("", _percent(pair, ".1f"), "", "", "% of d, pellets")
    if _of_mill(progress):
        residual = _percent(progress.ledger_residual, ".3f")
        readings.add_row("energy ledger", residual, "", "", "% not accounted for")
    work = f"file {megabytes(progress.file_size)}"
    if _has_charge(progress):
        pace = _number(progress.nanoseconds, ".0f")
        work = f"{progress.contacts} contacts   {pace} ns per particle and step   {work}"
    table = Group(readings, "") if readings.row_count else Group()
    return Panel(
        Group(bars, "", table, times, work),
        title=named,
        subtitle=heard,
        box=box.ROUNDED,
        expand=False,
        padding=(0, 1),
    )


def _of_mill(progress: Progress) -> bool:
    """Return whether the run has a crank pin and a driveshaft."""
    return math.isfinite(progress.crank_pin_force) or math.isfinite(progress.shaft_torque)


def _has_charge(progress: Progress) -> bool:
    """Return whether the run has a charge that moves."""
    return math.isfinite(progress.largest_wall_overlap) or math.isfinite(progress.largest_pair_overlap)


def _number(value: float, form: str) -> str:
    return format(value, f"z{form}") if math.isfinite(value) else "-"


def _percent(value: float, form: str) -> str:
    return _number(100.0 * value, form)


def _rate(progress: Progress) -> str:
    return f"{_number(progress.rate, '.3g')} s per s"


def _means(progress: Progress) -> str:
    """Format the means so far with their intervals, once they are known."""
    if not math.isfinite(progress.mean_force_half_width):
        return ""
    return (
        f"  means {progress.mean_force:.1f} ± {progress.mean_force_half_width:.1f} N,"
        f" {progress.mean_torque:.2f} ± {progress.mean_torque_half_width:.2f} N m"
    )


def _overlaps(progress: Progress) -> str:
    return (
        f"overlap {_percent(progress.largest_wall_overlap, '.1f')} % wall, "
        f"{_percent(progress.largest_pair_overlap, '.1f')} % pellets"
    )
