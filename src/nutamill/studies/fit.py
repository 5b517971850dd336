"""`fit`: identify keys of a case from measured values, through the same runs and modes a user would make by
hand.
"""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from nutamill.analysis.values import Reading
from nutamill.base.errors import CaseError, Fault, StepError
from nutamill.base.notebook_hook import notebook_html
from nutamill.base.schema import spelled
from nutamill.case import Case, Machine, load_case
from nutamill.case.toml.keys import held, si_at, unit_at
from nutamill.result import is_finished
from nutamill.studies.axes import Member, changed
from nutamill.studies.campaign_file import case_of, overrides
from nutamill.studies.fit_file import FreeKey, Measured, load_fit, position_of
from nutamill.studies.least_squares import Fitted, Free, fitted
from nutamill.studies.measurand import measurand_of, rest_frequency, si_in, value_in
from nutamill.studies.sweep import Report, run_all
from nutamill.studies.workers import ClusterWorkers, LocalProcesses, Workers

if TYPE_CHECKING:
    import distributed


class Target(NamedTuple):
    """A measured value."""

    what: Reading | str | int
    """What is read from a result, the name of a quantity of the papers, or the number of a mode, counted
    from 1.
    """
    case: Case | Machine
    """The case under which it was measured, with the free keys at their first guess."""
    value: float
    """What was measured, SI."""
    sigma: float
    """Its standard uncertainty, SI."""
    label: str
    """What to call it in a table."""
    unit: str
    """Its SI unit."""


class Fit(NamedTuple):
    """Free keys, targets, and the values that meet them best."""

    free: list[Free]
    """Keys that are fitted."""
    targets: list[Target]
    """What was to be met."""
    best: Fitted
    """Values, uncertainties, residuals."""

    def _repr_html_(self) -> str:
        return notebook_html("campaigns.fit_html", self)

    def lines(self) -> list[str]:
        """Format the fit as text: values, correlation, residuals."""
        best = self.best
        width = max(len(one.key) for one in self.free)
        shown = []
        for one, value, doubt, bound in zip(
            self.free, best.values, best.uncertainty, best.at_bound, strict=True
        ):
            unit = unit_at(one.key)
            mark = "   on its bound" if bound else ""
            shown.append(
                f"{one.key:{width}}  {value:10.5g} ± {doubt:.2g}{'' if unit == '1' else f' {unit}'}{mark}"
            )
        if len(self.free) > 1:
            shown.append("correlation")
            shown += [
                f"{one.key:{width}}  " + " ".join(f"{value:+.3f}" for value in row)
                for one, row in zip(self.free, best.correlation, strict=True)
            ]
        wide = max(len(target.label) for target in self.targets)
        shown.append(f"{'target':{wide}}  {'measured':>20}  {'computed':>10}  residual")
        for target, computed, residual in zip(self.targets, best.computed, best.residual, strict=True):
            measured = f"{target.value:.4g} ± {target.sigma:.2g} {target.unit}"
            shown.append(f"{target.label:{wide}}  {measured:>20}  {computed:10.4g}  {residual:+.2f} u")
        shown.append(
            f"chi squared {best.chi_squared:.3g} with {best.freedom} degrees of freedom, "
            f"{best.evaluations} evaluations" + ("" if best.converged else ": not converged")
        )
        return shown


def fit(
    file: str | Path,
    folder: str | Path | None = None,
    jobs: int | None = None,
    client: "distributed.Client | None" = None,
    report: Report | None = None,
    log: Callable[[str], None] | None = None,
) -> Fit:
    """Find the free keys of a fit file.

    Every run is stored in `folder`, named by its case: a fit that is repeated reads what it has already run.

    Parameters
    ----------
    file : the fit file (TOML)
    folder : for result files; ``fits/<file>`` if None
    jobs, client, report, log : as for `nutamill.studies.sweep.sweep`

    Raises
    ------
    CaseError : every fault of the file, before anything is run; keys that the targets cannot separate
    StepError : a run that did not end well, or gives no steady mean
    """
    free, targets = read_fit(file)
    directory = Path("fits") / Path(file).stem if folder is None else Path(folder)

    def workers() -> Workers:
        return ClusterWorkers(client) if client else LocalProcesses(jobs)

    def compute(points: np.ndarray) -> np.ndarray:
        asked = [{one.key: float(value) for one, value in zip(free, point, strict=True)} for point in points]
        return computed(asked, targets, directory, workers, report, log)

    measured, sigma = (np.array([getattr(target, name) for target in targets]) for name in ("value", "sigma"))
    return Fit(free, targets, fitted(free, measured, sigma, compute))


