"""Content of the page of a folder of runs: the tables and pictures that a sweep or a comparison with a paper
left there, and its runs.

Only files are read: CSV tables of a sweep, Markdown tables of a comparison, PNG pictures, and the head of
each result.
"""

import csv
import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from nutamill.base.atomic_file import io_errors
from nutamill.base.errors import CaseError, DamagedError, Fault, ResultError
from nutamill.result import open_result

NARROW = re.compile(r"(.*) half width 95 % \[(.*)\]")
"""Column of a sweep's table that belongs to the one before."""
NO_NUMBER, NOTHING = "nan", "–"
"""What a table of a sweep has where there is no number, and what the page has there."""
LAST = " last seconds ["
"""In the head of a column that the page leaves out: it stands in the CSV."""


class Table(NamedTuple):
    """A table as it is printed."""

    name: str
    """Stem of its file."""
    heads: list[str]
    """Heads of the columns."""
    rows: list[list[str]]
    """Cells."""


class RunLine(NamedTuple):
    """One run of the folder."""

    file: str
    """Name of its result file."""
    state: str
    """How far it has come."""


class CampaignFolder(NamedTuple):
    """Content of the page of a folder."""

    name: str
    """Name of the folder."""
    tables: list[Table]
    """Tables, by file name."""
    pictures: list[Path]
    """Pictures, by file name, numbers in them as numbers."""
    runs: list[RunLine]
    """Result files."""
    provenance: list[tuple[str, str]]
    """What made the first result."""


def read_campaign(folder: Path) -> CampaignFolder:
    """Read what a folder holds.

    Raises
    ------
    CaseError : neither a table nor a result in it
    ResultError : a file that cannot be read
    """
    tables = [table for file in _files(folder, "*.csv") if (table := _sweep_table(file))]
    tables += [table for file in _files(folder, "*.md") if (table := _markdown_table(file))]
    runs: list[RunLine] = []
    provenance: list[tuple[str, str]] = []
    for file in _files(folder, "*.h5"):
        try:
            with open_result(file) as result:
                runs.append(RunLine(file.name, result.state))
                provenance = provenance or [(key, fact(value)) for key, value in result.provenance.items()]
        except (ResultError, DamagedError) as error:
            runs.append(RunLine(file.name, str(error)))
    if not tables and not runs:
        what = (
            "must be a result, or a folder of a sweep or of a comparison, this one holds neither a table "
            "nor a result"
        )
        raise CaseError(Fault(str(folder), what, "nutamill sweep and nutamill validate make such folders"))
    return CampaignFolder(folder.resolve().name, tables, _files(folder, "*.png"), runs, provenance)


def _files(folder: Path, pattern: str) -> list[Path]:
    """Return files by name. Numbers in names count as numbers."""
    return sorted(
        folder.glob(pattern),
        key=lambda file: [
            part.zfill(9) if part.isdigit() else part for part in re.split(r"(\d+)", file.name)
        ],
    )


def _sweep_table(file: Path) -> Table | None:
    """Return the table of a sweep, each half width behind its mean, or None for a file that is not one."""
    with io_errors(file), file.open(encoding="utf-8", newline="") as text:
        lines = list(csv.reader(text))
    if not lines or "state" not in lines[0]:
        return None
    heads = lines[0]
    shown = [
        k
        for k, head in enumerate(heads)
        if not NARROW.fullmatch(head) and LAST not in head and head != "file"
    ]
    widths = {
        f"{match[1]} [{match[2]}]": k for k, head in enumerate(heads) if (match := NARROW.fullmatch(head))
    }

    def cell(row: list[str], k: int) -> str:
        width = row[widths[heads[k]]] if heads[k] in widths else NO_NUMBER
        if row[k] == NO_NUMBER:
            return NOTHING
        if heads[k] not in widths:
            return row[k].strip('"')
        return _rounded(row[k]) if width in (NO_NUMBER, "inf") else f"{_rounded(row[k])} ± {float(width):.2g}"

    known = [k for k in shown if any(cell(row, k) != NOTHING for row in lines[1:])]
    words = [_words(heads[k]) if heads[k] in widths else heads[k] for k in known]
    return Table(file.stem, words, [[cell(row, k) for k in known] for row in lines[1:]])


def fact(value: object) -> str:
    """Return a value of the provenance as text, numbers with a decimal point rounded."""
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _rounded(number: str) -> str:
    """Return a number of a table with five digits."""
    return f"{float(number):.5g}"


def _words(head: str) -> str:
    """Return the head of a column of readings as words: ``driveshaft torque (N m)``."""
    name, _, unit = head.rpartition(" [")
    return f"{name.replace('_', ' ')} ({unit.rstrip(']')})" if name else head


def _markdown_table(file: Path) -> Table | None:
    """Return the first table of a Markdown file, or None where there is none."""
    with io_errors(file):
        lines = list(_cells(file.read_text(encoding="utf-8")))
    return Table(file.stem, lines[0], lines[2:]) if len(lines) > 2 else None


def _cells(text: str) -> Iterator[list[str]]:
    """Return the cells of the lines of the first table in a text."""
    begun = False
    for line in text.splitlines():
        if line.startswith("|"):
            begun = True
            yield [cell.strip() for cell in line.strip().strip("|").split("|")]
        elif begun:
            return
