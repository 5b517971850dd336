"""Processes that the package starts: they load nothing from the working folder, and none outlives its
parent.
"""

import os
import pathlib
import re
import signal
import subprocess
import sys
import time

import pytest

import nutamill
from nutamill.base.child import ended, start_child
from nutamill.simulation import warm_up

PACKAGE = pathlib.Path(nutamill.__file__).parent
PATIENCE = 60.0
"""Longest wait for a process on a busy machine [s]."""

SLEEPER = (
    "import os, time; from nutamill.base.child import task_of_parent;"
    " open(task_of_parent(), 'w').write(str(os.getpid())); time.sleep(600)"
)
"""A child that writes its number into a file and would then stay for ten minutes."""


def until(true):
    """Wait until a condition holds; returns whether it does."""
    end = time.monotonic() + PATIENCE
    while not (holds := true()) and time.monotonic() < end:
        time.sleep(0.05)
    return holds


def number_in(path):
    return int(text) if path.exists() and (text := path.read_text()) else None


def runs(number):
    """Whether a process with this number is there and is no zombie."""
    try:
        os.kill(number, 0)
        stat = pathlib.Path(f"/proc/{number}/stat")
        return not stat.exists() or stat.read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except (ProcessLookupError, FileNotFoundError):
        return False


def test_every_child_is_started_without_the_working_folder_on_its_path():
    starts = [
        (path.name, line.strip())
        for path in PACKAGE.rglob("*.py")
        for line in path.read_text(encoding="utf-8").splitlines()
        if re.search(r"sys\.executable|multiprocessing|ProcessPool", line)
    ]
    assert len(starts) == 2
    assert {name for name, _ in starts} == {"child.py", "speed.py"}
    assert all('[sys.executable, "-P", ' in line for _, line in starts)


def test_a_module_beside_the_cases_is_not_run_in_a_child(tmp_path, monkeypatch):
    (tmp_path / "numpy.py").write_text("open('taken', 'w')", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    program = (
        "import numpy; from nutamill.base.child import task_of_parent; open(task_of_parent(), "
        "'w').write(numpy.__version__)"
    )
    child = start_child(program, "written")
    with child.stdin:
        assert child.wait(PATIENCE) == 0
    assert (tmp_path / "written").exists()
    assert not (tmp_path / "taken").exists()


@pytest.mark.skipif(os.name != "posix", reason="process numbers and signals are those of POSIX systems")
@pytest.mark.parametrize("end", [signal.SIGTERM, signal.SIGKILL])
def test_a_child_ends_with_its_parent(tmp_path, end):
    task = str(tmp_path / "number")
    program = (
        f"import time; from nutamill.base.child import start_child; start_child({SLEEPER!r}, "
        f"{task!r}); time.sleep(600)"
    )
    parent = subprocess.Popen([sys.executable, "-c", program])
    try:
        assert until(lambda: number_in(tmp_path / "number"))
        child = number_in(tmp_path / "number")
        assert runs(child)
    finally:
        parent.send_signal(end)
        parent.wait()
    assert until(lambda: not runs(child))


def test_a_child_ends_when_its_parent_is_interrupted(tmp_path):
    child = start_child(SLEEPER, str(tmp_path / "number"))
    with pytest.raises(KeyboardInterrupt), ended(child):
        assert child.poll() is None
        raise KeyboardInterrupt
    assert child.poll() is not None


def test_compiling_that_is_interrupted_leaves_no_compiling_process(tmp_path, monkeypatch):
    children = []

    def sleeper(program, task):
        children.append(start_child(SLEEPER, str(tmp_path / "number")))
        return children[0]

    def interrupt():
        raise KeyboardInterrupt

    monkeypatch.setattr(warm_up, "compiled_mark", lambda *names: tmp_path / "mark")
    monkeypatch.setattr(warm_up, "JIT", True)
    monkeypatch.setattr(warm_up, "start_child", sleeper)
    monkeypatch.setattr(warm_up, "march_turntable", interrupt)
    with pytest.raises(KeyboardInterrupt):
        warm_up.warm_up()
    assert children[0].poll() is not None
    assert not (tmp_path / "mark").exists()
