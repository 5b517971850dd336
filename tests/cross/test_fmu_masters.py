"""Our FMUs under the master of another program, libcosim: bits of a run, from whatever thread it calls."""

import shutil

import numpy as np
import pytest

from nutamill.case import load_case
from nutamill.export.fmu.write import export_machine

fmpy = pytest.importorskip("fmpy", reason="needs the extra fmu")
pytest.importorskip("libcosimpy", reason="needs the extra cross")
from fmu_session import recorded_rows  # noqa: E402
from libcosimpy.CosimExecution import CosimExecution  # noqa: E402
from libcosimpy.CosimObserver import CosimObserver  # noqa: E402
from libcosimpy.CosimSlave import CosimLocalSlave  # noqa: E402

pytestmark = [
    pytest.mark.external,
    pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler"),
]

RUN = ['run.until="60 ms"', "run.series_rate=1000 Hz", "run.threads=1"]
STEP = 1_000_000
"""Communication step [ns]: libcosim counts whole nanoseconds."""


def rows_in_libcosim(path, names, count):
    """Return rows (count, n) of an FMU after each of `count` steps, by libcosim."""
    model = fmpy.read_model_description(str(path))
    places = {variable.name: variable.valueReference for variable in model.modelVariables}
    execution = CosimExecution.from_step_size(step_size=STEP)
    slave = execution.add_local_slave(CosimLocalSlave(fmu_path=str(path), instance_name="mill"))
    observer = CosimObserver.create_last_value()
    assert execution.add_observer(observer=observer)
    references = [places[name] for name in names]
    rows = []
    for _ in range(count):
        assert execution.step()
        rows.append(observer.last_real_values(slave, references))
    return np.array(rows)


@pytest.mark.parametrize(
    ("machine", "what", "changes"),
    [
        ("numill", "mechanism", ["charge.kind=none", 'drive.ramp="7000 rpm/s"']),
        ("piston", "whole", ["charge.count=150"]),
    ],
)
def test_every_series_has_the_bits_of_a_run_under_another_master(tmp_path, machine, what, changes):
    case = load_case(machine, [*changes, *RUN])
    names, values = recorded_rows(case, tmp_path / "run.h5")
    path = export_machine(case.machine, tmp_path / "machine.fmu", what)
    rows = rows_in_libcosim(path, names, len(values) - 1)
    differ = [name for k, name in enumerate(names) if not np.array_equal(rows[:, k], values[1:, k])]
    assert not differ
    assert len(names) > 40