def read_fit(name: str | Path) -> tuple[list[Free], list[Target]]:
    """Return free keys and targets of a fit file. Raises CaseError with every fault."""
    file, layer = load_fit(name)
    case, fixed = case_of(file, layer)
    faults: list[Fault] = []
    free: list[Free] = []
    targets: list[Target] = []
    base = load_case(case, fixed)
    for key, limits in file.free.items():
        where = position_of(layer, "free", key)
        try:
            free.append(_free(key, limits, base, where))
        except CaseError as error:
            faults += error.faults
    for number, given in enumerate(file.target):
        where = position_of(layer, "target", number)
        try:
            under = changed(
                load_case(case, [*fixed, *overrides(given.set)]), {one.key: one.start for one in free}
            )
            targets.append(_target(given, under, where))
        except CaseError as error:
            faults += error.faults
    if faults:
        raise CaseError(*dict.fromkeys(faults))
    return free, targets


def _free(key: str, given: FreeKey, base: Case | Machine, where: str) -> Free:
    """Return a free key, its guess and bounds in SI."""
    try:
        tried = changed(base, {key: given.start})
    except CaseError as error:
        raise CaseError(*(Fault(where, fault.what, fault.hint) for fault in error.faults)) from None
    start, low, high = (
        si_at(key, getattr(given, name), f"{where}.{name}") for name in ("start", "low", "high")
    )
    if not isinstance(held(tried, key), (int, float)):
        what = f"must be a key of one number, got {spelled(held(tried, key))}"
        raise CaseError(Fault(where, what, "Name a key that holds a number"))
    return Free(key, start, low, high, given.step)


def _target(given: Measured, case: Case | Machine, where: str) -> Target:
    """Return a target, its quantity understood and its numbers in SI."""
    what, named, unit = measurand_of(given.quantity, f"{where}.quantity", case.machine)
    value, sigma = (si_in(unit, getattr(given, name), f"{where}.{name}") for name in ("value", "uncertainty"))
    under = ", ".join(f"{key} = {changes}" for key, changes in given.set.items())
    return Target(what, case, value, sigma, f"{named}{f', {under}' if under else ''}", unit)


def computed(
    points: Sequence[Mapping[str, float]],
    targets: Sequence[Target],
    folder: Path,
    workers: Callable[[], Workers],
    report: Report | None = None,
    log: Callable[[str], None] | None = None,
) -> np.ndarray:
    """Compute each target at each point, (n_points, n_targets), SI, with all runs of all points at the same
    time.
    """
    cases = [[changed(target.case, point).with_("run.threads", 1) for target in targets] for point in points]
    wanted: dict[str, Member] = {}
    for row, point in zip(cases, points, strict=True):
        for case, target in zip(row, targets, strict=True):
            if not isinstance(target.what, int):
                wanted.setdefault(case.digest, Member(_rounded(point) | {"target": target.label}, case))
    readings = tuple(dict.fromkeys(target.what for target in targets if isinstance(target.what, Reading)))
    outcomes = run_all(list(wanted.values()), folder, workers(), readings, report, log) if wanted else []
    by_case = {outcome.member.case.digest: outcome for outcome in outcomes}
    if bad := [outcome for outcome in outcomes if not is_finished(outcome.state)]:
        states = "; ".join(f"{outcome.member.label}: {outcome.state}" for outcome in bad)
        raise StepError(
            f"fit: {len(bad)} of {len(outcomes)} runs did not finish ({states}). Repeat the command: it "
            "reads the finished runs and does the rest."
        )
    values = np.empty((len(points), len(targets)))
    for k, row in enumerate(cases):
        for j, (case, target) in enumerate(zip(row, targets, strict=True)):
            if isinstance(target.what, int):
                values[k, j] = rest_frequency(case, target.what)
            else:
                values[k, j] = value_in(by_case[case.digest], target.what).mean
            if not np.isfinite(values[k, j]):
                raise StepError(
                    f"fit: {target.label} has no steady mean. Run longer "
                    "(run.until), or take another quantity."
                )
    return values


def _rounded(point: Mapping[str, float]) -> dict[str, Any]:
    return {key: f"{value:.6g}" for key, value in point.items()}
