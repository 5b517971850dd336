"""A machine with its charge as an FMU: bits of `nutamill run`, lists that grow, states, other steps."""

import shutil
import subprocess

import numpy as np
import pytest

from nutamill.base.errors import CaseError
from nutamill.case import load_case
from nutamill.charge import assembly
from nutamill.export.fmu.write import export_machine

fmpy = pytest.importorskip("fmpy", reason="needs the extra fmu")
from fmu_session import marched, opened, recorded_rows, rows_in_host, unpacked_library  # noqa: E402

pytestmark = [
    pytest.mark.external,
    pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler"),
]

RATE, END = 1000, 0.06
CHANGES = ["charge.count=150", f"run.until={END} s", f"run.series_rate={RATE} Hz", "run.threads=1"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("whole")


@pytest.fixture(scope="module")
def piston(folder):
    return export_machine(load_case("piston", CHANGES).machine, folder / "piston.fmu", "whole")


@pytest.fixture(scope="module")
def recorded(folder):
    return recorded_rows(load_case("piston", CHANGES), folder / "piston.h5")


def test_every_series_of_machine_and_charge_has_the_bits_of_a_run(piston, recorded):
    from fmpy.validation import validate_fmu

    assert not validate_fmu(str(piston))
    names, values = recorded
    assert {"piston_charge_force_z", "ledger_residual", "interface_impulse_defect"} <= set(names)
    unit, places = opened(piston)
    references = [places[name] for name in names]
    assert np.array_equal(unit.get(references), values[0])
    rows = marched(unit, references, len(values) - 1, 1.0 / RATE)
    differ = [name for k, name in enumerate(names) if not np.array_equal(rows[:, k], values[1:, k])]
    assert not differ
    assert np.abs(values[-1, names.index("piston_charge_force_z")]) > 0.0


def test_the_machine_with_its_charge_runs_without_python_and_calls_none(piston, recorded, folder):
    names, values = recorded
    assert np.array_equal(rows_in_host(piston, folder, names, len(values) - 1, 1.0 / RATE), values)
    library = unpacked_library(piston, folder)
    symbols = subprocess.run(["nm", "-D", str(library)], capture_output=True, text=True, check=True).stdout
    assert "fmi2DoStep" in symbols and " Py" not in symbols and "NRT_" not in symbols


def test_lists_that_are_full_grow_and_the_bits_stay(recorded, folder, monkeypatch):
    def cramped(model, poses, clumps, longest, real, point, per_particle):
        return assembly_state(model, poses, clumps, longest, real, point, 0)

    assembly_state = assembly.empty_state
    monkeypatch.setattr(assembly, "empty_state", cramped)
    small = export_machine(load_case("piston", CHANGES).machine, folder / "small.fmu", "whole")
    names, values = recorded
    unit, places = opened(small)
    before = len(unit.serializeFMUstate(unit.getFMUstate()))
    rows = marched(unit, [places[name] for name in names], len(values) - 1, 1.0 / RATE)
    assert len(unit.serializeFMUstate(unit.getFMUstate())) > before
    assert np.array_equal(rows, values[1:])


def test_a_state_that_is_set_again_gives_the_same_bits_also_in_another_instance(piston, recorded):
    names, _ = recorded
    unit, places = opened(piston)
    other, _ = opened(piston)
    references = [places[name] for name in names]
    marched(unit, references, 20, 1.0 / RATE)
    state = unit.getFMUstate()
    stored = unit.serializeFMUstate(state)
    once = marched(unit, references, 10, 1.0 / RATE, first=20)
    unit.setFMUstate(state)
    assert np.array_equal(marched(unit, references, 10, 1.0 / RATE, first=20), once)
    other.setFMUstate(other.deSerializeFMUstate(stored))
    assert np.array_equal(marched(other, references, 10, 1.0 / RATE, first=20), once)
    assert len(stored) % 8 == 0


def test_a_communication_step_between_windows_keeps_momentum_ledger_and_means(piston, recorded):
    # 2.64 windows: a row of eight windows is 7.04 long, and a mean over eight would be 12 % low
    unit, places = opened(piston)
    names = ("piston_charge_force_z", "interface_impulse_defect", "kinetic_energy_charge", "ledger_residual")
    step = 3.3e-4
    force, defect, kinetic, residual = marched(
        unit, [places[name] for name in names], int(END / step), step
    ).T
    weight = 150 * 7800.0 * np.pi / 6.0 * 0.006**3 * 9.81
    of_run = recorded[1][:, recorded[0].index(names[0])]
    assert np.mean(force) == pytest.approx(np.mean(of_run[1:]), rel=0.03)
    assert defect.max() < 1e-6 * weight * END
    assert np.abs(residual).max() < 0.05 * kinetic.max()


def test_a_machine_without_a_charge_is_not_exported_whole(folder):
    with pytest.raises(CaseError, match="--what: whole needs a charge, this machine has none"):
        export_machine(load_case("numill", ["charge.kind=none"]).machine, folder / "none.fmu", "whole")
