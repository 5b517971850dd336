"""Start Python processes that work for this one and end with it.

A child never looks for modules in the working folder: a ``numpy.py`` beside a case would run in place of
NumPy.  It reads a task from one line of its standard input, which then stays open as long as its parent
lives, and may bring more tasks.
"""

import contextlib
import json
import os
import queue
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

ROOT = str(Path(__file__).parents[2])
"""Folder that this package is imported from; last on a child's path, in case the child would not find it
otherwise.
"""

DISCARD = subprocess.DEVNULL
NO_MORE = object()
"""Stands for the end of the tasks."""


def start_child(
    program: str, task: object, stdout: int = DISCARD, stderr: int | IO[bytes] = DISCARD
) -> subprocess.Popen[str]:
    """Start a Python process.

    Parameters
    ----------
    program : its source text, which may call `task_of_parent` or `tasks_of_parent`
    task : what these return there: JSON data
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
    with contextlib.suppress(BrokenPipeError):  # it has ended already, with its own exit status
        give_task(process, task)
    return process


def give_task(process: subprocess.Popen[str], task: object) -> None:
    """Give a child its next task.

    Raises
    ------
    BrokenPipeError : it has ended
    """
    assert process.stdin is not None  # a pipe
    process.stdin.write(json.dumps(task) + "\n")
    process.stdin.flush()


def task_of_parent(when_alone: Callable[[], None] = lambda: os._exit(1)) -> Any:
    """Return the task that the parent has given, in a child. Call `when_alone` when the parent has ended."""
    return next(tasks_of_parent(when_alone))


def tasks_of_parent(when_alone: Callable[[], None]) -> Iterator[Any]:
    """Yield the tasks that the parent gives, one on each line, until it closes the input of this child. Call
    `when_alone` if it does so, or ends, while a task is under way.
    """
    tasks: queue.SimpleQueue[Any] = queue.SimpleQueue()
    busy = threading.Event()

    def listen() -> None:
        begun = b""
        while read := os.read(0, 65536):  # not through sys.stdin: this thread would hold its lock at the end
            *lines, begun = (begun + read).split(b"\n")
            for line in lines:
                tasks.put(json.loads(line))
        tasks.put(NO_MORE)
        if busy.is_set():
            when_alone()

    threading.Thread(target=listen, daemon=True).start()
    while (task := tasks.get()) is not NO_MORE:
        busy.set()
        yield task
        busy.clear()


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
