"""Steady means with their uncertainty, and where the power goes: from a result, without the engines."""

import fnmatch
import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple, Protocol

import numpy as np

from nutamill.base.errors import ResultError
from nutamill.base.steady import (
    FEWEST_TURNS,
    PRECISION,
    SteadyMean,
    batch_half_width,
    steady_mean,
    turn_means,
    whole_turns,
)
from nutamill.base.units import Kind, parse
from nutamill.case import Case
from nutamill.result import Result
from nutamill.result.fields import series_field

PAPER_WINDOW = 3.0
"""Length of the averaging window at the end of a run in both NuMill papers [s]."""
STEADY_SPEED = 1e-6
"""Share by which the speed may differ from the last one in steady running."""

SINKS: dict[str, tuple[str, ...]] = {
    "pellet-pellet": ("pair_normal_loss", "pair_tangential_loss", "pair_rolling_loss"),
    "pellet-wall": ("wall_normal_loss", "wall_tangential_loss", "wall_rolling_loss"),
    "substep": ("substep_loss",),
    "joints": ("driveshaft_bearing_loss", "pin_joint_loss", "chamber_pivot_loss", "yoke_pivot_loss"),
    "mounts": ("mount_*_loss",),
    "coupling": ("coupling_loss",),
    "stored": ("kinetic_energy_mechanism", "kinetic_energy_charge", "potential_energy", "elastic_energy"),
}
"""Where the motor's work can go: series of the power ledger, in groups; ``*`` stands for every mount."""


class Uncertain(Protocol):
    """A mean and the half width of its 95 % interval."""

    @property
    def mean(self) -> float:
        """The mean."""

    @property
    def half_width(self) -> float:
        """Half width of its interval; NaN if it is not known."""


class Estimate(NamedTuple):
    """A steady mean."""

    mean: float
    """Mean over whole turns, unit of the series."""
    half_width: float
    """Half width of its 95 % confidence interval by batch means, unit of the series; NaN below two turns."""
    window_mean: float
    """Plain mean of all samples of the window, as in the papers, unit of the series."""


class Steady(NamedTuple):
    """The steady end of a run."""

    start: float
    """Start of the window [s]."""
    end: float
    """End of the window and of the run [s]."""
    turns: np.ndarray
    """Times at which the whole turns in the window begin and end [s], (n_turns + 1,)."""
    values: dict[str, Estimate]
    """Steady mean of each series."""


class SteadyPart(NamedTuple):
    """What a stationarity test finds of a run at its last speed."""

    turns: np.ndarray
    """Times at which all whole turns at that speed begin and end [s], (n_turns + 1,)."""
    means: dict[str, SteadyMean]
    """Steady mean of each series, from the turns that were kept of it."""

    @property
    def start(self) -> float:
        """Time from which all of the series are kept [s]."""
        return float(self.turns[max(found.first for found in self.means.values())])

    @property
    def drifting(self) -> list[str]:
        """Series that are not steady."""
        return [name for name, found in self.means.items() if not found.steady]


class PowerSplit(NamedTuple):
    """Mean power over the whole turns of the steady window."""

    motor: float
    """Power of the motor [W]; with a prescribed motion, which the charge does not slow, also what that motion
    supplies.
    """
    sinks: dict[str, float]
    """Where it goes [W], by the groups of `SINKS`."""
    residual: float
    """What the ledger does not account for [W]."""


def ramp_end(result: Result) -> float:
    """Time from which the driveshaft keeps its last speed [s]; the start if it had it from the beginning.

    With a motor, whose speed is never quite steady: the time from which it is asked for its last speed, or
    has its supply back.
    """
    if "[drive.motor]" in result.case_text:
        drive = Case.from_toml(result.case_text).drive
        return max(drive.ramp_end, drive.motor.restored or drive.motor.cut or 0.0)
    time, speed = (result.series[name].values for name in ("time", "driveshaft_speed"))
    if not len(time):
        return math.nan
    changing = np.flatnonzero(np.abs(speed - speed[-1]) > STEADY_SPEED * abs(speed[-1]))
    return float(time[changing[-1] + 1]) if len(changing) else float(time[0])


def turns_at_speed(result: Result, since: float = -math.inf) -> tuple[np.ndarray, np.ndarray]:
    """Samples at the last speed from the time `since` [s] on, (n_samples,) of bool, and the times [s] (n +
    1,) between their whole turns.

    There are no turns, and fewer than two times, where the run has not made a whole one by then.
    """
    time, angle = result.series["time"].values, result.series["crank_angle"].values
    inside = time >= max(ramp_end(result), since)
    return inside, whole_turns(time[inside], angle[inside])


