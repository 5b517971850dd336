"""Print lines so that a terminal breaks them between words, below the text of the line and not its label."""

import re
import shutil
import sys
import textwrap
from collections.abc import Iterable

import typer

LABEL = re.compile(r"\s*(?:\S+ ?)+?\s{2,}|\s*")
"""What a line begins with: a label and the gap after it, or an indent."""
NARROWEST = 40
"""Columns below which lines are not broken [1]."""


def echo_lines(lines: Iterable[str], err: bool = False) -> None:
    """Print lines. On a terminal those that are too wide are broken between words.

    Parameters
    ----------
    err : print to standard error
    """
    stream = sys.stderr if err else sys.stdout
    width = shutil.get_terminal_size().columns if stream.isatty() else 0
    for line in lines:
        typer.echo(broken(line, width), err=err)


def broken(line: str, width: int) -> str:
    """Return a line broken between words to a width [1], or as it is where there is no width to fit."""
    if width < NARROWEST or len(line) <= width:
        return line
    match = LABEL.match(line)
    indent = len(match[0]) if match else 0
    return textwrap.fill(
        line,
        width,
        subsequent_indent=" " * (indent if indent <= width // 3 else 2),
        break_long_words=False,
        break_on_hyphens=False,
    )
