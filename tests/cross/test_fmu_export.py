"""Our mechanism as an FMU: bits of `nutamill run` under FMPy and in a C host without Python, whatever the
communication step; state, interface; and the same FMU as a foreign machine in our own run.
"""

import re
import shutil
import subprocess
import zipfile

import numpy as np
import pytest
from motor_on_shaft import SHAFT

from nutamill.base.errors import CaseError, NotInstalledError, OutputError
from nutamill.case import load_case
from nutamill.export.fmu import linking
from nutamill.export.fmu.interface import mechanism_interface
from nutamill.export.fmu.write import export_machine

pytestmark = [
    pytest.mark.external,
    pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler"),
]
fmpy = pytest.importorskip("fmpy", reason="needs the extra fmu")
from fmu_session import marched, opened, recorded_rows, rows_in_host, unpacked_library  # noqa: E402

CHANGES = ["charge.kind=none", 'run.until="0.1 s"', "run.series_rate=1000 Hz", 'drive.ramp="7000 rpm/s"']
RATE = 1000


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("fmu")


@pytest.fixture(scope="module")
def mill(folder):
    case = load_case("numill", CHANGES)
    return {
        version: export_machine(case.machine, folder / f"mill{version}.fmu", version=version)
        for version in (2, 3)
    }


@pytest.fixture(scope="module")
def recorded(folder):
    return recorded_rows(load_case("numill", CHANGES), folder / "mill.h5")


def test_a_mill_with_a_charge_is_exported_without_what_is_taken_of_the_charge(folder):
    path = export_machine(load_case("numill").machine, folder / "loaded.fmu")
    names = {variable.name for variable in fmpy.read_model_description(str(path)).modelVariables}
    assert {"driveshaft_torque", "crank_pin_force_resultant"} <= names
    assert not names & {"charge_force_x", "charge_phase_lag", "wall_normal_loss"}


@pytest.mark.parametrize("version", [2, 3])
def test_every_recorded_value_has_the_bits_of_a_run(mill, recorded, version):
    from fmpy.validation import validate_fmu

    assert not validate_fmu(str(mill[version]))
    names, values = recorded
    assert len(names) > 100
    unit, places = opened(mill[version])
    references = [places[name] for name in names]
    assert np.array_equal(unit.get(references), values[0])
    rows = marched(unit, references, len(values) - 1, 1.0 / RATE)
    differ = [name for k, name in enumerate(names) if not np.array_equal(rows[:, k], values[1:, k])]
    assert not differ


def test_the_library_runs_without_python_and_calls_none(mill, recorded, folder):
    names, values = recorded
    assert np.array_equal(rows_in_host(mill[2], folder, names, len(values) - 1, 1.0 / RATE), values)
    library = unpacked_library(mill[2], folder)
    symbols = subprocess.run(["nm", "-D", str(library)], capture_output=True, text=True, check=True)
    assert not re.search(r"\bPy|numba_(?!attempt)|NRT_", symbols.stdout)
    exported = {line.split()[-1] for line in symbols.stdout.splitlines() if line.split()[-2] not in "Uwv"}
    assert {name for name in exported if not name.startswith("fmi2")} <= {"nutamill_block"}
    assert "fmi2DoStep" in exported
    needed = subprocess.run(["ldd", str(library)], capture_output=True, text=True, check=True)
    assert "python" not in needed.stdout


