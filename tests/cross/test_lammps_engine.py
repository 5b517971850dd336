"""The charge in LAMMPS against this engine: pellets at every kind of wall, pairs, ledger, processes."""

import contextlib
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import lammps_bench

from nutamill.base.errors import MillError
from nutamill.result import open_result

pytestmark = pytest.mark.external


@pytest.fixture(autouse=True)
def _lammps():
    pytest.importorskip("lammps", reason='needs LAMMPS, of the extra "mpi"')


@pytest.mark.parametrize("kind", ["floor", "cylinder", "rib edge", "cone", "mesh"])
def test_a_pellet_at_a_nutating_wall_has_the_trajectory_of_this_engine(kind):
    both = lammps_bench.Both(
        [[0.001, 0.002, 0.0035]],
        [[0.02, -0.01, -0.5]],
        [[40.0, -20.0, 30.0]],
        lammps_bench.wall_of(kind),
        4e-6,
    )
    contacts = 0
    for _ in range(60):
        touched = both.theirs.state.ledger[3]
        both.march(5)
        contacts += both.theirs.state.ledger[3] != touched
    assert contacts >= 3
    ours, theirs = both.column("x")
    assert np.abs(ours - theirs).max() < 1e-9
    assert np.allclose(both.ours[1].ledger, both.theirs.state.ledger, rtol=1e-6, atol=1e-12)
    # every impact is counted once, in the same bin
    assert np.array_equal(
        *(charge[1].impacts.spectra.sum(axis=0) for charge in (both.ours, both.of_lammps()))
    )
    both.close()


def test_pellets_of_two_sizes_have_the_stiffness_of_both():
    sizes = ["charge.sizes=[['4 mm', 0.3], ['6 mm', 0.7]]", "contact.stiffness=young"]
    at_rest = [[0.0, 0.0, 0.0]] * 2
    motions = [[0.5, 0.0, 0.0], [-0.5, 0.0, 0.0]]
    both = lammps_bench.Both([[0, 0, 0], [0.0052, 0, 0]], motions, at_rest, [], 4e-7, False, sizes)
    both.march(80)
    ours, theirs = both.column("x")
    # a stiffness of 400 instead of 480 kN/m would make the contact longer by 5 us and more, at 1 m/s
    assert np.abs(ours - theirs).max() < 1e-6
    assert both.column("v")[0][0, 0] < 0.0
    both.close()


DAMPER = ["-s", "charge.engine=lammps", "-s", "charge.count=200"]
DAMPER += ["-s", "run.until=4 ms", "-s", "run.checkpoint=2 ms"]


def nutamill(ranks, *words):
    """Return the call of a command on some processes."""
    beside = str(pathlib.Path(sys.executable).parent)
    launcher = shutil.which("mpiexec", path=beside) or shutil.which("mpiexec")
    if launcher is None:
        pytest.skip("needs mpiexec, of the extra mpi")
    return [launcher, "-n", str(ranks), sys.executable, "-m", "nutamill", *map(str, words)]


def done(call):
    """Run a command to its end and return its output."""
    ended = subprocess.run(call, capture_output=True, text=True, timeout=300, check=False)
    assert ended.returncode == 0, ended.stdout + ended.stderr
    return ended.stdout


@pytest.fixture(scope="module")
def dampers(tmp_path_factory):
    """The particle damper for 4 ms on one process and on two."""
    pytest.importorskip("mpi4py", reason='needs mpi4py, of the extra "mpi"')
    folder = tmp_path_factory.mktemp("dampers")
    files = [folder / "one.h5", folder / "two.h5"]
    for ranks, file in enumerate(files, 1):
        done(nutamill(ranks, "run", "particle-damper", "--to", file, *DAMPER))
    return files


def series(file, name):
    with open_result(file) as result:
        return result.series[name].values


def test_two_processes_march_as_one(dampers):
    one, two = (
        np.column_stack([series(file, f"box_charge_force_{axis}") for axis in "xyz"]) for file in dampers
    )
    scale = np.abs(one).max()
    # sums in another order: rounding at first, which contacts then make grow
    assert np.abs(one - two)[1].max() <= 1e-12 * scale
    assert np.abs(one - two).max() <= 1e-9 * scale
    assert np.allclose(*(series(file, "box_position_x") for file in dampers), rtol=1e-12, atol=0.0)


