"""Figures of a whole run: what is felt over time, and where the power goes."""

import math

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from scipy.ndimage import maximum_filter1d, minimum_filter1d

from nutamill.analysis.power import ledger_groups, supply_series
from nutamill.analysis.summary import has_crank
from nutamill.analysis.windows import BLOCKS, ramp_end, turn_series
from nutamill.base.errors import ResultError
from nutamill.result import Result
from nutamill.result.fields import Field
from nutamill.view.figures.mechanism import draw_reactions
from nutamill.view.figures.style import BINS, ENVELOPE, MARK, MEAN, RMS, STYLE, WIDTH, unit_of

FEW = 60
"""Turns that a picture shows one by one [1]: of more, the band between smallest and largest is drawn."""
LEAST = 0.005
"""Share of the largest power below which a group of losses is not drawn [1]."""
GAP = "#DDDDDD"
"""Colour of the power that goes into storage or comes out of it."""
STILL = 1e-6
"""Acceleration below which a frame on rigid mounts stands still, round-off apart [m/s^2]."""


def draw_run(result: Result) -> Figure:
    """Draw crank-pin force, driveshaft torque and frame acceleration over the run, with a dashed line at the
    end of the ramp.

    A series of many turns is drawn as the band between its smallest and largest value in each column of the
    picture, one of few turns as it is, with the mean over a turn (for accelerations: the root mean square
    over a turn) as a line.  A frame that stands still has no acceleration panels.

    A machine without a crank has the largest forces of its joints and bushings and the torques of its drives
    instead.

    Source
    ------
    Janse van Vuuren, Bredell and Coetzee, Math. Comput. Appl. 31(5), 171, 2026, figure 11 (form of the
    picture)
    """
    if not has_crank(result):
        return draw_reactions(result)
    sensor = next(
        (
            name.removesuffix("_x")
            for name in map(str, result.series.data_vars)
            if name.endswith("_acceleration_x")
        ),
        None,
    )
    panels = [("crank_pin_force_resultant", "crank-pin force"), ("driveshaft_torque", "driveshaft torque")]
    if sensor is not None and float(abs(result.series[f"{sensor}_x"]).max()) > STILL:
        panels += [(f"{sensor}_x", "horizontal acceleration"), (f"{sensor}_z", "vertical acceleration")]
    with matplotlib.rc_context(fname=STYLE):
        figure = Figure(figsize=(WIDTH, 0.65 + 1.15 * len(panels)), layout="constrained")
        for k, (axes, (name, quantity)) in enumerate(
            zip(figure.subplots(len(panels), 1, sharex=True), panels, strict=True)
        ):
            _draw_series(axes, result, name, root_mean_square="acceleration" in name)
            axes.set_title(f"({'abcd'[k]}) {quantity}", loc="left")
            axes.set_ylabel(_axis_label(result.field(name)))
            axes.yaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 2.5, 5, 10]))
        axes.set_xlabel("time (s)")
        _mark_ramp(figure.axes, result)
        _legend(figure, columns=2, position="outside lower center")
        figure.align_ylabels()
    return figure


def draw_ledger(result: Result) -> Figure:
    """Draw where the power of motors, drives and given loads goes, turn by turn: losses stacked, what is put
    in as a line over them.

    The gap between the stack and the line, grey, goes into kinetic, potential and elastic energy, or comes
    out of them.  Groups that nowhere reach `LEAST` of the whole are not drawn.

    Raises
    ------
    ResultError : no sample, or no losses
    """
    time = result.series["time"].values
    if len(time) < 2 or not set(ledger_groups(result)) - {"stored"}:
        raise ResultError(
            f"{result.path}: holds no losses: nothing rubs in this machine, or the run is empty."
        )
    edges = _turns(result)
    across = np.repeat(edges, 2)[1:-1]  # each turn is a step

    def power(names: list[str]) -> np.ndarray:
        energy = sum(result.series[name].values for name in names)
        return np.repeat(np.diff(np.interp(edges, time, energy)) / np.diff(edges), 2)

    losses = {group: power(names) for group, names in ledger_groups(result).items() if group != "stored"}
    total = np.sum(list(losses.values()), axis=0)
    put_in = power(supplied) if (supplied := supply_series(result)) else total
    largest = max(np.abs(total).max(), np.abs(put_in).max())
    seen = {name: values for name, values in losses.items() if np.abs(values).max() >= LEAST * largest}
    with matplotlib.rc_context(fname=STYLE):
        figure = Figure(figsize=(WIDTH, 2.8), layout="constrained")
        axes = figure.subplots()
        if np.abs(put_in - total).max() >= LEAST * largest:
            axes.fill_between(across, total, put_in, color=GAP, linewidth=0, label="stored or returned")
        if seen:  # at the start of a ramp next to nothing is lost yet
            axes.stackplot(across, list(seen.values()), labels=list(seen), linewidth=0)
        if supplied:
            label = "motor" if supplied == ["motor_work"] else "put in"
            axes.plot(across, put_in, color="black", label=label)
        axes.set_xlabel("time (s)")
        axes.set_ylabel("power (W)")
        axes.set_xlim(time[0], time[-1])
        axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
        _mark_ramp([axes], result)
        _legend(figure, columns=3, position="outside lower center")
    return figure


