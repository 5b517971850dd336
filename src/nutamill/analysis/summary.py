"""Sentences on a run: whether it is steady, its means, where its power goes, and what to look at."""

import math
from collections.abc import Mapping

from nutamill.analysis.mechanism import mechanism_summary_lines, mechanism_warning_lines
from nutamill.analysis.power import LEDGER_LIMIT, power_split
from nutamill.analysis.source import any_case_of
from nutamill.analysis.windows import SteadyPart, steady_mean, steady_part, steady_window
from nutamill.base.errors import ResultError
from nutamill.base.steady import FEWEST_TURNS, Estimate
from nutamill.result import Result

CERTAIN = 1e-4
"""Share of a mean below which its half width is not shown [1]."""
LONGEST = 1e7
"""Life [h] beyond which only a limit is printed: more than a thousand years."""


CRANK = ("crank_pin_force_resultant", "driveshaft_torque", "driveshaft_power")
"""Series of a crank that drives a vessel."""


def has_crank(result: Result) -> bool:
    """Return whether a result holds the force and the torque of a crank."""
    return all(name in result.series for name in CRANK[:2])


def summary_lines(result: Result) -> list[str]:
    """Return the lines at the end of a run. Of a crank they are steadiness, steady force, torque and power,
    and the power split, of any other machine the loads of its parts.
    """
    return _crank_lines(result) if has_crank(result) else mechanism_summary_lines(result)


def _crank_lines(result: Result) -> list[str]:
    """Return the lines at the end of the run of a crank."""
    names = list(CRANK)
    try:
        window = steady_window(result)
        power = power_split(result)
    except ResultError:
        return [
            f"no steady means: the run has not made a whole turn at its last speed (state: {result.state})"
        ]
    force, torque, drawn = (steady_mean(result, name) for name in names)
    try:
        part = steady_part(result, names)
    except ResultError:
        lines = [
            f"{too_few_turns(force.turns)}; their plain mean:",
            f"crank-pin force {force.mean:.4g} N   shaft torque {torque.mean:.4g} N m   power "
            f"{drawn.mean:.0f} W",
        ]
    else:
        count = len(window.turns) - 1
        lines = [
            steady_line(result, part),
            f"crank-pin force {with_interval(force)} N   shaft torque {with_interval(torque)} N m   "
            f"power {drawn.mean:.0f} W",
            f"last {window.end - window.start:.3g} s ({count} whole turn{'s' if count > 1 else ''}), plain "
            f"mean: {force.plain_mean:.4g} N, {torque.plain_mean:.4g} N m",
        ]
    if power.motor:
        lines.append(
            f"where the power goes: {_shares(power.sinks, power.motor)}  | closes to "
            f"{100.0 * abs(power.residual / power.motor):.2f} %"
        )
    return lines


def too_few_turns(count: int) -> str:
    """Return the sentence on a run with too few turns at its last speed for a test of steadiness."""
    return f"too few turns at the last speed for a test of steadiness: {count}, needs {FEWEST_TURNS}"


def steady_line(result: Result, part: SteadyPart) -> str:
    """Return whether a run is steady and since when, or what drifts by how much."""
    turns = len(part.turns) - 1
    if not part.drifting:
        used = min(estimate.turns for estimate in part.means.values())
        return (
            f"steady since t = {part.start:.2f} s (stationarity test), {used} of {turns} turns at this "
            "speed used"
        )
    shares = {
        name: part.means[name].drift / part.means[name].mean / part.means[name].turns
        for name in part.drifting
    }
    labels = {
        name: result.field(name).label if name in result.series else name.replace("_", " ")
        for name in part.drifting
    }
    drifts = ", ".join(f"{labels[name]} {100.0 * share:+.2g} %" for name, share in shares.items())
    return f"not steady after {turns} turns at this speed; drift per turn: {drifts}"


def warning_lines(result: Result) -> list[str]:
    """Return warnings on a run: overlaps beyond the case's `overlap_warn`, a ledger that does not close."""
    case, series = any_case_of(result), result.series
    lines = []
    if "largest_pair_overlap" in series and series.sizes["time"]:
        for kind, wall in (("pair", False), ("wall", True)):
            pairs = [case.contact.pair(a, b) for a, b, walled in case.touching if walled == wall]
            limit = max(pair.overlap_warn for pair in pairs)
            largest = float(series[f"largest_{kind}_overlap"].max())
            if largest > limit:
                lines.append(
                    f"warning: largest {kind} overlap {100 * largest:.1f} % of the diameter, beyond "
                    f"overlap_warn = {100 * limit:.0f} %."
                    " Stiffer contacts would be nearer to the solids"
                )
    if not has_crank(result):
        return lines + mechanism_warning_lines(result)
    try:
        power = power_split(result)
    except ResultError:
        return lines
    if power.motor and abs(power.residual / power.motor) > LEDGER_LIMIT:
        lines.append(
            f"warning: the ledger leaves {100 * abs(power.residual / power.motor):.2f} % of the "
            "motor's power open"
            f" (limit {100 * LEDGER_LIMIT:.1f} %). Halve run.dt or run.window"
        )
    return lines


def with_interval(estimate: Estimate) -> str:
    """Format a mean with its interval as ``981 ± 6``, rounded to two digits of the interval or fewer."""
    if not estimate.half_width > CERTAIN * abs(estimate.mean):  # not known, or finer than anyone reads
        return f"{estimate.mean:.4g}"
    digits = max(0, 1 - math.floor(math.log10(estimate.half_width)) - (estimate.half_width >= 1.0))
    form = f".{digits}f" if digits < 7 else ".1e"
    return f"{estimate.mean:{form}} ± {estimate.half_width:{form}}"


def hours_text(time: float) -> str:
    """Format a life [s] in hours, 11 wide. Longer than `LONGEST` prints as ``> 1e+07``."""
    hours = time / 3600
    return f"{hours:11.4g}" if hours <= LONGEST else f"{f'> {LONGEST:.0e}':>11}"


def _shares(sinks: Mapping[str, float], motor: float) -> str:
    """Format shares as ``pellet-pellet 61 %  pellet-wall 27 % ...``, largest first."""
    largest_first = sorted(sinks.items(), key=lambda sink: -abs(sink[1]))
    return "  ".join(f"{group} {100.0 * power / motor:z.0f} %" for group, power in largest_first)
