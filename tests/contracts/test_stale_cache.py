"""No compiled function outlives the source that it was made of, and none is thrown away for a change of
words.
"""

import ast
import os
import pathlib
import shutil
import subprocess
import sys
import types

import pytest

import nutamill
from nutamill.base import source_code

PACKAGE = pathlib.Path(nutamill.__file__).parent

ENERGY_OF_A_CONTACT = """
import numpy as np
from nutamill.charge.laws.composition import stored_energy
from nutamill.charge.laws.composition import STANDARD_LAW
numbers = np.array([1e-4, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0.0])
energy = stored_energy(STANDARD_LAW, numbers, np.zeros(8), 1.0, 1e-3, 0.01, 0.01, 0.005)
print(energy[0], sum(stored_energy.stats.cache_hits.values()))
"""
"""Prints the normal energy of a linear spring of 1e4 N/m at an overlap of 1 mm [J], and how often it came
from the cache.
"""


@pytest.fixture
def copied(tmp_path):
    """A copy of the package, and a call of a kernel in it with a compiler cache of its own."""
    package = tmp_path / "nutamill"
    shutil.copytree(PACKAGE, package, ignore=shutil.ignore_patterns("__pycache__", "data"))

    def energy():
        surroundings = os.environ | {"PYTHONPATH": str(tmp_path), "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
        printed = subprocess.run(
            [sys.executable, "-c", ENERGY_OF_A_CONTACT],
            env=surroundings,
            capture_output=True,
            text=True,
            check=True,
        ).stdout.split()
        return float(printed[0]), int(printed[1])

    return package, energy


def edit(path, before, after):
    text = path.read_text(encoding="utf-8")
    assert before in text
    path.write_text(text.replace(before, after), encoding="utf-8")


def test_an_edited_law_is_compiled_anew_and_an_edited_sentence_is_not(copied):
    package, energy = copied
    law = package / "charge" / "laws" / "linear.py"
    assert energy() == (pytest.approx(5e-3), 0)
    edit(law, '"""Return the energy in a linear spring,', '"""Return the energy of a linear spring,')
    assert energy() == (pytest.approx(5e-3), 1)
    edit(law, "return 0.5 * k * overlap * overlap, k", "return 1.5 * k * overlap * overlap, k")
    assert energy() == (pytest.approx(15e-3), 0)


SMALL_PACKAGE = {
    "__init__.py": "",
    "base/kernel.py": "FAST = 1\ndef kernel(function): return function\ndef by_type(table): return table\n",
    "tags.py": "from typing import NamedTuple\nclass Tag(NamedTuple):\n    pass\n",
    "numbers.py": "import math\nHALF = 0.5\nTABLE = {}\nTABLE[1] = 2\ndef unused():\n    return 1\n",
    "kinds.py": "from enum import IntEnum\nclass Kind(IntEnum):\n    A = 0\n",
    "structs.py": "from typing import NamedTuple\nclass Inner(NamedTuple):\n    a: int\nWIDTH = 3\n",
    "room/__init__.py": "from nutamill.numbers import HALF\n",
    "room/loops.py": (
        '"""Loops."""\n'
        "from nutamill import tags\n"
        "from nutamill.base.errors import Fault\n"
        "from nutamill.base.kernel import by_type, kernel\n"
        "from nutamill.kinds import Kind\n"
        "from nutamill.room import HALF\n"
        "from nutamill.structs import WIDTH\n"
        "A = int(Kind.A)\n"
        "@kernel\ndef half(x):\n    '''Half of x.'''\n    return HALF * x + A + WIDTH\n"
        "stage = by_type({tags.Tag: half})\n"
        "def terms():\n    return Terms('half')\n"
        "names = [terms]\n"
        "def check(x: int):\n    raise ValueError('x is too long')\n"
    ),
    "errors.py": "class Fault: pass\n",
}
"""A package whose one kernel uses a constant through another room, an enumeration, a struct and a tag."""


@pytest.fixture
def digest(tmp_path, monkeypatch):
    """Digest of the small package after its files have been written anew."""
    package = tmp_path / "nutamill"
    for path, text in SMALL_PACKAGE.items():
        (package / path).parent.mkdir(parents=True, exist_ok=True)
        (package / path).write_text(text, encoding="utf-8")
    monkeypatch.setattr(source_code, "PACKAGE", package)
    monkeypatch.setattr(source_code, "cache_folder", lambda: tmp_path / "cache")

    def after(path, before, now):
        if before:
            edit(package / path, before, now)
        else:
            (package / path).write_text(now, encoding="utf-8")
        for remembered in (source_code.source_file, source_code._read, source_code._path):
            remembered.cache_clear()
        return source_code.code_digest(source_code.reached(source_code.compiled_definitions()))

    yield after
    monkeypatch.undo()
    for remembered in (source_code.source_file, source_code._read, source_code._path):
        remembered.cache_clear()


@pytest.mark.parametrize(
    ("path", "before", "now"),
    [
        ("room/loops.py", "HALF * x", "HALF / x"),
        ("numbers.py", "0.5", "0.25"),
        ("numbers.py", "TABLE[1] = 2", "TABLE[1] = 3"),
        ("kinds.py", "A = 0", "A = 1"),
        ("tags.py", "    pass", "    a: int = 0"),
        ("structs.py", "a: int", "b: int"),
        ("structs.py", "WIDTH = 3", "WIDTH = 4"),
        ("base/kernel.py", "return function", "return fast(function)"),
        (
            "room/new.py",
            "",
            "from nutamill.base.kernel import kernel\n@kernel\ndef double(x):\n    return 2 * x\n",
        ),
        ("room/new.py", "", "import numba\n\ndef made(f):\n    return numba.njit(f)\n"),
    ],
)
def test_what_a_kernel_is_made_of_counts(digest, path, before, now):
    assert digest("errors.py", "pass", "pass") != digest(path, before, now)


@pytest.mark.parametrize(
    ("path", "before", "now"),
    [
        ("room/loops.py", "Loops.", "Loops, all of them."),
        ("room/loops.py", "'''Half of x.'''", "# half of x\n"),
        ("room/loops.py", "x is too long", "x is too long, make it shorter"),
        ("room/loops.py", "Terms('half')", "Terms('a half')"),
        ("room/loops.py", "def check", "\n\ndef examine"),
        ("numbers.py", "return 1", "return 2"),
        ("room/new.py", "", "from nutamill.numbers import HALF\ndef double(x):\n    return HALF * x\n"),
    ],
)
def test_what_no_kernel_is_made_of_does_not_count(digest, path, before, now):
    assert digest("errors.py", "pass", "pass") == digest(path, before, now)


def test_a_digest_is_worked_out_once_for_each_state_of_the_package(digest, monkeypatch, tmp_path):
    first = digest("numbers.py", "0.5", "0.25")
    work_out = source_code._digest_of
    monkeypatch.setattr(source_code, "_digest_of", None)
    assert digest("errors.py", "pass", "pass") == first  # the same state: read from the cache
    monkeypatch.setattr(source_code, "_digest_of", work_out)
    assert digest("numbers.py", "0.25", "0.125") != first
    for stored in (tmp_path / "cache").iterdir():
        stored.write_bytes(stored.read_bytes().replace(first.encode(), b"0" * 64))
    assert digest("numbers.py", "0.125", "0.25") == first  # damaged: worked out anew


@pytest.fixture(scope="module")
def counted():
    """File and name of every function and class that counts, and the files that have something that
    counts.
    """
    places = source_code.reached(source_code.compiled_definitions())
    names = {
        (path, getattr(source_code.source_file(path).definitions[number], "name", ""))
        for path, number in places
    }
    return names, {path for path, _ in names}


def test_every_function_under_a_compiling_decorator_counts(counted):
    names, _ = counted
    count = 0
    for source in PACKAGE.rglob("*.py"):
        for node in ast.parse(source.read_bytes()).body:
            words = {
                word.id
                for item in getattr(node, "decorator_list", [])
                for word in ast.walk(item)
                if isinstance(word, ast.Name)
            }
            if words & {"kernel", "overload", "intrinsic"}:
                count += 1
                assert (source.relative_to(PACKAGE).as_posix(), node.name) in names
    assert count > 200


def test_every_struct_that_a_kernel_is_given_counts(counted):
    from nutamill.charge.laws.composition import STANDARD_LAW, law_names
    from nutamill.charge.measures.statistics import charge_statistics, statistics_plan
    from nutamill.mechanism.assembly import assemble
    from nutamill.mechanism.parts import Body
    from nutamill.mechanism.sensors import sensor_table
    from nutamill.simulation.coupling_model import (
        CoupledModel,
        CoupledState,
        Scheme,
        coupled_scratch,
        coupling_state,
    )
    from nutamill.simulation.row import RowTable, row_groups
    from nutamill.simulation.warm_up import STEP, ball, plan

    names, _ = counted
    charge, cstate, cscratch = ball(law_names(STANDARD_LAW), started=False)
    survey = statistics_plan(charge, cstate, STEP)
    mechanism, mstate, mscratch = assemble(
        [Body("shaft", 1.0, [[1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]], (0.0, 0.0, 0.0))], [], []
    )
    sensors = sensor_table(mechanism, mstate, [])
    starts = RowTable(row_groups(mechanism, sensors, ["hub"])).starts
    state = CoupledState(mstate, cstate, charge_statistics(survey, cstate), coupling_state(1))
    waiting = [
        CoupledModel(mechanism, sensors, charge, survey, plan(), starts),
        state,
        coupled_scratch(state, mscratch, cscratch, Scheme.STAGGERED),
    ]
    structs = set()
    while waiting:
        item = waiting.pop()
        if hasattr(item, "_fields"):
            structs.add(type(item))
            waiting += item
    assert len(structs) > 15
    for struct in structs:
        assert (
            struct.__module__.removeprefix("nutamill.").replace(".", "/") + ".py",
            struct.__name__,
        ) in names


def test_every_number_in_the_source_of_a_kernel_comes_from_a_file_that_counts(counted):
    import nutamill.simulation.warm_up  # noqa: F401  loads all kernels

    _, files = counted
    modules = {name: module for name, module in list(sys.modules.items()) if name.startswith("nutamill.")}
    paths = {
        name: pathlib.Path(module.__file__).relative_to(PACKAGE).as_posix()
        for name, module in modules.items()
    }
    homes = {}
    for module, path in paths.items():
        for node in ast.parse((PACKAGE / path).read_bytes()).body:
            for target in ast.walk(node) if isinstance(node, ast.Assign) else ():
                assigned = isinstance(target, ast.Name) and isinstance(target.ctx, ast.Store)
                if assigned and target.id in vars(modules[module]):
                    homes.setdefault((target.id, id(vars(modules[module])[target.id])), set()).add(path)
    looked_up = {
        (name, id(plain.__globals__[name]), paths[plain.__module__])
        for module in modules.values()
        for plain in [value.py_func for value in vars(module).values() if hasattr(value, "py_func")]
        for code in [
            plain.__code__,
            *(part for part in plain.__code__.co_consts if isinstance(part, types.CodeType)),
        ]
        for name in code.co_names
        if name in plain.__globals__
    }
    known = [(homes[name, value], own) for name, value, own in looked_up if (name, value) in homes]
    assert len(known) > 100
    for assigned_in, own in known:
        assert ({own} & assigned_in or assigned_in) & files
