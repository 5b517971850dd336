"""Figure of what runs do to an ore: sizes over energy, rates over size, sizes of the product."""

from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from nutamill.analysis.breakage.answer import Breakage
from nutamill.base.units import in_unit
from nutamill.view.figures.style import PALETTE, STYLE, WIDTH


def draw_breakage(answers: list[Breakage]) -> Figure:
    """Draw P80 over the specific energy, the rate of breakage over the size, and the sizes of feed and
    product, of one or more runs with one ore. Bands are 95 % intervals by the scatter of the impacts.
    """
    per = in_unit(1.0, "kWh/t")
    with matplotlib.rc_context(fname=STYLE):
        figure = Figure(figsize=(WIDTH, 6.4), layout="constrained")
        size, rate, product = figure.subplots(3, 1)
        for k, one in enumerate(answers):
            colour, name = PALETTE[k % len(PALETTE)], Path(one.grinding.path).stem
            energy, p80, half = (
                in_unit(one.energies, "kWh/t"),
                in_unit(one.p80, "mm"),
                in_unit(one.p80_half_width, "mm"),
            )
            size.plot(energy, p80, color=colour, label=name)
            size.fill_between(energy, np.maximum(p80 - half, 0.0), p80 + half, color=colour, alpha=0.2)
            across, often = in_unit(one.sizes, "mm"), one.selection / per
            doubt = one.selection_half_width / per
            rate.plot(across, often, color=colour)
            rate.fill_between(across, np.maximum(often - doubt, 1e-9), often + doubt, color=colour, alpha=0.2)
            product.plot(in_unit(one.edges, "mm"), 100.0 * one.passing, color=colour)
        first = answers[0]
        feed = np.minimum((first.edges / first.ore.top_size) ** first.ore.feed_exponent, 1.0)
        product.plot(in_unit(first.edges, "mm"), 100.0 * feed, color="#888888", ls="--", label="feed")
        size.axhline(in_unit(first.ore.product, "mm"), color="#888888", lw=0.6)
        for axes in (size, rate, product):
            axes.set_xscale("log")
            axes.xaxis.set_minor_formatter(NullFormatter())
        size.set_yscale("log")
        rate.set_yscale("log")
        product.set_ylim(0.0, 100.0)
        size.set(xlabel="specific energy (kWh/t)", ylabel="P80 (mm)")
        rate.set(xlabel="size (mm)", ylabel="breakage rate (t/kWh)")
        product.set(
            xlabel=f"size (mm), after {in_unit(first.energies[-1], 'kWh/t'):.3g} kWh/t",
            ylabel="finer (% of mass)",
        )
        size.set_title("(a) fineness over energy", loc="left")
        rate.set_title("(b) breakage of unharmed particles", loc="left")
        product.set_title("(c) feed (dashed) and product", loc="left")
        figure.legend(*size.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure
