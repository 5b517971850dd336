"""The archive of an exported machine: description, libraries, documentation."""

import hashlib
import io
import zipfile
from collections.abc import Callable
from pathlib import Path

from nutamill import __version__
from nutamill.base.atomic_file import check_writable, write_whole
from nutamill.base.kernel import kernel_digest
from nutamill.base.units import shown
from nutamill.case.machine import Machine
from nutamill.export.fmu.description import model_description, unit_name
from nutamill.export.fmu.interface import Interface, mechanism_interface
from nutamill.export.fmu.linking import PLATFORMS, code_target, library, this_platform
from nutamill.export.fmu.picture import picture
from nutamill.export.fmu.whole import whole_interface

FMU = (".fmu",)
"""Ends of the names of FMUs."""
VERSIONS = (2, 3)
"""Versions of FMI."""
STAMP = (2026, 1, 1, 0, 0, 0)
"""Time of every member of the archive, so that the same machine gives the same file."""


def export_machine(
    machine: Machine,
    path: str | Path,
    what: str = "mechanism",
    version: int = 2,
    drives: str = "programme",
    platforms: str = "this",
    log: Callable[[str], None] | None = None,
) -> Path:
    """Write a machine as an FMU for co-simulation, and return the path.

    Parameters
    ----------
    machine : the machine
    path : file to write
    what : "mechanism", without the charge, or "whole", with it
    version : version of FMI, 2 or 3
    drives : "programme", as the case says; "speed" or "torque", as inputs ask
    platforms : "this", for the computer at hand, or "all", for every computer of each of `PLATFORMS`
    log : called with a line for each platform

    Raises
    ------
    CaseError : every fault of the machine, or a name that does not end with .fmu
    NotInstalledError : no compiler for a platform
    OutputError : the compiler failed, or the file cannot be written
    """
    path = Path(path)
    check_writable(path, FMU)
    interface = (whole_interface if what == "whole" else mechanism_interface)(machine, drives)
    identifier = "nutamill"
    token = _token(interface, version)
    members = {"modelDescription.xml": model_description(interface, version, identifier, token).encode()}
    here, portable = this_platform(), platforms == "all"
    for target in PLATFORMS if portable else [here]:
        folder = target.tuple if version == 3 else target.folder
        code = library(interface, version, token, target, portable)
        members[f"binaries/{folder}/{identifier}{target.ending}"] = code
        if log is not None:
            run = "" if target == here else ", linked and not run here"
            cpu = code_target(interface, target, portable).cpu
            log(f"{target.tuple:15} {len(code)} bytes, instructions of {cpu}{run}")
    members |= _documents(interface, version, drives)
    members["documentation/machine.png"] = picture(machine)
    return write_whole(path, _archive(members))


def _token(interface: Interface, version: int) -> str:
    """Return what identifies description and library: a digest of both."""
    content = hashlib.sha256(kernel_digest().encode())
    content.update(interface.block.content.tobytes())
    content.update(repr((interface.variables, interface.inputs, interface.made, version)).encode())
    digest = content.hexdigest()
    return f"{{{digest[:8]}-{digest[8:12]}-{digest[12:16]}-{digest[16:20]}-{digest[20:32]}}}"


def _documents(interface: Interface, version: int, drives: str) -> dict[str, bytes]:
    """Return the page of the documentation and the case, by their names in the archive."""
    machine, folder = interface.model.machine, "documentation"
    rows = "\n".join(
        f"<tr><td>{v.name}</td><td>{v.causality}</td><td>{unit_name(v.unit)}</td><td>{v.meaning}</td></tr>"
        for v in interface.variables
    )
    charge = interface.model.charge
    if charge is None:
        content = "Mechanism without charge"
        promise = "A communication step that is a multiple of it gives the bits of <code>nutamill run</code>"
    else:
        plan = interface.model.plan
        between = shown(plan.dt * plan.windows_per_row, "us")
        content = f"Machine with its charge of {charge.n_particles} particles, on one thread"
        promise = (
            f"Series are those of the last row, rows are {between} apart. A communication step that is a "
            "multiple of the inner step gives the bits of <code>nutamill run</code> on the processor that "
            "the library was made on, elsewhere its means"
        )
    page = f"""<!DOCTYPE html>
<html><head><meta charset="utf-8"><title>{machine.name}</title></head><body>
<h1>{machine.title or machine.name}</h1>
<p>{content}, FMI {version}.0 for co-simulation, by nutamill {__version__}.
It needs no Python and no licence. Inner step {shown(interface.model.plan.dt, "us")}.
{promise}; another one ends with a shorter inner step. Drives: {drives}. Inputs are held over a step.
All quantities are in SI, vectors in world axes unless the meaning says otherwise.</p>
<p><img src="machine.png" alt="the machine"></p>
<table><tr><th>variable</th><th>causality</th><th>unit</th><th>meaning</th></tr>
{rows}
</table></body></html>
"""
    index = "index.html" if version == 3 else "_main.html"
    case = machine.to_toml().encode()
    pages = {f"{folder}/index.html": page.encode()}
    if index != "index.html":
        pages[f"{folder}/{index}"] = page.encode()
    return pages | {"resources/case.toml": case}


def _archive(members: dict[str, bytes]) -> bytes:
    """Return a ZIP archive of these members."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in members.items():
            archive.writestr(zipfile.ZipInfo(name, STAMP), data, zipfile.ZIP_DEFLATED)
    return content.getvalue()
