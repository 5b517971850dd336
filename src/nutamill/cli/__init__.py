"""The command line: reads what was typed, calls the package, prints; computes nothing.

Exit codes are those of `nutamill.base.errors.ExitCode`.  Heavy imports stand inside the commands, so that
``--help`` answers at once.
"""

# importing a room puts its commands into the application, in this order
from nutamill.cli import cases, runs, verify, page, campaigns, answers, readings  # noqa: F401, I001
from nutamill.cli import grinding, pictures, measured, information  # noqa: F401
from nutamill.cli.common import app

__all__ = ["app"]
