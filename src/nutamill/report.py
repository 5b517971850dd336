"""One HTML page for one run or several: case, steady values, where the power goes, figures, the moving charge, provenance, citation.

Or for the folder of a sweep or of a comparison with a paper: its tables, pictures and runs.

The page is `pages/report.html`; here it is filled.  It holds everything it shows and prints well.
"""

import base64
import io
import math
from collections.abc import Sequence
from importlib import resources
from pathlib import Path
from typing import NamedTuple

from matplotlib.figure import Figure

from nutamill import __version__
from nutamill.analysis import power_split, steady_window, warning_lines
from nutamill.campaign_report import CampaignFolder, read_campaign
from nutamill.case import Case
from nutamill.errors import CaseError, Fault, ResultError
from nutamill.fields import series_field
from nutamill.figures.motion import draw_steady_values
from nutamill.figures.named import FIGURES, figure_of
from nutamill.mechanism_analysis import is_mechanism
from nutamill.result import Result, open_result
from nutamill.units import rpm
from nutamill.webview import view_page
from nutamill.wholefile import PAGES, check_writable, write_whole

READINGS = ("crank_pin_force_resultant", "driveshaft_torque", "driveshaft_power", "charge_phase_lag")
"""Series whose steady means are tabulated, where a result holds them."""
FRAMES = 60
"""Moments of each run shown in motion: about a megabyte each for pellets."""
CITATION = f"nutamill {__version__}: coupled multibody and particle dynamics of nutating mills. Open-source software, MIT licence."
SOURCES = (
    "H. C. Janse van Vuuren, J. R. Bredell, C. J. Coetzee, Coupled multi-body and particle dynamics simulation of a nutating mill,"
    " Math. Comput. Appl. 31(5), 171, 2026.",
    "J. J. van Tonder, J. R. Bredell, C. Coetzee, J. Branehog, Simulation of kinetic joint forces in a nutating grinding mill,"
    " J. S. Afr. Inst. Min. Metall. 125, 99-106, 2025.",
)


class SteadyLine(NamedTuple):
    """One steady mean as it is printed."""

    label: str
    """What and in which unit."""
    text: str
    """Mean and interval."""
    mean: float
    """Mean, unit of the label."""
    half_width: float
    """Half width of its 95 % interval."""


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
    """What the page says of one run."""

    name: str
    """Stem of the file."""
    title: str
    """Title of the case."""
    state: str
    """State of the run."""
    speed: str
    """Last speed [rpm]."""
    steady: list[SteadyLine]
    """Steady means; none if there is no steady window."""
    ledger: list[Sink]
    """Where the power goes."""
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
    """Write the page of these results, or of the folder of a sweep or of a comparison; returns its path.

    Raises
    ------
    CaseError : no results, or a folder together with something else
    ResultError : a file that is no result, or a page that cannot be written
    """
    if not paths:
        raise CaseError(Fault("report", "at least one result must be given, got none", "nutamill report RESULT.h5"))
    check_writable(Path(to), PAGES)
    return write_whole(to, report_page(paths))


def report_page(paths: Sequence[str | Path]) -> str:
    """The page as text."""
    if Path(paths[0]).is_dir():
        if len(paths) > 1:
            what = f"one folder, or results only, can be reported at a time, got {len(paths)} of both"
            raise CaseError(Fault("report", what, "Report them one after another"))
        campaign = read_campaign(Path(paths[0]))
        count = len(campaign.runs)
        about = f"{count} result file{'' if count == 1 else 's'} in this folder" if count else "tables and pictures of this folder"
        return _filled(title=campaign.name, about=about, campaign=campaign, pictures=_drawn(campaign), runs=[])
    runs = []
    for path in paths:
        with open_result(path) as result:
            runs.append(_run_page(result))
    known = [run for run in runs if run.steady]
    overview = ""
    if len(known) > 1:
        overview = _image(draw_steady_values([(float(run.speed), run.steady) for run in known]))
    return _filled(
        title=runs[0].title or runs[0].name if len(runs) == 1 else f"{len(runs)} runs",
        about=f"{len(runs)} run{'' if len(runs) == 1 else 's'}",
        runs=runs,
        headings=[value.label for value in known[0].steady] if known else [],
        overview=overview,
    )


def _filled(**fields: object) -> str:
    """`pages/report.html` with these fields."""
    from jinja2 import Environment  # a tenth of a second

    text = (resources.files("nutamill") / "pages" / "report.html").read_text(encoding="utf-8")
    template = Environment(autoescape=True, trim_blocks=True).from_string(text)
    return template.render(version=__version__, citation=CITATION, sources=SOURCES, **fields)


def _drawn(campaign: CampaignFolder) -> list[Drawn]:
    """The pictures of a folder."""
    return [Drawn(file.stem, _address(file.read_bytes())) for file in campaign.pictures]


def _run_page(result: Result) -> RunPage:
    """What the page says of one result; figures and means that it cannot give are left out."""
    if not result.case_text:
        what = "must be the result of a run, it is measured data"
        raise CaseError(Fault(str(result.path), what, "Lay it over a run with nutamill compare"))
    if is_mechanism(result):
        raise CaseError(Fault(str(result.path), "must be the run of a mill, it is that of a mechanism", "nutamill show prints its loads"))
    case = Case.from_toml(result.case_text)
    figures = []
    for name, (_, caption) in FIGURES.items():
        try:
            figures.append(Drawn(caption, _image(figure_of(result, name))))
        except ResultError:
            continue  # no statistics, no charge, or no steady window: the page shows what there is
    try:
        view = view_page(result, FRAMES)
    except ResultError:
        view = ""
    last = rpm(float(result.series["driveshaft_speed"].values[-1])) if result.series.sizes["time"] else math.nan
    return RunPage(
        result.path.stem,
        case.title,
        result.state,
        f"{last:.4g}",
        _steady(result),
        _ledger(result),
        figures,
        warning_lines(result),
        view,
        [(key, str(value)) for key, value in result.provenance.items()],
        result.case_text,
    )


def _steady(result: Result) -> list[SteadyLine]:
    """Steady means of `READINGS`."""
    names = [name for name in READINGS if name in result.series]
    try:
        found = steady_window(result, names=names).values
    except ResultError:
        return []
    values = []
    for name, estimate in found.items():
        field = series_field(name)
        text = f"{estimate.mean:.4g}" + (f" ± {_short(estimate.half_width)}" if math.isfinite(estimate.half_width) else "")
        values.append(SteadyLine(f"{field.label} ({field.unit})", text, estimate.mean, estimate.half_width))
    return values


def _short(width: float) -> str:
    """Half width of an interval to two digits, never as a power of ten."""
    return f"{width:.0f}" if width >= 10.0 else f"{width:.2g}"


def _ledger(result: Result) -> list[Sink]:
    """Where the power goes, largest first, and what is not accounted for."""
    try:
        split = power_split(result)
    except ResultError:
        return []
    rows = [*sorted(split.sinks.items(), key=lambda sink: -abs(sink[1])), ("not accounted for", split.residual), ("motor", split.motor)]
    return [Sink(name, f"{power:.4g}", f"{100.0 * power / split.motor:.2f}" if split.motor else "-") for name, power in rows]


def _image(figure: Figure) -> str:
    """A figure as an address that holds the picture itself."""
    held = io.BytesIO()
    figure.savefig(held, format="png", dpi=200)
    return _address(held.getvalue())


def _address(picture: bytes) -> str:
    return "data:image/png;base64," + base64.b64encode(picture).decode("ascii")
