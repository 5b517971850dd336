"""A result and its steady means in a notebook."""

from nutamill.analysis.source import any_case_of
from nutamill.analysis.steady_table import SteadyTable, steady
from nutamill.analysis.summary import warning_lines
from nutamill.notebook.html import folded, heading, picture, table, warnings_html
from nutamill.result import Result
from nutamill.view.figures.run import draw_run

COMPLETE = "complete"
"""State of a run that has reached its end."""
FACTS = ("package_version", "seed", "threads", "processor", "wall_time")
"""Provenance that a summary shows."""


def result_html(result: Result) -> str:
    """Return title, verdict, steady means, warnings and a picture of a result."""
    if not result.case_text:
        return heading(result.path.stem, "measured data, without a run", True) + table(
            [(name, result.series.sizes["time"]) for name in result.series.data_vars], ("series", "samples")
        )
    case = any_case_of(result)
    empty = not result.series.sizes["time"]
    means = None if empty else steady(result)
    good = result.state == COMPLETE and means is not None and means.steady
    verdict = result.state if means is None else f"{result.state}; {means.verdict}"
    parts = [heading(case.title or case.name, verdict, good)]
    if not empty:
        parts.append(warnings_html(warning_lines(result)))
    if means is not None and means.means:
        parts.append(table(means.rows(), ("", means.heading)))
    if not empty:
        parts.append(picture(draw_run(result)))
    known = result.provenance
    facts = [("file", result.path), *((key, known[key]) for key in FACTS if key in known)]
    return "".join([*parts, folded("file and provenance", table(facts))])


def steady_html(means: SteadyTable) -> str:
    """Return verdict and means of a run."""
    return heading(means.run, means.verdict, means.steady) + table(means.rows(), ("", means.heading))