def steady_window(
    result: Result, last: float | str = PAPER_WINDOW, names: Sequence[str] | None = None
) -> Steady:
    """Means over the last seconds of a run, over whole turns, with their 95 % intervals.

    The window is the last `last` seconds, cut where the speed was still changing.  Readings of a mill repeat
    once or twice per turn, so that a mean over a broken number of turns depends on where it is cut; the
    estimate therefore takes the whole turns that end with the run.  The scatter of batches of turns gives
    the interval (`nutamill.base.steady.batch_half_width`).

    Parameters
    ----------
    last : length of the window [s], or a text with a unit as ``"3 s"``
    names : series to average, all if not given

    Raises
    ------
    ResultError : the run has not made one turn at its last speed
    """
    length = parse(last, Kind.TIME) if isinstance(last, str) else last
    series = result.series
    time = series["time"].values
    inside, turns = turns_at_speed(result, float(time[-1]) - length if len(time) else math.nan)
    if len(turns) < 2:
        reached = f"ends at t = {time[-1]:g} s" if len(time) else "is empty"
        raise ResultError(
            f"{result.path}: must hold a whole turn at constant speed, it {reached}. Continue it "
            "with `nutamill resume`."
        )
    values = {
        name: _estimate(time[inside], series[name].values[inside], turns)
        for name in names or map(str, series.data_vars)
    }
    return Steady(float(time[inside][0]), float(time[-1]), turns, values)


def _estimate(time: np.ndarray, value: np.ndarray, turns: np.ndarray) -> Estimate:
    """Steady mean of samples `value` at `time`, over the turns that begin and end at `turns`."""
    means = turn_means(time, value, turns)
    half_width = float(batch_half_width(means[:, None])[0])
    return Estimate(float(np.average(means, weights=np.diff(turns))), half_width, float(value.mean()))


def steady_part(result: Result, names: Sequence[str], precision: float = PRECISION) -> SteadyPart:
    """Find by a test where a run became steady, and its means from there, with 95 % intervals that account
    for correlation.

    All whole turns at the last speed are looked at; `nutamill.base.steady.steady_mean` says how.

    Parameters
    ----------
    names : series to average
    precision : drift over the turns kept that does not matter, share of the root mean square [1]

    Raises
    ------
    ResultError : fewer whole turns at the last speed than a test needs
    """
    time = result.series["time"].values
    inside, turns = turns_at_speed(result)
    if len(turns) <= FEWEST_TURNS:
        what = (
            f"must hold {FEWEST_TURNS} whole turns at its last speed for a test of steadiness, it holds "
            f"{max(0, len(turns) - 1)}"
        )
        raise ResultError(f"{result.path}: {what}. Continue it with `nutamill resume`.")
    values = {name: turn_means(time[inside], result.series[name].values[inside], turns) for name in names}
    return SteadyPart(
        turns, {name: steady_mean(means, precision=precision) for name, means in values.items()}
    )


def power_split(result: Result, last: float | str = PAPER_WINDOW) -> PowerSplit:
    """Where the motor's power goes, mean over the whole turns of the steady window; see `steady_window`."""
    turns = steady_window(result, last, names=["time"]).turns

    def power(name: str) -> float:
        first, end = np.interp(turns[[0, -1]], result.series["time"].values, result.series[name].values)
        return float((end - first) / (turns[-1] - turns[0]))

    sinks = {group: sum(map(power, names)) for group, names in ledger_groups(result).items()}
    supplied = power("motor_work") + (power("interface_work") if _prescribed(result) else 0.0)
    return PowerSplit(supplied, sinks, power("ledger_residual"))


def _prescribed(result: Result) -> bool:
    """Whether the motion was imposed on the charge."""
    return bool(result.case_text) and Case.from_toml(result.case_text).run.coupling == "prescribed"


def ledger_groups(result: Result) -> dict[str, list[str]]:
    """`SINKS` with the series that this result holds, groups without any left out."""
    held = list(result.series.data_vars)
    groups = {
        group: [name for name in held if any(fnmatch.fnmatchcase(name, pattern) for pattern in patterns)]
        for group, patterns in SINKS.items()
    }
    return {group: names for group, names in groups.items() if names}


