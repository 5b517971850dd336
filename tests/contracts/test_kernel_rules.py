"""Rules of the kernels and of the words in the source, checked on the syntax tree."""

import ast
import collections
import pathlib
import re

import pytest

import nutamill

PACKAGE = pathlib.Path(nutamill.__file__).parent
FILES = sorted(PACKAGE.rglob("*.py"))
MOST_FIELDS = 25


def tree(path):
    return ast.parse(path.read_text(encoding="utf-8"))


def named(path):
    return str(path.relative_to(PACKAGE))


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


@pytest.mark.parametrize("path", [path for path in FILES if path.name != "kernel.py"], ids=named)
def test_functions_are_compiled_by_the_one_decorator(path):
    compiled = {"njit", "jit", "vectorize", "guvectorize", "cfunc", "stencil"}
    assert not [function.name for function in functions(path) if compiled & set(decorators(function))]


@pytest.mark.parametrize("path", FILES, ids=named)
def test_a_kernel_has_plain_arguments_and_raises_nothing(path):
    for function in kernels(path):
        arguments = function.args
        assert not arguments.defaults, f"{function.name}: no defaults"
        assert not arguments.kwonlyargs and not arguments.vararg and not arguments.kwarg, (
            f"{function.name}: plain arguments only"
        )
        assert not [node for node in ast.walk(function) if isinstance(node, ast.Raise)], (
            f"{function.name}: return a status"
        )


@pytest.mark.parametrize("path", FILES, ids=named)
def test_every_public_thing_says_what_it_is(path):
    body = tree(path)
    assert ast.get_docstring(body) or not body.body, "the file says what it is for"
    public = [
        node
        for node in body.body
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)) and not node.name.startswith("_")
    ]
    inner = [
        node
        for outer in public
        if isinstance(outer, ast.ClassDef)
        for node in outer.body
        if isinstance(node, ast.FunctionDef) and not node.name.startswith("_")
    ]
    assert not [node.name for node in public + inner if not ast.get_docstring(node)]


@pytest.mark.parametrize("path", FILES, ids=named)
def test_every_field_of_a_struct_is_explained_below_it(path):
    for struct in structs(path):
        for field, below in zip(struct.body, [*struct.body[1:], None], strict=True):
            if isinstance(field, ast.AnnAssign):
                explained = (
                    isinstance(below, ast.Expr)
                    and isinstance(below.value, ast.Constant)
                    and isinstance(below.value.value, str)
                )
                assert explained, f"{struct.name}.{field.target.id}"


def test_structs_are_small_and_their_names_unique():
    # two struct classes of one name make a compiled call about two hundred times dearer
    found = [
        (struct.name, sum(isinstance(field, ast.AnnAssign) for field in struct.body))
        for path in FILES
        for struct in structs(path)
    ]
    assert not [name for name, fields in found if fields > MOST_FIELDS]
    assert not [name for name, times in collections.Counter(name for name, _ in found).items() if times > 1]


@pytest.mark.parametrize("path", FILES, ids=named)
def test_nothing_is_left_to_do(path):
    assert not re.findall(
        r"\b(?:TODO|FIXME|XXX|HACK|NotImplementedError)\b", path.read_text(encoding="utf-8")
    )
