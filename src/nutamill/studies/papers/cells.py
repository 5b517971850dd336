"""The cells of a row of a comparison as text: values, errors, targets, verdicts."""

import math

from nutamill.base import units
from nutamill.base.units import UNITS, Kind, in_unit, rpm
from nutamill.studies.papers.compare import Finding
from nutamill.studies.papers.model import Paper, Row, same_speed
from nutamill.studies.papers.quantities import QUANTITIES

Interval = tuple[float, float]
"""Ends of an interval, SI."""

HEADINGS = ("quantity", "experiment", "paper's simulation", "its error", "nutamill", "error", "target", "")
"""Columns of the printed and the Markdown table."""

TINY = 1e-3
"""Size below which a plain number is shown by its order [1]."""

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


def interval_text(interval: Interval | None, row: Row) -> str:
    """Format an interval of a row with its unit, empty if there is none."""
    if interval is None:
        return ""
    unit, many = unit_of(row.kind)
    return f"{interval[0] * many:.3g} to {interval[1] * many:.3g} {unit}".rstrip()


def _experiment(row: Row) -> str:
    """Format what a row is compared with, and whether it was computed."""
    computed = row.experiment is not None and row.experiment_is == "computed"
    return shown(row.experiment, row) + (" (computed)" if computed else "")


def _speed(speed: float) -> str:
    return units.shown(speed, "rpm", ".6g")


def rounded_rpm(speed: float) -> float:
    """Return a speed [rad/s] in rpm, rounded to six digits."""
    return float(f"{rpm(speed):.6g}")
