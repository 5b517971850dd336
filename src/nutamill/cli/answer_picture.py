"""The picture of an answer: where it goes, what it is called, and the table printed with it."""

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nutamill.cli.common import to
from nutamill.cli.paragraphs import echo_lines

if TYPE_CHECKING:
    from nutamill.case import Case, Machine


Picture = Annotated[Path | None, to("The picture; else beside the result, or in results/.")]
"""The option of a command that saves a picture."""
RESULTS = Path("results")
"""Folder of the pictures of a case."""


def picture_place(picture: Path | None, stem: str, folder: Path = RESULTS) -> Path:
    """Return where a picture goes, that of a case among the results, that of a result beside it. Refuse a
    place that cannot be written.
    """
    from nutamill.base.atomic_file import check_writable
    from nutamill.view.figures.saving import SUFFIXES

    path = picture or folder / f"{stem}.png"
    check_writable(path, SUFFIXES)
    return path


def print_answer(lines: list[str], figure: Any, picture: Path) -> None:
    """Print a table, save its figure and say where."""
    from nutamill.view.figures.saving import save_figure

    echo_lines(lines)
    typer.echo(f"picture {save_figure(figure, picture)}")


def picture_name(
    subject: "Case | Machine | Path", question: str, *options: str | None, charge: bool = False
) -> str:
    """Return the name of a picture without its suffix, one for each answer, so that none overwrites another.

    It holds the name of the case with its digest, or that of the result, as result files have it; the
    question; and the options that were given.
    """
    stem = subject.stem if isinstance(subject, Path) else subject.file_in().stem
    given = [option for option in (*options, "charge" if charge else None) if option]
    return "-".join([stem, question, *(re.sub(r"[^\w.+-]", "", option) for option in given)])
