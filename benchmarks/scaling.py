"""Cost of the charge engine from a thousand to a million spheres, of clumps, and of many sizes:
``python benchmarks/scaling.py``.

``spheres`` are on a cubic lattice, just overlapping (52 % solids), in a closed box, each moved a little and
with a velocity of its own: the same contacts per sphere at every number.  ``clumps`` of three spheres stand
side by side on a lattice of their own.  ``apart`` has twice the spacing, so that nothing touches.  ``1:1``
and ``1:10`` are random packings (55 % solids), pressed together by 1 %, of one size and of sizes from 1 to
10 mm by Rosin and Rammler.  Times are medians of several pieces: of the processor in user mode on one thread,
of the clock on all cores.  Memory is the peak of a process of its own.
"""

import resource
import statistics
import subprocess
import sys
import time

import numpy as np

from nutamill.base.provenance import processor
from nutamill.charge.face import Charge
from nutamill.charge.filling.relax import MARGIN, relaxed
from nutamill.charge.laws.pair import PairLaw
from nutamill.charge.model import Clock
from nutamill.charge.particles.particles import clumps, spheres
from nutamill.charge.particles.shapes import clump_shape
from nutamill.charge.particles.sizes import rosin_rammler_sizes
from nutamill.charge.walls.surface import Surface, plane
from nutamill.simulation.setup.threads import usable_cores

DIAMETER, SUBSTEP = 1.95e-3, 2e-6
SOLIDS, PRESSED = 0.55, 0.99
LAW = PairLaw(5e4, 0.0, 0.0, 2 / 3, 0.212, False, 0.5, 0.5, 0.01, 0.05, 0.5)
GRAIN = clump_shape([[0, 0, 0], [1.0, 0, 0], [0.4, 0.9, 0]], [1.0, 0.9, 0.8])
PIECES, SUBSTEPS = 7, 50
APART = {"spheres": (10, 22, 46), "clumps": (7, 15, 34)}


def box(half: np.ndarray) -> list[Surface]:
    """Six planes that face inwards, `half` [m] (3,) from the origin."""
    normals = [sign * axis for axis in np.eye(3) for sign in (1.0, -1.0)]
    return [plane(f"side {k}", -half * normal, normal) for k, normal in enumerate(normals)]


def lattice(side: int, spacing: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Places [m] (side^3, 3) about the origin, moved at random by at most 0.2 % of the spacing [m] (3,)."""
    steps = np.arange(side) - (side - 1) / 2
    places = np.stack(np.meshgrid(steps, steps, steps), -1).reshape(-1, 3)
    return (places + rng.uniform(-0.002, 0.002, places.shape)) * spacing


def packing(kind: str, number: int) -> Charge:
    """A charge of `number` particles, about."""
    if ":" in kind:
        return random_packing(kind, number)
    rng = np.random.default_rng(1)
    side = round(np.cbrt(number))
    n = side**3
    shape, _, apart = kind.partition(" ")
    particles = (
        spheres(np.full(n, DIAMETER))
        if shape == "spheres"
        else clumps([GRAIN], np.full(n, GRAIN.equivalent_diameter * DIAMETER / 2))
    )
    sizes = particles.shapes[0].extents * particles.scale[0] * (2.0 if apart else 0.998)
    attitudes = None if shape == "spheres" else np.tile([1.0, 0.0, 0.0, 0.0], (n, 1))
    placed = particles.placed(lattice(side, sizes, rng), attitudes)
    velocities = rng.normal(size=(n, 3)) * 0.05
    return Charge(placed, [2480.0], LAW, box(0.5 * side * sizes), dt=SUBSTEP, velocities=velocities)


def random_packing(kind: str, number: int) -> Charge:
    """A charge of `number` spheres of one size, or of sizes 1:10, in a cube."""
    rng = np.random.default_rng(1)
    law = rosin_rammler_sizes(5e-3, 2.0, 1e-3, 10e-3)
    radii = 0.5 * (law.of_number(number) if kind == "1:10" else np.full(number, DIAMETER))
    half = 0.5 * np.cbrt(4.0 / 3.0 * np.pi * (radii**3).sum() / SOLIDS)
    room = (half - MARGIN * radii)[:, None]

    def push(x, _):
        deep = float((np.abs(x) - room).max())
        np.clip(x, -room, room, out=x)
        return deep

    x = relaxed(rng.uniform(-1.0, 1.0, (number, 3)) * room, MARGIN * radii, push)
    velocities = rng.normal(size=(number, 3)) * 0.05
    placed = spheres(2.0 * radii).placed(PRESSED * x)
    walls = box(np.full(3, PRESSED * half))
    return Charge(placed, [2480.0], LAW, walls, dt=SUBSTEP / 2, velocities=velocities)


def user_time() -> float:
    """Time of the processor in user mode [s]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_utime


def measure(kind: str, number: int) -> None:
    """Print one line: cost on one thread and on all cores, contacts, rebuilds, memory."""
    charge = packing(kind, number)
    count = charge.model.n_particles
    charge.step(SUBSTEPS)
    begun, rebuilds = int(charge.state.clock[Clock.STEP]), int(charge.state.clock[Clock.REBUILDS])
    line = f"{kind:13} {number:9d} {count:9d}"
    for threads, now in ((1, user_time), (usable_cores(), time.perf_counter)):
        charge.threads, pieces = threads, []
        for _ in range(PIECES):
            since = now()
            charge.step(SUBSTEPS)
            pieces.append(1e9 * (now() - since) / SUBSTEPS / count)
        line += f"  {statistics.median(pieces):7.1f}"
    contacts = sum(charge.contacts) / count
    clock = charge.state.clock
    every = (int(clock[Clock.STEP]) - begun) / max(int(clock[Clock.REBUILDS]) - rebuilds, 1)
    candidates = charge.state.pairs.counts[clock[Clock.LIST], :-1].sum() / count
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"{line}  {contacts:8.2f}  {candidates:5.2f}  {every:6.0f}  {peak:4.0f}", flush=True)


def main() -> None:
    """All kinds and numbers, each in a process of its own."""
    cores = usable_cores()
    print(f"$ python benchmarks/scaling.py      # {processor()}, {cores} cores, {time.strftime('%Y-%m-%d')}")
    print(f"{'':33}ns per sphere and substep    per sphere    substeps  peak")
    heads = f"{'one':>7}  {f'all {cores}':>7}"
    print(f"kind          particles   spheres  {heads}  contacts  pairs  a list    MB", flush=True)
    kinds = [("spheres", side**3) for side in (10, 22, 46, 67, 100)]
    kinds += [("clumps", side**3) for side in (7, 15, 34)]
    kinds += [(f"{shape} apart", side**3) for shape, sides in APART.items() for side in sides]
    kinds += [(ratio, number) for number in (3000, 20_000) for ratio in ("1:1", "1:10")]
    for kind, number in kinds:
        subprocess.run([sys.executable, __file__, kind, str(number)], check=True)


if __name__ == "__main__":
    if len(sys.argv) == 3:
        measure(sys.argv[1], int(sys.argv[2]))
    else:
        main()
