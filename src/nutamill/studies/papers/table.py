"""The comparison as a table: on a terminal, as Markdown, CSV and JSON."""

import csv
import io
import json
import math
import sys
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nutamill import __version__
from nutamill.base.errors import CaseError, Fault
from nutamill.base.units import UNITS
from nutamill.studies.papers.compare import Finding
from nutamill.studies.papers.model import Paper

if TYPE_CHECKING:
    from rich.table import Table
from nutamill.studies.papers.cells import (
    HEADINGS,
    Interval,
    cells,
    interval_text,
    rounded_rpm,
    sensitivity_of,
    target_text,
    title_of,
)

WIDTH = 160
"""Columns of the printed table without a terminal [1]."""

IDENTIFIED = "identified, 90 %"
"""Column of predictive intervals of an identification."""
SHORT = ("quantity", "experiment", "paper's simulation", "nutamill", "error")
"""Columns of the table of headline rows."""
NARROW = 120
"""Columns of a terminal below which the table is printed row by row [1]."""


def read_identified(file: Path, paper: str) -> dict[str, Interval]:
    """Return the 90 % intervals of the rows of a paper by their names, from the ``identify.json`` of an
    identification.

    Raises
    ------
    CaseError : a file that is none
    """
    try:
        rows = json.loads(file.read_text(encoding="utf-8"))["rows"]
        named = [(row["published"], row["posterior_90"]) for row in rows if row["published"]]
        parted = [(*name.split("/"), (float(low), float(high))) for name, (low, high) in named]
        return {row: interval for of, row, interval in parted if of == paper}
    except (OSError, ValueError, TypeError, KeyError) as error:
        what = f"is no identify.json of an identification ({error})"
        raise CaseError(Fault(str(file), what, "Name the one that nutamill identify wrote")) from None


def markdown(
    findings: Iterable[Finding],
    paper: Paper,
    columns: Sequence[str] = HEADINGS,
    identified: Mapping[str, Interval] | None = None,
) -> str:
    """Format the table in Markdown, with those of the columns of `HEADINGS` that are asked for, and a column
    with the predictive intervals of an identification where there are any.

    Parameters
    ----------
    identified : intervals by the name of the row
    """
    chosen = [HEADINGS.index(column) for column in columns]
    heads = [*columns, IDENTIFIED] if identified else columns
    lines = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    for finding in findings:
        row = cells(finding, paper)
        taken = [row[number] for number in chosen]
        if identified:
            taken.append(interval_text(identified.get(finding.row.id), finding.row))
        lines.append("| " + " | ".join(taken) + " |")
    return "\n".join(lines) + "\n"


def csv_text(findings: Iterable[Finding], paper: Paper) -> str:
    """Format the table as CSV: one row each, numbers in SI."""
    records = [record(finding, paper) for finding in findings]
    out = io.StringIO()
    writer = csv.DictWriter(out, records[0] if records else ["row"], lineterminator="\n")
    writer.writeheader()
    writer.writerows({key: "" if value is None else value for key, value in one.items()} for one in records)
    return out.getvalue()


def json_text(findings: Iterable[Finding], paper: Paper) -> str:
    """Format the table as JSON: source, version that made it, and one object per row, numbers in SI."""
    content = {
        "paper": paper.citation,
        "nutamill": __version__,
        "rows": [record(finding, paper) for finding in findings],
    }
    return json.dumps(content, indent=1, ensure_ascii=False) + "\n"


def record(finding: Finding, paper: Paper) -> dict[str, Any]:
    """Return everything about a row under plain names, with numbers in SI, None where there is none."""
    row = finding.row
    numbers = {
        "experiment": row.experiment,
        "simulation": row.simulation,
        "simulation_error": finding.simulation_error,
        "nutamill": finding.value,
        "half_width_95": finding.half_width,
        "scatter_over_seeds": finding.scatter,
        "nutamill_plain_window": finding.plain_mean,
        "error": finding.error,
    }
    return {
        "row": row.id,
        "quantity": title_of(row, paper),
        "unit": "1" if row.kind is None else next(iter(UNITS[row.kind])),
        "speed_rpm": rounded_rpm(row.speed),
        "simulation_speed_rpm": None if row.simulation_speed is None else rounded_rpm(row.simulation_speed),
        **{name: None if value is None or math.isnan(value) else value for name, value in numbers.items()},
        "errors_are": "differences" if finding.points else "shares",
        "seeds": finding.runs,
        "target": target_text(row),
        "within": finding.within,
        "steady": finding.steady,
        "calibrated": row.calibrated,
        "experiment_is": row.experiment_is,
        "source": row.source,
        "derived": row.derived,
        "sensitivity": sensitivity_of(row, paper),
        "note": row.note,
        "trouble": finding.trouble,
    }


def rich_table(findings: Sequence[Finding], paper: Paper) -> "Table":
    """Build the table for a terminal."""
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE_HEAD, title=paper.short, title_justify="left", pad_edge=False)
    for heading in HEADINGS:
        table.add_column(heading, justify="left" if heading in ("quantity", "") else "right", overflow="fold")
    styles = {True: "green", False: "red", None: ""}
    for finding in findings:
        table.add_row(*cells(finding, paper), style=styles[finding.within])
    return table


def print_table(findings: Sequence[Finding], paper: Paper) -> None:
    """Print the table, what is missing with the command that makes it, and the tally."""
    from rich.console import Console

    console = Console(width=None if sys.stdout.isatty() else WIDTH)
    if console.width < NARROW:
        for line in narrow_lines(findings, paper, console.width):
            console.print(line, highlight=False, markup=False)
    else:
        console.print(rich_table(findings, paper))
    for line in (*trouble_lines(findings), tally(findings, paper)):
        console.print(line, highlight=False, markup=False, soft_wrap=True)


def narrow_lines(findings: Sequence[Finding], paper: Paper, width: int) -> list[str]:
    """Return the table for a terminal too narrow for its columns [1]: what is compared, and below it the
    numbers.
    """
    lines = [paper.short]
    for finding in findings:
        title, *texts = cells(finding, paper)
        numbers = [
            f"{heading} {text}" if heading else text
            for heading, text in zip(HEADINGS[1:], texts, strict=True)
            if text
        ]
        lines += textwrap.wrap(title, width)
        lines += textwrap.wrap(", ".join(numbers), width, initial_indent="  ", subsequent_indent="  ")
    return lines


def trouble_lines(findings: Iterable[Finding]) -> list[str]:
    """Return what has no number yet and what makes it, each once."""
    return list(
        dict.fromkeys(part for finding in findings if finding.trouble for part in finding.trouble.split("; "))
    )


def tally(findings: Sequence[Finding], paper: Paper) -> str:
    """Return the summarise in one line how many rows have a number, meet their target, and how we compare
    with the authors' simulation.

    Targets and comparisons are of the mill as it is: rows of a mill changed on purpose are not among them.
    """
    present = sum(not math.isnan(finding.value) for finding in findings)
    claims = [finding for finding in findings if not sensitivity_of(finding.row, paper)]
    judged = [finding for finding in claims if finding.within is not None]
    both = [finding for finding in claims if not math.isnan(finding.error + finding.simulation_error)]
    met = sum(bool(finding.within) for finding in judged)
    better = sum(abs(finding.error) < abs(finding.simulation_error) for finding in both)
    text = (
        f"{present} of {len(findings)} rows have a result; {met} of {len(judged)} with a target meet it;"
        f" {better} of {len(both)} are nearer to the experiment than the paper's simulation"
    )
    apart = len(findings) - len(claims)
    return text + (f"; {apart} rows of a mill changed on purpose are counted in neither" if apart else "")