def summary_lines(result: Result) -> list[str]:
    """What is said at the end of a run: whether it is steady, steady force, torque and power, and where the
    power goes.
    """
    names = ["crank_pin_force_resultant", "driveshaft_torque", "driveshaft_power"]
    try:
        window = steady_window(result, names=names)
        power = power_split(result)
    except ResultError:
        return [
            f"no steady means: the run has not made a whole turn at its last speed (state: {result.state})"
        ]
    force, torque, drawn = window.values.values()
    count = len(window.turns) - 1
    plain = (
        f"last {window.end - window.start:.3g} s ({count} whole turn{'s' if count > 1 else ''}), plain mean:"
        f" {force.window_mean:.4g} N, {torque.window_mean:.4g} N m"
    )
    try:
        part = steady_part(result, names)
    except ResultError:
        said = f"{too_few_turns(count)}; their plain mean:"
        lines = [
            said,
            f"crank-pin force {force.mean:.4g} N   shaft torque {torque.mean:.4g} N m   power "
            f"{drawn.mean:.0f} W",
        ]
    else:
        force, torque, drawn = part.means.values()
        means = (
            f"crank-pin force {with_interval(force)} N   shaft torque {with_interval(torque)} N m   "
            f"power {drawn.mean:.0f} W"
        )
        lines = [steady_line(part), means, plain]
    if power.motor:
        lines.append(
            f"where the power goes: {_shares(power.sinks, power.motor)}  | closes to "
            f"{100.0 * abs(power.residual / power.motor):.2f} %"
        )
    return lines


def too_few_turns(count: int) -> str:
    """Return the sentence on a run of so few turns at its last speed that nothing can be said about
    steadiness.
    """
    return f"too few turns at the last speed for a test of steadiness: {count}, needs {FEWEST_TURNS}"


def steady_line(part: SteadyPart) -> str:
    """Whether a run is steady, since when, or what drifts by how much."""
    turns = len(part.turns) - 1
    if not part.drifting:
        kept = min(found.turns for found in part.means.values())
        return (
            f"steady since t = {part.start:.2f} s (stationarity test), {kept} of {turns} turns at this "
            "speed kept"
        )
    shares = {
        name: part.means[name].drift / part.means[name].mean / part.means[name].turns
        for name in part.drifting
    }
    drifts = ", ".join(f"{series_field(name).label} {100.0 * share:+.2g} %" for name, share in shares.items())
    return f"not steady after {turns} turns at this speed; drift per turn: {drifts}"


LEDGER_LIMIT = 0.005
"""Share of the motor's work in the steady window that the ledger may leave open [1]."""


def warning_lines(result: Result) -> list[str]:
    """What is odd about a run: overlaps beyond the case's `overlap_warn`, a ledger that does not close."""
    case, series = Case.from_toml(result.case_text), result.series
    lines = []
    if "largest_pair_overlap" in series and series.sizes["time"]:
        for kind, wall in (("pair", False), ("wall", True)):
            pairs = [case.contact.pair(a, b) for a, b, walled in case.touching if walled == wall]
            limit = max(pair.overlap_warn for pair in pairs)
            largest = float(series[f"largest_{kind}_overlap"].max())
            if largest > limit:
                lines.append(
                    f"warning: largest {kind} overlap {100 * largest:.1f} % of the diameter, beyond "
                    f"overlap_warn = {100 * limit:.0f} %."
                    " Stiffer contacts would be nearer to the solids"
                )
    try:
        power = power_split(result)
    except ResultError:
        return lines
    if power.motor and abs(power.residual / power.motor) > LEDGER_LIMIT:
        lines.append(
            f"warning: the ledger leaves {100 * abs(power.residual / power.motor):.2f} % of the "
            "motor's power open"
            f" (limit {100 * LEDGER_LIMIT:.1f} %). Halve run.dt or run.window"
        )
    return lines


CERTAIN = 1e-4
"""Share of a mean below which its half width is not shown [1]."""


def with_interval(estimate: Uncertain) -> str:
    """``981 ± 6``, with as many digits as the interval has a meaning for."""
    if not estimate.half_width > CERTAIN * abs(estimate.mean):  # not known, or finer than anyone reads
        return f"{estimate.mean:.4g}"
    digits = max(0, 1 - math.floor(math.log10(estimate.half_width)) - (estimate.half_width >= 1.0))
    form = f".{digits}f" if digits < 7 else ".1e"
    return f"{estimate.mean:{form}} ± {estimate.half_width:{form}}"


def _shares(sinks: Mapping[str, float], motor: float) -> str:
    """``pellet-pellet 61 %  pellet-wall 27 % ...``, largest first."""
    largest_first = sorted(sinks.items(), key=lambda sink: -abs(sink[1]))
    return "  ".join(f"{group} {100.0 * power / motor:z.0f} %" for group, power in largest_first)
