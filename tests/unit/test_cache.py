"""Compiled kernels and settled beds in the cache: where they are, and what becomes of a run when they cannot
be there.
"""

import os
import pathlib
import pickle
import shutil
import subprocess
import sys

import numpy as np
import pytest

import nutamill
from nutamill.base import cache_folder, kernel
from nutamill.base.compiled_files import CompiledFiles
from nutamill.case import load_case
from nutamill.simulation import warm_up
from nutamill.simulation.progress_report import COMPILING
from nutamill.simulation.setup import bed as beds
from nutamill.simulation.setup.particles import particle_count


@pytest.fixture
def wanted(tmp_path, monkeypatch):
    """A cache folder that cannot be made, as a file is in its way."""
    (tmp_path / "file").write_text("", encoding="utf-8")
    monkeypatch.setenv(cache_folder.VARIABLE, str(tmp_path / "file" / "kernels"))
    cache_folder._chosen.cache_clear()
    yield tmp_path / "file" / "kernels"
    cache_folder._chosen.cache_clear()


def test_a_folder_that_cannot_be_written_is_replaced_by_a_temporary_one_with_one_sentence(
    wanted, tmp_path, monkeypatch
):
    folder = cache_folder.cache_folder()
    assert folder != wanted
    assert folder.is_dir() and os.access(folder, os.W_OK)
    assert os.environ[cache_folder.VARIABLE] == str(folder)  # of the processes that this one starts
    messages = []
    monkeypatch.setattr(warm_up, "compiled_mark", lambda *names: tmp_path / "mark")
    monkeypatch.setattr(warm_up, "JIT", True)
    monkeypatch.setattr(warm_up, "march_turntable", lambda: None)
    warm_up.warm_up_mechanism(messages.append)
    warm_up.warm_up_mechanism(messages.append)
    assert messages == [cache_folder.cache_trouble(), COMPILING]
    assert str(wanted) in messages[0] and "\n" not in messages[0]


DOUBLE = """
from nutamill.base.kernel import kernel

@kernel
def double(x):
    return 2 * x

print(double(21), sum(double.stats.cache_hits.values()), double.stats.cache_path is not None)
"""


@pytest.fixture
def doubled(tmp_path):
    """What a program with a kernel prints, the kernel's double and how often it came from the cache, and
    whether there is one.
    """
    (tmp_path / "double.py").write_text(DOUBLE, encoding="utf-8")
    (tmp_path / "temporary").mkdir()

    def run(cache):
        surroundings = os.environ | {cache_folder.VARIABLE: str(cache), "TMPDIR": str(tmp_path / "temporary")}
        command = [sys.executable, "-P", str(tmp_path / "double.py")]
        return subprocess.run(command, env=surroundings, capture_output=True, text=True, check=True).stdout

    return run


@pytest.mark.skipif(not kernel.JIT, reason="nothing is compiled")
def test_a_kernel_without_a_cache_runs_and_leaves_nothing_behind(doubled, tmp_path):
    assert doubled(tmp_path / "double.py" / "cache") == "42 0 True\n"
    assert not list((tmp_path / "temporary").iterdir())
    assert not list(tmp_path.glob("__pycache__/*.compiled"))


@pytest.mark.skipif(not kernel.JIT, reason="nothing is compiled")
def test_a_damaged_file_of_the_cache_is_compiled_anew(doubled, tmp_path):
    assert doubled(tmp_path / "cache") == "42 0 True\n"
    assert doubled(tmp_path / "cache") == "42 1 True\n"
    for file in (tmp_path / "cache").rglob("*.compiled"):
        file.write_bytes(file.read_bytes()[:100])
    assert doubled(tmp_path / "cache") == "42 0 True\n"
    assert doubled(tmp_path / "cache") == "42 1 True\n"


def test_the_mark_of_compiled_kernels_is_of_their_names_and_source(monkeypatch):
    here = kernel.compiled_mark("linear")
    assert here == kernel.compiled_mark("linear") != kernel.compiled_mark("hertz")
    monkeypatch.setattr(kernel, "kernel_digest", lambda: "another source")
    assert kernel.compiled_mark("linear") != here


