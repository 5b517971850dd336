"""The line above a figure that names the run it is drawn from."""

import textwrap

from matplotlib.figure import Figure

from nutamill.analysis.source import any_case_of
from nutamill.result import Result
from nutamill.view.figures.style import MARK

CHARACTERS = 21
"""Characters of the line for each inch of a figure [1/inch]."""


def named_after(figure: Figure, result: Result) -> Figure:
    """Return the figure with the title of its run above it: case, what was changed, demonstration or not."""
    title = any_case_of(result).title if result.case_text else ""
    text = textwrap.fill(title or result.path.stem, max(20, int(CHARACTERS * figure.get_figwidth())))
    figure.suptitle(text, fontsize=5.5, color=MARK, x=0.01, ha="left")
    return figure
