"""Notes and marks beside the numbers of case files: published, fitted, assumed."""

import re
from pathlib import Path

from nutamill.case.toml.addresses import Key
from nutamill.case.toml.layers import read_layers

MARKS = {"P": "published", "F": "fitted to a published number", "A": "assumed"}
"""What the letter before a note of a machine file means for the number."""
NOTE = re.compile(r"[^#]*#\s*(?:([PFA])\b(?: \+ [PFA]\b)?[ ;,]*)?(.*)")
"""A line with a note, and its mark."""


class Notes:
    """Notes of a case file and its bases, read once.

    Parameters
    ----------
    name : a case file, or a machine of the package
    """

    def __init__(self, name: str | Path):
        self._layers = read_layers(name)
        self._lines: dict[Path, list[str]] = {}

    def of(self, key: Key) -> tuple[str, str]:
        """Return mark and note of a key, from the last file that sets it, empty without one.

        Parameters
        ----------
        key : entries of lists by their number
        """
        for layer in reversed(self._layers):
            if (place := layer.places.get(key)) is None:
                continue
            file, _, line = place.rpartition(":")
            lines = self._lines_of(layer.folder / Path(file).name)
            if not line.isdigit() or int(line) > len(lines):
                return "", ""
            match = NOTE.match(lines[int(line) - 1])
            return (MARKS.get(match[1] or "", ""), match[2].strip()) if match else ("", "")
        return "", ""

    def _lines_of(self, file: Path) -> list[str]:
        if file not in self._lines:
            try:
                self._lines[file] = file.read_text(encoding="utf-8").splitlines()
            except (OSError, ValueError):
                self._lines[file] = []
        return self._lines[file]
