"""What an installation can do: versions, processor, optional parts, compiled kernels, a short self-test."""

import importlib.metadata
import platform
import re
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from nutamill import __version__
from nutamill.base.atomic_file import megabytes
from nutamill.base.cache_folder import cache_folder, cache_trouble
from nutamill.base.errors import MillError
from nutamill.base.host import free_disk, total_memory
from nutamill.base.kernel import compiled_mark
from nutamill.base.provenance import processor
from nutamill.case import load_case
from nutamill.charge.laws.composition import STANDARD_LAW, law_names
from nutamill.simulation.runs import run
from nutamill.simulation.setup.threads import usable_cores
from nutamill.view.film import ffmpeg_trouble
from nutamill.view.renderer import opengl_trouble

LIBRARIES = ("numpy", "scipy", "numba", "h5py", "pydantic", "xarray", "matplotlib")
"""Libraries that decide what an installation does."""
FOR_DEVELOPERS = ("dev", "docs", "cross")
"""Extras that a user does not need."""
LEDGER_SHARE = 1e-4
"""Share of the motor's work that the ledger of the self-test may leave open [1]."""
SELF_TEST = (
    "mechanism.mounting=rigid",
    "charge.kind=none",
    "drive.ramp=7000 rpm/s",
    "run.until=0.3 s",
)
"""Changes of the NuMill for the self-test."""


class Check(NamedTuple):
    """One thing that was looked at."""

    what: str
    """Its name."""
    state: str
    """``ok``, ``missing`` (an optional part), or ``FAULT``."""
    text: str
    """What was measured, or what to do."""

    @property
    def line(self) -> str:
        """One line of the answer."""
        return f"{self.state:8}{self.what:17}{self.text}"


def doctor() -> Iterator[Check]:
    """Yield everything about an installation that decides whether it works, the self-test last."""
    system = f"{platform.system()} {platform.release()}, Python {platform.python_version()}"
    yield Check("nutamill", "ok", f"{__version__}, {system}")
    yield Check("processor", "ok", f"{processor()}, {usable_cores()} cores")
    memory, disk = total_memory(), free_disk(Path.cwd())
    yield Check("memory", "ok", "not known" if memory is None else megabytes(memory))
    yield Check("free disk", "ok", "not known" if disk is None else f"{megabytes(disk)} in this folder")
    yield Check("libraries", "ok", ", ".join(f"{name} {_version(name)}" for name in LIBRARIES))
    for extra, lacking in lacking_packages().items():
        if extra in FOR_DEVELOPERS:
            continue
        advice = f'{", ".join(lacking)}: pip install ".[{extra}]" in your clone of the repository'
        yield Check(f'extra "{extra}"', "missing" if lacking else "ok", advice if lacking else "installed")
    yield _optional("OpenGL", opengl_trouble(), "pictures in three dimensions can be drawn")
    yield _optional("ffmpeg", ffmpeg_trouble(), "films can be written")
    yield _cache()
    yield _self_test()


def lacking_packages() -> dict[str, list[str]]:
    """Return the packages that are not installed, by the extra that they belong to."""
    lacking: dict[str, list[str]] = {}
    for text in importlib.metadata.requires("nutamill") or []:
        if match := re.match(r"([\w.-]+).*extra == ['\"](\w+)['\"]", text):
            lacking.setdefault(match[2], [])
            if not _version(match[1]):
                lacking[match[2]].append(match[1])
    return lacking


def _optional(what: str, trouble: str, good: str) -> Check:
    return Check(what, "missing" if trouble else "ok", trouble or good)


def _cache() -> Check:
    """Return the state of the compiled kernels."""
    if trouble := cache_trouble():
        return Check("kernels", "FAULT", trouble)
    folder = cache_folder()
    size = sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())
    compiled = compiled_mark(*law_names(STANDARD_LAW)).is_file()
    state = "compiled" if compiled else "not compiled yet: the first run with a charge takes minutes more"
    return Check("kernels", "ok", f"{state}; {megabytes(size)} in {folder}")


def _self_test() -> Check:
    """Run the empty NuMill for a moment and look at its energy ledger."""
    began = time.monotonic()
    try:
        case = load_case("numill", SELF_TEST)
        with tempfile.TemporaryDirectory() as folder, run(case, Path(folder) / "test.h5") as result:
            last = result.series.isel(time=-1)
            share = abs(float(last["ledger_residual"]) / float(last["motor_work"]))
    except MillError as error:
        return Check("self-test", "FAULT", str(error))
    seconds = time.monotonic() - began
    text = f"empty mill, 0.3 s simulated in {seconds:.1f} s; the energy ledger closes to {100 * share:.2g} %"
    return Check("self-test", "ok" if share < LEDGER_SHARE else "FAULT", text)


def _version(name: str) -> str:
    """Return the version of an installed package, or "" without it."""
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return ""
