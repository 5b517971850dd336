"""A sweep, a fit, an identification and a comparison with a paper in a notebook."""

from typing import TYPE_CHECKING

import numpy as np

from nutamill.analysis.steady_table import label_of, mean_text, shown_mean
from nutamill.base.steady import NO_ESTIMATE
from nutamill.notebook.html import escaped, heading, picture, table, warnings_html
from nutamill.result import is_finished
from nutamill.studies.figures import draw_sweep
from nutamill.studies.identify.figures import draw_corner, draw_rows
from nutamill.studies.papers.cells import HEADINGS, cells
from nutamill.studies.papers.table import tally, trouble_lines

if TYPE_CHECKING:
    from nutamill.studies.fit import Fit
    from nutamill.studies.identify.identification import Identification
    from nutamill.studies.sweep import Campaign
    from nutamill.studies.validate import Comparison


def campaign_html(campaign: "Campaign") -> str:
    """Return the table of a sweep, a row for each run, and its curves. Readings without a value are left
    out.
    """
    outcomes = campaign.outcomes
    readings = list(dict.fromkeys(reading for outcome in outcomes for reading in outcome.values))
    known = [
        reading
        for reading in readings
        if any(np.isfinite(outcome.values.get(reading, NO_ESTIMATE).mean) for outcome in outcomes)
    ]
    rows = [
        (
            *outcome.member.values.values(),
            *(
                mean_text(shown_mean(reading, outcome.values.get(reading, NO_ESTIMATE))).replace("nan", "–")
                for reading in known
            ),
            outcome.state,
        )
        for outcome in outcomes
    ]
    ended = sum(is_finished(outcome.state) for outcome in outcomes)
    head = (*outcomes[0].member.values, *map(label_of, known), "state")
    figure = draw_sweep(campaign.table, known)
    return (
        heading(
            f"sweep in {campaign.folder}", f"{ended} of {len(outcomes)} runs ended", ended == len(outcomes)
        )
        + table(rows, head)
        + ("" if figure is None else picture(figure))
    )


def fit_html(fit: "Fit") -> str:
    """Return values, uncertainties and residuals of a fit."""
    verdict = "converged" if fit.best.converged else "not converged"
    text = "\n".join(fit.lines())
    return heading("fit", verdict, fit.best.converged) + f"<pre>{escaped(text)}</pre>"


def identification_html(done: "Identification") -> str:
    """Return unknowns, rows and indices of an identification, and its two figures."""
    count = sum(row.learned for row in done.problem.rows)
    text = "\n".join(done.lines())
    return (
        heading("identification", f"learned from {count} rows", done.posterior.converged)
        + f"<pre>{escaped(text)}</pre>"
        + picture(draw_corner(done))
        + picture(draw_rows(done))
    )


def comparison_html(done: "Comparison") -> str:
    """Return the rows of a paper beside our numbers."""
    rows = [cells(finding, done.paper) for finding in done.findings]
    lacking = [*trouble_lines(done.findings), *done.failures, *done.undrawn]
    return (
        heading(done.paper.short, tally(done.findings, done.paper), not done.failures)
        + table(rows, HEADINGS)
        + warnings_html(lacking)
    )
