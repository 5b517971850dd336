"""Start Python processes that work for this one and end with it.

A child never looks for modules in the working folder: a ``numpy.py`` beside a case would run in place of
NumPy.  It reads one line from its standard input, which then stays open as long as its parent lives.
"""

import json
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

ROOT = str(Path(__file__).parents[2])
"""Folder that this package is imported from; last on a child's path, in case the child would not find it
otherwise.
"""

DISCARD = subprocess.DEVNULL


def start_child(
    program: str, task: object, stdout: int = DISCARD, stderr: int = DISCARD
) -> subprocess.Popen[str]:
    """Start a Python process.

    Parameters
    ----------
    program : its source text, which may call `task_of_parent`
    task : what `task_of_parent` returns there: JSON data
    stdout, stderr : as for `subprocess.Popen`
    """
    whole = f"import sys; sys.path.append({ROOT!r}); {program}"
    # a session of its own: an interrupt at the terminal reaches the parent alone, which decides what becomes
    # of its children
    process = subprocess.Popen(
        [sys.executable, "-P", "-c", whole],
        stdin=subprocess.PIPE,
        text=True,
        encoding="utf-8",
        start_new_session=True,
        stdout=stdout,
        stderr=stderr,
    )
    assert process.stdin is not None  # a pipe
    try:
        process.stdin.write(json.dumps(task) + "\n")
        process.stdin.flush()
    except BrokenPipeError:
        pass  # it has ended already, with its own exit status
    return process


def task_of_parent(when_alone: Callable[[], None] = lambda: os._exit(1)) -> Any:
    """Return the task that the parent has given, in a child. Call `when_alone` when the parent has ended."""
    task = json.loads(sys.stdin.readline())

    def wait() -> None:
        while os.read(
            0, 1
        ):  # not through sys.stdin, whose lock a waiting thread would hold when the process ends
            pass
        when_alone()

    threading.Thread(target=wait, daemon=True).start()
    return task


@contextmanager
def ended(*processes: subprocess.Popen) -> Iterator[None]:
    """Kill what is left of these processes at the end of the block, however it ends."""
    try:
        yield
    finally:
        for process in processes:
            process.kill()
            process.wait()
            if process.stdin is not None:
                process.stdin.close()
