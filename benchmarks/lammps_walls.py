"""Cost of our walls in LAMMPS: ``python benchmarks/lammps_walls.py [SPHERES]``.

Spheres on a cubic lattice, just overlapping, in a closed box of six planes, each with a velocity of its own,
on one process. Times are of the processor, per sphere and step: of whole windows, of the part in the callback
that holds our walls, and of a run of LAMMPS beside its steps. Needs the extra ``mpi``.
"""

import sys
import time

import numpy as np

from nutamill.base.provenance import processor
from nutamill.case import load_case
from nutamill.charge.assembly import charge_of
from nutamill.charge.kernels.dynamics import start
from nutamill.charge.walls.surface import plane
from nutamill.simulation.lammps.grains import Grains
from nutamill.simulation.lammps.ranks import Ranks
from nutamill.simulation.setup.charge import contact_law_of, pair_laws
from nutamill.simulation.setup.particles import charge_particles

DIAMETER, SUBSTEP, STEPS, WINDOWS = 2e-3, 1e-6, 10, 12
GAP = 0.998
"""Distance of neighbours, over the diameter [1]."""


class Timed(Grains):
    """Particles in LAMMPS, with the time spent in the callback [s]."""

    spent = 0.0

    def _push(self, *given):
        begun = time.process_time()
        super()._push(*given)
        self.spent += time.process_time() - begun


def main() -> None:
    side = round((int(sys.argv[1]) if len(sys.argv) > 1 else 118_605) ** (1 / 3))
    n = side**3
    asked = ["charge.engine=lammps", f"charge.count={n}", f"charge.diameter={1e3 * DIAMETER:g} mm"]
    machine = load_case("numill", asked).machine
    grid = (np.indices((side,) * 3).reshape(3, -1).T - 0.5 * (side - 1)) * DIAMETER * GAP
    half = 0.5 * side * DIAMETER * GAP
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
    grains = Timed(machine, charge, SUBSTEP, Ranks())
    motion = np.zeros((1, 19))
    motion[0, 3] = 1.0
    grains.window(motion, STEPS)
    grains.spent, begun = 0.0, time.process_time()
    grains.march(WINDOWS, STEPS, lambda: motion, lambda: True)
    whole, walls_part = time.process_time() - begun, grains.spent
    per = 1e9 / (n * STEPS * WINDOWS)
    begun = time.process_time()
    for _ in range(50):
        grains._run("run 0 pre no post no")
    window = (time.process_time() - begun) / 50
    print(f"{processor()}, one process, {n} spheres, 6 planes")
    print(f"a step {whole * per:.0f} ns per sphere, our walls in it {walls_part * per:.1f} ns", end=" ")
    print(f"({100 * walls_part / whole:.0f} %), a run of LAMMPS beside its steps {1e3 * window:.2f} ms")


if __name__ == "__main__":
    main()
