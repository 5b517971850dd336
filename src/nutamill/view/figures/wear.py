"""Picture of worn walls: the liner unrolled, and how deep each wall is worn along it."""

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nutamill.analysis.wear import SERVICE, SurfaceWear, Wear
from nutamill.base.units import in_unit
from nutamill.view.figures.style import PALETTE, STYLE, WIDTH

SHOWN = 6
"""Surfaces whose wear along the wall is drawn, the worst first [1]."""


def draw_wear(wear: Wear, surfaces: list[SurfaceWear]) -> Figure:
    """Draw the depth of wear in 1000 h: on the surface that loses the largest volume, unrolled, and along
    each of the most worn surfaces, mean and largest around it.
    """
    depth = in_unit(SERVICE * wear.depth, "mm")
    names = [one.name for one in surfaces]
    lost = [(wear.depth * wear.area)[wear.surface == name].sum() for name in names]
    with matplotlib.rc_context(fname=STYLE):
        figure = Figure(figsize=(WIDTH, 5.0), layout="constrained")
        unrolled, along = figure.subplots(2, 1, height_ratios=[1.2, 1.0])
        if names:
            _draw_unrolled(figure, unrolled, wear, depth, names[int(np.argmax(lost))])
        for k, name in enumerate(names[:SHOWN]):
            own = np.flatnonzero((wear.surface == name) & (wear.area > 0.0))
            places, number = np.unique(wear.along[own], return_inverse=True)
            mean = np.bincount(number, depth[own] * wear.area[own]) / np.bincount(number, wear.area[own])
            largest = np.zeros(len(places))
            np.maximum.at(largest, number, depth[own])
            colour = PALETTE[k % len(PALETTE)]
            along.plot(in_unit(places, "mm"), mean, ".-", color=colour, label=name)
            along.plot(in_unit(places, "mm"), largest, ":", color=colour)
        along.set_ylim(bottom=0.0)
        along.set(xlabel="height or radius (mm)", ylabel="mm per 1000 h")
        along.set_title("(b) mean and largest (dotted) along each wall", loc="left")
        figure.legend(*along.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


def _draw_unrolled(figure: Figure, axes: Axes, wear: Wear, depth: np.ndarray, name: str) -> None:
    """Draw the depth of wear on one surface, around it and along it."""
    own = np.flatnonzero(wear.surface == name)
    columns = int(wear.column[own].max()) + 1
    azimuth, along = (values[own].reshape(columns, -1) for values in (wear.azimuth, wear.along))
    around, label = in_unit(azimuth[:, 0], "deg"), "azimuth in the chamber (deg)"
    if np.isnan(around).any():
        around, label = np.arange(columns, dtype=float), "face (-x, +x, -y, +y, -z, +z)"
    elif len(np.unique(around)) < columns:  # of a wall about another axis
        around, label = (np.arange(columns) + 0.5) * 360.0 / columns, "angle about the wall's axis (deg)"
    order = np.argsort(around)
    if columns > 1 and along.shape[1] > 1:
        drawn = axes.pcolormesh(
            around[order],
            in_unit(along[0], "mm"),
            depth[own].reshape(columns, -1)[order].T,
            cmap="viridis",
            vmin=0.0,
            rasterized=True,
        )
        figure.colorbar(drawn, ax=axes, label="mm per 1000 h")
    axes.grid(False)
    axes.set(xlabel=label, ylabel="height or radius (mm)")
    axes.set_title(f"(a) {name}, unrolled", loc="left")
