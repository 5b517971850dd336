"""Cost of the charge engine from a thousand to a million spheres, and of clumps, in the same packing:
``python benchmarks/scaling.py``.

Spheres lie on a cubic lattice, just overlapping (52 % solids), in a closed box, each moved a little and with
a velocity of its own: the same contacts per sphere at every number.  Clumps of three spheres stand side by
side on a lattice of their own.  Figures are medians of several pieces; memory is the peak of a process of its
own.
"""

import resource
import statistics
import subprocess
import sys
import time

import numpy as np

from nutamill.base.provenance import processor
from nutamill.charge.face import Charge
from nutamill.charge.laws.pair import PairLaw
from nutamill.charge.model import Clock
from nutamill.charge.particles.particles import clumps, spheres
from nutamill.charge.particles.shapes import clump_shape
from nutamill.charge.walls.surface import Surface, plane
from nutamill.simulation.setup.threads import usable_cores

DIAMETER, SUBSTEP = 1.95e-3, 2e-6
LAW = PairLaw(5e4, 0.0, 0.0, 2 / 3, 0.212, False, 0.5, 0.5, 0.01, 0.05, 0.5)
GRAIN = clump_shape([[0, 0, 0], [1.0, 0, 0], [0.4, 0.9, 0]], [1.0, 0.9, 0.8])
PIECES, SUBSTEPS = 7, 50


def box(half: np.ndarray) -> list[Surface]:
    """Six planes that face inwards, `half` [m] (3,) from the origin."""
    normals = [sign * axis for axis in np.eye(3) for sign in (1.0, -1.0)]
    return [plane(f"side {k}", -half * normal, normal) for k, normal in enumerate(normals)]


def lattice(side: int, spacing: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Places [m] (side^3, 3) about the origin, moved at random by at most 0.2 % of the spacing [m] (3,)."""
    steps = np.arange(side) - (side - 1) / 2
    places = np.stack(np.meshgrid(steps, steps, steps), -1).reshape(-1, 3)
    return (places + rng.uniform(-0.002, 0.002, places.shape)) * spacing


def packing(kind: str, side: int) -> Charge:
    """A charge of `side`^3 particles."""
    rng = np.random.default_rng(1)
    n = side**3
    particles = (
        spheres(np.full(n, DIAMETER))
        if kind == "spheres"
        else clumps([GRAIN], np.full(n, GRAIN.equivalent_diameter * DIAMETER / 2))
    )
    sizes = particles.shapes[0].extents * particles.scale[0]
    attitudes = None if kind == "spheres" else np.tile([1.0, 0.0, 0.0, 0.0], (n, 1))
    placed = particles.placed(lattice(side, 0.998 * sizes, rng), attitudes)
    walls = box(0.5 * 0.998 * side * sizes)
    velocities = rng.normal(size=(n, 3)) * 0.05
    return Charge(placed, [2480.0], LAW, walls, dt=SUBSTEP, velocities=velocities)


def measure(kind: str, side: int) -> None:
    """Print one line: cost on one thread and on all cores, contacts, rebuilds, memory."""
    charge = packing(kind, side)
    count = charge.model.n_particles
    charge.step(SUBSTEPS)
    line = f"{kind:8} {side**3:9d} {count:9d}"
    for threads in sorted({1, usable_cores()}):
        clock = charge.state.clock
        begun, rebuilds, pieces = int(clock[Clock.STEP]), int(clock[Clock.REBUILDS]), []
        charge.threads = threads
        for _ in range(PIECES):
            since = time.perf_counter()
            charge.step(SUBSTEPS)
            pieces.append(1e9 * (time.perf_counter() - since) / SUBSTEPS / count)
        line += f"  {statistics.median(pieces):7.1f}"
    clock = charge.state.clock
    every = (int(clock[Clock.STEP]) - begun) / max(int(clock[Clock.REBUILDS]) - rebuilds, 1)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"{line}  {sum(charge.contacts) / count:6.2f}  {every:7.0f}  {peak:6.0f}", flush=True)


def main() -> None:
    """All sizes, each in a process of its own."""
    print(f"{processor()}, {usable_cores()} cores for this process, {time.strftime('%Y-%m-%d')}")
    print("                              ns per sphere and substep      contacts  substeps     peak")
    heads = "  ".join(f"{count:7}" for count in sorted({1, usable_cores()}))
    print(
        f"kind     particles   spheres  {heads}  per sphere  a list   MB     (columns of times: threads)",
        flush=True,
    )
    sizes = [("spheres", side) for side in (10, 22, 46, 100)] + [("clumps", side) for side in (7, 15, 34)]
    for kind, side in sizes:
        subprocess.run([sys.executable, __file__, kind, str(side)], check=True)


if __name__ == "__main__":
    if len(sys.argv) == 3:
        measure(sys.argv[1], int(sys.argv[2]))
    else:
        main()
