"""Figures of what a designer asks of a case.  One function, one figure; saving is left to the caller."""

import math

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import LogFormatter

from nutamill.base.units import in_unit, rpm, shown, si_value
from nutamill.case import Case, Machine
from nutamill.case.mill_quantities import crank_radius
from nutamill.design.balancing import Balancing
from nutamill.design.campbell import ORDERS, Campbell
from nutamill.design.isolation import Isolation
from nutamill.design.modes import MachineModes
from nutamill.design.runup import RunUp
from nutamill.design.sticks import Stick
from nutamill.simulation.setup.altered import supports
from nutamill.view.figures.style import PALETTE, STYLE, WIDTH, unit_of

GREY, MOVED, ORBIT = "#B8B8B8", "#0072B2", "#D55E00"
LARGEST = 0.1
"""Size of the largest drawn displacement of a mode, as a share of the machine's [1]."""
LINES = {1.0: "-", 2.0: (0, (5, 2))}


def draw_modes(lines: list[Stick], vibrations: MachineModes) -> Figure:
    """Draw the shapes of the modes, seen from above and from the side: the machine at rest in grey, displaced
    in blue, paths of its corners in orange.

    Parameters
    ----------
    lines : the machine as `nutamill.design.sticks.sticks` draws it
    """
    count = len(vibrations.frequency)
    columns = min(count, 4)
    rows = math.ceil(count / columns)
    look = _looking(si_value(-62.0, "deg"), si_value(18.0, "deg"))
    largest = LARGEST * float(np.ptp(np.concatenate([line.points for line in lines]), axis=0).max())
    with matplotlib.rc_context(fname=STYLE):
        figure = Figure(figsize=(7.0, 2.6 * rows), layout="constrained")
        panels = figure.subplots(rows, columns, squeeze=False).ravel()
        for panel in panels:
            panel.set_axis_off()
            panel.set_aspect("equal")
        for k in range(count):
            axes, shape = panels[k], vibrations.shape[:, :, k]
            moves = [line.moved(shape[vibrations.bodies.index(line.body)]) for line in lines]
            scale = largest / max(largest / 1.5, *(np.abs(move).max() for move in moves))
            for line, move in zip(lines, moves, strict=True):
                axes.plot(*(line.points @ look).T, color=GREY, linewidth=0.6)
                axes.plot(*((line.points + scale * move.real) @ look).T, color=MOVED, linewidth=0.9)
            for line, move in zip(lines, moves, strict=True):
                turn = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 41))[:, None]
                ends = {0, len(move) - 1} if len(move) <= 3 else set()
                for corner in ends:
                    path = line.points[corner] + scale * (move[corner] * turn).real
                    axes.plot(*(path @ look).T, color=ORBIT, linewidth=0.7)
            title = (
                f"{vibrations.frequency[k]:.2f} Hz, {round(100 * vibrations.damping_ratio[k], 1) + 0.0:.1f} "
                f"%\n{vibrations.label(k)}"
            )
            axes.set_title(title, loc="center")
    return figure


def draw_campbell(diagram: Campbell) -> Figure:
    """Draw the Campbell diagram: natural frequencies over driveshaft speed, lines of one and two excitations
    per period, speeds to avoid.
    """
    speeds, turns = rpm(diagram.speeds), in_unit(diagram.speeds, "rev/s")
    highest = 1.08 * max(
        diagram.frequency[diagram.frequency < 2.2 * turns[-1]].max(initial=1.0),
        turns[-1],
    )
    with matplotlib.rc_context(fname=STYLE):
        figure = Figure(figsize=(WIDTH, 3.4), layout="constrained")
        axes = figure.subplots()
        lowest = [k for k in range(len(diagram.labels)) if diagram.frequency[:, k].min() < highest]
        for n, k in enumerate(lowest):
            axes.plot(
                speeds,
                diagram.frequency[:, k],
                color=PALETTE[n % 7],
                linestyle=("-", (0, (2, 2)))[n % 2],
                linewidth=1.4,
                label=diagram.labels[k],
            )
        for order in ORDERS:
            axes.plot(
                speeds,
                order * turns,
                color="black",
                linewidth=0.8,
                linestyle=LINES[order],
                label=f"{order:.0f}x speed",
            )
        axes.plot(
            [rpm(a.speed) for a in diagram.avoid],
            [a.frequency for a in diagram.avoid],
            "ko",
            markersize=3,
            label="speeds to avoid",
        )
        if diagram.working <= diagram.speeds[-1]:
            at = rpm(diagram.working)
            axes.axvline(at, color="0.5", linewidth=0.8, linestyle=":", label=f"working speed, {at:.4g} rpm")
        axes.set_ylim(0.0, highest)
        axes.set_xlabel("driveshaft speed (rpm)")
        axes.set_ylabel("natural frequency (Hz)")
        figure.legend(loc="outside lower center", ncols=2)
    return figure


