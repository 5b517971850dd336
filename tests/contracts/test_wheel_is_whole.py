"""What ``pip install`` gives is what the checkout holds: the wheel leaves no file of the package behind."""

import pathlib
import subprocess
import sys
import zipfile

import pytest

ROOT = pathlib.Path(__file__).parents[2]


def test_wheel_holds_every_file_of_the_package(tmp_path):
    pytest.importorskip("hatchling", reason="the wheel is built by hatchling: pip install -e '.[dev]'")
    built = subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(tmp_path)],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )
    assert built.returncode == 0, built.stderr
    (wheel,) = tmp_path.glob("*.whl")
    packed = {name for name in zipfile.ZipFile(wheel).namelist() if name.startswith("nutamill/")}
    source = ROOT / "src"
    files = {
        p.relative_to(source).as_posix()
        for p in (source / "nutamill").rglob("*")
        if p.is_file() and "__pycache__" not in p.parts
    }
    assert packed == files
