"""The exceptions, the one way to word them, and the exit code of each kind.

Wording, always: *where: what is wrong, got what. What to do.*  A case reports all its faults at once.
"""

import re
from enum import IntEnum
from pathlib import Path
from typing import NamedTuple

_UNSHOWABLE = re.compile(
    r"[\x00-\x08\x0a-\x1f\x7f-\x9f\xad\u200b\u200e\u200f\u2028-\u202e\u2060-\u2064\u2066-\u206f\ufeff\ud800-\udfff]"
)
"""Control characters but the tab, line ends, marks that turn the writing or are not seen, half characters."""


def printable(text: str) -> str:
    """Return text of a user as one line that a terminal shows and does not obey: control characters are
    escaped.
    """
    return _UNSHOWABLE.sub(lambda match: match[0].encode("unicode_escape").decode(), text)


class ExitCode(IntEnum):
    """What every command returns to the shell: one code for each kind of outcome, and its meaning for the
    documentation.
    """

    meaning: str

    def __new__(cls, code: int, meaning: str) -> "ExitCode":
        """Make the member of a code and its meaning."""
        member = int.__new__(cls, code)
        member._value_ = code
        member.meaning = meaning
        return member

    DONE = 0, "Everything that was asked for is done."
    FAILED = 1, "A run could not go on, or a campaign has runs that did not finish."
    BAD_INPUT = 2, "The words typed, or a file they name, are not what the command takes."
    NOT_STEADY = 3, "A run that should end when steady reached its longest time; its file is whole."
    NOT_WRITTEN = 4, "A file could not be written: no permission, no such place, or no room."
    NOT_INSTALLED = 5, "An optional package, or a library of the system, is missing."
    INTERRUPTED = 130, "The user interrupted the command."


class Fault(NamedTuple):
    """One thing that is wrong with an input."""

    where: str
    """File, line and key, as ``mymill.toml:14: chamber.ribs``; or a part of the machine."""
    what: str
    """What is wrong, and what was given."""
    hint: str = ""
    """What to write instead."""

    def __str__(self) -> str:
        return printable(f"{self.where}: {self.what}" + (f". {self.hint}" if self.hint else ""))


def reason(error: Exception) -> str:
    """Return why a file could not be read, in the system's words, without the error number and the name."""
    return getattr(error, "strerror", None) or str(error)


class MillError(Exception):
    """Base of everything this package raises on purpose."""

    exit_code = ExitCode.FAILED


class CaseError(MillError, ValueError):
    """Bad input; carries all faults of the input, so that a user corrects a file once and not ten times."""

    exit_code = ExitCode.BAD_INPUT

    def __init__(self, *faults: Fault):
        self.faults = tuple(faults)
        super().__init__("\n".join(str(fault) for fault in faults))


class StepError(MillError, RuntimeError):
    """A run that cannot go on: blow-up, overlap beyond its limit, constraint that cannot be met."""


class NotSteadyError(MillError, RuntimeError):
    """A run that should have ended when it was steady, and never was; its file is whole and can be
    continued.
    """

    exit_code = ExitCode.NOT_STEADY


class Interrupted(KeyboardInterrupt):
    """A run that was asked to stop while it marched, with all it has recorded saved."""

    def __init__(self, path: Path):
        self.path = path
        """The result file, from which it can be resumed."""
        super().__init__(f"interrupted, saved in {path}")


class ResultError(MillError, OSError):
    """A result file that cannot be read or continued, or that does not hold what was asked of it."""

    exit_code = ExitCode.BAD_INPUT


class DamagedError(MillError, RuntimeError):
    """A result file of which a part is not as it was written: nothing of that part is used."""

    exit_code = ExitCode.BAD_INPUT

    def __init__(self, file: object, where: str, how: str):
        self.fault = f"{where}: {how}"
        """The damaged part and what is wrong with it, without the name of the file."""
        super().__init__(f"{file}: {where} is damaged: {how}. `nutamill verify {file}` lists what is whole.")


class OutputError(ResultError):
    """A file that cannot be written."""

    exit_code = ExitCode.NOT_WRITTEN


class NotInstalledError(MillError):
    """An optional package, or a library of the system, that is missing."""

    exit_code = ExitCode.NOT_INSTALLED


def missing_extra(what: str, package: str, extra: str) -> NotInstalledError:
    """Return the error for a `package` that only `what` needs, with the command that installs its `extra`."""
    return NotInstalledError(
        f"{what} needs {package}, which is not installed. Type in your clone of the nutamill "
        f'repository: pip install ".[{extra}]"'
    )
