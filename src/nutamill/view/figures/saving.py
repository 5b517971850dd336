"""Save a figure to a file."""

import io
from pathlib import Path

from matplotlib.figure import Figure

from nutamill.base.atomic_file import refuse_suffix, write_whole

SUFFIXES = (".png", ".pdf", ".svg", ".jpg", ".jpeg", ".tif", ".tiff", ".eps")
"""Suffixes of figures."""


def save_figure(figure: Figure, path: str | Path) -> Path:
    """Save a figure in the format of its suffix, make its folder if needed, and return its path.

    Raises
    ------
    CaseError : a suffix of no format of pictures
    OutputError : the system refuses, or there is no room
    """
    path = Path(path)
    refuse_suffix(path, SUFFIXES)
    content = io.BytesIO()
    figure.savefig(content, format=path.suffix[1:].lower())
    return write_whole(path, content.getvalue())


def png_of(figure: Figure, resolution: float) -> bytes:
    """Return a figure as the content of a PNG file, with so many dots per inch."""
    content = io.BytesIO()
    figure.savefig(content, format="png", dpi=resolution)
    return content.getvalue()
