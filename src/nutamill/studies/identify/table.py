"""An identification as Markdown and as JSON."""

import csv
import io
import json
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from nutamill import __version__
from nutamill.studies.identify.members import Ran
from nutamill.studies.identify.problem import Problem

if TYPE_CHECKING:
    from nutamill.studies.identify.identification import Identification

IMPOSSIBLE = 3.0
"""Implausibility from which no value in the ranges reaches a row [1]."""
SLIGHT = 0.005
"""Indices below which a cell is left empty [1]."""


def lines(done: "Identification") -> list[str]:
    """Format unknowns, rows, indices and what is wrong with them as Markdown."""
    names = [one.name for one in done.problem.unknowns]
    labels = [row.label for row in done.problem.rows]
    shares = "share of the variance over the ranges that an unknown has a part in (total effect)"
    settles = "share of the posterior variance of an unknown that one more measurement would take away"
    return [
        "## Unknowns",
        "",
        *_markdown(("unknown", "range", "mode", "median", "90 % interval"), _unknown_cells(done)),
        "",
        "## Rows",
        "",
        *_markdown(
            ("row", "measured", "over the ranges, 90 %", "posterior, 90 %", "", "emulator's error"),
            _row_cells(done),
        ),
        "",
        f"## Which unknown moves which row: {shares}",
        "",
        *_markdown(("row", *names), _index_cells(labels, done.effects)),
        "",
        f"## What to measure: {settles}",
        "",
        *_markdown(("row", *names), _index_cells(labels, done.settles)),
        "",
        *_remarks(done),
    ]


def members_csv(problem: Problem, ran: Ran) -> str:
    """Format the members of a stage as CSV: values of the unknowns that change its rows, then of its rows
    without gains, in SI.
    """
    rows = [problem.rows[number] for number in ran.values]
    acting = sorted({int(k) for row in rows for k in (*problem.columns(row), *problem.gains(row))})
    heads = [f"{problem.unknowns[k].name} ({problem.unknowns[k].unit})" for k in acting]
    heads += [f"{row.label} ({row.measurand.unit})" for row in rows]
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(heads)
    values = problem.values(ran.points)[:, acting]
    for number, unknowns in enumerate(values):
        table.writerow(f"{value:.7g}" for value in (*unknowns, *(one[number] for one in ran.values.values())))
    return text.getvalue()


def _markdown(heads: Sequence[str], cells: Sequence[Sequence[str]]) -> list[str]:
    """Format a table in Markdown with columns of even width."""
    table = [list(heads), *map(list, cells)]
    widths = [max(3, *(len(row[k]) for row in table)) for k in range(len(heads))]
    text = [
        "| " + " | ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) + " |"
        for row in table
    ]
    return [text[0], "|" + "|".join("-" * (width + 2) for width in widths) + "|", *text[1:]]


def _unknown_cells(done: "Identification") -> list[list[str]]:
    mode = done.problem.values(done.posterior.mode)
    return [
        [
            one.name,
            _interval(one.low, one.high, one.unit),
            _number(best, one.unit),
            _number(middle, one.unit),
            _interval(low, high, one.unit),
        ]
        for one, best, (low, middle, high) in zip(done.problem.unknowns, mode, done.unknowns, strict=True)
    ]


def _row_cells(done: "Identification") -> list[list[str]]:
    cells = []
    for number, row in enumerate(done.problem.rows):
        unit = row.measurand.unit
        measured = f"{row.value:.4g} ± {row.scatter:.2g} {_unit(unit)}".strip()
        words = ["learned" if row.learned else "predicted"]
        if (inside := done.inside[number]) is not None:
            words.append("inside" if inside else "outside")
        low, _, high = done.prior_rows[number]
        left, _, right = done.posterior_rows[number]
        cells.append(
            [
                row.label,
                "–" if np.isnan(row.value) else measured,
                "–" if done.problem.drawn(row) else _interval(low, high, unit),
                _interval(left, right, unit),
                ", ".join(words),
                _error(done, number),
            ]
        )
    return cells


