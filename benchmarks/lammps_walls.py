"""Cost of our walls in LAMMPS: ``[mpiexec -n 2] python benchmarks/lammps_walls.py [SPHERES] [--apart GAP]``.

Spheres on a cubic lattice in a closed box of six planes, each with a velocity of its own. Times are of the
processor, per sphere and step, of the busiest process: of whole windows, of the part in the callback that
holds our walls, of the same steps with walls and gravity of LAMMPS alone, and of a run of LAMMPS beside its
steps. Memory is the largest of each process, with the particles gathered and saved once as at a checkpoint.
Needs the extra ``mpi``.
"""

import argparse
import resource
import time

import numpy as np

from nutamill.base.provenance import processor
from nutamill.case import load_case
from nutamill.charge.assembly import charge_of
from nutamill.charge.kernels.dynamics import start
from nutamill.charge.walls.surface import plane
from nutamill.simulation.lammps.commands import FRAME
from nutamill.simulation.lammps.grains import Grains
from nutamill.simulation.lammps.ranks import all_ranks
from nutamill.simulation.setup.charge import contact_law_of, pair_laws
from nutamill.simulation.setup.particles import charge_particles
from nutamill.simulation.setup.touches import granular_words, touches

DIAMETER, SUBSTEP, STEPS = 1e-3, 5e-7, 10


class Timed(Grains):
    """Particles in LAMMPS, with the time spent in the callback [s]."""

    spent = 0.0

    def _push(self, *given):
        begun = time.process_time()
        super()._push(*given)
        self.spent += time.process_time() - begun


def asked() -> argparse.Namespace:
    """Return the arguments of the command."""
    parser = argparse.ArgumentParser(description="Cost of our walls in LAMMPS.")
    parser.add_argument("spheres", type=int, nargs="?", default=118_605)
    parser.add_argument(
        "--apart", type=float, default=0.998, help="distance of neighbours, over the diameter"
    )
    parser.add_argument("--windows", type=int, default=6, help=f"windows of {STEPS} steps that are timed")
    parser.add_argument("--rounds", type=int, default=2, help="times both are timed, in turn")
    return parser.parse_args()


def memory() -> float:
    """Return the largest memory of this process so far [GB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024**2


def made(given: argparse.Namespace, ranks) -> tuple[Timed, int, float, str, float]:
    """Return the particles, their number, half the edge of the box [m], the words of LAMMPS for its walls,
    and the memory with the arrays of all particles, before LAMMPS has its own [GB].
    """
    side = round(given.spheres ** (1 / 3))
    n = side**3
    words = ["charge.engine=lammps", f"charge.count={n}", f"charge.diameter={1e3 * DIAMETER:g} mm"]
    machine = load_case("numill", words).machine
    pitch = DIAMETER * given.apart
    grid = (np.indices((side,) * 3).reshape(3, -1).T - 0.5 * (side - 1)) * pitch
    half = 0.5 * side * pitch
    walls = [
        plane(f"{sign}{axis}", -sign * half * np.eye(3)[axis], sign * np.eye(3)[axis], material=1)
        for axis in range(3)
        for sign in (1, -1)
    ]
    charge = charge_of(
        charge_particles(machine).placed(grid, None),
        [machine.materials[name].density for name in machine.charge.materials],
        pair_laws(machine),
        walls,
        1,
        velocities=np.random.default_rng(1).normal(0.0, 0.05, (n, 3)),
        gravity=machine.gravity,
        law=contact_law_of(machine),
        domain=((0.0, 0.0, 0.0), 4.0 * half),
        precision="double",
    )
    start(*charge, SUBSTEP)
    arrays = memory()
    grains = Timed(machine, charge, SUBSTEP, ranks)
    contact = next(contact for contact in touches(machine).values() if contact.touch.wall)
    # LAMMPS takes the mass of the particle itself, so its words for a wall are those of a pair
    return grains, n, half, granular_words(contact), arrays


def at_rest() -> np.ndarray:
    """Return the motion of a body at rest (1, 19)."""
    motion = np.zeros((1, 19))
    motion[0, 3] = 1.0
    return motion


def walls_of_lammps(grains: Grains, half: float, words: str, windows: int) -> float:
    """Return the time of the same steps with walls and gravity of LAMMPS [s], and put ours back."""
    names = []
    for axis in "xyz":
        grains._run(f"fix wall_{axis} all wall/gran granular {words} {axis}plane {-half:.15g} {half:.15g}")
        names.append(f"wall_{axis}")
    down = float(-grains.model.gravity[2])
    grains._run(f"fix weight all gravity {down:.15g} vector 0 0 -1", f"unfix {FRAME}", "run 0 post no")
    begun = time.process_time()
    grains._run(f"run {windows * STEPS} pre no post no")
    taken = time.process_time() - begun
    grains._run(
        f"fix {FRAME} all external pf/callback 1 1", *(f"unfix {name}" for name in [*names, "weight"])
    )
    grains._engine.set_fix_external_callback(FRAME, grains._push, None)
    grains._run("run 0 post no")
    return taken


def main() -> None:
    given, ranks = asked(), all_ranks()
    empty = memory()
    grains, n, half, words, arrays = made(given, ranks)
    motion = at_rest()
    grains.window(motion, STEPS)
    ours, walls, theirs = [], [], []
    for _ in range(given.rounds):
        grains.spent, begun = 0.0, time.process_time()
        grains.march(given.windows, STEPS, lambda: motion, lambda: True)
        ours.append(time.process_time() - begun)
        walls.append(grains.spent)
        theirs.append(walls_of_lammps(grains, half, words, given.windows))
    begun = time.process_time()
    for _ in range(5):
        grains._run("run 0 pre no post no")
    window = (time.process_time() - begun) / 5
    grains.gather()
    if ranks.rank == 0:
        grains.ranks.order = lambda content: None  # nobody waits for orders here
        grains.saved_arrays()
    else:
        grains.part_of_save()
    best = np.array([min(ours), walls[int(np.argmin(ours))], min(theirs), memory()])
    all_of = ranks.gathered(best[None, :])
    if ranks.rank > 0:
        return
    per = 1e9 / (n * STEPS * given.windows) * ranks.size
    whole, part, alone, _ = all_of.max(axis=0)
    text = f"{processor()}, {ranks.size} process{'es' if ranks.size > 1 else ''}, {n} spheres"
    print(f"{text}, {given.apart:g} diameters apart, 6 planes")
    print(f"a step {whole * per:.0f} ns per sphere and process, our walls in it {part * per:.1f} ns", end=" ")
    print(f"({100 * part / whole:.1f} %), with walls of LAMMPS {alone * per:.0f} ns", end=" ")
    print(f"(ours {whole / alone:.3f} of it), a run beside its steps {1e3 * window:.1f} ms")
    sizes = " and ".join(f"{row[3]:.2f} GB" for row in all_of)
    print(f"memory {sizes}, of the first {empty:.2f} without particles, {arrays:.2f} before LAMMPS")


if __name__ == "__main__":
    main()
