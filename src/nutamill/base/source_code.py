"""Digest the source code that decides a result: the definitions that given functions reach, without words.

A definition is a statement at the top of a file: a function, a class, a constant.  It reaches what its names
stand for, in its own file or in the file of this package that they are imported from, and so on.  Comments,
docstrings, annotations of functions and the wording of errors are left out, because none of them changes a
number.
"""

import ast
import contextlib
import functools
import hashlib
import pickle
import sys
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from nutamill.base.cache_folder import cache_folder
from nutamill.base.compiled_files import CompiledFiles

PACKAGE = Path(__file__).parents[1]

COMPILING = {"nutamill.base.kernel": {"kernel", "by_type", "like"}}
"""What compiles a function, by the module that has it; so does all that is imported from Numba."""

APART = ("nutamill.base.source_code", "nutamill.base.cache_folder", "nutamill.base.compiled_files")
"""Modules that kernels reach and that decide no number: where compiled code is stored, and when it is made
anew.
"""

WORDING = {"Fault", "Terms"}
"""Calls whose arguments are words: a message, or the terms of another program."""

IMPORT = (ast.Import, ast.ImportFrom)

Definition = tuple[str, int]
"""A definition: path of its file, relative to the package, and its number among the definitions of the
file.
"""


class SourceFile(NamedTuple):
    """What a file defines and imports."""

    definitions: list[ast.stmt]
    """Statements at the top of the file, but imports and docstrings."""
    named: dict[str, list[int]]
    """Numbers of the functions and classes of each name."""
    always: list[int]
    """Numbers of the definitions that belong to all others: statements that run when the file is imported, as
    they may fill a table that another one has made, and the `NamedTuple` classes, which kernels take as
    arguments.
    """
    imports: dict[str, tuple[str, str]]
    """Module and name that each imported name stands for; an empty name for the module itself."""


@functools.cache
def source_file(path: str) -> SourceFile:
    """Parse the file at `path`, relative to the package."""
    body = ast.parse((PACKAGE / path).read_bytes()).body
    inner = [node for block in body if isinstance(block, (ast.If, ast.Try)) for node in block.body]
    made = SourceFile(
        [node for node in body if not isinstance(node, IMPORT) and not _is_docstring(node)], {}, [], {}
    )
    for node in body + inner:
        if isinstance(node, IMPORT):
            made.imports.update(_imported_names(node))
    for number, node in enumerate(made.definitions):
        if name := getattr(node, "name", None):
            made.named.setdefault(name, []).append(number)
        if not name or any(getattr(base, "id", "") == "NamedTuple" for base in getattr(node, "bases", [])):
            made.always.append(number)
    return made


class Definitions:
    """Definitions that are looked for when they are asked for: a digest that is stored needs none of them.

    Parameters
    ----------
    what : what they are; the same text stands for the same definitions of the same package
    find : returns them
    """

    def __init__(self, what: str, find: Callable[[], Iterable[Definition]]):
        self.what, self.find = what, find

    def __iter__(self) -> Iterator[Definition]:
        return iter(self.find())


def compiled_definitions() -> Definitions:
    """Return all definitions of the package that have something compiled."""
    return Definitions("compiled", _compiled_definitions)


def _compiled_definitions() -> list[Definition]:
    sources = {source: source.read_bytes() for source in sorted(PACKAGE.rglob("*.py"))}
    compiled = [
        source for source, text in sources.items() if b"numba" in text or b"nutamill.base.kernel" in text
    ]
    paths = [source.relative_to(PACKAGE).as_posix() for source in compiled]
    return [
        (path, number)
        for path in paths
        if (compiling := {name for name, origin in source_file(path).imports.items() if _compiles(*origin)})
        for number in range(len(source_file(path).definitions))
        if compiling & _read((path, number))[1]
    ]


def definition_of(function: Callable) -> Definition:
    """Return the definition of a function or class at the top of a file of the package."""
    path = _path(tuple(function.__module__.split(".")[1:]))
    return path, source_file(path).named[function.__name__][-1]


def reached(roots: Definitions | list[Definition]) -> Definitions:
    """Return `roots` and all definitions that they reach."""
    what = roots.what if isinstance(roots, Definitions) else repr(sorted(roots))
    return Definitions(f"reached {what}", lambda: _reached(roots))


def _reached(roots: Iterable[Definition]) -> set[Definition]:
    definitions: set[Definition] = set()
    waiting = list(roots)
    while waiting:
        definition = waiting.pop()
        if definition not in definitions:
            definitions.add(definition)
            waiting += _neighbours(definition)
    return definitions


