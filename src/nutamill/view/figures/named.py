"""Which figures there are, by the names under which `nutamill plot` draws them."""

from collections.abc import Callable
from pathlib import Path

from matplotlib.figure import Figure

from nutamill.analysis.orders import sensor_orders, waterfall
from nutamill.base.errors import CaseError, Fault, ResultError
from nutamill.result import Result
from nutamill.view.figures.charge import draw_flow, draw_spectra, draw_wall
from nutamill.view.figures.motion import draw_histories, draw_orbit, draw_spectrum
from nutamill.view.figures.naming import named_after
from nutamill.view.figures.reading import draw_orders
from nutamill.view.figures.run import draw_ledger, draw_run
from nutamill.view.figures.saving import save_figure

FIGURES: dict[str, tuple[Callable[[Result], Figure], str]] = {
    "run": (draw_run, "{panels} over the run"),
    "power": (draw_ledger, "where the power goes, turn by turn"),
    "impacts": (draw_spectra, "how many impacts with how much energy"),
    "wall": (draw_wall, "pressure, shear power and cutting power on the unrolled bore"),
    "flow": (draw_flow, "solids fraction and velocity of the charge in axes that turn with the crank"),
    "orbit": (draw_orbit, "path of the charge's mass centre and its phase lag"),
}
"""Figures of a whole result: the function, and what it shows; ``{panels}`` are the titles of the panels that
were drawn.
"""
SERIES_FIGURES: dict[str, tuple[Callable[[Result, list[str]], Figure], str]] = {
    "history": (draw_histories, "series over time"),
    "spectrum": (draw_spectrum, "power spectral density of series in the steady window"),
    "orders": (
        lambda result, names: draw_orders(
            sensor_orders(result, names[0]), waterfall(result, names[0]), result.field(names[0])
        ),
        "amplitude of a series once and twice per turn, and over time and frequency",
    ),
}
"""Figures of series: written ``history:driveshaft_torque,crank_pin_force_radial``."""


def figure_of(result: Result, what: str) -> Figure:
    """Draw the figure called `what`: a name of `FIGURES`, or one of `SERIES_FIGURES` with its series,
    ``spectrum:driveshaft_torque``.

    Raises
    ------
    CaseError : no figure or series of this name
    ResultError : the result does not hold what the figure needs
    """
    samples = len(result.series["time"])
    if samples < 2:
        held = "one sample" if samples else "no sample"
        raise ResultError(f"{result.path}: holds {held} to draw, a curve needs two. Run the case again")
    kind, _, names = what.partition(":")
    if not names and kind in FIGURES:
        return named_after(FIGURES[kind][0](result), result)
    if names and kind in SERIES_FIGURES:
        return named_after(SERIES_FIGURES[kind][0](result, names.split(",")), result)
    known = ", ".join([*FIGURES, *(f"{name}:SERIES" for name in SERIES_FIGURES)])
    raise CaseError(
        Fault(f'figure "{what}"', f"must be one of {known}", "`nutamill info fields` lists the series")
    )


def caption_of(what: str, figure: Figure) -> str:
    """Return what a figure of `FIGURES` shows, naming the panels that it has."""
    titles = [axes.get_title(loc="left").partition(") ")[2] for axes in figure.axes]
    return FIGURES[what][1].format(panels=", ".join(filter(None, titles)))


def write_figures(result: Result, wanted: list[str], folder: Path) -> list[Path]:
    """Draw figures to ``<result>-<name>.png`` in `folder`, and return the files. All names are checked by
    drawing before one is written.
    """
    drawn = {what: figure_of(result, what) for what in dict.fromkeys(wanted)}
    files = []
    for what, figure in drawn.items():
        file = folder / f"{result.path.stem}-{what.replace(':', '-').replace(',', '-')}.png"
        files.append(save_figure(figure, file))
    return files
