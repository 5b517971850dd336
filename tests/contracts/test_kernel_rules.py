"""Rules of the kernels and of the words in the source, checked on the syntax tree."""

import ast
import collections
import functools
import pathlib
import re

import pytest

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


MOVES = "charge/kernels/simd.py"
"""File of the plain Python of the vector moves, which no decorator marks."""

FIRST = ("model", "state", "scratch")
"""Parameters that come first, in this order."""

LAST = ("tid", "n_threads")
"""Parameters that may stand behind what is written: every thread has its own."""

NOT_YET = {
    "charge/kernels/columns.py",
}
"""Files whose kernels do not keep the rule of outputs yet.  The list may only become shorter."""


def is_output(name):
    """Whether a name marks a parameter that may be written: ``..._out``, or a struct that is to change."""
    return name == "out" or name.endswith(("_out", "state", "scratch"))


def home(expression, homes):
    """Parameters whose array an expression is, or is a part of: ``a.b[c].reshape(d)`` is a part of ``a``."""
    while not isinstance(expression, ast.Name):
        if isinstance(expression, (ast.Attribute, ast.Subscript)):
            expression = expression.value
        elif isinstance(expression, ast.Call) and getattr(expression.func, "attr", "") == "reshape":
            expression = expression.func.value
        else:
            return set()
    return homes.get(expression.id, set())


def written(function, known):
    """Parameters of a kernel that it writes, itself or by a kernel it calls.

    `known` are the parameters of each kernel, and which of them it writes as far as is known.
    """
    homes = {argument.arg: {argument.arg} for argument in function.args.args}
    assignments = [node for node in ast.walk(function) if isinstance(node, ast.Assign)]
    calls = [node for node in ast.walk(function) if isinstance(node, ast.Call)]

    def bind(target, value):
        if isinstance(target, ast.Name):
            homes[target.id] = homes.get(target.id, set()) | home(value, homes)
        elif isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
            for one, other in zip(target.elts, value.elts, strict=True):
                bind(one, other)

    for node in assignments * 2:
        for target in node.targets:
            bind(target, node.value)
    targets = [target for node in assignments for target in node.targets]
    targets += [node.target for node in ast.walk(function) if isinstance(node, ast.AugAssign)]
    targets += [part for target in targets if isinstance(target, ast.Tuple) for part in target.elts]
    out = set().union(*(home(target, homes) for target in targets if isinstance(target, ast.Subscript)))
    for call in calls:
        names, changed = known.get(getattr(call.func, "id", ""), ((), ()))
        for argument, name in zip(call.args, names, strict=False):
            out |= home(argument, homes) if name in changed else set()
    return out & {argument.arg for argument in function.args.args}


@pytest.fixture(scope="module")
def all_kernels():
    """Every kernel of the package by file, and what each writes."""
    by_file = {named(path): kernels(path) for path in FILES}
    by_file[MOVES] = [function for function in functions(PACKAGE / MOVES) if function.name[0] != "_"]
    known = {}
    while True:
        now = {
            function.name: ([argument.arg for argument in function.args.args], written(function, known))
            for inside in by_file.values()
            for function in inside
        }
        if now == known:
            return by_file, known
        known = now


def faults_of(functions_of_a_file, known):
    """Sentences on the parameters that break the rule of `test_a_kernel_writes_only_its_outputs`."""
    faults = []
    for function in functions_of_a_file:
        names, changed = known[function.name]
        silent = [name for name in names if name in changed and not is_output(name)]
        faults += [f"{function.name}: {name} is written" for name in silent]
        ends = [name == "out" or name.endswith("_out") for name in names]
        if True in ends and not all(
            end or name in LAST for end, name in list(zip(ends, names, strict=True))[ends.index(True) :]
        ):
            faults.append(f"{function.name}: outputs are not last")
        if [name for name in names if name in FIRST] != [name for name in FIRST if name in names]:
            faults.append(f"{function.name}: {', '.join(FIRST)} is the order")
    return faults


def test_a_kernel_writes_only_its_outputs(all_kernels):
    """A kernel writes only what is named ``..._out``, or a state or scratch; outputs stand last.

    An array that is written in part, through a local name or by a kernel that is called counts as written.
    """
    by_file, known = all_kernels
    faults = {path: faults_of(inside, known) for path, inside in by_file.items()}
    assert not {path: wrong for path, wrong in faults.items() if wrong and path not in NOT_YET}
    assert not [path for path in NOT_YET if not faults[path]], "take these off the list NOT_YET"


def test_the_rule_of_outputs_sees_writing_through_names_parts_and_calls():
    source = """
def fill(value, row_out):
    row_out[0] = value

def direct(a, b): a[0] = b
def part(a, b): a.rows[1, 2] += b
def local(a, b):
    rows, other = a.rows, b
    rows[0], other = 1.0, 2.0
def called(a, b): fill(b, a.rows[3])
def clean(a, b):
    b = a[0]
    return b
"""
    body = ast.parse(source).body
    known = {"fill": (["value", "row_out"], {"row_out"})}
    assert {function.name: written(function, known) for function in body} == {
        "fill": {"row_out"},
        "direct": {"a"},
        "part": {"a"},
        "local": {"a"},
        "called": {"a"},
        "clean": set(),
    }


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
