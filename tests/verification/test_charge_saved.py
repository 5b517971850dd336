"""A charge goes on from its checkpoint with the bits it would have had, and the checkpoint is small."""

import h5py
import numpy as np
import pytest
from charge_bench import FLOOR, law
from mesh_bench import box

from nutamill.base.kernel import JIT
from nutamill.charge.face import FIXED_FRAME, Charge
from nutamill.charge.model import Clock
from nutamill.charge.particles.particles import clumps, spheres
from nutamill.charge.particles.shapes import clump_shape
from nutamill.charge.saved_state import put_back, saved_arrays
from nutamill.charge.walls.mesh_patches import mesh_surfaces
from nutamill.charge.walls.surface import Surface, SurfaceKind
from nutamill.result.layout import Checkpoint
from nutamill.result.parts import write_checkpoint

R = 0.0025
GRAIN = clump_shape([[0, 0, 0], [0.001, 0, 0], [0.0004, 0.0009, 0]], [0.001, 0.0009, 0.0008])
EXACT = (
    FLOOR,
    Surface("bore", SurfaceKind.CYLINDER, 0, 0, size=(0.022, 0, 0)),
    Surface("rib", SurfaceKind.BOX, 0, 0, origin=(0.022, 0, 0.01), size=(0.004, 0.004, 0.01)),
)
ROOM = tuple(mesh_surfaces(box([0.022, 0.022, 0.2], "inside", centre=(0.0, 0.0, 0.2)), 0, 0))
WINDOWS, SUBSTEPS = (30, 60) if JIT else (8, 2)


def crowd(kind, walls, n=90, seed=5):
    """Particles thrown about at 1 m/s on a loose lattice in a tube or a box, and pressed down by 200 g."""
    rng = np.random.default_rng(seed)
    grid = np.array([[a, b, c] for c in range(n) for a in range(5) for b in range(5)], float)
    grid = grid[np.hypot(grid[:, 0] - 2, grid[:, 1] - 2) < 2.5][:n]
    x = (grid - [2, 2, 0]) * 2.3 * R + [-0.002, 0, 1.3 * R]
    if kind == "spheres":
        placed = spheres(np.full(n, 2 * R)).placed(x)
    else:
        turned = rng.normal(size=(n, 4))
        turned /= np.linalg.norm(turned, axis=1)[:, None]
        placed = clumps([GRAIN], np.full(n, 1.8 * GRAIN.equivalent_diameter)).placed(x, turned)
    pair = law(1e5, 0.2, 0.8, friction=0.5, rolling=0.05)
    return Charge(
        placed,
        [2480.0],
        pair,
        walls,
        dt=3e-6,
        velocities=rng.normal(size=(n, 3)),
        gravity=(0.0, 0.0, -1962.0),
        spins=50.0 * rng.normal(size=(n, 3)),
        skin=0.3 * R,
    )


def saved(charge):
    """Return copies of the arrays of a checkpoint."""
    return {name: array.copy() for name, array in saved_arrays(charge.model, charge.state).items()}


@pytest.mark.parametrize("walls", [EXACT, ROOM], ids=["exact walls", "a mesh"])
@pytest.mark.parametrize("kind", ["spheres", "clumps"])
def test_a_charge_resumed_at_any_moment_has_the_bits_of_one_that_never_stopped(kind, walls):
    whole, stopped = crowd(kind, walls), {}
    moments = np.random.default_rng(8).choice(np.arange(WINDOWS // 2, WINDOWS), 3, replace=False)
    for window in range(WINDOWS):
        whole.step(SUBSTEPS)
        if window in moments:
            stopped[window] = saved(whole)
    end = saved(whole)
    for window, checkpoint in stopped.items():
        if JIT:  # what could go wrong is there: contacts, slots out of their first order, a list of the past
            assert len(checkpoint["contact_owners"]) > 5
            assert len(checkpoint["wall_slots"]) > 5
            assert (np.diff(checkpoint["ids"]) < 0).any()
            assert (checkpoint["listed_x"] != checkpoint["x"]).all()
            assert end["clock"][Clock.REBUILDS] > checkpoint["clock"][Clock.REBUILDS]
        resumed = crowd(kind, walls)
        resumed.model, resumed.state, resumed.scratch = put_back(*resumed.parts, checkpoint, FIXED_FRAME)
        for _ in range(window + 1, WINDOWS):
            resumed.step(SUBSTEPS)
        again = saved(resumed)
        assert [name for name in end if again[name].tobytes() != end[name].tobytes()] == []


@pytest.mark.parametrize("kind", ["spheres", "clumps"])
def test_a_checkpoint_takes_at_most_120_bytes_for_a_particle_and_its_contacts_beside(kind, tmp_path):
    charge = crowd(kind, EXACT, 1800 if JIT else 600).step(400 if JIT else 4)
    arrays = saved(charge)
    with h5py.File(tmp_path / "file.h5", "w") as file:
        write_checkpoint(file, Checkpoint(0.0, {"charge": arrays}, {}), {}, set())
        written = file["a/charge"]
        sizes = {name: written[name].id.get_storage_size() for name in arrays}
        assert all(np.array_equal(written[name], array) for name, array in arrays.items())
    contacts = sum(size for name, size in sizes.items() if name.startswith(("contact_", "wall_")))
    number = len(arrays["contact_owners"]) + len(arrays["wall_slots"])
    assert sum(sizes.values()) - contacts < 120 * charge.model.n_particles
    # two numbers of four bytes and eight of four
    assert contacts < 42 * number + 2**12
