"""A figure by its name, for a script or a notebook."""

import functools

from matplotlib.figure import Figure

from nutamill.result import Result
from nutamill.view.figures.named import figure_of
from nutamill.view.figures.saving import png_of

SCREEN = 160.0
"""Resolution of a figure in a notebook [dots/inch]."""


def plot(result: Result, what: str = "run") -> Figure:
    """Draw a figure of a result. A notebook shows it, ``figure.savefig("power.png")`` writes it.

    Parameters
    ----------
    result : an opened result
    what : ``run``, ``power``, ``impacts``, ``wall``, ``flow`` or ``orbit``; or ``history``, ``spectrum`` or
        ``orders`` with series, ``"history:driveshaft_torque,driveshaft_power"``

    Raises
    ------
    CaseError : no figure or series of this name
    ResultError : the result does not hold what the figure needs
    """
    figure = figure_of(result, what)
    # a notebook asks for this name; without it a figure that pyplot did not make is shown as text
    setattr(figure, "_repr_png_", functools.partial(png_of, figure, SCREEN))  # noqa: B010
    return figure
