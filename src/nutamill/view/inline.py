"""The page in which the mill turns, inside a notebook."""

import html
from typing import NamedTuple

from nutamill.result import Result
from nutamill.view.webview import MOST_FRAMES, view_page

HEIGHT = 560
"""Height of the page in a notebook [px]."""


class InlineView(NamedTuple):
    """A page that a notebook shows below the cell."""

    page: str
    """The page, complete HTML."""
    height: int
    """Its height [px]."""

    def _repr_html_(self) -> str:
        return (
            f'<iframe srcdoc="{html.escape(self.page)}" width="100%" height="{self.height}" '
            'style="border:0" allowfullscreen></iframe>'
        )

    def __repr__(self) -> str:
        return f"page of {len(self.page)} characters. A notebook shows it, nm.write_view writes it to a file"


def inline_view(result: Result, frames: int = MOST_FRAMES, height: int = HEIGHT) -> InlineView:
    """Return the page in which the machine turns and the charge moves, for a notebook to show.

    Parameters
    ----------
    result : an opened result with snapshots
    frames : most snapshots to show [1]; of more, evenly spaced ones are taken
    height : height of the page in the notebook [px]

    Raises
    ------
    ResultError : no snapshots
    """
    return InlineView(view_page(result, frames), height)
