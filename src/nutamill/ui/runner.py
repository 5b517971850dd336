"""What a child of the page does: it runs one case and reports its progress, a line of JSON each.

It stops, saved, when the page ends or asks for it.
"""

import json
import math
import os
import signal
import sys
from pathlib import Path
from typing import NamedTuple

from nutamill.base.child import task_of_parent
from nutamill.base.errors import ExitCode, MillError
from nutamill.case import case_of_text
from nutamill.result import is_finished, state_of
from nutamill.simulation.progress_report import Progress
from nutamill.simulation.runs import resume, run
from nutamill.studies.member import holds_checkpoint

PROGRAM = "from nutamill.ui.runner import main; main()"
"""Source text of the child."""


class RunTask(NamedTuple):
    """One run, in words that travel."""

    case_text: str
    """The case (TOML)."""
    name: str
    """Its short name."""
    path: str
    """Its result file, of which the name holds the digest of the case."""
    again: bool
    """Whether a finished result is made anew."""


def perform(task: RunTask) -> None:
    """Run a case, or continue one that was stopped. A finished one is left as it is, unless it is asked for
    again. The errors are those of `run` and `resume`.
    """
    file = Path(task.path)
    if not task.again and not is_finished(state_of(file)) and holds_checkpoint(file):
        resume(file, progress=_report, log=_message).close()
    else:
        case = case_of_text(task.case_text, task.name)
        run(case, file, progress=_report, log=_message, again=task.again).close()


def _report(progress: Progress) -> None:
    known = {key: value for key, value in progress._asdict().items() if _finite(value)}
    print(json.dumps({"progress": known}), flush=True)


def _finite(value: object) -> bool:
    return not isinstance(value, float) or math.isfinite(value)


def _message(text: str) -> None:
    print(json.dumps({"message": text}), flush=True)


def main() -> None:
    """Take a task from standard input, perform it, and exit with the code of its fault."""
    task = RunTask(*task_of_parent(when_alone=lambda: os.kill(os.getpid(), signal.SIGTERM)))
    try:
        perform(task)
        code = ExitCode.DONE
    except MillError as error:
        _message(str(error))
        code = error.exit_code
    except KeyboardInterrupt:
        code = ExitCode.INTERRUPTED
    sys.stdout.flush()
    os._exit(code)  # the thread that waits for the end of the input must not keep the process
