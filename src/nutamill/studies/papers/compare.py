"""Rows of a paper against our results: what was measured, what its authors simulated, what we find, and by
how much each is off.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from nutamill.base.errors import DamagedError, ResultError
from nutamill.base.steady import NO_ESTIMATE, Estimate
from nutamill.base.units import Kind
from nutamill.result import MISSING, open_result
from nutamill.studies.papers.model import Paper, Row
from nutamill.studies.papers.quantities import MODES, QUANTITIES
from nutamill.studies.papers.runs import COMPLETE, PlannedRun, read_modes, run_state


class Key(NamedTuple):
    """Names one number of ours."""

    configuration: str
    """Set-up."""
    speed: float
    """Speed, rounded so that equal ones are equal [rad/s]."""
    quantity: str
    """What of it."""
    at: float | None = None
    """Place or time at which it is taken, SI."""

    @classmethod
    def of(cls, configuration: str, speed: float, quantity: str, at: float | None = None) -> "Key":
        """Return the key of a need (`nutamill.studies.papers.model.Row.needs`)."""
        return cls(configuration, round(speed, 6), quantity, at)


class Measured(NamedTuple):
    """One number of ours, from one run or from several that differ in their seed."""

    estimate: Estimate
    """Mean over the runs, SI; its half width is from within the runs, and it is steady if every run is."""
    scatter: float
    """Standard deviation from run to run; NaN of a single run."""
    runs: int
    """Runs it is made of [1]."""
    trouble: str = ""
    """Why there is no number, or not from all runs; empty if all is well."""


class Finding(NamedTuple):
    """One row, compared."""

    row: Row
    """What was published."""
    value: float
    """Ours, SI; NaN if there is none."""
    half_width: float
    """Half width of its 95 % interval; NaN where none is known."""
    scatter: float
    """Standard deviation over seeds; NaN of single runs."""
    runs: int
    """Least number of runs behind either part of the row [1]."""
    plain_mean: float
    """Ours from the plain means of the papers' window."""
    error: float
    """How far we are off, `points` or not; NaN if nothing was published."""
    simulation_error: float
    """How far the authors' simulation is off; NaN if not known."""
    points: bool
    """Whether errors are plain differences, and not shares of what was published."""
    within: bool | None
    """Whether the target is met; None if there is none or no number."""
    trouble: str
    """Why there is no number, or not from all runs."""
    steady: bool
    """Whether the runs behind it are steady."""


NOTHING = Measured(NO_ESTIMATE, math.nan, 0)


def measure(
    paper: Paper, runs: Sequence[PlannedRun], keys: Iterable[Key], command: str
) -> dict[Key, Measured]:
    """Take numbers from the result files, each opened once.

    Parameters
    ----------
    runs : all runs of the paper
    keys : what to take
    command : what makes missing results, up to the name of a run: ``nutamill validate mca2026 --only``
    """
    wanted: dict[tuple[str, float], list[Key]] = {}
    for key in dict.fromkeys(keys):
        wanted.setdefault(key[:2], []).append(key)
    numbers = {}
    for (configuration, speed), asked in wanted.items():
        own = [run for run in runs if (run.configuration, round(run.speed, 6)) == (configuration, speed)]
        taken = [_take(run, asked, f"{command} {run.name}") for run in own]
        for key in asked:
            numbers[key] = _together([values[key] for values in taken])
    return numbers


def _take(run: PlannedRun, keys: Sequence[Key], command: str) -> dict[Key, Estimate | str]:
    """Return the numbers of one run, or why there is none."""
    values: dict[Key, Estimate | str] = {}
    series = [key for key in keys if key.quantity != MODES]
    state = run_state(run) if series else COMPLETE
    if state == COMPLETE and series:
        with open_result(run.path) as result:
            for key in series:
                measure = QUANTITIES[key.quantity].measure
                assert measure is not None  # only that of `MODES` is read from no result
                try:
                    values[key] = measure(result, run.average, *(() if key.at is None else (key.at,)))
                except (ResultError, DamagedError) as error:
                    values[key] = str(error)
    elif series:
        values = dict.fromkeys(series, trouble_of(state, command))
    for key in keys:
        if key.quantity != MODES:
            continue
        frequencies = read_modes(run)
        if frequencies is None:
            values[key] = trouble_of(MISSING, command)
        else:
            values[key] = (
                Estimate.exact(frequencies[0]) if frequencies else "no mode oscillates below twice the speed"
            )
    return values


