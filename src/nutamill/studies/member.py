"""What a worker does: settle one bed, or run, resume or leave one member of a campaign.

As a program it takes one task after another from its standard input, answers each with a line, and stops,
saved, when the input is closed: a campaign that dies takes its workers with it.
"""

import os
import signal
import sys
from pathlib import Path
from typing import Literal, NamedTuple

from nutamill.base.child import tasks_of_parent
from nutamill.base.errors import ExitCode, MillError, NotSteadyError
from nutamill.case import case_of_text
from nutamill.result import is_finished, open_result, state_of
from nutamill.simulation.runs import resume, run
from nutamill.simulation.setup.bed import settled_bed

DONE = "done"
"""What a worker answers when a task is done."""


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
        (resume(file) if holds_checkpoint(file) else run(case, file)).close()
    except NotSteadyError:
        return


def holds_checkpoint(file: Path) -> bool:
    """Return whether there is a result file with a state to resume from."""
    if not file.exists():
        return False
    with open_result(file) as result:
        return result.has_checkpoint


def main() -> None:
    """Do the tasks of the parent one after another and answer `DONE` to each. Exit with the code of the
    first fault.
    """
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # whatever prints does not answer
    code = ExitCode.DONE
    try:
        for task in tasks_of_parent(when_alone=lambda: os.kill(os.getpid(), signal.SIGTERM)):
            perform(Task._make(task))
            print(DONE, file=answers, flush=True)
    except MillError as error:
        print(error, file=sys.stderr)
        code = error.exit_code
    except KeyboardInterrupt:
        code = ExitCode.INTERRUPTED
    except BrokenPipeError:
        pass  # nobody waits for the answer
    sys.stderr.flush()
    os._exit(code)  # the thread that waits for the end of the input must not keep the process