def code_digest(definitions: Definitions) -> str:
    """Return the SHA-256 of definitions and of the paths of their files. Their order does not count.

    Reading the definitions takes half a second, so that the digest is stored beside the compiled kernels,
    for this state of all files of the package.
    """
    state = hashlib.sha256(repr((definitions.what, sys.version)).encode())
    for file in sorted(PACKAGE.rglob("*.py")):
        state.update(repr((file.relative_to(PACKAGE).as_posix(), file.read_bytes())).encode())
    store = CompiledFiles(cache_folder(), "digest")
    stored = store.load(state.hexdigest())
    if isinstance(stored, str):
        return stored
    digest = _digest_of(definitions)
    with contextlib.suppress(OSError):
        store.save(state.hexdigest(), pickle.dumps(digest))
    return digest


def _digest_of(definitions: Iterable[Definition]) -> str:
    digest = hashlib.sha256()
    for definition in sorted(definitions):
        digest.update(repr((definition[0], _read(definition)[0])).encode())
    return digest.hexdigest()


def _compiles(module: str, name: str) -> bool:
    """Return whether ``from module import name`` is one of `COMPILING`, or Numba's."""
    return module.split(".")[0] == "numba" or name in COMPILING.get(module, ())


def _neighbours(definition: Definition) -> Iterator[Definition]:
    """Yield the definitions that one definition reaches directly."""
    path, _ = definition
    file = source_file(path)
    _, names, inner_imports = _read(definition)
    imports = file.imports | inner_imports
    yield from ((path, number) for number in file.always)
    for name in names:
        yield from ((path, number) for number in file.named.get(name, ()))
        if name in imports:
            yield from _imported(*imports[name])


def _imported(module: str, name: str) -> Iterator[Definition]:
    """Yield the definitions of this package that ``from module import name`` stands for: the named one, or
    all of a module.
    """
    first, *parts = module.split(".")
    if first != PACKAGE.name or module in APART:
        return
    path = _path((*parts, name)) if name else ""
    if path or not name:
        path = path or _path(tuple(parts))
        yield from ((path, number) for number in range(len(source_file(path).definitions)))
        return
    file = source_file(path := _path(tuple(parts)))
    yield from ((path, number) for number in file.named.get(name, file.always))
    if name in file.imports:
        yield from _imported(*file.imports[name])


@functools.cache
def _path(parts: tuple[str, ...]) -> str:
    """Return the file of a module, relative to the package, or "" if there is none."""
    candidates = ["/".join((*parts, "__init__.py")), "/".join(parts) + ".py"]
    return next((path for path in candidates if (PACKAGE / path).is_file()), "")


def _imported_names(node: ast.Import | ast.ImportFrom) -> dict[str, tuple[str, str]]:
    """Return module and name that each name of an import statement stands for."""
    if isinstance(node, ast.ImportFrom):
        return {alias.asname or alias.name: (node.module or "", alias.name) for alias in node.names}
    return {alias.asname or alias.name.split(".")[0]: (alias.name, "") for alias in node.names}


def _is_docstring(node: ast.AST) -> bool:
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    )


@functools.cache
def _read(definition: Definition) -> tuple[object, set[str], dict[str, tuple[str, str]]]:
    """Return the content of a definition as nested tuples, the names that it uses, and what it imports
    itself.

    The content is that of the syntax tree without line numbers and empty parts, so that it is the same in
    every version of Python.
    """
    names: set[str] = set()
    imports: dict[str, tuple[str, str]] = {}

    def content(part):
        if isinstance(part, list):
            return [content(item) for item in part if not _is_docstring(item)]
        if not isinstance(part, ast.AST):
            return part
        kind = type(part).__name__
        if isinstance(part, ast.Name):
            names.add(part.id)
            return part.id
        if kind == "Raise" or (isinstance(part, ast.Call) and getattr(part.func, "id", "") in WORDING):
            return kind
        if isinstance(part, IMPORT):
            imports.update(_imported_names(part))
        fields = [
            (field, getattr(part, field, None))
            for field in part._fields
            if field not in ("ctx", "returns", "type_comment")
        ]
        if kind == "arg":
            fields = fields[:1]
        return (
            kind,
            *((field, content(value)) for field, value in fields if value is not None and value != []),
        )

    path, number = definition
    return content(source_file(path).definitions[number]), names, imports
