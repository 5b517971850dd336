"""What became of one hostile input."""

import time
import traceback
import warnings
from collections.abc import Callable
from typing import Any, NamedTuple

from nutamill.base.errors import MillError

SLOW = 2.0
"""Time after which an answer has come too late [s]."""
KINDS = ("accepted", "refused", "slow", "warned", "garbled", "failed")
"""Outcomes; the first two are good ones."""


class Outcome(NamedTuple):
    """The answer of the program to one input."""

    kind: str
    """One of `KINDS`."""
    detail: str = ""
    """The message of a refusal, or what went wrong."""

    @property
    def good(self) -> bool:
        """Whether the input was used, or refused in words and in time."""
        return self.kind in KINDS[:2]


def outcome(act: Callable[[], Any], longest: float = SLOW) -> Outcome:
    """Return what becomes of an input.

    A good outcome takes no longer than `longest` [s] of processor time, gives no warning of a library, and
    words a refusal in printable text.

    Parameters
    ----------
    act : reads the input; an error that the package raises on purpose is a refusal
    """
    began = time.process_time()
    try:
        with warnings.catch_warnings(record=True) as given:
            warnings.simplefilter("always")
            act()
    except MillError as error:
        found = Outcome("refused", str(error))
    except Exception as error:
        last = traceback.extract_tb(error.__traceback__)[-1]
        where = f"{last.filename.rpartition('nutamill/')[2]}:{last.lineno}"
        return Outcome("failed", f"{type(error).__name__} in {where}: {error}"[:300])
    else:
        found = Outcome("accepted")
    if given:
        return Outcome("warned", str(given[0].message)[:300])
    if not found.detail.replace("\n", "").replace("\t", "").isprintable():
        return Outcome("garbled", found.detail[:300])
    spent = time.process_time() - began
    return Outcome("slow", f"{spent:.1f} s") if spent > longest else found
