"""What a worker does: settle one bed, or run, resume or leave one member of a campaign.

As a program it takes its task from one line of its standard input, and stops, saved, when that is closed: a
campaign that dies takes its workers with it.
"""

import os
import signal
import sys
from pathlib import Path
from typing import Literal, NamedTuple

from nutamill.base.child import task_of_parent
from nutamill.base.errors import ExitCode, MillError, NotSteadyError
from nutamill.case import case_of_text
from nutamill.result import is_finished, open_result, state_of
from nutamill.simulation.march import resume, run
from nutamill.simulation.setup.bed import settled_bed


class Task(NamedTuple):
    """One piece of work, in words that travel."""

    work: Literal["settle", "run"]
    """Settle the bed of the case into the cache, or run it."""
    case_text: str
    """The case (TOML)."""
    name: str
    """Its short name."""
    path: str
    """Its result file."""


def perform(task: Task) -> None:
    """Do a task in this process.

    A run that was finished is left as it is, one that was begun goes on from its last checkpoint, one that
    was killed before its first checkpoint begins anew.

    Raises
    ------
    MillError, KeyboardInterrupt : as `run` and `resume` do; a run that is not steady at its longest time is
        finished all the same
    """
    case, file = case_of_text(task.case_text, task.name), Path(task.path)
    if task.work == "settle":
        settled_bed(case.machine)
        return
    if is_finished(state_of(file)):
        return
    try:
        (resume(file) if _holds_checkpoint(file) else run(case, file)).close()
    except NotSteadyError:
        return


def _holds_checkpoint(file: Path) -> bool:
    if not file.exists():
        return False
    with open_result(file) as result:
        return result.has_checkpoint


def main() -> None:
    """Take a task from standard input, perform it, and exit with the code of its fault."""
    task = Task._make(task_of_parent(when_alone=lambda: os.kill(os.getpid(), signal.SIGTERM)))
    try:
        perform(task)
        code = ExitCode.DONE
    except MillError as error:
        print(error, file=sys.stderr)
        code = error.exit_code
    except KeyboardInterrupt:
        code = ExitCode.INTERRUPTED
    sys.stderr.flush()
    os._exit(code)  # the thread that waits for the end of the input must not keep the process