ONE_KERNEL = """
from nutamill.base.frames import dot3
dot3((1.0, 0.0, 0.0), (1.0, 0.0, 0.0))
print(sum(dot3.stats.cache_hits.values()))
"""


def test_two_versions_stored_at_once_are_not_taken_for_each_other(tmp_path):
    one, other = (CompiledFiles(tmp_path, "module.function") for _ in range(2))
    one.save(("float64",), pickle.dumps("of floats"))
    other.save(("int64",), pickle.dumps("of integers"))
    assert one.load(("int64",)) == "of integers" and other.load(("float64",)) == "of floats"


def test_a_file_under_the_name_of_another_key_is_not_used(tmp_path):
    files = CompiledFiles(tmp_path, "module.function")
    files.save(("float64",), pickle.dumps("of floats"))
    files._file(("float64",)).rename(files._file(("int64",)))
    assert files.load(("int64",)) is None


@pytest.mark.skipif(not kernel.JIT, reason="nothing is compiled")
def test_a_second_installation_uses_what_the_first_has_compiled(tmp_path):
    hits = []
    for installation in ("first", "second"):
        package = tmp_path / installation / "nutamill"
        shutil.copytree(
            pathlib.Path(nutamill.__file__).parent, package, ignore=shutil.ignore_patterns("data")
        )
        surroundings = os.environ | {
            cache_folder.VARIABLE: str(tmp_path / "cache"),
            "PYTHONPATH": str(package.parent),
        }
        printed = subprocess.run(
            [sys.executable, "-c", ONE_KERNEL], env=surroundings, capture_output=True, text=True, check=True
        ).stdout
        hits.append(int(printed))
    assert hits == [0, 1]


@pytest.fixture
def case():
    """A handful of pellets."""
    return load_case("numill", ["charge.mass=0.01 kg"]).machine


@pytest.fixture
def settled(case, tmp_path, monkeypatch):
    """The beds that were settled, without a step; the cache is empty at first."""
    done = []

    def settle(case, progress):
        done.append(np.random.default_rng(len(done)).random((particle_count(case.machine), 3)))
        return done[-1]

    monkeypatch.setattr(beds, "_settle", settle)
    monkeypatch.setattr(beds, "beds_folder", lambda: tmp_path / "beds")
    monkeypatch.setattr(beds, "_settling_code", lambda: "")
    return done


def test_a_bed_is_settled_once(case, settled):
    assert not beds.bed_is_cached(case)
    first = beds.settled_bed(case)
    assert beds.bed_is_cached(case)
    assert beds.settled_bed(case).tobytes() == first.tobytes()
    assert len(settled) == 1


def flipped(content):
    return content[:-9] + bytes([content[-9] ^ 1]) + content[-8:]


@pytest.mark.parametrize(
    "damage", [lambda content: content[:-20], lambda content: b"", flipped], ids=["cut", "empty", "a bit"]
)
def test_a_damaged_bed_is_settled_anew(case, settled, damage):
    beds.settled_bed(case)
    file = beds.bed_file(case)
    file.write_bytes(damage(file.read_bytes()))
    assert not beds.bed_is_cached(case)
    assert beds.settled_bed(case).tobytes() == settled[1].tobytes()
    assert beds.settled_bed(case).tobytes() == settled[1].tobytes()
    assert len(settled) == 2


@pytest.mark.parametrize(
    "bed", [np.full((20, 3), np.nan), np.zeros((1, 3)), np.zeros(3)], ids=["NaN", "too few", "a row"]
)
def test_a_bed_that_is_none_is_not_used(case, settled, bed):
    if len(bed) == 20:
        bed = np.full((particle_count(case.machine), 3), np.nan)
    beds._keep(beds.bed_file(case), bed)
    assert beds.bed_file(case).exists()
    assert not beds.bed_is_cached(case)


@pytest.mark.parametrize("call", ["replace", "fsync"])
def test_a_bed_that_cannot_be_stored_leaves_nothing_behind(case, settled, tmp_path, monkeypatch, call):
    def refuse(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(beds.os, call, refuse)
    assert beds.settled_bed(case) is settled[0]
    assert not list((tmp_path / "beds").iterdir())
