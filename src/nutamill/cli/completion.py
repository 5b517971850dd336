"""What the tab key offers: machines of the package and case files, keys after ``-s``, results, figures."""

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

RESULT_FOLDER = Path("results")
"""Folder whose results are offered from above it."""

WORDS = ("COMP_WORDS", "_TYPER_COMPLETE_ARGS", "_TYPER_COMPLETE_WORDS")
"""Variables in which shells hand over the words of the line."""


def cases(incomplete: str) -> list[str]:
    """Return the machines of the package and the case files that begin as typed."""
    from nutamill.base.library import library_names

    return [name for name in library_names() if name.startswith(incomplete)] + files(incomplete, ".toml")


def ores(incomplete: str) -> list[str]:
    """Return the ores of the package and the files that begin as typed."""
    from nutamill.base.library import ore_names

    return [name for name in ore_names() if name.startswith(incomplete)] + files(incomplete, ".toml")


def results(incomplete: str) -> list[str]:
    """Return the result files that begin as typed, those of the folder ``results`` too."""
    beside = files(incomplete, ".h5")
    if incomplete or beside or not RESULT_FOLDER.is_dir():
        return beside
    return files(f"{RESULT_FOLDER}/", ".h5")


def cases_and_results(incomplete: str) -> list[str]:
    """Return what `show` takes."""
    return cases(incomplete) + files(incomplete, ".h5")


def files(incomplete: str, suffix: str) -> list[str]:
    """Return the files with a suffix, and the folders, that begin as typed."""
    folder = Path(incomplete) if incomplete.endswith("/") else Path(incomplete).parent
    shown = "" if str(folder) == "." and not incomplete.startswith("./") else f"{folder}/"
    try:
        entries = sorted(folder.iterdir())
    except OSError:
        return []
    names = [
        f"{shown}{entry.name}" + "/" * entry.is_dir()
        for entry in entries
        if not entry.name.startswith(".") and (entry.is_dir() or entry.suffix == suffix)
    ]
    return [name for name in names if name.startswith(incomplete)]


def names(incomplete: str) -> list[tuple[str, str]]:
    """Return the keys of the first mill of the package that begin as typed, and its tables."""
    known = case_keys("numill")
    tables = dict.fromkeys(key.rpartition(".")[0] for key, _ in known if "." in key)
    offered = [*known, *((table, "a table") for table in tables)]
    return [(key, value) for key, value in offered if key.startswith(incomplete)]


def keys(incomplete: str) -> list[tuple[str, str]]:
    """Return the keys of the case that is typed, each with its present value as help."""
    if "=" in incomplete:
        return []
    return [(f"{key}=", value) for key, value in case_keys(typed_case()) if key.startswith(incomplete)]


def typed_case() -> str:
    """Return the case among the words of the line that is completed, or the first mill of the package.

    The words are read where the shell puts them: an option without its value keeps Typer from reading them.
    """
    from nutamill.base.library import library_names

    words = next((os.environ[name] for name in WORDS if name in os.environ), "").split()
    return next((word for word in words if word in library_names() or word.endswith(".toml")), "numill")


def case_keys(name: str) -> list[tuple[str, str]]:
    """Return key and value of all that a case holds, none for what is no case."""
    from nutamill.base.errors import MillError
    from nutamill.case import load_case
    from nutamill.case.titles import leaves

    try:
        content = load_case(name).model_dump(mode="json", by_alias=True, exclude_none=True)
    except MillError:
        return []
    return [(key, str(value)) for key, value in leaves(content)]


def figures(ctx: Any, incomplete: str) -> list[str]:
    """Return the names of figures, and after ``history:`` and the like the series of the result."""
    kind, colon, typed = incomplete.partition(":")
    if not colon:
        from nutamill.view.figures.names import OF_A_RUN, OF_SERIES

        names = [*OF_A_RUN, *(f"{name}:" for name in OF_SERIES)]
        return [name for name in names if name.startswith(incomplete)]
    before, comma, last = typed.rpartition(",")
    return [f"{kind}:{before}{comma}{name}" for name in _series(ctx) if name.startswith(last)]


def _series(ctx: Any) -> Iterator[str]:
    """Yield the series of the result that is typed, or all known ones without it."""
    from nutamill.base.errors import MillError
    from nutamill.result import open_result
    from nutamill.result.fields import SERIES

    try:
        with open_result(ctx.params["file"]) as result:
            yield from map(str, result.series.data_vars)
    except (MillError, KeyError, TypeError):
        yield from (field.name for field in SERIES)
