"""A charge in LAMMPS beside our engine: what both are meant to share.

    python -m validation.many_processes            pairs and processes, and write the table
    python -m validation.many_processes pairs      one part, printed only
    python -m validation.many_processes processes
    python -m validation.many_processes mill [REVOLUTIONS]      some minutes a turn

``pairs``: two pellets that collide obliquely, without walls, with shorter and shorter substeps of both.
``processes``: a particle damper with 200 balls on one process and on two. ``mill``: the NuMill with its 2618
pellets on its mounts, two-way coupled, from the same bed by the same ramp. Needs the extra ``mpi``.
"""

import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

import nutamill as nm
from nutamill.base.provenance import processor
from nutamill.case import load_case
from nutamill.case.machine import Machine
from nutamill.charge.assembly import charge_of
from nutamill.charge.kernels.dynamics import start, window
from nutamill.charge.readout import positions
from nutamill.simulation.lammps.grains import Grains
from nutamill.simulation.lammps.ranks import Ranks
from nutamill.simulation.setup.charge import contact_law_of, pair_laws
from nutamill.simulation.setup.clock import run_clock
from nutamill.simulation.setup.particles import charge_particles

TABLE = Path(__file__).parent / "results" / "many-processes.txt"
SUBSTEPS, TIME, PHASES = 10, 1e-3, 16
STEPS = (1, 2, 4, 8, 16)
FINEST = 64
LATER = 3.5e-6
"""How much farther the last two are apart than the first [m]: what they close in a substep of the mill."""
DAMPER = ("charge.engine=lammps", "charge.count=200", "run.until=4 ms", "run.checkpoint=2 ms")
SPEED = 700 * np.pi / 30
MILL = ("drive.ramp=14000 rpm/s", "run.statistics=false", "run.checkpoint=10 s")
READINGS = ("crank_pin_force_resultant", "driveshaft_torque", "driveshaft_power")


def two_pellets(machine: Machine, dt: float, theirs: bool) -> np.ndarray:
    """Return where pairs of pellets are after `TIME` [m] (2 PHASES, 3), by LAMMPS or by our engine.

    Each two meet a little later than those before, at another phase of a substep.
    """
    radius = 0.5 * machine.charge.diameter
    two = np.array([[0.0, 0.0, 0.0], [2.0 * radius + 2e-4, 0.6 * radius, 0.0]])
    aside, later = 6.0 * radius * np.arange(PHASES), LATER / PHASES * np.arange(PHASES)
    places = np.tile(two, (PHASES, 1))
    places[:, 1] += np.repeat(aside, 2)
    places[1::2, 0] += later
    charge = charge_of(
        charge_particles(machine).placed(places, None),
        [machine.materials[name].density for name in machine.charge.materials],
        pair_laws(machine),
        [],
        1,
        velocities=np.tile([[0.5, 0.0, 0.0], [-0.5, 0.0, 0.1]], (PHASES, 1)),
        spins=np.tile([[0.0, 0.0, 60.0], [20.0, 0.0, -30.0]], (PHASES, 1)),
        gravity=(0.0, 0.0, 0.0),
        law=contact_law_of(machine),
        domain=((0.0, 0.0, 0.0), 1.0),
        precision="double",
    )
    start(*charge, dt)
    motion, reference = np.zeros((1, 19)), np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0])
    motion[0, 3] = 1.0
    windows = round(TIME / (SUBSTEPS * dt))
    if not theirs:
        for _ in range(windows):
            window(*charge, motion, reference, SUBSTEPS, dt, 0, 1)
        return positions(charge[0], charge[1], dt)
    grains = Grains(machine, charge, dt, Ranks())
    grains.march(windows, SUBSTEPS, lambda: motion, lambda: True)
    grains.take()
    grains.close()
    return positions(charge[0], charge[1], dt)


def apart(places: np.ndarray, others: np.ndarray) -> float:
    """Return the root of the mean square of the distances of places [m] (n, 3)."""
    return float(np.sqrt(((places - others) ** 2).sum(axis=1).mean()))


def pairs() -> Iterator[str]:
    """Yield the orders of both engines for a collision, and their difference at the step of the mill."""
    machine = load_case("numill", ["charge.engine=lammps", f"charge.count={2 * PHASES}"]).machine
    production = run_clock(machine).substep
    # a whole number of windows for all steps
    longest = TIME / (SUBSTEPS * round(TIME / (SUBSTEPS * production)))
    exact = two_pellets(machine, longest / FINEST, False)
    errors = {
        name: np.array([np.abs(two_pellets(machine, longest / step, theirs) - exact).max() for step in STEPS])
        for name, theirs in (("our engine", False), ("LAMMPS", True))
    }
    yield f"two pellets, oblique collision at 1 m/s at {PHASES} phases of a substep: places after"
    yield f"{1e3 * TIME:g} ms beside those of our engine at 1/{FINEST} of the step, root mean square"
    yield "| substep [us] | our engine [m] | order | LAMMPS [m] | order |"
    yield "|---|---|---|---|---|"
    for k, step in enumerate(STEPS):
        cells = []
        for error in errors.values():
            order = f"{np.log2(error[k - 1] / error[k]):.2f}" if k else ""
            cells += [f"{error[k]:.2e}", order]
        yield f"| {1e6 * longest / step:.3f} | " + " | ".join(cells) + " |"
    steps = np.log(1.0 / np.array(STEPS))
    fitted = [f"{name} {np.polyfit(steps, np.log(error), 1)[0]:.2f}" for name, error in errors.items()]
    yield f"order fitted to all: {', '.join(fitted)}"
    between = apart(two_pellets(machine, longest, True), two_pellets(machine, longest, False))
    diameter = machine.charge.diameter
    yield (
        f"at the step of the mill, {1e6 * longest:.3f} us, the two engines differ by {between:.2e} m, "
        f"{100 * between / diameter:.3f} % of the diameter"
    )


