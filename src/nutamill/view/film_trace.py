"""The force over time below a film, with a mark at the present moment."""

import matplotlib
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from nutamill.analysis.traces import thinned, traced
from nutamill.base.errors import ResultError
from nutamill.result import Result
from nutamill.view.figures.style import MEAN, RMS, STYLE, label_of
from nutamill.view.looks import Look

SHARE = 0.24
"""Share of the height of a film that the trace takes [1]."""
POINTS = 500.0
"""Points of type across a film, whatever its size in pixels [pt]."""
MARK = 0.006
"""Radius of the mark over the width of the film [1]."""


class FilmTrace:
    """A strip below the pictures of a film: drawn once, and marked anew for each picture.

    Parameters
    ----------
    result : the run
    times : simulated times of the pictures [s]
    look : background of the film
    size : width and height of the film [px]

    Raises
    ------
    ResultError : no series to draw
    """

    def __init__(self, result: Result, times: np.ndarray, look: Look, size: tuple[int, int]):
        names = traced(result)
        if not names:
            raise ResultError(f"{result.path}: holds no force and no torque to draw below a film.")
        self.height = 2 * round(0.5 * SHARE * size[1])
        """Height of the strip [px]."""
        time, values = result.series["time"].values, result.series[names[0]].values
        dots = 72.0 * size[0] / POINTS
        with matplotlib.rc_context(fname=STYLE):
            ink = {"axes.edgecolor": look.ink, "axes.labelcolor": look.ink}
            matplotlib.rcParams.update({**ink, "xtick.color": look.ink, "ytick.color": look.ink})
            figure = Figure(figsize=(size[0] / dots, self.height / dots), dpi=dots, layout="constrained")
            figure.set_facecolor(look.background)
            canvas, axes = FigureCanvasAgg(figure), figure.subplots()
            axes.set_facecolor(look.background)
            inside = (time >= times[0]) & (time <= times[-1])
            drawn = thinned(int(inside.sum()), [values[inside]])
            axes.plot(time[inside][drawn], values[inside][drawn], color=MEAN, linewidth=1.0)
            axes.set_xlim(times[0], times[-1])
            axes.set_xlabel("time (s)")
            words, _, unit = label_of(result.field(names[0])).rpartition(" (")
            axes.set_ylabel(f"{words}\n({unit}")
            axes.yaxis.set_major_locator(MaxNLocator(3))
            axes.grid(alpha=0.3)
            canvas.draw()
            self._strip = np.asarray(canvas.buffer_rgba())[..., :3].copy()
            where = axes.transData.transform(np.column_stack([times, np.interp(times, time, values)]))
            box = axes.get_window_extent()
        self._times, self._across = times, where[:, 0]
        self._down = self._strip.shape[0] - where[:, 1]
        self._top, self._bottom = (int(self._strip.shape[0] - y) for y in (box.y1, box.y0))
        self._radius = MARK * size[0]
        self._ink, self._dot = (np.round(255 * np.array(to_rgb(c))).astype(np.uint8) for c in (look.ink, RMS))

    def at(self, time: float) -> np.ndarray:
        """Return the strip with its mark at a time [s], (height, width, 3)."""
        marked = self._strip.copy()
        x, y = (float(np.interp(time, self._times, place)) for place in (self._across, self._down))
        column = round(min(max(x, 0.0), marked.shape[1] - 1.0))
        marked[self._top : self._bottom, column] = self._ink
        rows, columns = np.ogrid[: marked.shape[0], : marked.shape[1]]
        marked[(rows - y) ** 2 + (columns - x) ** 2 <= self._radius**2] = self._dot
        return marked
