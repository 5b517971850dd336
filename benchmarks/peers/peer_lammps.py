"""LAMMPS: input of a scene, and runs of it by the Python inside each LAMMPS there is."""

import json
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from peer import Job, Outcome
from scene import Law, Record, Scene

PAIR_STYLES = {"granular": "the same law", "gran/hooke/history": "a cheaper law: no rolling resistance"}
"""Pair styles that are run, and how their law compares with ours."""


@dataclass(frozen=True, slots=True)
class Lammps:
    """One LAMMPS with one pair style."""

    place: str
    """Where it came from."""
    version: str
    """Day of its version."""
    style: str
    """Pair style."""
    python: str
    """Interpreter that imports its module."""
    launcher: tuple[str, ...]
    """Starts as many processes as the number that follows says."""
    environment: dict[str, str]
    """Environment of its processes."""

    @property
    def name(self) -> str:
        """For the table."""
        return f"LAMMPS {self.place}, {self.style}"

    @property
    def pace(self) -> float:
        """Rough time per particle and step on one thread [ns]."""
        return 450.0 if self.style == "granular" else 230.0

    @property
    def note(self) -> str:
        """What it runs."""
        return (
            f"version {self.version}; {PAIR_STYLES[self.style]}; sees the chamber at rest in a moving "
            "frame, the cost of which is taken off"
        )

    def run(self, scene: Scene, job: Job) -> Outcome:
        """Run a scene.

        Raises
        ------
        subprocess.SubprocessError : the engine fails, or takes too long
        """
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            write_data(folder / "particles", scene)
            (folder / "input").write_text(commands(scene, self.style, job.threads))
            given = {
                part: getattr(scene, part)
                for part in ("angle", "speed", "tilt", "gravity", "mass", "diameter", "substep")
            }
            given |= {"before": job.before, "steps": job.steps, "pieces": job.pieces, "sample": job.sample}
            given |= {"input": "input"}
            (folder / "given").write_text(json.dumps(given))
            call = [
                *self.launcher,
                str(job.threads),
                self.python,
                str(Path(__file__).with_name("inside_lammps.py")),
                "given",
            ]
            subprocess.run(
                call,
                cwd=folder,
                env=self.environment,
                capture_output=True,
                text=True,
                check=True,
                timeout=job.patience,
            )
            return outcome(scene, job, [np.load(folder / f"rank_{rank}.npz") for rank in range(job.threads)])


def write_data(file: Path, scene: Scene) -> None:
    """The particles as LAMMPS data, in chamber axes."""
    local = scene.to_chamber(scene.particles, scene.angle)
    r, low, high = 1.1 * scene.bore, scene.floor - scene.diameter, scene.ceiling + scene.diameter
    head = (
        f"particles\n\n{scene.n} atoms\n1 atom types\n\n{-r} {r} xlo xhi\n{-r} {r} ylo yhi\n{low} {high} "
        "zlo zhi\n\nAtoms\n\n"
    )
    atoms = (
        f"{i} 1 {scene.diameter} {scene.density} {p[0]:.15g} {p[1]:.15g} {p[2]:.15g}"
        for i, p in enumerate(local, 1)
    )
    motions = (f"{i} " + " ".join(f"{value:.15g}" for value in p[3:]) for i, p in enumerate(local, 1))
    file.write_text(head + "\n".join(atoms) + "\n\nVelocities\n\n" + "\n".join(motions) + "\n")


def commands(scene: Scene, style: str, threads: int) -> str:
    """LAMMPS input; processes share the chamber by height, as the charge goes round in every other
    direction.
    """
    if style == "granular":
        pair_style, coefficients, wall = "granular", granular(scene.pair), f"granular {granular(scene.wall)}"
    else:
        pair_style, coefficients, wall = (
            f"{style} {hooke(scene.pair)}",
            "",
            f"granular {granular(scene.wall, rolling=False)}",
        )
    return f"""units si
atom_style sphere
boundary f f f
newton off
comm_modify vel yes
processors 1 1 {threads}
read_data particles
neighbor {0.25 * scene.diameter} bin
neigh_modify delay 0 every 1 check yes
pair_style {pair_style}
pair_coeff * * {coefficients}
timestep {scene.substep}
balance 1.0 shift z 20 1.01
region chamber cylinder z 0 0 {scene.bore} {scene.floor} {scene.ceiling} side in
fix wall all wall/gran/region {wall} region chamber
fix frame all external pf/callback 1 1
fix move all nve/sphere
fix share all balance 2000 1.05 shift z 10 1.02
thermo 1000000
"""


def granular(law: Law, rolling: bool = True) -> str:
    """Coefficients of ``granular``: linear spring and dashpot, tangential spring, and the spring against
    rolling.
    """
    rolls = f"rolling sds {law.tangential} 0.0 {law.rolling}" if rolling else ""
    return (
        f"hooke {law.stiffness} {law.damping_rate} tangential linear_history {law.tangential} 0.0 "
        f"{law.sliding}"
        f" {rolls} damping mass_velocity"
    )


def hooke(law: Law) -> str:
    """Coefficients of ``gran/hooke/history``."""
    return f"{law.stiffness} {law.tangential} {law.damping_rate} 0.0 {law.sliding} 0"


def outcome(scene: Scene, job: Job, ranks: list) -> Outcome:
    """Time and record of a run from what its processes wrote."""
    seconds = max(float(rank["seconds"] - rank["spent"]) for rank in ranks)
    time = 1e9 * seconds / job.pieces / job.steps / scene.n
    if not job.sample:
        return Outcome(time, None)
    samples = np.sum([rank["samples"] for rank in ranks], axis=0)
    times = ranks[0]["samples"][:, 0]
    # what acts on the particles, chamber axes; the chamber gets the opposite
    wrench = np.array(
        [
            -(scene.attitude(scene.crank_angle(t)) @ row.reshape(2, 3).T).T.ravel()
            for t, row in zip(times, samples[:, 1:], strict=True)
        ]
    )
    moments = job.snapshot_times(scene)
    local = [np.vstack([rank[f"piece_{number}"] for rank in ranks]) for number in range(job.pieces)]
    snapshots = [scene.to_world(p, scene.crank_angle(t)) for p, t in zip(local, moments, strict=True)]
    return Outcome(time, Record(times, wrench, moments, np.array(snapshots)))