def done(ranks: int, *words: str) -> None:
    """Run a command of nutamill on some processes."""
    beside = str(Path(sys.executable).parent)
    launcher = shutil.which("mpiexec", path=beside) or shutil.which("mpiexec")
    assert launcher is not None, "needs mpiexec, of the extra mpi"
    call = [launcher, "-n", str(ranks)] if ranks > 1 else []
    subprocess.run([*call, sys.executable, "-m", "nutamill", *words], check=True, stdout=subprocess.DEVNULL)


def processes() -> Iterator[str]:
    """Yield what one process and two make of the same run, its momentum and its ledger."""
    with tempfile.TemporaryDirectory() as folder:
        files = [Path(folder, f"{ranks}.h5") for ranks in (1, 2)]
        for ranks, file in enumerate(files, 1):
            asked = [word for change in DAMPER for word in ("-s", change)]
            done(ranks, "run", "particle-damper", "--to", str(file), *asked)
        rows = []
        for file in files:
            with nm.open_result(file) as result:
                series = result.series
                force = np.column_stack([series[f"box_charge_force_{axis}"].values for axis in "xyz"])
                names = ("interface_impulse_defect", "ledger_residual", "elastic_energy")
                rows.append((force, *(series[name].values for name in names)))
    (one, *_), (two, defect, residual, energy) = rows
    scale = np.abs(one).max()
    difference = np.abs(one - two).max(axis=1) / scale
    yield "particle damper, 200 balls, 4 ms, on one process and on two (goals in brackets)"
    yield f"force on the box, first row of 1 ms: differs by {difference[1]:.1e} of the largest (1e-12)"
    yield f"force on the box, all rows: differs by {difference.max():.1e} of the largest (1e-9)"
    yield (
        f"momentum given less received on two processes: {np.abs(defect).max():.1e} N s, "
        f"{np.abs(defect).max() / (0.5 * 0.05):.1e} of the box's (1e-12)"
    )
    yield (
        f"energy that the ledger leaves open on two: {100 * np.abs(residual).max() / energy[0]:.2e} % "
        "of that of the bent spring (0.1 %)"
    )


def mill(revolutions: float = 1.0) -> Iterator[str]:
    """Yield force, torque and power of the NuMill by both engines: means and scatter of quarter turns."""
    turn = 2 * np.pi / SPEED
    end = 0.05 + (0.5 + revolutions) * turn
    read: dict[str, dict[str, np.ndarray]] = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, changes in (("our engine", ()), ("LAMMPS", ("charge.engine=lammps",))):
            file = Path(folder, f"{name}.h5")
            asked = ["drive.speed=700 rpm", *MILL, *changes, f"run.until={end:.6f} s"]
            done(1, "run", "numill", "--to", str(file), *(w for change in asked for w in ("-s", change)))
            with nm.open_result(file) as result:
                times = result.series["time"].values
                quarter = np.floor((times - (end - revolutions * turn)) / (turn / 4.0)).astype(int)
                read[name] = {
                    one: np.array(
                        [
                            result.series[one].values[quarter == q].mean()
                            for q in range(round(4 * revolutions))
                        ]
                    )
                    for one in READINGS
                }
    yield f"NuMill, 2618 pellets on its mounts, 700 rpm, two-way: {revolutions:g} turns, after"
    yield "the ramp of 50 ms and half a turn; means ± scatter of quarters of turns"
    yield "| quantity | our engine | LAMMPS | difference, over the standard error of both |"
    yield "|---|---|---|---|"
    for one in READINGS:
        ours, theirs = read["our engine"][one], read["LAMMPS"][one]
        error = np.hypot(*(values.std(ddof=1) / np.sqrt(len(values)) for values in (ours, theirs)))
        cells = [f"{values.mean():.4g} ±{values.std(ddof=1):.2g}" for values in (ours, theirs)]
        yield f"| {one} | {' | '.join(cells)} | {(theirs.mean() - ours.mean()) / error:+.2f} |"


PARTS: dict[str, Callable[..., Iterator[str]]] = {"pairs": pairs, "processes": processes, "mill": mill}


def main() -> None:
    asked = sys.argv[1:]
    if asked:
        for line in PARTS[asked[0]](*map(float, asked[1:])):
            print(line, flush=True)
        return
    lines = ["$ python -m validation.many_processes", processor()]
    for part in (pairs, processes):
        for line in ("", *part()):
            lines.append(line)
            print(line, flush=True)
    TABLE.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
