"""`steady`: the steady means of a run with their intervals, and whether the run is steady, as one table."""

from typing import NamedTuple

from nutamill.analysis.source import any_case_of
from nutamill.analysis.summary import CERTAIN, has_crank, steady_line, too_few_turns
from nutamill.analysis.values import Reading, default_readings, reading_of
from nutamill.analysis.windows import SteadyPart, steady_mean, turns_at_speed
from nutamill.base.notebook_hook import notebook_html
from nutamill.base.steady import FEWEST_TURNS, Estimate
from nutamill.base.units import in_unit
from nutamill.result import Result

OF_A_MILL = (
    Reading("crank_pin_force_resultant"),
    Reading("driveshaft_torque"),
    Reading("driveshaft_power"),
    Reading("charge_phase_lag"),
)
"""Readings of a mill, where a result holds them."""


class SteadyTable(NamedTuple):
    """Steady means of one run. It prints as text, and shows itself as a table in a notebook."""

    run: str
    """Name of the result file, without its suffix."""
    verdict: str
    """Whether the run is steady and since when, what drifts, or why there is no test of that."""
    steady: bool
    """Whether every reading is steady."""
    heading: str
    """What the means are: steady, not steady, or plain means."""
    means: dict[Reading, Estimate]
    """Mean of each reading, in the unit of its series; none without a whole turn at constant speed."""

    def rows(self) -> list[tuple[str, str]]:
        """Return label with unit, and mean with interval, of each reading."""
        return [
            (label_of(reading), mean_text(shown_mean(reading, mean))) for reading, mean in self.means.items()
        ]

    def __str__(self) -> str:
        """Return verdict and means, one line each."""
        rows = self.rows()
        width = max((len(label) for label, _ in rows), default=0)
        return "\n".join([self.verdict, *(f"{label:{width}}  {mean}" for label, mean in rows)])

    def _repr_html_(self) -> str:
        return notebook_html("results.steady_html", self)


def steady(result: Result, *readings: str) -> SteadyTable:
    """Return the steady means of a run with their 95 % intervals.

    Parameters
    ----------
    result : an opened result
    readings : series, or ``rms`` or ``swing`` and a series, ``"rms driveshaft_torque"``; without any those of
        a mill, or the quantities, torques or forces of another machine

    Raises
    ------
    CaseError : no such series, or no such way to read it
    ResultError : a series that this result does not hold
    """
    case = any_case_of(result) if result.case_text else None
    if readings:
        machine = None if case is None else case.machine
        chosen = [reading_of(text, "steady", machine) for text in readings]
    else:
        known = OF_A_MILL if case is None or has_crank(result) else default_readings(case)
        chosen = [reading for reading in known if reading.series in result.series]
    times = turns_at_speed(result)[1]
    turns = max(0, len(times) - 1)
    if turns < 1:
        return SteadyTable(result.path.stem, "no whole turn at constant speed: no means", False, "", {})
    means = {reading: steady_mean(result, reading.series, reading.by) for reading in chosen}
    if turns < FEWEST_TURNS:
        heading = f"plain mean of {turns} turn{'s' * (turns > 1)}, without an interval"
        return SteadyTable(result.path.stem, too_few_turns(turns), False, heading, means)
    part = SteadyPart(times, {reading.name: mean for reading, mean in means.items()})
    heading = "mean and 95 % interval, not steady" if part.drifting else "steady mean and 95 % interval"
    return SteadyTable(result.path.stem, steady_line(result, part), not part.drifting, heading, means)


def label_of(reading: Reading) -> str:
    """Return the label of a reading with the unit of `shown_mean`."""
    how = "" if reading.by == "mean" else f", {reading.by}"
    unit = "deg" if reading.field.unit == "rad" else reading.field.unit
    return f"{reading.field.label}{how} ({unit})"


def shown_mean(reading: Reading, mean: Estimate) -> Estimate:
    """Return the mean of a reading as tables show it: angles in degrees, as in figures."""
    if reading.field.unit != "rad":
        return mean
    numbers = ("mean", "half_width", "plain_mean", "drift")
    return mean._replace(**{name: in_unit(getattr(mean, name), "deg") for name in numbers})


def mean_text(estimate: Estimate) -> str:
    """Format a mean with its interval, where it has one that is not finer than anyone reads."""
    width = estimate.half_width
    shown = width > CERTAIN * abs(estimate.mean)
    return f"{estimate.mean:.4g}" + (f" ± {_short(width)}" if shown else "")


def _short(width: float) -> str:
    """Format the half width of an interval to two digits, never as a power of ten."""
    return f"{width:.0f}" if width >= 10.0 else f"{width:.2g}"
