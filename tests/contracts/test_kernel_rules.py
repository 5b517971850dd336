"""Rules of the kernels and of the words in the source, checked on the syntax tree."""

import ast
import collections
import functools
import pathlib
import re

import nutamill

PACKAGE = pathlib.Path(nutamill.__file__).parent
FILES = sorted(PACKAGE.rglob("*.py"))
MOST_FIELDS = 25


@functools.cache
def tree(path):
    return ast.parse(path.read_text(encoding="utf-8"))


def named(path):
    return path.relative_to(PACKAGE).as_posix()


def decorators(function):
    """Bare names of a function's decorators: ``@kernel(fast=True)`` is ``kernel``."""
    for decorator in function.decorator_list:
        target = decorator.func if isinstance(decorator, ast.Call) else decorator
        yield target.attr if isinstance(target, ast.Attribute) else target.id


def functions(path):
    return [
        node for node in ast.walk(tree(path)) if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef))
    ]


def kernels(path):
    return [function for function in functions(path) if "kernel" in decorators(function)]


def structs(path):
    """NamedTuple classes of a file."""
    classes = (node for node in ast.walk(tree(path)) if isinstance(node, ast.ClassDef))
    return [node for node in classes if any(getattr(base, "id", "") == "NamedTuple" for base in node.bases)]


def offences(faults_of):
    """Return what `faults_of` says of each file, by file, where it says anything."""
    return {named(path): faults for path in FILES if (faults := faults_of(path))}


def test_functions_are_compiled_by_the_one_decorator():
    compiled = {"njit", "jit", "vectorize", "guvectorize", "cfunc", "stencil"}

    def faults(path):
        return [function.name for function in functions(path) if compiled & set(decorators(function))]

    assert not {path: names for path, names in offences(faults).items() if path != "base/kernel.py"}


def test_a_kernel_has_plain_arguments_without_defaults():
    def faults(path):
        return [
            function.name
            for function in kernels(path)
            if (arguments := function.args).defaults
            or arguments.kwonlyargs
            or arguments.vararg
            or arguments.kwarg
        ]

    assert not offences(faults)


def test_a_kernel_raises_nothing_and_returns_a_status():
    def faults(path):
        return [
            function.name
            for function in kernels(path)
            if any(isinstance(node, ast.Raise) for node in ast.walk(function))
        ]

    assert not offences(faults)


def public_things(body):
    """Yield the public functions and classes of a file, and the public methods of those classes."""
    for outer in body.body:
        if isinstance(outer, (ast.FunctionDef, ast.ClassDef)) and not outer.name.startswith("_"):
            yield outer
            if isinstance(outer, ast.ClassDef):
                yield from (
                    node
                    for node in outer.body
                    if isinstance(node, ast.FunctionDef) and not node.name.startswith("_")
                )


def test_every_file_and_every_public_thing_has_a_docstring():
    def faults(path):
        body = tree(path)
        without = [node.name for node in public_things(body) if not ast.get_docstring(node)]
        return without + ["the file"] * (bool(body.body) and not ast.get_docstring(body))

    assert not offences(faults)


def test_every_field_of_a_struct_is_explained_below_it():
    def explained(below):
        return (
            isinstance(below, ast.Expr)
            and isinstance(below.value, ast.Constant)
            and isinstance(below.value.value, str)
        )

    def faults(path):
        return [
            f"{struct.name}.{field.target.id}"
            for struct in structs(path)
            for field, below in zip(struct.body, [*struct.body[1:], None], strict=True)
            if isinstance(field, ast.AnnAssign) and not explained(below)
        ]

    assert not offences(faults)


def test_structs_are_small_and_their_names_unique():
    # two struct classes of one name make a compiled call about two hundred times dearer
    sizes = [
        (struct.name, sum(isinstance(field, ast.AnnAssign) for field in struct.body))
        for path in FILES
        for struct in structs(path)
    ]
    assert not [name for name, fields in sizes if fields > MOST_FIELDS]
    assert not [name for name, times in collections.Counter(name for name, _ in sizes).items() if times > 1]


def test_nothing_is_left_to_do():
    words = re.compile(r"\b(?:TODO|FIXME|XXX|HACK|NotImplementedError)\b")
    assert not offences(lambda path: words.findall(path.read_text(encoding="utf-8")))