def draw_run_up(runs: list[RunUp]) -> Figure:
    """Draw the amplitude of each order over speed, one line for each ramp, and the phase lag of the first
    order.
    """
    field = runs[0].field
    unit = unit_of(field)
    orders = runs[0].orders.orders
    with matplotlib.rc_context(fname=STYLE):
        figure = Figure(figsize=(WIDTH, 1.5 * (len(orders) + 1)), layout="constrained")
        panels = figure.subplots(len(orders) + 1, 1, sharex=True)
        for n, run in enumerate(runs):
            style = {"color": PALETTE[n % 7], "label": f"{rpm(run.ramp):.4g} rpm/s"}
            for k in range(len(orders)):
                panels[k].plot(rpm(run.orders.speed), run.orders.amplitude[k], **style)
            visible = run.orders.amplitude[0] > 0.02 * run.orders.amplitude[0].max()
            if visible.any():
                lag = in_unit(np.unwrap(run.orders.lag[0][visible]), "deg")
                whole = 360.0 * round(lag.mean() / 360.0)
                panels[-1].plot(rpm(run.orders.speed[visible]), lag - whole, **style)
        for k, order in enumerate(orders):
            panels[k].set_title(f"({'abcdefg'[k]}) {field.label}, {order:g}x", loc="left")
            panels[k].set_ylabel(f"amplitude ({unit})")
            panels[k].set_ylim(bottom=0.0)
        panels[-1].set_title(f"({'abcdefg'[len(orders)]}) phase lag, {orders[0]:g}x", loc="left")
        panels[-1].set_ylabel("lag (°)")
        panels[-1].set_xlabel("driveshaft speed (rpm)")
        panels[-1].set_xlim(0.0, rpm(max(run.orders.speed.max() for run in runs)))
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
        figure.align_ylabels()
    return figure


def draw_isolation(answer: Isolation) -> Figure:
    """Draw the force on the floor over the shaking force, over speed, beside that of one mass on a spring."""
    with matplotlib.rc_context(fname=STYLE):
        figure = Figure(figsize=(WIDTH, 2.6), layout="constrained")
        axes = figure.subplots()
        axes.plot(rpm(answer.speed), answer.transmissibility, color=PALETTE[0], label="mill on its mounts")
        axes.plot(
            rpm(answer.speed),
            answer.single,
            color=PALETTE[5],
            linestyle=(0, (5, 2)),
            label="one mass on a spring",
        )
        axes.axhline(1.0, color="black", linewidth=0.6)
        axes.set_yscale("log")
        axes.yaxis.set_major_formatter("{x:g}")
        axes.yaxis.set_minor_formatter(LogFormatter(minor_thresholds=(2.0, 0.5)))
        axes.set_xlim(0.0, rpm(answer.speed[-1]))
        axes.set_xlabel("driveshaft speed (rpm)")
        axes.set_ylabel("force passed on")
        figure.legend(loc="outside lower center", ncols=2)
    return figure


def draw_balancing(balancing: Balancing, case: Case | Machine) -> Figure:
    """Draw vibration before and after, and the driveshaft seen from above with pin and weights."""
    unit = "mm" if supports(case.machine) else "N"
    with matplotlib.rc_context(fname=STYLE):
        figure = Figure(figsize=(WIDTH, 2.0), layout="constrained")
        bars, view = figure.subplots(1, 2)
        bars.bar(
            ["before", "after"],
            [in_unit(balancing.before, unit), in_unit(balancing.after, unit)],
            color=[PALETTE[5], PALETTE[0]],
            width=0.6,
        )
        bars.set_ylabel(f"{'travel' if unit == 'mm' else 'force'}, r.m.s. ({unit})")
        bars.set_title("(a) once per turn", loc="left")
        bars.grid(axis="x", visible=False)
        view.plot([0.0], [0.0], "+", color="black", markersize=6)
        if crank := in_unit(crank_radius(case.machine), "mm"):
            view.plot([crank], [0.0], "o", color="black", markersize=4, label="crank pin")
        for k, weight in enumerate(balancing.weights):
            direction = np.array([math.cos(weight.azimuth), math.sin(weight.azimuth)])
            position = in_unit(weight.radius, "mm") * direction
            label = f"{weight.mass:.3g} kg at {shown(weight.depth, 'mm', '.0f')}"
            view.plot(*position[:, None], "s", color=PALETTE[k], markersize=8 - 4 * k, label=label)
        most = 1.3 * max(crank, *(in_unit(weight.radius, "mm") for weight in balancing.weights))
        view.set_xlim(-most, most)
        view.set_ylim(-most, most)
        view.set_aspect("equal")
        view.set_xlabel("x (mm)")
        view.set_ylabel("y (mm)")
        view.set_title("(b) from above", loc="left")
        figure.legend(*view.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


def _looking(azimuth: float, height: float) -> np.ndarray:
    """Compute the matrix (3, 2) that projects world points on the plane of the picture, for a view from
    `azimuth` [rad], `height` [rad] above.
    """
    right = [-math.sin(azimuth), math.cos(azimuth), 0.0]
    up = [-math.sin(height) * math.cos(azimuth), -math.sin(height) * math.sin(azimuth), math.cos(height)]
    return np.array([right, up]).T
