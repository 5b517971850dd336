"""Figures of what a designer reads from a result.  One function, one figure; saving is left to the caller."""

import math
import textwrap

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nutamill.analysis.bearings import BearingLife
from nutamill.analysis.fatigue import SectionLife
from nutamill.analysis.load_paths import hodograph, joints_of
from nutamill.analysis.mounts import floor_series, recorded_vector
from nutamill.analysis.orders import Orders, Waterfall
from nutamill.analysis.source import machine_of
from nutamill.analysis.summary import LONGEST, hours_text
from nutamill.analysis.windows import PAPER_WINDOW, window_length
from nutamill.base.units import in_unit, rpm
from nutamill.case.drawing import GROUND
from nutamill.result import Result
from nutamill.result.fields import Field
from nutamill.view.figures.style import PALETTE, STYLE, WIDTH, unit_of

NO_FORCE = 1e-9
"""Share of the largest force below which a joint carries none but round-off [1]."""
NOISE = 0.1
"""Share of the largest amplitude of an order below which its phase is noise [1]."""
FEW = 20
"""Points up to which a curve shows each of them [1]."""
TITLE = 20
"""Letters in a line of a title over half a column [1]."""
FLOOR = 1e-3
"""Share of the largest amplitude of a waterfall below which it is white [1]."""
SWEEP = 0.05
"""Share by which the speed must change for orders to be drawn over it [1]."""
YEAR = 8760.0
"""Hours in a year, for a mark of lives [h]."""


def draw_orders(history: Orders, falls: Waterfall, field: Field) -> Figure:
    """Draw amplitude and phase of the orders of a series, and its spectra below (logarithmic grey).

    The first two are drawn over speed; over time where the speed hardly changes.
    """
    sweeps = np.ptp(history.speed) > SWEEP * history.speed.max()
    across = rpm(history.speed) if sweeps else history.time
    unit = unit_of(field)
    with matplotlib.rc_context(fname=STYLE):
        figure = Figure(figsize=(WIDTH, 4.8), layout="constrained")
        size, lag, fall = figure.subplots(3, 1, height_ratios=[1.2, 0.8, 1.4])
        mark = "-" if len(across) > FEW else "o-"
        for k, order in enumerate(history.orders):
            label = "once per turn" if order == 1 else f"{order:g} times per turn"
            size.plot(across, history.amplitude[k], mark, markersize=3, color=PALETTE[k % 7], label=label)
            drawn = (
                history.amplitude[k] > NOISE * history.amplitude[k].max()
            )  # of a small amplitude the phase is noise
            degrees = in_unit(history.lag[k][drawn], "deg")
            dot = 1.5 if len(across) > FEW else 5.0
            lag.plot(across[drawn], degrees, ".", markersize=dot, color=PALETTE[k % 7])
        size.set_ylim(bottom=0.0)
        size.set_ylabel(f"amplitude ({unit})")
        size.set_title(f"(a) {field.label}", loc="left")
        lag.set_ylim(-180, 180)
        lag.set_yticks([-180, -90, 0, 90, 180])
        lag.set_ylabel("angle (°)")
        lag.set_title("(b) phase behind the drive", loc="left")
        _draw_waterfall(figure, fall, falls, unit)
        fall.set_title("(c) spectra", loc="left")
        for axes in (size, lag):
            axes.set_xlim(0.0 if sweeps else across[0], across.max())
            axes.set_xlabel("speed (rpm)" if sweeps else "time (s)")
        figure.legend(*size.get_legend_handles_labels(), loc="outside lower center", ncols=4)
        figure.align_ylabels()
    return figure


def _draw_waterfall(figure: Figure, axes: Axes, falls: Waterfall, unit: str) -> None:
    """Draw spectra over time as a map, with lines of one and two per turn."""
    fastest = falls.speed.max() / (2.0 * math.pi)
    shown = falls.frequency <= 4.5 * fastest
    level = np.log10(np.maximum(falls.amplitude[shown] / falls.amplitude[shown].max(), FLOOR))
    drawn = axes.pcolormesh(
        falls.time, falls.frequency[shown], level, cmap="Greys", shading="nearest", rasterized=True
    )
    for k, order in enumerate((1, 2)):
        axes.plot(
            falls.time,
            order * falls.speed / (2.0 * math.pi),
            color=PALETTE[k],
            linewidth=0.6,
            linestyle=(0, (4, 3)),
        )
    axes.grid(False)
    axes.set_xlabel("time (s)")
    axes.set_ylabel("frequency (Hz)")
    bar = figure.colorbar(drawn, ax=axes, label="share of largest", ticks=[-3, -2, -1, 0])
    bar.ax.set_yticklabels(["0.001", "0.01", "0.1", "1"])


