"""A run and a test in one figure."""

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from nutamill.analysis.measured_comparison import series_in_window
from nutamill.analysis.spectra import spectrum
from nutamill.result import Result
from nutamill.view.figures.motion import HIGHEST, density_unit
from nutamill.view.figures.style import STYLE, label_of

SHOWN_TURNS = 0.5
"""Time shown of the histories [s]: so that single turns can be seen."""


def draw_comparison(
    run: Result, test: Result, names: list[str], last: float, cut: float | None = None
) -> Figure:
    """Draw each quantity of a run and of a test over the last whole turns, and its spectrum, filtered alike.
    Raises as `compare`.

    Times are counted back from the ends, which are whole turns: where the crank stood then is not known of a
    test.
    """
    with matplotlib.rc_context(fname=STYLE):
        figure = Figure(figsize=(7.0, 0.6 + 1.5 * len(names)), layout="constrained")
        panels = np.atleast_2d(figure.subplots(len(names), 2, sharex="col"))
        for (left, right), name in zip(panels, names, strict=True):
            for result, colour, label in ((run, "#0072B2", "run"), (test, "#D55E00", "measured")):
                time, values = series_in_window(result, name, last, cut)
                shown = time >= time[-1] - SHOWN_TURNS
                left.plot(time[shown] - time[-1], values[shown], color=colour, label=label, linewidth=0.8)
                if len(values) >= 32:
                    lines = spectrum(values, result.rate)
                    drawn = (lines.frequency > 0.0) & (lines.frequency <= HIGHEST) & (lines.density > 0.0)
                    right.semilogy(lines.frequency[drawn], lines.density[drawn], color=colour, linewidth=0.8)
            left.set_ylabel(label_of(run.field(name)))
            left.margins(x=0.0)
            right.set_ylabel(density_unit(run.field(name)))
        panels[-1, 0].set_xlabel("time before the end (s)")
        panels[-1, 1].set_xlabel("frequency (Hz)")
        panels[-1, 1].set_xlim(left=0.0)
        figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
        figure.align_ylabels()
    return figure
