"""Single keys of a terminal, while a run draws its screen; each becomes the signal that asks the same of the
run.
"""

import contextlib
import os
import signal
import sys
from collections.abc import Collection, Iterator

from nutamill.simulation.signals import checkpoint_signal


def key_signals() -> dict[str, signal.Signals]:
    """Return the signal of each key: ``q`` stops, ``c`` saves a checkpoint where the system has a signal for
    that.
    """
    asks = checkpoint_signal()
    return {"q": signal.SIGINT} | ({} if asks is None else {"c": asks})


@contextlib.contextmanager
def single_keys() -> Iterator[bool]:
    """Deliver keys at once and unseen, and yield whether that is possible (a terminal, on a system with
    termios).
    """
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
        with contextlib.suppress(termios.error):  # a terminal that is gone
            termios.tcsetattr(sys.stdin, termios.TCSADRAIN, before)


def typed_keys() -> str:
    """Return the keys typed since the last call."""
    import select

    typed = b""
    with contextlib.suppress(OSError):  # a terminal that is gone
        while select.select([sys.stdin], [], [], 0.0)[0]:
            key = os.read(sys.stdin.fileno(), 1)
            if not key:
                break
            typed += key
    return typed.decode(errors="ignore")


def obey_key(key: str, offered: Collection[str]) -> bool:
    """Raise the signal of `key` if it is one of those that are `offered`, and return whether it is."""
    asks = key_signals().get(key) if key in offered else None
    if asks is None:
        return False
    signal.raise_signal(asks)
    return True
