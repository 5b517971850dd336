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
from nutamill.base import units
from nutamill.base.errors import CaseError, Fault
from nutamill.base.units import UNITS, Kind, in_unit, rpm
from nutamill.studies.papers.compare import Finding
from nutamill.studies.papers.model import Paper, Row, same_speed
from nutamill.studies.papers.quantities import QUANTITIES

if TYPE_CHECKING:
    from rich.table import Table

Interval = tuple[float, float]
"""Ends of an interval, SI."""

WIDTH = 160
"""Columns of the printed table without a terminal [1]."""

TINY = 1e-3
"""Size below which a plain number is shown by its order [1]."""

HEADINGS = ("quantity", "experiment", "paper's simulation", "its error", "nutamill", "error", "target", "")
"""Columns of the printed and the Markdown table."""
IDENTIFIED = "identified, 90 %"
"""Column of predictive intervals of an identification."""
SHORT = ("quantity", "experiment", "paper's simulation", "nutamill", "error")
"""Columns of the table of headline rows."""
NARROW = 120
"""Columns of a terminal below which the table is printed row by row [1]."""

SHOWN = {Kind.ANGLE: "deg", Kind.LENGTH: "mm", Kind.TIME: "s", Kind.POWER: "kW"}
"""Units of kinds that are not shown in their SI unit."""


def unit_of(kind: Kind | None) -> tuple[str, float]:
    """Return how numbers of a kind are shown: the unit, and how many of it are one of the SI unit."""
    if kind is None:
        return "", 1.0
    unit = SHOWN.get(kind, next(iter(UNITS[kind])))
    return unit, in_unit(1.0, unit)


def title_of(row: Row, paper: Paper) -> str:
    """Return what a row compares, in words."""
    own, quantity = paper.configurations[row.configuration].title, QUANTITIES[row.quantity]
    text = f"{quantity.label}, {own}" + (f", {_speed(row.speed)}" if row.speed else "")
    if row.at is not None:
        unit, many = unit_of(quantity.at)
        text += f", at {row.at * many:.4g} {unit}"
    if row.against is not None:
        other, speed, _ = row.needs[1]
        words = {"difference": "less", "change": "change from", "ratio": "over"}[row.against.how]
        text += f", {words} {paper.configurations[other].title}" + (
            "" if same_speed(speed, row.speed) else f" at {_speed(speed)}"
        )
    return text


def shown(value: float | None, row: Row, digits: int = 4) -> str:
    """Format a value of a row with its unit, or as a dash if there is none."""
    if value is None or math.isnan(value):
        return "–"
    if row.kind is None and row.against is not None and row.against.how == "change":
        return f"{100.0 * value:+.1f} %"
    unit, many = unit_of(row.kind)
    return f"{value * many:.{digits}g} {unit}".rstrip()


def with_uncertainty(finding: Finding) -> str:
    """Format our value with its interval, and the scatter over seeds where there are several: ``935 ± 4 N (3
    seeds, s = 6)``.
    """
    row = finding.row
    if math.isnan(finding.value):
        return "not run" if finding.trouble.startswith("not run") else "no result"
    change = row.kind is None and row.against is not None and row.against.how == "change"
    if row.kind is None and not change and abs(finding.value) < TINY:
        return f"{finding.value:.1g}"
    unit, many = ("%", 100.0) if change else unit_of(row.kind)
    known = finding.half_width > 1e-6 * abs(finding.value)
    size = finding.half_width * many if known else 0.0
    four = 1 if change else max(0, 3 - math.floor(math.log10(abs(finding.value * many) or 1.0)))
    digits = min(four, max(0, 1 - math.floor(math.log10(size)))) if size else four
    sign = "+" if change else ""
    text = f"{finding.value * many:{sign}.{digits}f}" + (
        f" ± {size:.{digits}f}" if size >= 0.5 * 10.0**-digits else ""
    )
    seeds = (
        f" ({finding.runs} seeds, s = {finding.scatter * many:.2g})"
        if not math.isnan(finding.scatter)
        else ""
    )
    return f"{text} {unit}".rstrip() + seeds


def error_text(error: float, finding: Finding) -> str:
    """Format how far a value is off, as a share or in the row's unit."""
    if math.isnan(error):
        return ""
    if not finding.points:
        return f"{100.0 * error:+.0f} %" if abs(error) >= 0.095 else f"{100.0 * error:+.1f} %"
    if finding.row.kind is None:
        return f"{100.0 * error:+.1f} points"
    unit, many = unit_of(finding.row.kind)
    return f"{error * many:+.2g} {unit}"


def target_text(row: Row) -> str:
    """Format the target of a row, empty if it has none."""
    texts = ["sign"] if row.same_sign else []
    if row.relative is not None:
        texts.append(f"{100.0 * row.relative:g} %")
    if row.absolute is not None:
        unit, many = ("points", 100.0) if row.kind is None else unit_of(row.kind)
        texts.append(f"{row.absolute * many:.3g} {unit}")
    return ", ".join(texts)


def sensitivity_of(row: Row, paper: Paper) -> str:
    """Return what is changed on purpose of the mill that a row is of, empty for the mill as it is."""
    changes = [paper.configurations[name].sensitivity for name, _, _ in row.needs]
    return "; ".join(dict.fromkeys(change for change in changes if change))


def verdict(finding: Finding, paper: Paper) -> str:
    """Return ``within`` or ``missed`` the target, whether the row was calibrated on or predicted, and if a
    run behind it is not steady.
    """
    words = [] if finding.within is None else ["within" if finding.within else "missed"]
    changed = bool(sensitivity_of(finding.row, paper))
    if finding.row.calibrated or (finding.row.reference not in (None, 0.0) and not changed):
        words.append("calibrated" if finding.row.calibrated else "predicted")
    if changed:
        words.append("sensitivity")
    if not finding.steady and not math.isnan(finding.value):
        words.append("not steady")
    return ", ".join(words)


def cells(finding: Finding, paper: Paper) -> list[str]:
    """Return one row of the printed table, under `HEADINGS`."""
    row = finding.row
    simulated = shown(row.simulation, row)
    if row.simulation_speed is not None:
        simulated += f" at {_speed(row.simulation_speed)}"
    return [
        title_of(row, paper),
        _experiment(row),
        simulated,
        error_text(finding.simulation_error, finding),
        with_uncertainty(finding),
        error_text(finding.error, finding),
        target_text(row),
        verdict(finding, paper),
    ]


def _interval(interval: Interval | None, row: Row) -> str:
    """Format an interval of a row with its unit, empty if there is none."""
    if interval is None:
        return ""
    unit, many = unit_of(row.kind)
    return f"{interval[0] * many:.3g} to {interval[1] * many:.3g} {unit}".rstrip()


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


def _experiment(row: Row) -> str:
    """Format what a row is compared with, and whether it was computed."""
    computed = row.experiment is not None and row.experiment_is == "computed"
    return shown(row.experiment, row) + (" (computed)" if computed else "")


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
            taken.append(_interval(identified.get(finding.row.id), finding.row))
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
        "speed_rpm": _rounded_rpm(row.speed),
        "simulation_speed_rpm": None if row.simulation_speed is None else _rounded_rpm(row.simulation_speed),
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


def _speed(speed: float) -> str:
    return units.shown(speed, "rpm", ".6g")


def _rounded_rpm(speed: float) -> float:
    return float(f"{rpm(speed):.6g}")
