"""``python -m nutamill`` is the command ``nutamill``."""

from nutamill.cli import app

app()