def _axis_label(field: Field) -> str:
    """Return what a series measures and its unit: ``force (N)``."""
    word = next(word for word in ("acceleration", "force", "torque") if word in field.name)
    return f"{word} ({unit_of(field)})"


def _draw_series(axes: Axes, result: Result, name: str, root_mean_square: bool) -> None:
    """Draw the band of smallest and largest values, and the mean or root mean square over a turn."""
    time, value = result.series["time"].values, result.series[name].values
    turn = math.tau / max(abs(result.series["driveshaft_speed"].values[-1]), math.tau)
    if len(time) > 4 * BINS and turn * FEW < time[-1] - time[0]:
        starts = np.linspace(0, len(time), BINS + 1).astype(int)[:-1]
        # widened to a turn at the last speed: narrower columns would show the beat of the columns with the
        # turns
        width = 1 + 2 * math.ceil(0.5 * turn * BINS / (time[-1] - time[0]))
        low = minimum_filter1d(np.minimum.reduceat(value, starts), width)
        high = maximum_filter1d(np.maximum.reduceat(value, starts), width)
        axes.fill_between(time[starts], low, high, color=ENVELOPE, linewidth=0, label="smallest to largest")
    else:
        axes.plot(time, value, color=ENVELOPE, label="samples")
    if root_mean_square:
        at, mean = _mean_over_turn(result, value**2)
        axes.plot(at, np.sqrt(mean), color=RMS, label="r.m.s. over a turn")
    else:
        at, mean = _mean_over_turn(result, value)
        axes.plot(at, mean, color=MEAN, label="mean over a turn")
    axes.set_xlim(time[0], time[-1])


def _mean_over_turn(result: Result, value: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return times [s] and means of `value` over the turn around each of them, (n,) both. A turn needs half a
    turn on each side.
    """
    time, angle = result.series["time"].values, result.series["crank_angle"].values
    integral = np.concatenate(([0.0], np.cumsum(0.5 * np.diff(time) * (value[1:] + value[:-1]))))
    at = np.linspace(time[0], time[-1], BINS)
    centre = np.interp(at, time, angle)
    whole = (centre - math.pi >= angle[0]) & (centre + math.pi <= angle[-1])
    first, end = (np.interp(centre[whole] + side * math.pi, angle, time) for side in (-1.0, 1.0))
    return at[whole], (np.interp(end, time, integral) - np.interp(first, time, integral)) / (end - first)


def _turns(result: Result) -> np.ndarray:
    """Return the times [s] between which the ledger is averaged: whole turns, several together in a long run,
    or `BLOCKS` equal lengths of time where nothing turns, (n + 1,).
    """
    time, turning = result.series["time"].values, turn_series(result)
    if turning is None:
        return np.linspace(time[0], time[-1], min(BLOCKS, len(time) - 1) + 1)
    angle = result.series[turning].values
    count = max(1, math.floor((angle[-1] - angle[0]) / math.tau))
    each = math.ceil(count / BINS)
    ends = angle[-1] - math.tau * each * np.arange(count // each, -1, -1)
    return np.interp(ends, angle, time)


def _mark_ramp(all_axes: list[Axes], result: Result) -> None:
    """Draw a dashed line where the speed reaches its last value, if that is within the run."""
    time = result.series["time"].values
    end = ramp_end(result)
    if time[0] < end < time[-1]:
        for axes in all_axes:
            axes.axvline(end, color=MARK, linewidth=0.7, linestyle=(0, (4, 3)), zorder=3, label="end of ramp")


def _legend(figure: Figure, columns: int, position: str) -> None:
    """Add one legend for all panels, outside them, so that it never hides a curve. The curve drawn last comes
    first.
    """
    handles = {
        label: handle
        for axes in figure.axes
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)
    }
    figure.legend(list(handles.values())[::-1], list(handles)[::-1], loc=position, ncols=columns)
