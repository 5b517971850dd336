"""The exceptions, and the one way to word them.

Wording, always: *where: what must hold, got what. What to do.*  A case reports all its faults at once.
Exit codes of the command line: 0 ok, 1 the run failed, 2 bad input, 3 not steady, 130 interrupted.
"""

from typing import NamedTuple


class Fault(NamedTuple):
    """One thing that is wrong with an input."""

    where: str
    """File, line and key, as ``mymill.toml:14: chamber.ribs``; or a part of the machine."""
    what: str
    """What must hold, and what was given."""
    hint: str = ""
    """What to write instead."""

    def __str__(self) -> str:
        return f"{self.where}: {self.what}" + (f". {self.hint}" if self.hint else "")


def reason(error: Exception) -> str:
    """Why a file could not be read, in the system's words without its number and the name, which the message has already."""
    return getattr(error, "strerror", None) or str(error)


class MillError(Exception):
    """Base of everything this package raises on purpose."""

    exit_code = 1


class CaseError(MillError, ValueError):
    """Bad input; carries every fault found, so that a user mends a file once and not ten times."""

    exit_code = 2

    def __init__(self, *faults: Fault):
        self.faults = tuple(faults)
        super().__init__("\n".join(str(fault) for fault in faults))


class StepError(MillError, RuntimeError):
    """A run that cannot go on: blow-up, overlap beyond its limit, constraint that cannot be met."""


class NotSteadyError(MillError, RuntimeError):
    """A run that should have ended when it was steady, and never was; its file is whole and can be continued."""

    exit_code = 3


class ResultError(MillError, OSError):
    """A result file that cannot be written, read or continued."""
