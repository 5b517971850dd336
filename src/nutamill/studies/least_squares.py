"""Least squares with bounds: values of free keys that meet measured values best, and how well they are then
known.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from nutamill.base.errors import CaseError, Fault

STEPS = 30
"""Evaluations after which a fit is given up [1]."""
CLOSE = 1e-3
"""Relative change of the parameters or of the sum of squares below which a fit has converged [1]."""

Compute = Callable[[np.ndarray], np.ndarray]
"""Computed values (n_points, n_targets) at parameter points (n_points, n_free), in SI."""


class Free(NamedTuple):
    """A key that is fitted."""

    key: str
    """Dotted key of the case."""
    start: float
    """First guess, SI."""
    low: float
    """Lower bound, SI."""
    high: float
    """Upper bound, SI."""
    step: float = 0.01
    """Difference for its influence, share of the range [1]."""


class Fitted(NamedTuple):
    """Result of a fit."""

    values: np.ndarray
    """Values of the free keys, (n_free,), SI."""
    uncertainty: np.ndarray
    """Their standard uncertainties, (n_free,), SI."""
    correlation: np.ndarray
    """Their correlation matrix, (n_free, n_free)."""
    computed: np.ndarray
    """What the model gives with them, (n_targets,), SI."""
    residual: np.ndarray
    """Computed less measured, in standard uncertainties of the measurement, (n_targets,)."""
    chi_squared: float
    """Sum of squared residuals [1]."""
    freedom: int
    """Targets less free keys [1]."""
    at_bound: np.ndarray
    """Which of the values are on a bound, (n_free,); their uncertainty means little."""
    converged: bool
    """Whether the search ended by itself."""
    evaluations: int
    """Points at which the model and its derivatives were computed [1]."""


def fitted(free: Sequence[Free], measured: np.ndarray, sigma: np.ndarray, compute: Compute) -> Fitted:
    """Minimise the sum of squared residuals over the free keys within their bounds.

    Derivatives are one-sided differences.  Each point is computed together with its differences in one call,
    so that all of them can run at the same time.  The covariance is that of the linearised problem,
    `inv(J^T J)` with J in standard uncertainties; where the residuals are larger than these explain,
    uncertainties are multiplied by the root of chi squared per degree of freedom.

    Parameters
    ----------
    free : keys, first guesses and bounds
    measured, sigma : measured values and their standard uncertainties, (n_targets,), SI
    compute : the model

    Raises
    ------
    CaseError : fewer targets than free keys, a first guess out of bounds, or keys that the targets cannot
        separate

    Source
    ------
    M. A. Branch, T. F. Coleman, Y. Li, SIAM J. Sci. Comput. 21(1), 1-23, 1999 (the search, as in SciPy);
    R. T. Birge, Phys. Rev. 40, 207-227, 1932 (the ratio)
    """
    _refuse(free, measured, sigma)
    low, high = (np.array([getattr(one, name) for one in free]) for name in ("low", "high"))
    span = high - low
    known: dict[bytes, tuple[np.ndarray, np.ndarray]] = {}

    def at(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return computed values and their derivatives with respect to x."""
        if x.tobytes() not in known:
            steps = np.array([one.step for one in free]) * span
            steps = np.where(x + steps > high, -steps, steps)
            values = compute(np.vstack([x, x + np.diag(steps)]))
            known[x.tobytes()] = values[0], ((values[1:] - values[0]) / steps[:, None]).T
        return known[x.tobytes()]

    solution = least_squares(
        lambda x: (at(x)[0] - measured) / sigma,
        np.array([one.start for one in free]),
        jac=lambda x: at(x)[1] / sigma[:, None],
        bounds=(low, high),
        x_scale=span,
        xtol=CLOSE,
        ftol=CLOSE,
        gtol=None,
        max_nfev=STEPS,
    )
    scaled = solution.jac * span
    _refuse_blind(free, scaled)
    freedom = len(measured) - len(free)
    chi_squared = float(solution.fun @ solution.fun)
    covariance = np.linalg.inv(scaled.T @ scaled) * max(1.0, chi_squared / freedom if freedom else 1.0)
    deviation = np.sqrt(np.diag(covariance))
    return Fitted(
        values=solution.x,
        uncertainty=deviation * span,
        correlation=covariance / np.outer(deviation, deviation),
        computed=at(solution.x)[0],
        residual=solution.fun,
        chi_squared=chi_squared,
        freedom=freedom,
        at_bound=np.minimum(solution.x - low, high - solution.x) < 1e-6 * span,
        converged=solution.status > 0,
        evaluations=len(known),
    )


def _refuse(free: Sequence[Free], measured: np.ndarray, sigma: np.ndarray) -> None:
    """Raise what makes a fit impossible before it is begun."""
    faults = [
        Fault(
            f"free {one.key}",
            f"must have low < start < high, got {one.low:g}, {one.start:g}, {one.high:g} (SI)",
        )
        for one in free
        if not one.low < one.start < one.high
    ]
    if len(measured) < len(free):
        faults.append(
            Fault(
                "target",
                f"there must be as many targets as free keys or more, got {len(measured)} for {len(free)}",
                "Fix some keys",
            )
        )
    faults += [
        Fault(f"target {k + 1}", f"must have an uncertainty above zero, got {u:g}")
        for k, u in enumerate(sigma)
        if not u > 0.0
    ]
    if faults:
        raise CaseError(*faults)


def _refuse_blind(free: Sequence[Free], scaled: np.ndarray) -> None:
    """Raise where the targets say nothing about a key, or only about several together. `scaled` is the
    Jacobian over the ranges.
    """
    size = np.linalg.norm(scaled, axis=0)
    blind = [
        one.key for one, length in zip(free, size, strict=True) if not length > 1e-9 * max(size.max(), 1e-300)
    ]
    if blind:
        raise CaseError(
            *(
                Fault(f"free {key}", "no target depends on it", "Fix it, or add a target that does")
                for key in blind
            )
        )
    _, singular, right = np.linalg.svd(scaled / size)
    if singular[-1] < 1e-8 * singular[0]:
        together = ", ".join(one.key for one, share in zip(free, right[-1], strict=True) if abs(share) > 0.1)
        raise CaseError(
            Fault("free", f"the targets cannot separate: {together}", "Fix one of them, or add targets")
        )