def test_communication_steps_that_are_multiples_of_the_inner_step_give_the_same_bits(mill):
    inner = mechanism_interface(load_case("numill", CHANGES).machine).model.plan.dt
    ends = []
    for count in (1, 3, 6):
        unit, places = opened(mill[2])
        references = [places["crank_pin_force_resultant"], places["bodies.chamber.quaternion.y"]]
        ends.append(marched(unit, references, 60 // count, count * inner)[-1])
    assert np.array_equal(ends[0], ends[1])
    assert np.array_equal(ends[0], ends[2])


def test_other_communication_steps_are_of_second_order(folder):
    """Steps of 1.4 inner steps are made as 1 and 0.4: the error against the plain grid is that of the scheme,
    and falls by four with the inner step; a factor 3 leaves room for the next order.
    """
    errors = []
    for inner in (500e-6, 250e-6):
        machine = load_case("particle-damper").machine
        machine = machine.model_copy(update={"run": machine.run.model_copy(update={"step": inner})})
        path = export_machine(machine, folder / "steps.fmu")
        ends = []
        for ratio in (1.0, 1.4):
            unit, places = opened(path)
            references = [places["bodies.box.position.x"]]
            ends.append(marched(unit, references, round(0.07 / inner / ratio), ratio * inner)[-1][0])
        errors.append(abs(ends[0] - ends[1]))
    assert errors[0] > 3.0 * errors[1] > 0.0


def test_a_state_that_is_set_again_gives_the_same_bits_also_in_another_instance(mill):
    unit, places = opened(mill[2])
    references = list(places.values())[1:]
    marched(unit, references, 5, 1.0 / RATE)
    state = unit.getFMUstate()
    first = marched(unit, references, 5, 1.0 / RATE, first=5)
    unit.setFMUstate(state)
    assert np.array_equal(marched(unit, references, 5, 1.0 / RATE, first=5), first)
    other, _ = opened(mill[2])
    marched(other, references, 2, 3e-4)  # somewhere else before it gets the state
    other.setFMUstate(other.deSerializeFMUstate(unit.serializeFMUstate(state)))
    assert np.array_equal(marched(other, references, 5, 1.0 / RATE, first=5), first)


def test_two_instances_do_not_disturb_each_other(mill):
    alone, places = opened(mill[2])
    references = list(places.values())[1:]
    wanted = marched(alone, references, 4, 1.0 / RATE)
    one, _ = opened(mill[2])
    two, _ = opened(mill[2])
    for k in range(4):
        two.set([places["wrench.chamber.force.x"]], [50.0 * k])
        two.doStep(k / RATE, 1.0 / RATE)
        one.doStep(k / RATE, 1.0 / RATE)
        assert np.array_equal(one.get(references), wanted[k])
    assert not np.array_equal(two.get(references), wanted[3])


def shaft(folder):
    without_drag = SHAFT.replace('friction = { viscous = "0.02 N m s/rad" }\n', "")
    (folder / "shaft.toml").write_text(without_drag, encoding="utf-8")
    return load_case(folder / "shaft.toml").machine


def test_a_torque_that_is_an_input_accelerates_the_shaft(folder):
    """0.5 N m on 0.02 kg m^2 are 25 rad/s^2; the first inner step has half of it, the mean of both ends."""
    unit, places = opened(export_machine(shaft(folder), folder / "torque.fmu", drives="torque"))
    unit.set([places["drives.shaft.torque"]], [0.5])
    rows = marched(unit, [places["drive_shaft_speed"], places["drive_shaft_torque"]], 10, 1e-3)
    assert rows[-1, 0] == pytest.approx(25.0 * (10e-3 - 0.5 * 50e-6), rel=1e-12)
    assert rows[-1, 1] == 0.5


def test_a_speed_that_is_an_input_is_reached_at_the_end_of_the_step(folder):
    unit, places = opened(export_machine(shaft(folder), folder / "speed.fmu", drives="speed"))
    names = ("drive_shaft_speed", "drive_shaft_angle", "drive_shaft_torque")
    rows = []
    for k, speed in enumerate((1.0, 3.0, 3.0)):
        unit.set([places["drives.shaft.speed"]], [speed])
        rows.append(marched(unit, [places[name] for name in names], 1, 1e-3, first=k)[0])
    speeds, angles, torques = np.array(rows).T
    assert speeds == pytest.approx([1.0, 3.0, 3.0], rel=1e-12)
    assert angles == pytest.approx([0.5e-3, 2.5e-3, 5.5e-3], rel=1e-12)
    assert torques == pytest.approx([0.02 * 1e3, 0.02 * 2e3, 0.0], rel=1e-9, abs=1e-9)


def test_a_wrench_that_is_an_input_acts_as_in_a_run_with_a_charge(folder):
    """A moment about the axis on the free shaft, held over a step, gives exactly its impulse."""
    machine = shaft(folder)
    unit, places = opened(export_machine(machine, folder / "wrench.fmu", drives="torque"))
    unit.set([places["wrench.shaft.moment.z"]], [0.5])
    rows = marched(unit, [places["bodies.shaft.angular_velocity.z"]], 4, 1e-3)
    assert rows[:, 0] == pytest.approx(25.0 * 1e-3 * np.arange(1, 5), rel=1e-12)


def test_the_same_machine_gives_the_same_file(folder):
    machine = shaft(folder)
    one, two = (export_machine(machine, folder / f"{name}.fmu") for name in ("one", "two"))
    assert one.read_bytes() == two.read_bytes()


def test_documentation_units_and_start_values_are_in_the_archive(mill):
    with zipfile.ZipFile(mill[2]) as archive:
        assert {"documentation/machine.png", "documentation/index.html", "resources/case.toml"} <= set(
            archive.namelist()
        )
    variables = fmpy.read_model_description(str(mill[2])).modelVariables
    units = {variable.name: variable.unit for variable in variables}
    assert units["crank_pin_force_resultant"] == "N"
    assert units["wrench.chamber.moment.z"] == "N.m"
    assert units["bodies.frame.acceleration.z"] == "m/s2"
    assert all(variable.description for variable in variables)
    assert all(float(variable.start) == 0.0 for variable in variables if variable.causality == "input")


def test_a_machine_with_an_fmu_is_not_exported(folder, tmp_path):
    (tmp_path / "m.fmu").write_bytes(b"not looked at")
    shaft(folder)
    text = (folder / "shaft.toml").read_text(encoding="utf-8")
    text += '\n[[fmus]]\nname="m"\nfile="m.fmu"\n[[fmus.drives]]\ndrive="shaft"\ntorque="M"\n'
    (tmp_path / "with.toml").write_text(text, encoding="utf-8")
    with pytest.raises(CaseError, match="cannot be exported in an FMU"):
        mechanism_interface(load_case(tmp_path / "with.toml").machine)


def test_what_cannot_be_linked_is_refused_with_a_sentence(folder, monkeypatch):
    interface = mechanism_interface(shaft(folder))
    here = linking.this_platform()
    monkeypatch.setattr(linking.shutil, "which", lambda name: None)
    monkeypatch.setattr(linking.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(NotInstalledError, match="needs ziglang, which is not installed"):
        linking.library(interface, 2, "token", here)
    monkeypatch.setattr(linking.shutil, "which", lambda name: "/bin/false")
    with pytest.raises(OutputError, match="the compiler failed: no message"):
        linking.library(interface, 2, "token", here)
    monkeypatch.setattr(linking.platform, "machine", lambda: "abacus")
    with pytest.raises(OutputError, match="no library can be made for abacus"):
        linking.this_platform()


def test_a_drive_option_without_a_drive_is_refused(folder):
    machine = shaft(folder).model_copy(update={"drives": ()})
    with pytest.raises(CaseError, match="has no use here, got torque: the machine has no drives"):
        mechanism_interface(machine, "torque")
