"""Signals as requests to a run: to stop and save, and to save a checkpoint and go on.

A system has some of the signals only: Windows has neither SIGHUP nor SIGUSR1.
"""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple


class Requests(NamedTuple):
    """What is asked of a march from outside; it looks between two entries of the compiled march."""

    stop: threading.Event
    """Stop, and save: an interrupt, a request to end, or a terminal that is closed."""
    checkpoint: threading.Event
    """Save a checkpoint now, and go on."""

    def take_checkpoint(self) -> bool:
        """Return whether a checkpoint was asked for since the last call."""
        asked = self.checkpoint.is_set()
        self.checkpoint.clear()
        return asked


def checkpoint_signal() -> signal.Signals | None:
    """Return the signal that asks a run to save a checkpoint now: SIGUSR1, or None on a system without it."""
    return getattr(signal, "SIGUSR1", None)


def stop_signals() -> list[signal.Signals]:
    """Return the signals that ask a run to stop: SIGINT, SIGTERM, and SIGHUP where there is one that `nohup`
    has not switched off.
    """
    hang_up = getattr(signal, "SIGHUP", None)
    if hang_up is None or signal.getsignal(hang_up) is signal.SIG_IGN:
        return [signal.SIGINT, signal.SIGTERM]
    return [signal.SIGINT, signal.SIGTERM, hang_up]


@contextmanager
def requests() -> Iterator[Requests]:
    """Turn signals into requests, which a march meets between two steps. In a thread that is not the main one
    there are never any.
    """
    asked = Requests(threading.Event(), threading.Event())
    with _handled(asked.stop.set, asked.checkpoint.set):
        yield asked


@contextmanager
def stop_at_once() -> Iterator[None]:
    """Raise KeyboardInterrupt at a request to stop, and ignore one for a checkpoint: as long as there is
    nothing to save.

    It is entered before the first signal can come.  Without it the system ends the process at a request for a
    checkpoint.
    """

    def stop() -> None:
        raise KeyboardInterrupt

    with _handled(stop, lambda: None):
        yield


@contextmanager
def _handled(stop: Callable[[], None], checkpoint: Callable[[], None]) -> Iterator[None]:
    """Call these at the signals. The previous handlers are restored afterwards."""
    if (
        threading.current_thread() is not threading.main_thread()
    ):  # Python handles signals in the main thread only
        yield
        return
    answers: dict[signal.Signals, Callable[[], None]] = dict.fromkeys(stop_signals(), stop)
    if (asks := checkpoint_signal()) is not None:
        answers[asks] = checkpoint
    before: dict[signal.Signals, Any] = {}
    try:
        for number, answer in answers.items():
            before[number] = signal.signal(number, lambda *_, answer=answer: answer())
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler if handler is not None else signal.SIG_DFL)
