"""A charge on many processes, on paper: ``python benchmarks/scaleout.py``.

Works out the wall time of a substep of a charge in LAMMPS on 64 to 4096 processes, and of our own engine on
64 and 128 cores of one machine, from costs measured here and assumptions about a cluster, all of which are
printed.  Nothing is run.
"""

import argparse
import math
from dataclasses import dataclass

CHARGES = (10**7, 10**8)
RANKS = (64, 128, 256, 512, 1024, 2048, 4096)
CORES = (64, 128)


@dataclass(frozen=True)
class Costs:
    """Measured costs and assumptions; each is an option of the command."""

    particle: float = 347.0
    """Measured: LAMMPS `granular`, one process, wall time per particle and step [ns] (peers-sand.txt)."""
    walls: float = 43.4
    """Measured: our walls beside it, per particle and step [ns] (lammps-walls.txt)."""
    window: float = 0.4
    """Python in a window [ms]: measured 0.3 in its ten callbacks (lammps-walls.txt, 8 spheres, 29 us a step
    beside LAMMPS), assumed 0.1 at its ends."""
    substeps: float = 10.0
    """Steps in a window [1], the default of a case."""
    own: float = 88.9
    """Measured: our engine, one thread, a million spheres [ns] (scaling.txt)."""
    own_two: float = 47.3
    """Measured: the same on two threads [ns]."""
    cutoff: float = 1.25
    """Reach of the halo, in diameters [1]: one, and the skin of the lists."""
    solids: float = 0.4
    """Solids fraction of the moving charge [1]."""
    halo_bytes: float = 96.0
    """What a ghost costs in a step [bytes]: position, velocity, spin, and the copies of them."""
    bandwidth: float = 1.0
    """Assumed: of the network, for each process [GB/s]."""
    latency: float = 2.0
    """Assumed: of one message [us]; a halo takes six, one behind the other."""
    reduction: float = 4.0
    """Assumed: of one level of the tree of a reduction [us]."""
    unbalance: float = 1.05
    """Excess of the busiest process [1], at which particles are shared anew."""
    memory: float = 400.0
    """Assumed: bandwidth of the memory of one big machine [GB/s]."""
    base: float = 0.18
    """Measured: memory of a process without particles [GB] (lammps-walls.txt)."""
    own_memory: float = 2.8
    """Measured: memory of a process for a particle of its own [kB] (lammps-walls.txt)."""
    all_memory: float = 0.42
    """Measured: memory of every process for a particle of the whole charge [kB] (lammps-walls.txt)."""
    touched: float = 495.0
    """What our engine moves through memory for a particle and substep [bytes] (stages.txt)."""


def ghosts(costs: Costs, particles: float) -> float:
    """Return the ghosts of a process with `particles` in a cube: a layer of the cutoff around it."""
    edge = (particles * math.pi / 6.0 / costs.solids) ** (1.0 / 3.0)  # of the cube, in diameters
    return particles * ((1.0 + 2.0 * costs.cutoff / edge) ** 3 - 1.0)


def lammps_step(costs: Costs, particles: float, ranks: int) -> tuple[float, float, float, float]:
    """Return the wall time of a step [us]: particles, halo, reduction and window of it, and the sum."""
    own = particles / ranks
    work = costs.unbalance * own * (costs.particle + costs.walls) * 1e-3
    halo = 6.0 * costs.latency + ghosts(costs, own) * costs.halo_bytes / costs.bandwidth * 1e-3
    window = (costs.reduction * math.log2(ranks) + 1e3 * costs.window) / costs.substeps
    return work, halo, window, work + halo + window


def process_memory(costs: Costs, particles: float, ranks: int) -> float:
    """Return the memory of a process [GB]."""
    return costs.base + 1e-6 * (costs.own_memory * particles / ranks + costs.all_memory * particles)


def own_step(costs: Costs, particles: float, cores: int) -> tuple[float, float]:
    """Return the wall time of a substep of our engine [us]: at best, shared without a loss, or as fast as the
    memory; at worst, with the loss of two threads as a share that one thread does alone (law of Amdahl).
    """
    alone = max(0.0, 2.0 * costs.own_two / costs.own - 1.0)
    worst = costs.own * (alone + (1.0 - alone) / cores)
    best = max(costs.own / cores, costs.touched / costs.memory)
    return particles * best * 1e-3, particles * max(best, worst) * 1e-3


def largest_useful(costs: Costs, particles: float) -> int:
    """Return the processes from which twice as many save less than a third of the time [1]."""
    ranks = 64
    while lammps_step(costs, particles, ranks)[3] > 1.5 * lammps_step(costs, particles, 2 * ranks)[3]:
        ranks *= 2
    return ranks


def equal_ranks(costs: Costs, particles: float, step: float) -> int:
    """Return the processes on which LAMMPS takes at most `step` [us]."""
    ranks = 1
    while lammps_step(costs, particles, ranks)[3] > step:
        ranks += 1
    return ranks


def main() -> None:
    parser = argparse.ArgumentParser(description="A charge on many processes, on paper.")
    for name, value in vars(Costs()).items():
        parser.add_argument(f"--{name}", type=float, default=value)
    costs = Costs(**vars(parser.parse_args()))
    print("costs: " + ", ".join(f"{name} {value:g}" for name, value in vars(costs).items()))
    print("times of a step in us")
    print(
        "| particles | processes | of each | work | halo | window | step | efficiency | memory of each [GB] |"
    )
    print("|---|---|---|---|---|---|---|---|---|")
    for particles in CHARGES:
        first = lammps_step(costs, particles, RANKS[0])[3] * RANKS[0]
        for ranks in RANKS:
            work, halo, window, step = lammps_step(costs, particles, ranks)
            share = first / (step * ranks)
            parts = f"{work:.0f} | {halo:.0f} | {window:.0f} | {step:.0f} | {100 * share:.0f} %"
            size = process_memory(costs, particles, ranks)
            print(f"| {particles:.0e} | {ranks} | {particles / ranks:.0f} | {parts} | {size:.1f} |")
        most = largest_useful(costs, particles)
        print(f"{particles:.0e} particles: beyond {most} processes, twice as many save less than a third")
    print("| particles | cores of one machine | our substep [us] | as fast as LAMMPS on |")
    print("|---|---|---|---|")
    for particles in CHARGES:
        for cores in CORES:
            best, worst = own_step(costs, particles, cores)
            least, most = (equal_ranks(costs, particles, step) for step in (worst, best))
            print(f"| {particles:.0e} | {cores} | {best:.0f} to {worst:.0f} | {least} to {most} processes |")


if __name__ == "__main__":
    main()