def trouble_of(state: str, command: str) -> str:
    """Return why a run is not complete, and what to do."""
    if state == MISSING:
        return f"not run. Do: {command}"
    if state.startswith("failed"):
        return f"{state} To run it again, delete its file"
    return f"not finished ({state}). Do: {command}"


def _together(values: Sequence[Estimate | str]) -> Measured:
    """Combine the estimates of several runs, and the reasons of those that have none."""
    good = [value for value in values if not isinstance(value, str)]
    trouble = "; ".join(dict.fromkeys(value for value in values if isinstance(value, str)))
    if not good:
        return NOTHING._replace(trouble=trouble or "no run has it")
    means = np.array([value.mean for value in good])
    half_width = math.sqrt(sum(value.half_width**2 for value in good)) / len(good)
    scatter = float(means.std(ddof=1)) if len(good) > 1 else math.nan
    together = Estimate(
        mean=float(means.mean()),
        half_width=half_width,
        plain_mean=float(np.mean([value.plain_mean for value in good])),
        turns=sum(value.turns for value in good),
        steady=all(value.steady for value in good),
    )
    return Measured(together, scatter, len(good), trouble)


def compare(rows: Iterable[Row], measured: Mapping[Key, Measured]) -> list[Finding]:
    """Set our numbers against the paper's, row by row."""
    return [
        _finding(row, [measured.get(Key.of(*need, row.at), NOTHING) for need in row.needs]) for row in rows
    ]


def _finding(row: Row, parts: Sequence[Measured]) -> Finding:
    means = [row.factor * part.estimate.mean for part in parts]
    value = _how(row, means)
    plain_mean = _how(row, [row.factor * part.estimate.plain_mean for part in parts])
    half_width = _spread(row, means, [row.factor * part.estimate.half_width for part in parts])
    scatter = _spread(row, means, [row.factor * part.scatter for part in parts])
    plain = (
        row.kind is None and row.against is not None and row.against.how == "change"
    ) or row.kind is Kind.ANGLE
    points = plain or row.absolute is not None or row.reference == 0.0
    error = _off(value, row.reference, points)
    simulated = row.simulation_error
    if simulated is None:
        simulated = math.nan if row.simulation is None else _off(row.simulation, row.experiment, points)
    trouble = "; ".join(dict.fromkeys(part.trouble for part in parts if part.trouble))
    runs = min(part.runs for part in parts)
    steady = all(part.estimate.steady for part in parts if part.runs)
    within = _within(row, value, error)
    return Finding(
        row, value, half_width, scatter, runs, plain_mean, error, simulated, points, within, trouble, steady
    )


def _how(row: Row, values: Sequence[float]) -> float:
    """Return the row's number from its one or two parts."""
    if row.against is None:
        return values[0]
    own, other = values
    if row.against.how == "difference":
        return own - other
    ratio = own / other if other else math.nan
    return ratio - 1.0 if row.against.how == "change" else ratio


def _spread(row: Row, means: Sequence[float], spreads: Sequence[float]) -> float:
    """Compute the uncertainty of the row's number from those of its parts, taken as independent. A part
    without one counts as exact.
    """
    if row.against is None:
        return _how(row, spreads)
    if all(math.isnan(spread) for spread in spreads):
        return math.nan
    spreads = [0.0 if math.isnan(spread) else spread for spread in spreads]
    if row.against.how == "difference":
        return math.hypot(*spreads)
    if not all(means) or math.isnan(means[0] + means[1]):
        return math.nan
    return abs(means[0] / means[1]) * math.hypot(
        *(spread / mean for spread, mean in zip(spreads, means, strict=True))
    )


def _off(value: float, reference: float | None, points: bool) -> float:
    """Return how far a value is off: a difference, or a share of what was published."""
    if reference is None:
        return math.nan
    return value - reference if points else value / reference - 1.0


def _within(row: Row, value: float, error: float) -> bool | None:
    limit = row.absolute if row.absolute is not None else row.relative
    if math.isnan(value) or (limit is None and not row.same_sign):
        return None
    right_sign = (
        not row.same_sign
        or row.reference is None
        or math.copysign(1.0, value) == math.copysign(1.0, row.reference)
    )
    return right_sign and (limit is None or abs(error) <= limit)


def keys_of(paper: Paper) -> list[Key]:
    """List the numbers that all rows and all figures over the speed need."""
    keys = [Key.of(*need, row.at) for row in paper.rows for need in row.needs]
    for panel in (panel for figure in paper.figures for panel in figure.panels):
        for curve in panel.curves:
            for name in curve.configurations:
                keys += [
                    Key.of(name, speed, curve.quantity or panel.quantity)
                    for speed in paper.configurations[name].speeds
                ]
    return keys
