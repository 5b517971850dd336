"""One HTML page for one run or several: case, steady values, where the power goes, figures, the moving
charge, provenance, citation.

Or for the folder of a sweep or of a comparison with a paper: its tables, pictures and runs.

The page is `data/pages/report.html`; here it is filled.  It holds everything it shows and prints well.
"""

import base64
import tempfile
from collections.abc import Sequence
from importlib import resources
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

from nutamill import __version__
from nutamill.analysis.power import power_split
from nutamill.analysis.source import any_case_of
from nutamill.analysis.steady_table import label_of, mean_text, shown_mean, steady
from nutamill.analysis.summary import warning_lines
from nutamill.analysis.windows import turn_series
from nutamill.base.atomic_file import PAGES, check_writable, write_whole
from nutamill.base.citation import PAPERS, SOFTWARE
from nutamill.base.errors import CaseError, Fault, NotInstalledError, ResultError
from nutamill.base.files import is_folder
from nutamill.base.steady import Estimate
from nutamill.base.units import rpm
from nutamill.case.differences import swept_axis
from nutamill.result import Result, open_result
from nutamill.view.figures.motion import draw_steady_values
from nutamill.view.figures.named import FIGURES, caption_of, figure_of
from nutamill.view.figures.saving import png_of
from nutamill.view.report_folder import fact, read_campaign
from nutamill.view.scene import draw_scene
from nutamill.view.webview import view_page

PICTURE = (800, 600)
"""Pixels of the picture of the machine, across and down."""
FRAMES = 60
"""Moments of each run shown in motion: about a megabyte each for pellets."""


class Sink(NamedTuple):
    """One line of the ledger."""

    name: str
    """Where the power goes."""
    power: str
    """[W]."""
    share: str
    """Share of the motor's power [%]."""


class Drawn(NamedTuple):
    """A figure within the page."""

    caption: str
    """What it shows."""
    image: str
    """``data:`` address of the picture."""


class RunPage(NamedTuple):
    """Content of the page for one run."""

    name: str
    """Stem of the file."""
    title: str
    """Title of the case."""
    state: str
    """State of the run."""
    speed: str
    """Last speed [rpm]; empty where nothing turns."""
    verdict: str
    """Whether the run is steady, or why there is no test of that."""
    heading: str
    """What the means are: steady, not steady, or plain means."""
    steady: dict[str, Estimate]
    """Means by label and unit; none without a whole turn at constant speed."""
    ledger: list[Sink]
    """Where the power goes."""
    machine: str
    """Picture of the machine and its charge in three dimensions; empty without snapshots, PyVista or
    OpenGL.
    """
    figures: list[Drawn]
    """Pictures that could be drawn."""
    warnings: list[str]
    """What is odd."""
    view: str
    """A page in which the mill turns; empty without snapshots."""
    provenance: list[tuple[str, str]]
    """What made the numbers."""
    case: str
    """The case file."""


def write_report(paths: Sequence[str | Path], to: str | Path) -> Path:
    """Write the page of these results, or of the folder of a sweep or of a comparison, and return its path.

    Raises
    ------
    CaseError : no results, or a folder together with something else
    ResultError : a file that is no result, or a page that cannot be written
    """
    if not paths:
        raise CaseError(
            Fault("report", "at least one result must be given, got none", "nutamill report RESULT.h5")
        )
    check_writable(Path(to), PAGES)
    return write_whole(to, report_page(paths))


