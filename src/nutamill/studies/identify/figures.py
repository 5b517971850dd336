"""Figures of an identification: the posterior in pairs of unknowns, and each row before and after."""

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from nutamill.studies.identify.identification import Identification
from nutamill.view.figures.style import ENVELOPE, MARK, MEAN, RMS, STYLE, WIDTH

BINS = 30
"""Bins of a histogram [1]."""
LONGEST = 60
"""Characters of a row's name above its axes [1]."""


def draw_corner(done: Identification) -> Figure:
    """Draw the posterior of each unknown over its range, of each pair below, and the mode."""
    unknowns = done.problem.unknowns
    values, mode = done.problem.values(done.posterior.points), done.problem.values(done.posterior.mode)
    count = len(unknowns)
    side = max(WIDTH, 1.0 * count)
    with matplotlib.rc_context(fname=STYLE):
        figure = Figure(figsize=(side, side), layout="constrained")
        panels = figure.subplots(count, count, squeeze=False)
        for i in range(count):
            for j in range(count):
                axes, across = panels[i, j], (unknowns[j].low, unknowns[j].high)
                if j > i:
                    axes.set_visible(False)
                    continue
                if i == j:
                    axes.hist(values[:, j], BINS, range=across, density=True, color=ENVELOPE)
                    axes.axvline(mode[j], color=RMS)
                else:
                    axes.plot(values[:, j], values[:, i], ".", ms=0.6, color=MEAN, rasterized=True)
                    axes.plot(mode[j], mode[i], "+", color=RMS)
                    axes.set_ylim(unknowns[i].low, unknowns[i].high)
                axes.set_xlim(across)
                axes.xaxis.set_major_locator(MaxNLocator(2))
                axes.yaxis.set_major_locator(MaxNLocator(2))
                axes.tick_params(labelbottom=i == count - 1, labelleft=j == 0 and i > 0)
                if i == count - 1:
                    axes.set_xlabel(_label(unknowns[j].name, unknowns[j].unit))
                if j == 0 and i > 0:
                    axes.set_ylabel(_label(unknowns[i].name, unknowns[i].unit))
    return figure


def draw_rows(done: Identification) -> Figure:
    """Draw each row in its own unit: 90 % interval over the ranges, over the posterior, and the measured
    value with its standard uncertainty.
    """
    rows = done.problem.rows
    with matplotlib.rc_context(fname=STYLE):
        figure = Figure(figsize=(WIDTH, 0.5 + 0.62 * len(rows)), layout="constrained")
        panels = np.atleast_1d(figure.subplots(len(rows), 1))
        for number, (axes, row) in enumerate(zip(panels, rows, strict=True)):
            prior, posterior = done.prior_rows[number], done.posterior_rows[number]
            if not done.problem.drawn(row):
                axes.plot(prior[[0, 2]], [0, 0], color=ENVELOPE, lw=6, label="over the ranges")
            axes.plot(posterior[[0, 2]], [0, 0], color=MEAN, lw=3, label="posterior")
            axes.plot(posterior[1], 0, "|", color="white", ms=5)
            if np.isfinite(row.value):
                axes.errorbar(
                    row.value, 0, xerr=row.scatter, fmt="o", ms=3, color=RMS if row.learned else MARK,
                    label="measured, learned from" if row.learned else "measured, predicted",
                )  # fmt: skip
            axes.set_yticks([])
            axes.set_ylim(-1, 1)
            unit = "" if row.measurand.unit == "1" else f" ({row.measurand.unit})"
            axes.set_title(f"{row.label[:LONGEST]}{unit}", fontsize=6, loc="left", pad=2)
        handles = {
            label: handle
            for axes in panels
            for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)
        }
        figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=2)
    return figure


def _label(name: str, unit: str) -> str:
    return name.replace("_", " ") + ("" if unit == "1" else f"\n({unit.replace('^2', '$^2$')})")
