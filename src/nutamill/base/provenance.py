"""Where the numbers of a result come from: versions, commit, kernels, processor, threads, seed."""

import datetime
import importlib.metadata
import os
import platform
import subprocess
from pathlib import Path

PACKAGE = Path(__file__).parents[1]


def run_provenance(kernel_digest: str, seed: int, threads: int) -> dict[str, str | int]:
    """Collect the texts and numbers for ``/provenance`` of a result file.

    Parameters
    ----------
    kernel_digest : `nutamill.base.kernel.kernel_digest`, given so that this module needs no compiler
    seed : seed of the case [1]
    threads : threads of the charge [1]
    """
    known: dict[str, str | int] = {
        "package_version": _version("nutamill"),
        "git_commit": git_commit(),
        "kernel_digest": kernel_digest,
        "python": platform.python_version(),
        **{name: _version(name) for name in ("numpy", "numba", "llvmlite", "h5py")},
        "system": platform.platform(),
        "processor": processor(),
        "cores": os.cpu_count() or 0,
        "threads": threads,
        "seed": seed,
        "started": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
    }
    return {key: value for key, value in known.items() if value != ""}


def git_commit() -> str:
    """Return the commit of the sources, marked ``-dirty`` if they have been changed, or "" for an installed
    package or without git.
    """
    if not (PACKAGE.parent.parent / ".git").exists():
        return ""
    try:
        described = subprocess.run(
            ["git", "describe", "--always", "--abbrev=40", "--exclude=*", "--dirty"],
            cwd=PACKAGE,
            capture_output=True,
            text=True,
            timeout=5,
            check=True,
        )
    except (OSError, subprocess.SubprocessError):
        return ""
    return described.stdout.strip()


def processor() -> str:
    """Return the name of the processor, as the system gives it."""
    try:
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    except OSError:  # not Linux
        pass
    return platform.processor() or platform.machine()


def _version(name: str) -> str:
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return ""
