"""Libraries of an exported machine for all platforms: linked, and looked at; run only where they can be."""

import shutil
import zipfile

import numpy as np
import pytest

from nutamill.case import load_case
from nutamill.export.fmu import linking, tables
from nutamill.export.fmu.linking import PLATFORMS, this_platform
from nutamill.export.fmu.write import export_machine

fmpy = pytest.importorskip("fmpy", reason="needs the extra fmu")
pytest.importorskip("ziglang", reason="needs the extra fmu")
pytest.importorskip("lief", reason="needs the extra cross")
from fmu_session import marched, opened  # noqa: E402
from library_symbols import of_python, symbols  # noqa: E402

pytestmark = pytest.mark.external

NEEDED = {".so": {"libm.so.6", "libc.so.6"}, ".dylib": {"/usr/lib/libSystem.B.dylib"}}
"""Libraries that each system has."""


@pytest.fixture(scope="module")
def machine():
    return load_case("particle-damper", ["charge.kind=none"]).machine


@pytest.fixture(scope="module")
def archive(machine, tmp_path_factory):
    return export_machine(machine, tmp_path_factory.mktemp("all") / "all.fmu", platforms="all")


@pytest.mark.parametrize("target", PLATFORMS, ids=[target.tuple for target in PLATFORMS])
def test_the_library_of_every_platform_calls_nothing_but_what_its_system_has(archive, target):
    with zipfile.ZipFile(archive) as members:
        looked = symbols(members.read(f"binaries/{target.folder}/nutamill{target.ending}"))
    assert not of_python(looked.asked + looked.offered)
    assert {"fmi2Instantiate", "fmi2DoStep", "fmi2GetReal"} <= set(looked.offered)
    assert {name for name in looked.offered if not name.startswith("fmi2")} <= {"nutamill_block"}
    assert all(not name.startswith(("nutamill_", "fmi2")) for name in looked.asked)
    if target.ending == ".dll":
        assert all(name.startswith("api-ms-win-crt-") or name == "KERNEL32.dll" for name in looked.libraries)
    else:
        assert set(looked.libraries) <= NEEDED[target.ending]
    if target.ending == ".so":
        assert tuple(map(int, looked.glibc.split("."))) <= (2, 17)
    if target.ending == ".dylib":
        assert looked.names == ["@rpath/nutamill.dylib"]


def test_a_library_for_every_computer_has_the_bits_of_the_one_for_this(archive, machine, tmp_path):
    rows = []
    for path in (archive, export_machine(machine, tmp_path / "this.fmu")):
        unit, places = opened(path)
        rows.append(marched(unit, list(places.values())[1:], 20, 1e-3))
    assert np.array_equal(rows[0], rows[1])


def refusal(path, token):
    """What an FMU of FMI 3 that gives no instance says."""
    messages = []
    unit = fmpy.fmi3.FMU3Slave(
        guid=token,
        unzipDirectory=fmpy.extract(str(path)),
        modelIdentifier="nutamill",
        instanceName="mill",
    )
    with pytest.raises(Exception, match="Failed to instantiate"):
        unit.instantiate(logMessage=lambda where, status, category, text: messages.append(text.decode()))
    return messages[0]


@pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler")
def test_a_processor_without_the_instructions_of_the_kernels_gets_a_sentence(machine, tmp_path, monkeypatch):
    """No processor has all of the 32 bits, of which some are reserved."""
    monkeypatch.setattr(tables, "EBX_7", {f"bit{k}": k for k in range(32)})
    written = linking.header
    wanted = ",".join(f"+bit{k}" for k in range(32))
    monkeypatch.setattr(linking, "header", lambda interface, token, _: written(interface, token, wanted))
    if not this_platform().tuple.startswith("x86_64"):
        pytest.skip("asked of x86-64 processors only")
    path = export_machine(machine, tmp_path / "other.fmu", version=3)
    message = refusal(path, fmpy.read_model_description(str(path)).guid)
    assert message.startswith("this processor lacks instructions of the one that the library was made for")


@pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler")
def test_the_library_of_another_description_is_refused(machine, tmp_path):
    path = export_machine(machine, tmp_path / "one.fmu", version=3)
    assert refusal(path, "{another}") == "the library does not belong to this modelDescription.xml"
