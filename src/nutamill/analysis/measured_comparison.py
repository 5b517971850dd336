"""A run beside a test: steady values and their errors, filtered and averaged in the same way."""

import math
from typing import NamedTuple

import numpy as np

from nutamill.analysis.windows import MEASURED_SPEED, TURNING, turns_at_speed
from nutamill.base.errors import CaseError, Fault
from nutamill.result import Result

ORDER = 4
"""Order of the low-pass filter, each way."""
FEWEST_FILTERED = 3 * (ORDER + 1) + 1
"""Samples below which a record is too short for the filter [1]: its ends are continued by three times the
coefficients of the filter.
"""


class Compared(NamedTuple):
    """One quantity of a run and of a test, over whole turns at the end of each."""

    name: str
    """The series."""
    label: str
    """What to call it, with its unit."""
    run: float
    """Mean of the run, unit of the series."""
    test: float
    """Mean of the test."""
    run_rms: float
    """Root mean square about the mean, of the run."""
    test_rms: float
    """The same of the test."""

    @property
    def error(self) -> float:
        """Error of the run's mean, share of the test's, NaN where that is zero."""
        return self.run / self.test - 1.0 if self.test else math.nan


def compare(run: Result, test: Result, last: float, cut: float | None = None) -> list[Compared]:
    """Compare all quantities that both hold, over the whole turns of the last `last` seconds at the last
    speed.

    Parameters
    ----------
    last : length of the window [s]
    cut : cut-off of a low-pass filter for both [Hz]; none if None

    Raises
    ------
    CaseError : nothing in common, or a cut-off beyond half a rate
    """
    names = shared(run, test)
    rows = []
    for name in names:
        values = [series_in_window(result, name, last, cut) for result in (run, test)]
        rows.append(
            Compared(
                name,
                _label(run, name),
                *(float(np.mean(value)) for _, value in values),
                *(float(np.std(value)) for _, value in values),
            )
        )
    return rows


def shared(run: Result, test: Result) -> list[str]:
    """Return the quantities that both files hold.

    Raises
    ------
    CaseError : no quantity in common, or the test is a run
    """
    if test.case_text:
        raise CaseError(
            Fault(str(test.path), "is a run, not measured data", "Give a file that nutamill import wrote")
        )
    aside = {"time", "crank_angle", "driveshaft_speed", *(test.provenance.get(name) for name in TURNING)}
    names = [str(name) for name in run.series.data_vars if name in test.series and name not in aside]
    if not names:
        held = ", ".join(str(name) for name in test.series.data_vars if name not in aside)
        raise CaseError(
            Fault(
                f"{test.path}",
                f"has no series in common with {run.path}, got {held}",
                "Map its columns to series of the run",
            )
        )
    return names


def series_in_window(
    result: Result, name: str, last: float, cut: float | None
) -> tuple[np.ndarray, np.ndarray]:
    """Return the times [s] and filtered values of a series in the whole turns at the end, at the last speed.

    Raises
    ------
    CaseError : no whole turn, or a cut-off beyond half the rate
    """
    series = result.series
    time = series["time"].values
    since = float(time[-1]) - last - 1e-9 if len(time) else 0.0
    turns = turns_at_speed(result, since, MEASURED_SPEED)[1]
    if len(turns) < 2:
        raise CaseError(
            Fault(
                str(result.path),
                "fewer than one whole turn at constant speed at its end",
                "Take a longer record",
            )
        )
    first = int(np.searchsorted(time, turns[0] - 1e-9))
    values = series[name].values if cut is None else low_pass(series[name].values, result.rate, cut)
    return time[first:], values[first:]


def low_pass(values: np.ndarray, rate: float, cut: float) -> np.ndarray:
    """Apply a zero-phase fourth-order Butterworth low-pass at `cut` [Hz] to `values`, (n,).

    Raises
    ------
    CaseError : a cut-off that is not between zero and half of `rate` [Hz], or fewer than `FEWEST_FILTERED`
        samples
    """
    from scipy.signal import butter, sosfiltfilt

    if len(values) < FEWEST_FILTERED:
        what = f"needs {FEWEST_FILTERED} samples, got {len(values)}"
        raise CaseError(Fault("--filter", what, "Take a longer record, or leave it out"))

    if not 0.0 < cut < 0.5 * rate:
        raise CaseError(
            Fault(
                "--filter",
                f"must lie between 0 and {0.5 * rate:g} Hz, half the rate, got {cut:g} Hz",
                "Lower it",
            )
        )
    return sosfiltfilt(butter(ORDER, cut, fs=rate, output="sos"), values)


def comparison_lines(rows: list[Compared]) -> list[str]:
    """Return the comparison as a table."""
    width = max(len(row.label) for row in rows)
    lines = [
        f"{'quantity':{width}}  {'run':>11} {'measured':>11} {'error':>8}  {'run r.m.s.':>11} "
        f"{'measured':>11}"
    ]
    for row in rows:
        error = f"{100.0 * row.error:+.1f} %" if math.isfinite(row.error) else "-"
        numbers = f"{row.run:11.4g} {row.test:11.4g} {error:>8}  {row.run_rms:11.4g} {row.test_rms:11.4g}"
        lines.append(f"{row.label:{width}}  {numbers}")
    return lines


def _label(run: Result, name: str) -> str:
    field = run.field(name)
    return f"{field.label} ({field.unit})"
