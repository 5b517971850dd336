"""States of exported FMUs: a thousand of them, in two instances by turns, and in another process."""

import resource
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from nutamill.case import load_case
from nutamill.export.fmu.write import export_machine

pytest.importorskip("fmpy", reason="needs the extra fmu")
from fmu_session import States, marched, opened

pytestmark = [
    pytest.mark.external,
    pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler"),
]

CASES = {
    "mechanism, FMI 2": ("particle-damper", ["charge.kind=none"], "mechanism", 2),
    "mechanism, FMI 3": ("particle-damper", ["charge.kind=none"], "mechanism", 3),
    "whole, FMI 2": ("piston", ["charge.count=150", "run.threads=1"], "whole", 2),
}
STEP = 1e-3
OTHER = r"""
import sys
from pathlib import Path

import numpy as np
from fmu_session import States, marched, opened

path, state, rows = sys.argv[1:]
unit, places = opened(path)
states = States(unit)
states.set(states.load(Path(state).read_bytes()))
np.save(rows, marched(unit, list(places.values())[1:], 5, 1e-3, first=20))
"""


@pytest.fixture(scope="module", params=CASES)
def path(request, tmp_path_factory):
    machine, changes, what, version = CASES[request.param]
    target = tmp_path_factory.mktemp("states") / "machine.fmu"
    return export_machine(load_case(machine, changes).machine, target, what, version)


def test_a_thousand_states_have_the_same_bits_and_leave_no_memory_behind(path):
    """A state that is never freed would cost its size at each of 1000 turns: ten sizes are allowed for."""
    unit, places = opened(path)
    states, references = States(unit), list(places.values())[1:]
    marched(unit, references, 20, STEP)
    first = states.get()
    wanted = states.store(first)

    def turn():
        state = states.get()
        content = states.store(state)
        again = states.load(content)
        states.set(again)
        states.free(state)
        states.free(again)
        return content

    for _ in range(1000):  # what FMPy leaves to Python's collector has then reached its most
        turn()
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    assert all(turn() == wanted for _ in range(1000))
    kibibytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    assert kibibytes * 1024 < 10 * len(wanted)
    after = marched(unit, references, 5, STEP, first=20)
    states.set(first)
    assert np.array_equal(marched(unit, references, 5, STEP, first=20), after)


def test_two_instances_that_march_by_turns_give_the_bits_of_each_alone(path):
    alone, places = opened(path)
    references = list(places.values())[1:]
    wanted = marched(alone, references, 12, STEP)
    one, two = opened(path)[0], opened(path)[0]
    marched(two, references, 4, STEP)
    for k in range(8):
        assert np.array_equal(marched(one, references, 1, STEP, first=k)[0], wanted[k])
        assert np.array_equal(marched(two, references, 1, STEP, first=k + 4)[0], wanted[k + 4])
    assert not np.array_equal(wanted[0], wanted[11])


def test_a_state_goes_on_in_another_process_with_the_same_bits(path, tmp_path):
    unit, places = opened(path)
    states, references = States(unit), list(places.values())[1:]
    marched(unit, references, 20, STEP)
    (tmp_path / "state").write_bytes(states.store(states.get()))
    given = [str(path), str(tmp_path / "state"), str(tmp_path / "rows.npy")]
    subprocess.run([sys.executable, "-c", OTHER, *given], check=True, cwd=Path(__file__).parent)
    wanted = marched(unit, references, 5, STEP, first=20)
    assert np.array_equal(np.load(tmp_path / "rows.npy"), wanted)
