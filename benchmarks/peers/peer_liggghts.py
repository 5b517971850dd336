"""LIGGGHTS: input of a scene, and runs of it.

Its exact walls cannot move, and a moving mesh of flat faces kicks the fast charge at every edge.  So it sees
the chamber at rest, and ``fix addforce`` adds the forces of the moving frame,
``m (g - W x (W x r) - W' x r - 2 W x v)``.  What that costs is measured by adding nothing several times more,
and taken off.
"""

import re
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from peer import Job, Outcome
from scene import Record, Scene

IDLE = 4
"""Idle copies of the frame's forces in the run that measures their cost [1]."""


@dataclass(frozen=True, slots=True)
class Liggghts:
    """LIGGGHTS of the distribution."""

    launcher: tuple[str, ...]
    """Starts as many processes as the number that follows says."""
    environment: dict[str, str]
    """Environment of its processes."""
    name: str = "LIGGGHTS Debian, hooke/stiffness + epsd2"
    note: str = (
        "version 3.8.0; the same law; sees the chamber at rest in a moving frame, the cost of which "
        "is taken off"
    )
    pace: float = 1500.0

    def run(self, scene: Scene, job: Job) -> Outcome:
        """Run a scene.

        Raises
        ------
        subprocess.SubprocessError : the engine fails, or takes too long
        """
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            write_data(folder / "particles", scene)
            (folder / "input").write_text(commands(scene, job))
            call = [*self.launcher, str(job.threads), "liggghts", "-in", "input", "-log", "none"]
            said = subprocess.run(
                call, cwd=folder, env=self.environment, capture_output=True, text=True, timeout=job.patience
            )
            loops = [float(found) for found in re.findall(r"Loop time of ([0-9.e+-]+)", said.stdout)]
            if said.returncode or len(loops) < 3 - bool(job.sample):
                raise subprocess.CalledProcessError(
                    said.returncode, call, said.stdout, said.stdout[-2000:] + said.stderr
                )
            frame = 0.0 if job.sample else (loops[2] - loops[1]) / IDLE
            time = 1e9 * (loops[1] - frame) / job.pieces / job.steps / scene.n
            return Outcome(time, record(scene, folder) if job.sample else None)


def write_data(file: Path, scene: Scene) -> None:
    """The particles in chamber axes, in a box whose halves by height hold as many each."""
    local = scene.to_chamber(scene.particles, scene.angle)
    r, high = 1.1 * scene.bore, scene.ceiling + scene.diameter
    low = min(2 * np.median(local[:, 2]) - high, scene.floor - scene.diameter)
    head = (
        f"particles\n\n{scene.n} atoms\n2 atom types\n\n{-r} {r} xlo xhi\n{-r} {r} ylo yhi\n{low} {high} "
        "zlo zhi\n\nAtoms\n\n"
    )
    atoms = (
        f"{i} 1 {scene.diameter} {scene.density} {a[0]:.15g} {a[1]:.15g} {a[2]:.15g}"
        for i, a in enumerate(local, 1)
    )
    motions = (f"{i} " + " ".join(f"{value:.15g}" for value in a[3:]) for i, a in enumerate(local, 1))
    file.write_text(head + "\n".join(atoms) + "\n\nVelocities\n\n" + "\n".join(motions) + "\n")


def commands(scene: Scene, job: Job) -> str:
    """The input file."""
    pair, wall = scene.pair, scene.wall
    model = "model hooke/stiffness tangential history rolling_friction epsd2"
    switches = "tangential_damping off limitForce off absolute_damping off"

    def of_pairs(name: str, of_pair: float, of_wall: float) -> str:
        return (
            f"fix {name} all property/global {name} peratomtypepair 2 {of_pair} {of_wall} {of_wall} {of_pair}"
        )

    walls = "\n".join(
        f"fix {name} all wall/gran {model} primitive type 2 {shape} {switches}"
        for name, shape in (
            ("bore", f"zcylinder {scene.bore} 0.0 0.0"),
            ("floor", f"zplane {scene.floor}"),
            ("ceiling", f"zplane {scene.ceiling}"),
        )
    )
    idle = (
        "\n".join(f"fix idle_{number} all addforce v_zx v_zy v_zz" for number in range(IDLE))
        + f"\nrun {job.steps * job.pieces}"
    )
    return f"""units si
atom_style granular
atom_modify map array
boundary f f f
newton off
communicate single vel yes
processors 1 1 {job.threads}
read_data particles
neighbor {0.25 * scene.diameter} bin
neigh_modify delay 0
{of_pairs("kn", pair.stiffness, wall.stiffness)}
{of_pairs("kt", pair.tangential, wall.tangential)}
{of_pairs("gamman", pair.damping_rate, wall.damping_rate)}
{of_pairs("gammat", 0.0, 0.0)}
{of_pairs("coefficientFriction", pair.sliding, wall.sliding)}
{of_pairs("coefficientRollingFriction", pair.rolling, wall.rolling)}
pair_style gran {model} {switches}
pair_coeff * *
timestep {scene.substep}
{walls}
{frame_forces(scene)}
fix frame all addforce v_fx v_fy v_fz
fix move all nve/sphere
thermo 1000000
run {job.before}
{watch(job) if job.sample else ""}run {job.steps * job.pieces}
{"" if job.sample else idle}
"""


