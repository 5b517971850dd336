"""Rows of a paper against our results: what was measured, what its authors simulated, what we find, and by
how much each is off.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from nutamill.analysis.values import Value
from nutamill.base.errors import DamagedError, ResultError
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

    @classmethod
    def of(cls, configuration: str, speed: float, quantity: str) -> "Key":
        """The key of a need (`nutamill.studies.papers.model.Row.needs`)."""
        return cls(configuration, round(speed, 6), quantity)


class Measured(NamedTuple):
    """One number of ours, from one run or from several that differ in their seed."""

    mean: float
    """Mean over the runs, SI."""
    half_width: float
    """Half width of its 95 % interval from within the runs; NaN where none is known."""
    scatter: float
    """Standard deviation from run to run; NaN of a single run."""
    runs: int
    """Runs it is made of [1]."""
    window_mean: float
    """Mean over all samples of the window, as in the papers, not over whole turns."""
    trouble: str = ""
    """Why there is no number, or not from all runs; empty if all is well."""
    steady: bool = True
    """Whether the test calls every run steady; runs with too few turns for it are not."""


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
    window_value: float
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


NOTHING = Measured(math.nan, math.nan, math.nan, 0, math.nan)


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
    wanted: dict[tuple[str, float], list[str]] = {}
    for key in dict.fromkeys(keys):
        wanted.setdefault(key[:2], []).append(key.quantity)
    numbers = {}
    for (configuration, speed), quantities in wanted.items():
        own = [run for run in runs if (run.configuration, round(run.speed, 6)) == (configuration, speed)]
        taken = [_take(run, quantities, f"{command} {run.name}") for run in own]
        for quantity in quantities:
            numbers[Key(configuration, speed, quantity)] = _together([values[quantity] for values in taken])
    return numbers


def _take(run: PlannedRun, quantities: Sequence[str], command: str) -> dict[str, Value | str]:
    """Numbers of one run by quantity, or why there is none."""
    values: dict[str, Value | str] = {}
    series = [quantity for quantity in quantities if quantity != MODES]
    state = run_state(run) if series else COMPLETE
    if state == COMPLETE and series:
        with open_result(run.path) as result:
            for quantity in series:
                try:
                    values[quantity] = QUANTITIES[quantity].measure(result, run.average)
                except (ResultError, DamagedError) as error:
                    values[quantity] = str(error)
    elif series:
        values = dict.fromkeys(series, trouble_of(state, command))
    if MODES in quantities:
        frequencies = read_modes(run)
        if frequencies is None:
            values[MODES] = trouble_of(MISSING, command)
        else:
            values[MODES] = (
                Value(frequencies[0], math.nan, frequencies[0], 1, True)
                if frequencies
                else "no mode oscillates below twice the speed"
            )
    return values


def trouble_of(state: str, command: str) -> str:
    """Return why a run is not complete, and what to do."""
    if state == MISSING:
        return f"not run. Do: {command}"
    if state.startswith("failed"):
        return f"{state} To run it again, delete its file"
    return f"not finished ({state}). Do: {command}"


def _together(values: Sequence[Value | str]) -> Measured:
    """One number of several runs; troubles are joined in words."""
    good = [value for value in values if not isinstance(value, str)]
    trouble = "; ".join(dict.fromkeys(value for value in values if isinstance(value, str)))
    if not good:
        return NOTHING._replace(trouble=trouble or "no run has it")
    means = np.array([value.mean for value in good])
    half_width = math.sqrt(sum(value.half_width**2 for value in good)) / len(good)
    scatter = float(means.std(ddof=1)) if len(good) > 1 else math.nan
    return Measured(
        float(means.mean()),
        half_width,
        scatter,
        len(good),
        float(np.mean([value.window for value in good])),
        trouble,
        all(value.steady for value in good),
    )


def compare(rows: Iterable[Row], measured: Mapping[Key, Measured]) -> list[Finding]:
    """Set our numbers against the paper's, row by row."""
    return [_finding(row, [measured.get(Key.of(*need), NOTHING) for need in row.needs]) for row in rows]


def _finding(row: Row, parts: Sequence[Measured]) -> Finding:
    value, half_width, scatter = (_combined(row, parts, which) for which in ("mean", "half_width", "scatter"))
    window_value = _how(row, [part.window_mean for part in parts])
    plain = (
        row.kind is None and row.against is not None and row.against.how == "change"
    ) or row.kind is Kind.ANGLE
    points = plain or row.absolute is not None or row.reference == 0.0
    error = _off(value, row.reference, points)
    simulated = row.simulation_error
    if simulated is None:
        same = row.experiment is not None and row.simulation is not None
        simulated = _off(row.simulation, row.experiment, points) if same else math.nan
    trouble = "; ".join(dict.fromkeys(part.trouble for part in parts if part.trouble))
    runs = min(part.runs for part in parts)
    steady = all(part.steady for part in parts)
    within = _within(row, value, error)
    return Finding(
        row, value, half_width, scatter, runs, window_value, error, simulated, points, within, trouble, steady
    )


def _how(row: Row, values: Sequence[float]) -> float:
    """The row's number from its one or two parts."""
    if row.against is None:
        return values[0]
    own, other = values
    if row.against.how == "difference":
        return own - other
    ratio = own / other if other else math.nan
    return ratio - 1.0 if row.against.how == "change" else ratio


def _combined(row: Row, parts: Sequence[Measured], which: str) -> float:
    """The row's number (`which` is ``mean``), or its uncertainty, parts taken as independent; a part without
    one counts as exact.
    """
    means = [part.mean for part in parts]
    if which == "mean" or row.against is None:
        return _how(row, [getattr(part, which) for part in parts])
    spreads = [getattr(part, which) for part in parts]
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
    """How far a value is off: a difference, or a share of what was published."""
    if reference is None:
        return math.nan
    return value - reference if points else value / reference - 1.0


def _within(row: Row, value: float, error: float) -> bool | None:
    limit = row.absolute if row.absolute is not None else row.relative
    if math.isnan(value) or (limit is None and not row.same_sign):
        return None
    right_sign = not row.same_sign or math.copysign(1.0, value) == math.copysign(1.0, row.reference)
    return right_sign and (limit is None or abs(error) <= limit)


def keys_of(paper: Paper) -> list[Key]:
    """Numbers that all rows and all figures over the speed need."""
    keys = [Key.of(*need) for row in paper.rows for need in row.needs]
    for panel in (panel for figure in paper.figures for panel in figure.panels):
        for curve in panel.curves:
            for name in curve.configurations:
                keys += [
                    Key.of(name, speed, curve.quantity or panel.quantity)
                    for speed in paper.configurations[name].speeds
                ]
    return keys
