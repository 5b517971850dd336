"""Single keys of a terminal, while a run draws its screen; each becomes the signal that asks the same of the run."""

import contextlib
import os
import signal
import sys
from collections.abc import Iterator

CHECKPOINT = getattr(signal, "SIGUSR1", None)
"""Signal that asks a run to keep a checkpoint now; a system without it has none."""
MEANS = {"q": signal.SIGINT, **({"c": CHECKPOINT} if CHECKPOINT is not None else {})}
"""What each key asks: to stop and save, to keep a checkpoint."""


@contextlib.contextmanager
def single_keys() -> Iterator[bool]:
    """Deliver keys at once and unseen; tells whether that can be had (a terminal, on a system with termios)."""
    try:
        import termios
        import tty

        if not sys.stdin.isatty():
            raise OSError("no terminal")
        before = termios.tcgetattr(sys.stdin)
    except (ImportError, OSError, ValueError):
        yield False
        return
    tty.setcbreak(sys.stdin)
    try:
        yield True
    finally:
        termios.tcsetattr(sys.stdin, termios.TCSADRAIN, before)


def obey_keys() -> None:
    """Raise the signal of every key typed since the last call."""
    import select

    while select.select([sys.stdin], [], [], 0.0)[0]:
        typed = os.read(sys.stdin.fileno(), 1).decode(errors="ignore")
        if not typed:
            return
        if typed in MEANS:
            signal.raise_signal(MEANS[typed])