def _error(done: "Identification", number: int) -> str:
    """Return the error of a row's emulator, or the number of draws it is predicted from."""
    row, check = done.problem.rows[number], done.emulators[number].check
    if done.problem.drawn(row):
        return f"{check.members} draws"
    return _number(check.error, row.measurand.unit, ".2g")


def _index_cells(labels: Sequence[str], indices: np.ndarray) -> list[list[str]]:
    return [
        [label, *(f"{value:.2f}" if value >= SLIGHT else "" for value in row)]
        for label, row in zip(labels, indices, strict=True)
    ]


def _remarks(done: "Identification") -> list[str]:
    """Return what a reader has to know before the numbers are used."""
    remarks = []
    judged = [
        inside
        for inside, row in zip(done.inside, done.problem.rows, strict=True)
        if inside is not None and not row.learned
    ]
    if judged:
        remarks.append(f"{sum(judged)} of {len(judged)} predicted rows are inside their 90 % interval.")
    remarks += [
        f"{row.label}: no value in the ranges reaches the measurement, it is {least:.1f} standard deviations "
        "away at least."
        for row, least in zip(done.problem.rows, done.least, strict=True)
        if least > IMPOSSIBLE
    ]
    if done.refused:
        remarks.append(f"{done.refused} members were refused, because the drawing cannot hold them.")
    if not done.posterior.converged:
        remarks.append(
            f"The chain is short: {done.posterior.steps} steps for a memory of {done.posterior.memory:.0f}."
        )
    return remarks


def _unit(unit: str) -> str:
    return "" if unit == "1" else unit


def _number(value: float, unit: str, form: str = ".4g") -> str:
    return f"{value:{form}} {_unit(unit)}".strip()


def _interval(low: float, high: float, unit: str) -> str:
    return f"{low:.4g} to {high:.4g} {_unit(unit)}".strip()


def json_text(done: "Identification") -> str:
    """Format an identification as JSON, numbers in SI."""
    mode = done.problem.values(done.posterior.mode)
    names = [one.name for one in done.problem.unknowns]
    content = {
        "nutamill": __version__,
        "unknowns": [
            {
                "name": one.name,
                "keys": one.keys,
                "gain_of": one.gain_of,
                "campaign": one.campaign,
                "unit": one.unit,
                "range": [one.low, one.high],
                "reason": one.reason,
                "mode": float(best),
                "quantiles": dict(zip(("5 %", "50 %", "95 %"), map(float, three), strict=True)),
            }
            for one, best, three in zip(done.problem.unknowns, mode, done.unknowns, strict=True)
        ],
        "rows": [
            {
                "row": row.label,
                "published": row.published or None,
                "unit": row.measurand.unit,
                "learned": row.learned,
                "measured": None if np.isnan(row.value) else row.value,
                "scatter": row.scatter,
                "discrepancy": row.discrepancy,
                "prior_90": None
                if done.problem.drawn(row)
                else [float(done.prior_rows[k][0]), float(done.prior_rows[k][2])],
                "draws": done.emulators[k].check.members if done.problem.drawn(row) else None,
                "posterior_90": [float(done.posterior_rows[k][0]), float(done.posterior_rows[k][2])],
                "posterior_median": float(done.posterior_rows[k][1]),
                "inside": done.inside[k],
                "least_implausibility": None if np.isnan(done.least[k]) else float(done.least[k]),
                "emulator": done.emulators[k].check._asdict(),
                "total_effects": dict(zip(names, map(float, done.effects[k]), strict=True)),
                "would_settle": dict(zip(names, map(float, done.settles[k]), strict=True)),
            }
            for k, row in enumerate(done.problem.rows)
        ],
        "posterior": {
            "steps": done.posterior.steps,
            "memory": done.posterior.memory if np.isfinite(done.posterior.memory) else None,
            "points": np.round(done.problem.values(done.posterior.points), 12).tolist(),
        },
        "refused_members": done.refused,
    }
    return json.dumps(content, indent=1, ensure_ascii=False) + "\n"
