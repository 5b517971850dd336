"""Figures in the papers' form, drawn from their plans: forces and torques over speed or centrifugal number,
particles, run-ups.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nutamill.base.errors import ResultError
from nutamill.base.units import Kind, parse, rpm
from nutamill.case.drawing import DrawnMechanism
from nutamill.result import open_result
from nutamill.studies.papers.cells import unit_of
from nutamill.studies.papers.compare import Key, Measured, compare
from nutamill.studies.papers.model import Curve, FigurePlan, Paper, Row, same_speed
from nutamill.studies.papers.particle_views import PUBLISHED, draw_particles
from nutamill.studies.papers.quantities import QUANTITIES
from nutamill.studies.papers.runs import COMPLETE, PlannedRun, run_name, run_state
from nutamill.view.figures.run import draw_run
from nutamill.view.figures.style import STYLE, WIDTH

MARKS = ("o", "s", "^", "D", "v")


def draw_figure(
    plan: FigurePlan, paper: Paper, runs: Sequence[PlannedRun], measured: Mapping[Key, Measured]
) -> Figure:
    """Draw the figure of a plan.

    Raises
    ------
    ResultError : nothing it shows has a result yet
    """
    if plan.form in ("speed", "lambda"):
        return draw_over_speed(plan, paper, runs, measured)
    if plan.form == "place":
        return draw_over_place(plan, paper, measured)
    assert plan.speed is not None  # these forms have one
    speed = plan.speed
    run = next(
        run for run in runs if run.configuration == plan.configuration and same_speed(run.speed, speed)
    )
    if (state := run_state(run)) != COMPLETE:
        raise ResultError(f"{run_name(run.configuration, run.speed)} is {state}")
    with open_result(run.path) as result:
        return draw_particles(result) if plan.form == "particles" else draw_run(result)


def draw_over_place(plan: FigurePlan, paper: Paper, measured: Mapping[Key, Measured]) -> Figure:
    """Draw the rows of each panel's quantity over the place or time at which they are taken, with published
    numbers as hollow marks.

    Raises
    ------
    ResultError : none of them has a result yet
    """
    with matplotlib.rc_context(fname=STYLE):
        figure = Figure(figsize=(WIDTH, 0.75 + 1.9 * len(plan.panels)), layout="constrained")
        panels = figure.subplots(len(plan.panels), 1, squeeze=False)[:, 0]
        drawn = 0
        for axes, panel in zip(panels, plan.panels, strict=True):
            quantity = QUANTITIES[panel.quantity]
            (unit, many), (across, many_across) = unit_of(quantity.kind), unit_of(quantity.at)
            for number, curve in enumerate(panel.curves):
                rows = [
                    row
                    for row in paper.rows
                    if row.quantity == panel.quantity and row.configuration in curve.configurations
                ]
                places = [many_across * (row.at or 0.0) for row in rows]
                ours = [many * finding.value for finding in compare(rows, measured)]
                drawn += int(np.isfinite(ours).sum())
                color = f"C{number}"
                axes.plot(places, ours, MARKS[number] + "-", color=color, label=curve.label)
                axes.errorbar(
                    places,
                    [math.nan if row.experiment is None else many * row.experiment for row in rows],
                    yerr=[many * (row.absolute or 0.0) for row in rows],
                    fmt="o", mfc="white", color=PUBLISHED, label=None if number else _called(rows),
                )  # fmt: skip
            axes.set_xlabel(f"{'time' if quantity.at is Kind.TIME else 'place'} ({across})")
            axes.set_ylabel(f"{quantity.label}\n({unit})")
            axes.legend()
        if not drawn:
            raise ResultError("none of its rows has a result")
        figure.suptitle(f"{paper.short}: {plan.title}", fontsize=8)
        return figure


def _called(rows: Sequence[Row]) -> str:
    """Return what the marks of rows are called."""
    return "paper, " + " and ".join(sorted({row.experiment_is for row in rows}))


def draw_over_speed(
    plan: FigurePlan, paper: Paper, runs: Sequence[PlannedRun], measured: Mapping[Key, Measured]
) -> Figure:
    """Draw each panel's quantity over the speed, or over lambda = L12 w^2/g with the speed along the top,
    with published numbers as hollow marks.

    A line joins our runs of a curve's configurations; where two have the same speed, the one named last
    counts.  Bars are 95 % intervals of the steady means, mostly smaller than the marks.

    Source
    ------
    van Tonder, Bredell, Coetzee and Branehog, J. S. Afr. Inst. Min. Metall. 125 (2025), figures 11 to 16,
    equation 1; Janse van Vuuren, Bredell and Coetzee, Math. Comput. Appl. 31(5), 171 (2026), figures 7, 8,
    10, 12 to 14 (forms of the pictures)
    """
    with matplotlib.rc_context(fname=STYLE):
        figure = Figure(figsize=(WIDTH, 0.75 + 1.9 * len(plan.panels)), layout="constrained")
        drawn, published = 0, dict[str, str]()
        all_axes = figure.subplots(len(plan.panels), 1, sharex=True, squeeze=False)[:, 0]
        for k, (axes, panel) in enumerate(zip(all_axes, plan.panels, strict=True)):
            quantity = QUANTITIES[panel.quantity]
            for number, curve in enumerate(panel.curves):
                drawn += _draw_curve(axes, curve, panel.quantity, number, plan, paper, runs, measured)
                published |= _draw_published(axes, curve, panel.quantity, number, plan, paper, runs)
            unit, _ = unit_of(quantity.kind)
            axes.set_ylabel(
                f"{quantity.label} ({unit})"
                if len(plan.panels) == 1
                else f"{'torque' if unit == 'N m' else 'force'} ({unit})"
            )
            if np.isfinite(axes.dataLim.y1):  # else the panel is empty
                axes.set_ylim(min(0.0, 1.1 * axes.dataLim.y0), 1.1 * axes.dataLim.y1)
                axes.set_xlim(0.0, 1.04 * axes.dataLim.x1)
            if len(plan.panels) > 1:
                axes.set_title(f"({'abcd'[k]}) {quantity.label}", loc="left")
        if not drawn:
            raise ResultError("none of its runs is complete")
        if plan.form == "lambda":
            _speed_on_top(all_axes[0], runs)
            all_axes[-1].set_xlabel("centrifugal number $\\lambda = L_{12}\\,\\omega^2/g$")
        else:
            all_axes[-1].set_xlabel("speed (rpm)")
        _legend(figure, all_axes, published)
        figure.align_ylabels()
    return figure


def _draw_curve(
    axes: Axes,
    curve: Curve,
    quantity: str,
    number: int,
    plan: FigurePlan,
    paper: Paper,
    runs: Sequence[PlannedRun],
    measured: Mapping[Key, Measured],
) -> int:
    """Draw our numbers of a curve, and return how many there are."""
    points = {}
    for name in curve.configurations:
        for speed in paper.configurations[name].speeds:
            value = measured.get(Key.of(name, speed, curve.quantity or quantity))
            if value is not None and not math.isnan(value.estimate.mean):
                points[round(speed, 6)] = value.estimate
    if not points:
        return 0
    speeds = sorted(points)
    _, many = unit_of(QUANTITIES[quantity].kind)
    means = [points[speed].mean * many for speed in speeds]
    bars = np.nan_to_num([points[speed].half_width * many for speed in speeds])
    style: dict[str, Any] = {
        "color": _colour(number),
        "marker": MARKS[number],
        "markersize": 3.0,
        "capsize": 1.5,
        "elinewidth": 0.7,
    }
    if curve.quantity is not None:
        style |= {"linestyle": (0, (3, 1.5))}
    axes.errorbar(_abscissa(speeds, plan, runs), means, bars, label=curve.label, **style)
    return len(points)


def _draw_published(
    axes: Axes,
    curve: Curve,
    quantity: str,
    number: int,
    plan: FigurePlan,
    paper: Paper,
    runs: Sequence[PlannedRun],
) -> dict[str, str]:
    """Draw the printed numbers of a curve: what we are compared with as a hollow mark, the authors'
    simulation as a cross, each at its own speed. Return what the marks are called, and a mark of each.
    """
    _, many = unit_of(QUANTITIES[quantity].kind)
    published = {}
    for row in paper.rows:
        if (
            row.against is not None
            or row.configuration not in curve.configurations
            or row.quantity != quantity
            or curve.quantity is not None
        ):
            continue
        if row.experiment is not None:
            published[f"paper, {row.experiment_is}"] = "o"
            at = _abscissa([row.speed], plan, runs)
            axes.plot(
                at,
                [row.experiment * many],
                marker=MARKS[number],
                markersize=6.0,
                mfc="none",
                mec=_colour(number),
                mew=1.0,
                linestyle="none",
            )
        if row.simulation is not None:
            published["paper, simulated"] = "x"
            at = _abscissa([row.simulation_speed or row.speed], plan, runs)
            axes.plot(
                at,
                [row.simulation * many],
                marker="x",
                markersize=5.0,
                mec=_colour(number),
                mew=1.0,
                linestyle="none",
            )
    return published


def _colour(number: int) -> str:
    """Return the colour of a curve of the style, not as ``C0``, which a picture saved later would look up in
    another style.
    """
    colours = matplotlib.rcParams["axes.prop_cycle"].by_key()["color"]
    return colours[number % len(colours)]


def _abscissa(speeds: Sequence[float], plan: FigurePlan, runs: Sequence[PlannedRun]) -> np.ndarray:
    """Return speeds [rad/s] on the axis of a figure: in rpm, or as centrifugal numbers."""
    speed = np.asarray(speeds)
    return centrifugal_number(speed, _drawn(runs)) if plan.form == "lambda" else rpm(speed)


def _drawn(runs: Sequence[PlannedRun]) -> DrawnMechanism:
    """Return the drawing of the mill that is run. Raises ResultError for another machine."""
    drawing = runs[0].case.drawing
    if drawing is None:
        raise ResultError('form = "lambda" is for nutating mills. Write form = "speed".')
    return drawing.mechanism


def centrifugal_number(speed: np.ndarray, mechanism: DrawnMechanism) -> np.ndarray:
    """Return the centripetal acceleration of the crank pin over gravity [1] at speeds [rad/s].

    Source
    ------
    van Tonder, Bredell, Coetzee and Branehog, J. S. Afr. Inst. Min. Metall. 125 (2025), equation 1
    """
    return mechanism.crank_radius * speed**2 / mechanism.gravity


def _speed_on_top(axes: Axes, runs: Sequence[PlannedRun]) -> None:
    """Add a second axis along the top, in rpm."""
    scale = float(centrifugal_number(np.array(parse("1 rpm", Kind.SPEED)), _drawn(runs)))

    def speed_of(number: Any) -> Any:
        return np.sqrt(np.maximum(number, 0.0) / scale)

    def number_of(speed: Any) -> Any:
        return scale * speed**2

    top = axes.secondary_xaxis("top", functions=(speed_of, number_of))
    top.set_xticks([200, 300, 400, 500, 600, 700])
    top.set_xlabel("speed (rpm)")


def _legend(figure: Figure, all_axes: np.ndarray, published: Mapping[str, str]) -> None:
    """Add one legend below: our curves, and what hollow marks and crosses are called."""
    handles = {
        label: handle
        for axes in all_axes
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)
    }
    hollow: dict[str, Any] = {"color": PUBLISHED, "linestyle": "none", "markerfacecolor": "none"}
    for called, mark in sorted(published.items()):
        size = 5.0 if mark == "x" else 6.0
        handles[called] = Line2D([], [], marker=mark, markersize=size, **hollow)
    figure.legend(
        list(handles.values()), list(handles), loc="outside lower center", ncols=min(3, len(handles))
    )
