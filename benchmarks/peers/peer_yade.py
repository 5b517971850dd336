"""YADE: what a scene is in its terms, and runs of it."""

import json
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from chamber_mesh import chamber_triangles
from peer import Job, Outcome
from scene import Record, Scene


@dataclass(frozen=True, slots=True)
class Yade:
    """YADE of the distribution."""

    environment: dict[str, str]
    """Environment of its process."""
    name: str = "YADE Debian, ViscElMat"
    note: str = (
        "version 2023.02; no rolling resistance, tension cut; the chamber is a mesh that nutates, "
        "and a sphere at an edge between two"
        " facets touches both"
    )
    pace: float = 6000.0

    def run(self, scene: Scene, job: Job) -> Outcome:
        """Run a scene.

        Raises
        ------
        subprocess.SubprocessError : the engine fails, or takes too long
        """
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            np.save(folder / "particles.npy", scene.particles)
            corners = (
                chamber_triangles(scene.bore, scene.floor, scene.ceiling) @ scene.attitude(scene.angle).T
            )
            np.save(folder / "triangles.npy", corners)
            (folder / "given").write_text(json.dumps(numbers(scene, job)))
            call = ["yade", "-n", "-x", f"-j{job.threads}", str(Path(__file__).with_name("inside_yade.py"))]
            said = subprocess.run(
                call,
                cwd=folder,
                env=self.environment,
                capture_output=True,
                text=True,
                timeout=job.patience,
                stdin=subprocess.DEVNULL,
            )
            if not (folder / "told.npz").is_file():
                raise subprocess.CalledProcessError(
                    said.returncode, call, said.stdout, said.stdout[-2000:] + said.stderr
                )
            told = np.load(folder / "told.npz")
            time = 1e9 * float(told["seconds"]) / job.pieces / job.steps / scene.n
            record = None
            if job.sample:
                samples = told["samples"]
                record = Record(samples[:, 0], samples[:, 1:], told["moments"], told["seen"])
            return Outcome(time, record)


def numbers(scene: Scene, job: Job) -> dict:
    """The scene and the job as plain numbers; YADE puts the springs, and the dashpots, of two bodies in
    series.
    """
    of_pair, of_wall = (
        {"kn": law.stiffness, "ks": law.tangential, "cn": law.damping_rate * law.reduced_mass}
        for law in (scene.pair, scene.wall)
    )
    sphere = {name: 2 * value for name, value in of_pair.items()}
    plate = {name: own * of_wall[name] / (own - of_wall[name]) for name, own in sphere.items()}
    given = {
        part: getattr(scene, part)
        for part in ("angle", "speed", "tilt", "gravity", "density", "diameter", "substep")
    }
    given |= {"before": job.before, "steps": job.steps, "pieces": job.pieces, "sample": job.sample}
    return given | {
        "sphere": sphere | {"friction": scene.pair.sliding},
        "plate": plate | {"friction": scene.wall.sliding},
    }