def draw_loads(result: Result, axes: str = "frame", last: float | str = PAPER_WINDOW) -> Figure:
    """Draw polar plots: the path of the tip of each joint's force in the plane of x and y of the chosen axes,
    over the steady turns.

    A mean that is more than a tenth of the largest force is drawn as a line with a dot: in axes that turn
    along, the path may be a point.
    """
    joints = joints_of(result)
    columns = 2
    with matplotlib.rc_context(fname=STYLE):
        figure = Figure(figsize=(WIDTH, 1.75 * math.ceil(len(joints) / columns)), layout="constrained")
        panels = figure.subplots(math.ceil(len(joints) / columns), columns, squeeze=False).ravel()
        paths = {joint: hodograph(result, joint, axes, last).reaction for joint in joints}
        largest = max(np.abs(force).max() for force in paths.values())
        for panel, (joint, force) in zip(panels, paths.items(), strict=False):
            most = 1.15 * np.abs(force[:, :2]).max()
            panel.set_title(textwrap.fill(joint.replace("_", " "), TITLE), loc="left")
            if not most > NO_FORCE * largest:
                panel.annotate(
                    "no force in\nthis plane",
                    (0.5, 0.5),
                    xycoords="axes fraction",
                    ha="center",
                    va="center",
                    fontsize=6.5,
                )
                panel.set_axis_off()
                continue
            panel.plot(force[:, 0], force[:, 1], color=PALETTE[0], linewidth=0.8)
            panel.plot([0.0], [0.0], "+", color="black", markersize=5)
            mean = force[:, :2].mean(axis=0)
            if math.hypot(*mean) > 0.1 * most:
                panel.plot([0.0, mean[0]], [0.0, mean[1]], color=PALETTE[1], linewidth=0.8)
                panel.plot(*mean, "o", color=PALETTE[1], markersize=2.5)
            panel.set_xlim(-most, most)
            panel.set_ylim(-most, most)
            panel.set_aspect("equal")
            panel.locator_params(nbins=4)
            panel.set_xlabel("$F_x$ (N)")
            panel.set_ylabel("$F_y$ (N)")
        for panel in panels[len(joints) :]:
            panel.set_axis_off()
        figure.suptitle(f"force of each joint, {axes} axes", fontsize=8)
    return figure


def draw_floor(result: Result, last: float | str = PAPER_WINDOW) -> Figure:
    """Draw the path of the first mount's foot and of the force on the floor, in the plane of the floor, over
    the steady end of the run.
    """
    length = window_length(last)
    time = result.series["time"].values
    inside = time >= time[-1] - min(length, 0.5 * time[-1])
    machine = machine_of(result)
    force = floor_series(result.series, machine)[inside]
    paths = [("force on the floor", force[:, 0], force[:, 1], "N")]
    if foot := next((entry.name for entry in machine.bushings if GROUND in entry.between), ""):
        travel = in_unit(recorded_vector(result, machine, f"bushing_{foot}_travel")[inside], "mm")
        paths.append((f"travel of {foot.replace('_', ' ')}", travel[:, 0], travel[:, 1], "mm"))
    with matplotlib.rc_context(fname=STYLE):
        figure = Figure(figsize=(WIDTH, 2.0 if len(paths) == 2 else 3.2), layout="constrained")
        for panel, (title, x, y, unit) in zip(
            figure.subplots(1, len(paths), squeeze=False).ravel(), paths, strict=True
        ):
            panel.plot(x, y, color=PALETTE[0], linewidth=0.6)
            panel.set_aspect("equal", adjustable="datalim")
            panel.locator_params(nbins=4)
            panel.margins(0.1)
            panel.set_title(title, loc="left")
            panel.set_xlabel(f"x ({unit})")
            panel.set_ylabel(f"y ({unit})")
    return figure


def draw_lives(bearings: list[BearingLife], sections: list[SectionLife]) -> Figure:
    """Draw the lives of bearings and sections as bars on a logarithmic axis, up to `LONGEST`."""
    lives = [(one.joint, one.time, PALETTE[0]) for one in bearings] + [
        (one.name, one.time, PALETTE[1]) for one in sections
    ]
    with matplotlib.rc_context(fname=STYLE):
        figure = Figure(figsize=(WIDTH, 0.8 + 0.28 * len(lives)), layout="constrained")
        axes = figure.subplots()
        for k, (_name, time, color) in enumerate(lives):
            hours = min(max(in_unit(time, "h"), 1.0), LONGEST)
            axes.barh(k, hours, color=color, height=0.6)
            label = f"{hours_text(time).strip()} h"
            axes.annotate(
                label, (hours, k), xytext=(3, 0), textcoords="offset points", va="center", fontsize=6.5
            )
        axes.set_yticks(range(len(lives)), [name.replace("_", " ") for name, _, _ in lives])
        axes.invert_yaxis()
        axes.set_xscale("log")
        axes.set_xlim(1.0, 100.0 * LONGEST)
        axes.axvline(YEAR, color="black", linewidth=0.7, linestyle=(0, (4, 3)))
        axes.annotate(
            "one year",
            (YEAR, 1.0),
            xycoords=("data", "axes fraction"),
            xytext=(2, 2),
            textcoords="offset points",
            fontsize=6,
        )
        axes.grid(axis="y", visible=False)
        axes.set_xlabel("life (h)")
    return figure
