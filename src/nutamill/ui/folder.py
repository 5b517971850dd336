"""The one folder that a page reads and writes: no request leads out of it."""

from collections.abc import Iterator
from itertools import islice
from pathlib import Path

from nutamill.base.errors import CaseError, Fault
from nutamill.base.files import exists, is_file
from nutamill.base.schema import spelled
from nutamill.case.case_file import RESULTS

MOST_FILES = 200
"""Files of a kind that a page lists [1]."""


class Folder:
    """A folder, and the files below it by their names relative to it.

    Parameters
    ----------
    root : the folder, which must exist
    """

    def __init__(self, root: str | Path):
        try:
            self.root = Path(root).resolve(strict=True)
        except (OSError, ValueError):
            self.root = Path(root)
        if not self.root.is_dir():
            raise CaseError(Fault(str(root), "must be a folder", "Give the folder of your cases"))

    @property
    def results(self) -> Path:
        """Folder of the results of runs that the page starts."""
        return self.root / RESULTS

    def file(self, name: object, *suffixes: str) -> Path:
        """Return the path of a file below the folder.

        Parameters
        ----------
        name : its path relative to the folder
        suffixes : of which its name must have one

        Raises
        ------
        CaseError : no such file, or one outside the folder, also through a link
        """
        path = self._inside(name, *suffixes)
        if not is_file(path):
            raise CaseError(Fault(spelled(name), "is no file in the folder of this page", "Reload the page"))
        return path

    def new_file(self, name: object, *suffixes: str) -> Path:
        """Return the path of a file that is not there yet, directly in the folder.

        Raises
        ------
        CaseError : the file exists, or its name is not one of a file in the folder
        """
        path = self._inside(name, *suffixes)
        if path.parent != self.root:
            raise CaseError(Fault(spelled(name), "must be a name without folders", "Write e.g. mymill.toml"))
        if exists(path):
            raise CaseError(Fault(spelled(name), "exists already", "Choose another name"))
        return path

    def _inside(self, name: object, *suffixes: str) -> Path:
        """Return the path of a name, after links are followed. Raise CaseError for what is outside."""
        outside = CaseError(Fault(spelled(name), "is outside the folder of this page", "Copy it there"))
        if not isinstance(name, str) or "\\" in name or Path(name).is_absolute():
            raise outside
        try:
            path = (self.root / name).resolve()
        except (OSError, ValueError, RuntimeError):
            raise outside from None
        if not path.is_relative_to(self.root):
            raise outside
        if path.suffix not in suffixes or path.name.startswith("."):
            raise CaseError(Fault(spelled(name), f"must end with {', '.join(suffixes)}"))
        return path

    def listed(self, *suffixes: str) -> list[str]:
        """Return the files with one of the suffixes, newest first: those of the folder and of the folders in
        it.
        """
        walked = islice(self._walked(*suffixes), 10 * MOST_FILES)
        files = [path for path in walked if self._safe(path, *suffixes)]
        files.sort(key=lambda path: path.stat().st_mtime, reverse=True)
        return [self.name_of(path) for path in files[:MOST_FILES]]

    def name_of(self, path: Path) -> str:
        """Return the name of a path relative to the folder, with forward slashes."""
        return path.relative_to(self.root).as_posix()

    def _walked(self, *suffixes: str) -> Iterator[Path]:
        for suffix in suffixes:
            for pattern in (f"*{suffix}", f"*/*{suffix}"):
                yield from self.root.glob(pattern)

    def _safe(self, path: Path, *suffixes: str) -> bool:
        """Return whether a path is a visible file inside the folder."""
        try:
            name = self.name_of(path)
            return not any(part.startswith(".") for part in Path(name).parts) and bool(
                self.file(name, *suffixes)
            )
        except (CaseError, OSError):
            return False