def report_page(paths: Sequence[str | Path]) -> str:
    """Return the page as text."""
    if is_folder(paths[0]):
        if len(paths) > 1:
            what = f"one folder, or results only, can be reported at a time, got {len(paths)} of both"
            raise CaseError(Fault("report", what, "Report them one after another"))
        campaign = read_campaign(Path(paths[0]))
        count = len(campaign.runs)
        about = (
            f"{count} result file{'' if count == 1 else 's'} in this folder"
            if count
            else "tables and pictures of this folder"
        )
        names = {table.name for table in campaign.tables}
        pictures = [file for file in campaign.pictures if file.stem not in names]
        curves = {file.stem: _address(file.read_bytes()) for file in campaign.pictures if file.stem in names}
        return _filled(
            title=campaign.name,
            about=about,
            campaign=campaign,
            curves=curves,
            pictures=[Drawn(file.stem, _address(file.read_bytes())) for file in pictures],
            runs=[],
        )
    runs, cases = [], []
    for path in paths:
        with open_result(path) as result:
            runs.append(_run_page(result))
            cases.append(any_case_of(result))
    known = [run for run in runs if run.steady]
    alike = len({tuple(run.steady) for run in known}) == 1 and all(run.speed for run in known)
    overview, axis = "", None
    if len(known) > 1 and alike:
        axis = swept_axis([case for case, run in zip(cases, runs, strict=True) if run.steady])
        positions = axis.values if axis else [float(run.speed) for run in known]
        label = axis.label if axis else "speed (rpm)"
        values = list(zip(positions, (run.steady for run in known), strict=True))
        overview = _image(draw_steady_values(values, label, joined=axis is not None))
    return _filled(
        title=runs[0].title or runs[0].name if len(runs) == 1 else f"{len(runs)} runs",
        about=f"{len(runs)} run{'' if len(runs) == 1 else 's'}",
        runs=runs,
        headings=list(known[0].steady) if known else [],
        overview=overview,
        over=axis.label if axis else "speed; runs that differ in more than one number are not joined",
    )


def _filled(**fields: object) -> str:
    """Fill these fields into `data/pages/report.html`."""
    from jinja2 import Environment  # a tenth of a second

    text = (resources.files("nutamill") / "data" / "pages" / "report.html").read_text(encoding="utf-8")
    template = Environment(autoescape=True, trim_blocks=True).from_string(text)
    return template.render(
        mean_text=mean_text,
        version=__version__,
        citation=SOFTWARE,
        sources=[paper.text for paper in PAPERS],
        **fields,
    )


def _run_page(result: Result) -> RunPage:
    """Return the content of the page for one result, without the figures and means it has no data for."""
    if not result.case_text:
        what = "holds measured data, not the result of a run"
        raise CaseError(Fault(str(result.path), what, "Lay it over a run with nutamill compare"))
    case = any_case_of(result)
    figures = []
    for name in FIGURES:
        try:
            figure = figure_of(result, name)
            figures.append(Drawn(caption_of(name, figure), _image(figure)))
        except ResultError:
            continue  # no statistics, no charge, no crank, or no steady window: the page shows what there is
    try:
        view = view_page(result, FRAMES)
    except ResultError:
        view = ""
    table = steady(result)
    return RunPage(
        result.path.stem,
        case.title,
        result.state,
        _last_speed(result),
        table.verdict,
        table.heading,
        {label_of(reading): shown_mean(reading, mean) for reading, mean in table.means.items()},
        _ledger(result),
        _machine_picture(result),
        figures,
        warning_lines(result),
        view,
        [(key, fact(value)) for key, value in result.provenance.items()],
        result.case_text,
    )


def _machine_picture(result: Result) -> str:
    """Return the machine and its charge at the last snapshot, or "" where they cannot be drawn."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            return _address(draw_scene(result, Path(folder) / "machine.png", size=PICTURE).read_bytes())
        except (NotInstalledError, ResultError):
            return ""


def _last_speed(result: Result) -> str:
    """Return the last speed of the drive of the period [rpm], empty where nothing turns."""
    turning = turn_series(result)
    if turning is None or len(result.series[turning]) < 2:
        return ""
    angle, time = result.series[turning].values[-2:], result.series["time"].values[-2:]
    if "driveshaft_speed" in result.series:
        return f"{rpm(float(result.series['driveshaft_speed'].values[-1])):.4g}"
    return f"{rpm(float(np.diff(angle)[0] / np.diff(time)[0])):.4g}"


def _ledger(result: Result) -> list[Sink]:
    """Return where the power goes, largest first, and what is not accounted for."""
    try:
        split = power_split(result)
    except ResultError:
        return []
    rows = [
        *sorted(split.sinks.items(), key=lambda sink: -abs(sink[1])),
        ("not accounted for", split.residual),
        ("put in" if "motor_work" not in result.series else "motor", split.motor),
    ]
    return [
        Sink(name, f"{power:.4g}", _two_decimals(100.0 * power / split.motor) if split.motor else "-")
        for name, power in rows
    ]


def _two_decimals(number: float) -> str:
    """Return a number to two decimals, zero without a sign."""
    return f"{round(number, 2) + 0.0:.2f}"


def _image(figure: Figure) -> str:
    """Return a figure as an address that holds the picture itself."""
    return _address(png_of(figure, 200.0))


def _address(picture: bytes) -> str:
    return "data:image/png;base64," + base64.b64encode(picture).decode("ascii")