def test_two_processes_count_the_walls_as_one(dampers):
    one, two = (done_at_walls(file) for file in dampers)
    assert one["impact_number"].sum() > 0.0 and one["wall_contacts"].sum() > 0.0
    for name in ("impact_number", "wall_contacts", "cell_particles", "cell_neighbours", "neighbour_time"):
        assert np.array_equal(one[name], two[name]), name
    # sums of whole small units, of works that agree to rounding
    for name in ("wall_load", "wall_cutting_energy", "cell_mass"):
        assert np.allclose(one[name], two[name], rtol=1e-6, atol=1e-6 * np.abs(one[name]).max()), name


def test_samples_see_all_particles_and_their_contacts(dampers):
    sums, n = done_at_walls(dampers[1]), 200
    assert sums["cell_particles"].sum() == pytest.approx(n * sums["sampled_time"])
    assert sums["neighbour_time"].sum() == pytest.approx(n * sums["sampled_time"])
    # contacts of the rows, at the ends of the same intervals
    pairs, walls = (series(dampers[1], f"{kind}_contacts")[1:].sum() * 1e-3 for kind in ("pair", "wall"))
    assert sums["cell_neighbours"].sum() == pytest.approx(2.0 * pairs)
    assert sums["wall_contacts"].sum() == pytest.approx(walls, rel=0.05)


def done_at_walls(file):
    """The last statistics of a file, by name."""
    with open_result(file) as result:
        last = result.statistics.isel(time=-1)
        return {name: last[name].values for name in last.data_vars}


def test_the_ledger_closes_on_two_processes(dampers):
    residual, energy = (series(dampers[1], name) for name in ("ledger_residual", "elastic_energy"))
    assert np.abs(residual).max() < 1e-3 * energy[0]


def test_the_mechanism_receives_the_impulse_that_the_charge_gives(dampers):
    defect = series(dampers[1], "interface_impulse_defect")
    # 0.5 kg that the spring brings to some 0.05 m/s
    assert np.abs(defect).max() < 1e-12 * 0.5 * 0.05


def test_a_run_goes_on_with_another_number_of_processes(dampers, tmp_path):
    file = shutil.copy(dampers[1], tmp_path / "a.h5")
    done(nutamill(1, "resume", file, "--until", "6 ms"))
    kinetic, residual = (series(file, name) for name in ("kinetic_energy_charge", "ledger_residual"))
    energy = series(file, "elastic_energy")[0]
    assert len(kinetic) == 7
    assert np.abs(residual).max() < 1e-3 * energy


def test_a_killed_process_ends_the_run_and_leaves_a_file_that_goes_on(tmp_path):
    file = tmp_path / "a.h5"
    call = nutamill(2, "run", "particle-damper", "--to", file, *DAMPER, "-s", "run.until=1 s")
    with subprocess.Popen(call, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as run:
        begun = time.monotonic()
        while not (file.exists() and (marks := processes_of(file)) and reached(file) >= 0.002):
            assert time.monotonic() < begun + 200.0
            time.sleep(0.2)
        os.kill(max(marks), signal.SIGKILL)
        killed = time.monotonic()
        output, _ = run.communicate(timeout=60)
        assert time.monotonic() < killed + 10.0
    assert run.returncode != 0
    assert "Killed" in output or "signal 9" in output
    end = reached(file) + 0.02
    done(nutamill(1, "resume", file, "--until", f"{end} s"))
    assert reached(file) >= end - 1e-9


def processes_of(file):
    """Numbers of the processes of Python whose command names a file."""
    numbers = []
    for place in pathlib.Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            words = (place / "cmdline").read_bytes().split(b"\0")
            if str(file).encode() in words and words[0] == sys.executable.encode():
                numbers.append(int(place.name))
    return numbers


def reached(file):
    """Simulated time that a file holds, 0 where it cannot be read now [s]."""
    with contextlib.suppress(MillError), open_result(file) as result:
        return result.reached if result.has_checkpoint else 0.0
    return 0.0