def frame_forces(scene: Scene) -> str:
    """Variables: forces of the moving frame on a particle, and the same times nothing."""
    s, c, speed = np.sin(scene.tilt), np.cos(scene.tilt), scene.speed
    lines = [
        f"variable angle equal {scene.angle}+{speed * scene.substep}*step",
        f"variable ox equal {speed * s}*cos(v_angle)",
        f"variable oy equal {speed * s}*sin(v_angle)",
        f"variable ax equal -{speed**2 * s}*sin(v_angle)",
        f"variable ay equal {speed**2 * s}*cos(v_angle)",
        f"variable gx equal -{scene.gravity * s}*cos(v_angle)",
        f"variable gy equal -{scene.gravity * s}*sin(v_angle)",
        f"variable gz equal -{scene.gravity * c}",
    ]
    # W x (W x r) = W (W . r) - W^2 r, coefficients once a step and not once a particle
    down = speed * (1 - c)  # the chamber turns by as much about less its axis
    lines += [
        f"variable cxx equal {down * down}+v_oy*v_oy",
        f"variable cyy equal {down * down}+v_ox*v_ox",
        "variable czz equal v_ox*v_ox+v_oy*v_oy",
        "variable cxy equal -v_ox*v_oy",
        f"variable cxz equal v_ox*{down}-v_ay",
        f"variable cyz equal v_oy*{down}+v_ax",
        f"variable czx equal v_ox*{down}+v_ay",
        f"variable czy equal v_oy*{down}-v_ax",
    ]
    accelerations = {
        "x": f"v_gx+v_cxx*x+v_cxy*y+v_cxz*z-2*v_oy*vz-{2 * down}*vy",
        "y": f"v_gy+v_cxy*x+v_cyy*y+v_cyz*z+{2 * down}*vx+2*v_ox*vz",
        "z": "v_gz+v_czx*x+v_czy*y+v_czz*z-2*v_ox*vy+2*v_oy*vx",
    }
    lines += [f"variable f{axis} atom {scene.mass}*({formula})" for axis, formula in accelerations.items()]
    lines += [f"variable z{axis} atom 0.0*({formula})" for axis, formula in accelerations.items()]
    return "\n".join(lines)


def watch(job: Job) -> str:
    """Sums of what acts on the particles, with and without the frame's forces, and snapshots."""
    columns = " ".join(f"c_{part}[{k}]" for part in ("all_of", "frame_of") for k in range(1, 7))
    return f"""variable mx atom y*fz-z*fy+tqx
variable my atom z*fx-x*fz+tqy
variable mz atom x*fy-y*fx+tqz
variable nx atom y*v_fz-z*v_fy
variable ny atom z*v_fx-x*v_fz
variable nz atom x*v_fy-y*v_fx
compute all_of all reduce sum fx fy fz v_mx v_my v_mz
compute frame_of all reduce sum v_fx v_fy v_fz v_nx v_ny v_nz
fix sums all ave/time {job.sample} 1 {job.sample} {columns} file sums
dump seen all custom {job.steps} seen x y z vx vy vz omegax omegay omegaz
dump_modify seen format "%.12g %.12g %.12g %.12g %.12g %.12g %.12g %.12g %.12g"
"""


def record(scene: Scene, folder: Path) -> Record:
    """What a sampled run wrote; the walls' part is what the frame leaves of the sum, as pairs cancel."""
    rows = np.loadtxt(folder / "sums")
    times = scene.substep * rows[:, 0]
    on_charge = (rows[:, 1:7] - rows[:, 7:13]).reshape(-1, 2, 3)
    wrench = np.array(
        [-(w @ scene.attitude(scene.crank_angle(t)).T).ravel() for t, w in zip(times, on_charge, strict=True)]
    )
    blocks = (folder / "seen").read_text().split("ITEM: TIMESTEP\n")[1:]
    moments = [scene.substep * int(block.split("\n", 1)[0]) for block in blocks]
    local = [np.array(block.split("omegaz", 1)[1].split(), float).reshape(-1, 9) for block in blocks]
    snapshots = [scene.to_world(p, scene.crank_angle(t)) for p, t in zip(local, moments, strict=True)]
    return Record(times, wrench, np.array(moments), np.array(snapshots))
