"""Pieces of HTML for a notebook: every text is escaped here."""

import base64
import html
from collections.abc import Iterable, Sequence

from matplotlib.figure import Figure

from nutamill.view.figures.saving import png_of

GOOD, DOUBTFUL = "#2a7d2a", "#a05a00"
"""Colours of verdicts."""
CELL = "text-align:left;padding:1px 10px 1px 0"
THUMBNAIL = 90
"""Resolution of a picture in a summary [dots/inch]."""


def escaped(text: object) -> str:
    """Return text as HTML shows it."""
    return html.escape(str(text))


def heading(title: str, verdict: str, good: bool) -> str:
    """Return a title in bold and, below it, a verdict in the colour of what it says."""
    colour = GOOD if good else DOUBTFUL
    return f'<b>{escaped(title)}</b><br><span style="color:{colour}">{escaped(verdict)}</span>'


def warnings_html(warnings: Iterable[object]) -> str:
    """Return warnings, one line each."""
    return "".join(
        f'<div style="color:{DOUBTFUL}">warning: {escaped(str(text).removeprefix("warning: "))}</div>'
        for text in warnings
    )


def table(rows: Iterable[Sequence[object]], head: Sequence[object] = ()) -> str:
    """Return a table of text, with a line of headings where they are given."""
    top = "".join(f'<th style="{CELL}">{escaped(cell)}</th>' for cell in head)
    body = "".join(
        "<tr>" + "".join(f'<td style="{CELL}">{escaped(cell)}</td>' for cell in row) + "</tr>" for row in rows
    )
    return f"<table>{f'<tr>{top}</tr>' if head else ''}{body}</table>"


def folded(summary: str, content: str, opened: bool = False) -> str:
    """Return HTML content that a click on its summary shows."""
    return f"<details{' open' * opened}><summary>{escaped(summary)}</summary>{content}</details>"


def picture(figure: Figure, resolution: float = THUMBNAIL) -> str:
    """Return a figure as an image within the page."""
    code = base64.b64encode(png_of(figure, resolution)).decode("ascii")
    return f'<img alt="figure" src="data:image/png;base64,{code}">'
