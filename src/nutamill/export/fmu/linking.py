"""Shared libraries of an FMU: object code of the kernels, the C skeleton, and a linker for each platform."""

import importlib.resources
import importlib.util
import os
import platform
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

from nutamill.base.errors import OutputError, missing_extra
from nutamill.base.object_code import CodeTarget, KernelEntry, constant_object, object_code, this_processor
from nutamill.export.fmu.interface import Interface
from nutamill.export.fmu.tables import header
from nutamill.mechanism.dynamics import march
from nutamill.simulation.coupling import march_coupled
from nutamill.simulation.row import mechanism_row

ENTRIES = (
    KernelEntry("nutamill_advance", march, ("mechanism", "state", "scratch", "step", "count"), True),
    KernelEntry(
        "nutamill_read",
        mechanism_row,
        ("mechanism", "state", "scratch", "sensors", "starts", "row"),
        False,
    ),
)
"""What the skeleton calls of the kernels of a mechanism."""
WHOLE_ENTRIES = (
    KernelEntry(
        "nutamill_advance", march_coupled, ("model", "state", "scratch", "count", "row", "0", "1"), True
    ),
)
"""What it calls of the kernels of a machine with its charge: the march by the only thread of its team."""
LINKED = {".so": ["-lm"], ".dylib": ["-Wl,-install_name,@rpath/nutamill.dylib"]}
"""Options of the linker for an ending.  A .dylib is named as the file of the link, unless it has one."""
BLOCK = "nutamill_block"
"""Name of the first block in a library."""


class Platform(NamedTuple):
    """A platform of FMI."""

    tuple: str
    """Folder of its library in FMI 3."""
    folder: str
    """Folder of its library in FMI 2, which names fewer platforms."""
    ending: str
    """Ending of a library."""
    target: CodeTarget
    """What the kernels are emitted for."""
    zig: str
    """Zig's name."""


PLATFORMS = (
    Platform(
        "x86_64-linux",
        "linux64",
        ".so",
        CodeTarget("x86_64-unknown-linux-gnu", "x86-64"),
        "x86_64-linux-gnu.2.17",
    ),
    Platform(
        "aarch64-linux",
        "aarch64-linux",
        ".so",
        CodeTarget("aarch64-unknown-linux-gnu", "generic"),
        "aarch64-linux-gnu.2.17",
    ),
    Platform(
        "x86_64-windows",
        "win64",
        ".dll",
        CodeTarget("x86_64-w64-windows-gnu", "x86-64"),
        "x86_64-windows-gnu",
    ),
    Platform(
        "x86_64-darwin", "darwin64", ".dylib", CodeTarget("x86_64-apple-darwin", "x86-64"), "x86_64-macos"
    ),
    Platform(
        "aarch64-darwin",
        "aarch64-darwin",
        ".dylib",
        CodeTarget("aarch64-apple-darwin", "generic"),
        "aarch64-macos",
    ),
)
"""Platforms that libraries are made for, with instructions that every processor of a platform has."""


def this_platform() -> Platform:
    """Return the platform that this program runs on. Raise OutputError if it is none of `PLATFORMS`."""
    machine = {"amd64": "x86_64", "arm64": "aarch64"}.get(
        platform.machine().lower(), platform.machine().lower()
    )
    system = {"win32": "windows"}.get(sys.platform, sys.platform)
    for known in PLATFORMS:
        if known.tuple == f"{machine}-{system}":
            return known
    raise OutputError(f"--platforms: no library can be made for {machine}-{system}")


def library(
    interface: Interface, version: int, token: str, target: Platform, portable: bool = False
) -> bytes:
    """Return the shared library of a machine for a platform.

    Parameters
    ----------
    interface : the machine
    version : version of FMI, 2 or 3
    token : as in the description
    target : the platform; another one than this needs ziglang
    portable : whether every computer of the platform can load it; needs ziglang. Else the library of this
        platform is for this computer, by its own compiler

    Raises
    ------
    NotInstalledError : no compiler for that platform
    OutputError : the compiler failed
    """
    command = _compiler(target, portable)
    whole = interface.whole is not None
    entries = WHOLE_ENTRIES if whole else ENTRIES
    code = code_target(interface, target, portable)
    with tempfile.TemporaryDirectory(prefix="nutamill-link-") as name:
        folder = Path(name)
        (folder / "kernels.o").write_bytes(object_code(entries, interface.arguments, code))
        (folder / "block.o").write_bytes(
            constant_object(BLOCK, interface.block.content.tobytes(), target.target)
        )
        (folder / "model.h").write_text(header(interface, token, code.features), encoding="utf-8")
        skeleton = importlib.resources.files("nutamill.export.fmu") / "skeleton"
        sources = ["core.c", f"fmi{version}.c", "whole.c" if whole else "mechanism.c"]
        for source in ("core.h", *sources):
            (folder / source).write_bytes((skeleton / source).read_bytes())
        out = folder / f"library{target.ending}"
        options = [
            "-O2",
            "-std=gnu11",
            "-fvisibility=hidden",
            "-ffp-contract=off",
            "-shared",
            "-s",
            "-o",
            str(out),
        ]
        options += [] if target.ending == ".dll" else ["-fPIC"]
        files = [str(folder / part) for part in (*sources, "kernels.o", "block.o")]
        libraries = LINKED.get(target.ending, [])
        environment = os.environ | {
            "ZIG_GLOBAL_CACHE_DIR": os.environ.get("ZIG_GLOBAL_CACHE_DIR", str(_zig_cache()))
        }
        done = subprocess.run(
            [*command, *options, *files, *libraries], capture_output=True, text=True, env=environment
        )
        if done.returncode or not out.is_file():
            lines = [line for line in done.stderr.splitlines() if line.strip()] or ["no message"]
            raise OutputError(f"{target.tuple}: the compiler failed: {lines[0]}")
        return out.read_bytes()


def code_target(interface: Interface, target: Platform, portable: bool = False) -> CodeTarget:
    """Return what the kernels are emitted for: what every processor of the platform has.

    A charge that need not be `portable` is emitted for this very processor where the platform is this one. It
    then has the bits of a run.
    """
    if interface.whole is not None and not portable and target == this_platform():
        return this_processor(target.target.triple)
    return target.target


def _zig_cache() -> Path:
    return Path(tempfile.gettempdir()) / "nutamill-zig"


def _compiler(target: Platform, portable: bool) -> list[str]:
    """Return the command that compiles and links for a platform.

    A library of this computer's own compiler asks for its C library or a newer one.
    """
    if not portable and target == this_platform() and (local := shutil.which("cc")):
        return [local]
    if (package := importlib.util.find_spec("ziglang")) is not None and package.origin is not None:
        program = "zig.exe" if sys.platform == "win32" else "zig"
        return [str(Path(package.origin).with_name(program)), "cc", "-target", target.zig]
    raise missing_extra(f"A library for {target.tuple}", "ziglang", "fmu")
