"""What every analysis begins with: the result of a mill, its case, and vectors among its series."""

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import numpy as np

from nutamill.base.errors import CaseError, Fault
from nutamill.case import Case, Machine, case_of_text
from nutamill.result import Result

CASES_IN_MEMORY = 32
"""Cases of results that stay in memory [1]."""


def any_case_of(result: Result) -> Case | Machine:
    """Return the case of a run, of a mill or of a mechanism. It is parsed once.

    Raises
    ------
    CaseError : measured data, or a case that this version cannot read
    """
    return _parsed(result.case_text)


def drawing_of(result: Result) -> Case | None:
    """Return the drawing of the mill that a result is a run of. None for a machine given part by part and for
    measured data.
    """
    return any_case_of(result).drawing if result.case_text else None


def case_of(result: Result) -> Case:
    """Return the case of a run of a mill. It is parsed once.

    Raises
    ------
    CaseError : measured data, the run of a mechanism, or a case that this version cannot read
    """
    case = any_case_of(result).drawing
    if case is None:
        raise CaseError(
            Fault(
                str(result.path),
                "is the run of a mechanism, not of a mill",
                "nutamill show prints its loads",
            )
        )
    return case


@lru_cache(maxsize=CASES_IN_MEMORY)
def _parsed(text: str) -> Case | Machine:
    return case_of_text(text)


def machine_of(result: Result) -> Machine:
    """Return the machine of a run, of a mill as drawn the one that its drawing describes. It is made once.

    Raises
    ------
    CaseError : measured data, or a case that this version cannot read
    """
    return any_case_of(result).machine


def vector(series: Mapping[Any, Any], name: str) -> np.ndarray:
    """Return the three components of a vector among series by name, (n, 3)."""
    return np.column_stack([np.asarray(series[f"{name}_{axis}"]) for axis in "xyz"])
