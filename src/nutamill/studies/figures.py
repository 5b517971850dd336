"""Readings over a swept key, with their intervals."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from nutamill.analysis.values import Reading
from nutamill.base.units import in_unit
from nutamill.view.figures.style import STYLE, WIDTH

if TYPE_CHECKING:
    import xarray

PANELS = 3
"""Readings drawn at most [1]."""
MARKS = "osD^vP"


def draw_sweep(table: "xarray.Dataset", readings: Sequence[Reading]) -> Figure | None:
    """Draw steady means over the longest of the swept keys that holds numbers, with 95 % intervals and a line
    for each of the other values.

    None if there is no such key with two values, or nothing was read.
    """
    numeric = [key for key in table.dims if table[key].dtype.kind in "fi" and table.sizes[key] > 1]
    drawn = [reading for reading in readings if bool(np.isfinite(table[reading.name]).any())][:PANELS]
    if not numeric or not drawn:
        return None
    along = str(max(numeric, key=lambda key: table.sizes[key]))
    others = [key for key in table.dims if key != along]
    lines = table.stack(line=others).transpose("line", along) if others else table.expand_dims("line")
    unit = table[along].attrs["units"]
    shown = "rpm" if unit == "rad/s" else unit
    positions = in_unit(table[along].values, shown) if shown != unit else table[along].values
    with matplotlib.rc_context(fname=STYLE):
        figure = Figure(figsize=(WIDTH, 0.75 + 1.25 * len(drawn)), layout="constrained")
        panels = np.atleast_1d(figure.subplots(len(drawn), 1, sharex=True))
        for axes, reading in zip(panels, drawn, strict=True):
            for k in range(lines.sizes["line"]):
                one = lines.isel(line=k)
                doubt = np.nan_to_num(one[f"{reading.name}_half_width"].values)
                label = ", ".join(f"{key} = {_text(one[key].item())}" for key in others)
                axes.errorbar(
                    positions,
                    one[reading.name].values,
                    doubt,
                    marker=MARKS[k % len(MARKS)],
                    ms=3,
                    label=label,
                )
            by = "" if reading.by == "mean" else f", {reading.by}"
            axes.set_ylabel(f"{reading.field.label}{by}\n({reading.field.unit})")
            axes.margins(x=0.04)  # marks on the edge must be whole
            axes.yaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 2.5, 5, 10]))
        panels[-1].set_xlabel(along + (f" ({shown})" if shown != "1" else ""))
        if others:
            figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=1)
        figure.align_ylabels()
    return figure


def _text(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
