"""The charge engine beside LAMMPS on one state: the same 2618 pellets in developed flow, the same law, the same step.

    python benchmarks/against_lammps.py [--lammps lmp]

LAMMPS (Debian: ``apt-get install lammps``) runs ``pair_style granular`` with linear springs, tangential and rolling memory.  Its
cylinder stands upright and swings round the circle that the chamber makes at the height of the charge, as LAMMPS cannot tilt a
region without spinning it; contacts per particle are printed for both.  Both engines run in turn, several times; medians count.
"""

import argparse
import re
import statistics
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from nutamill.bench import REPEATS, ROWS, developed_case, developed_flow, mechanism_step, on_threads, piece
from nutamill.build.clock import contact_facts
from nutamill.charge.assembly import positions, spins, velocities
from nutamill.frames import rotation_matrix
from nutamill.provenance import processor
from nutamill.warm import warm_up

STEPS = 4000


def write_case(folder: Path, model, state) -> None:
    """LAMMPS data and input of the present state, in chamber axes, with the cylinder upright."""
    case, mechanism = model.case, state.mechanism
    chamber = int(model.plan.carriers[0])
    rotation = np.empty((3, 3))
    rotation_matrix(mechanism.quaternion[chamber], rotation)
    x = positions(model.charge, state.charge, model.clock.substep)
    v, w = velocities(model.charge, state.charge) @ rotation, spins(model.charge, state.charge) @ rotation
    middle = x.mean(axis=0)
    wall_v = (mechanism.velocity[chamber] + np.cross(mechanism.angular_velocity[chamber], middle - mechanism.position[chamber])) @ rotation
    nutation_point = np.zeros(3)
    local = (x - nutation_point) @ rotation
    omega = case.drive.speed
    radius, phase = np.hypot(wall_v[0], wall_v[1]) / omega, np.arctan2(-wall_v[0], wall_v[1])
    diameter, density = case.charge.diameter, case.materials[case.charge.material].density
    n = len(local)
    lines = ["pellets", "", f"{n} atoms", "1 atom types", "", "-0.2 0.2 xlo xhi", "-0.2 0.2 ylo yhi", "-0.4 0.0 zlo zhi", "", "Atoms", ""]
    lines += [f"{i + 1} 1 {diameter} {density} {a:.12g} {b:.12g} {c:.12g}" for i, (a, b, c) in enumerate(local)]
    lines += ["", "Velocities", ""]
    lines += [f"{i + 1} {v[i, 0]:.9g} {v[i, 1]:.9g} {v[i, 2]:.9g} {w[i, 0]:.9g} {w[i, 1]:.9g} {w[i, 2]:.9g}" for i in range(n)]
    (folder / "pellets.data").write_text("\n".join(lines) + "\n")
    (ball, wall), mass = contact_facts(case), density * np.pi * diameter**3 / 6
    law = []
    for facts, m_eff in ((ball, mass / 2), (wall, mass)):
        eta = 2 * facts.law.damping_ratio * np.sqrt(facts.stiffness / m_eff)
        k, mu, mu_r = facts.stiffness, facts.law.static_friction, facts.law.rolling_friction
        law.append(f"hooke {k} {eta} tangential linear_history {k} 0.0 {mu} rolling sds {k} 0.0 {mu_r} damping mass_velocity")
    floor, ceiling = -case.chamber.floor_depth, -case.chamber.ceiling_depth
    (folder / "in.pellets").write_text(f"""units si
atom_style sphere
boundary f f f
newton off
comm_modify vel yes
read_data pellets.data
neighbor {0.25 * diameter} bin
neigh_modify delay 0 every 1 check yes
pair_style granular
pair_coeff * * {law[0]}
timestep {model.clock.substep}
variable x equal {radius}*(cos({omega}*time+{phase})-cos({phase}))
variable y equal {radius}*(sin({omega}*time+{phase})-sin({phase}))
region bore cylinder z 0 0 {case.chamber.inner_diameter / 2} {floor} {ceiling} side in move v_x v_y NULL
fix wall all wall/gran/region granular {law[1]} region bore
fix weight all gravity {case.mechanism.gravity} vector 0 0 -1
fix move all nve/sphere
compute contacts all contact/atom
compute z all reduce sum c_contacts
thermo_style custom step atoms ke c_z
thermo {STEPS}
run 500
run {STEPS}
""")


def lammps(command: str, folder: Path, threads: int) -> tuple[float, float]:
    """Nanoseconds per particle and step, and pair contacts per particle, of one run."""
    call = [command, "-in", "in.pellets", "-log", "none"]
    if threads > 1:
        call = ["mpirun", "--allow-run-as-root", "-np", str(threads), *call]
    said = subprocess.run(call, cwd=folder, capture_output=True, text=True, check=True).stdout
    seconds = float(re.findall(r"Loop time of ([0-9.e+-]+)", said)[-1])
    last = [line.split() for line in said.splitlines() if re.match(r"^\s*\d+\s+\d+\s", line)][-1]
    return 1e9 * seconds / STEPS / float(last[1]), float(last[3]) / 2 / float(last[1])


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--lammps", default="lmp")
    command = parser.parse_args().lammps
    warm_up(print)
    model, state = developed_flow(developed_case())
    n, substeps = model.charge.n_particles, model.plan.substeps
    steps = ROWS * model.plan.windows_per_row * substeps
    mechanism = mechanism_step(model, state)
    print(f"{processor()}; {n} pellets, 700 rpm, step {1e6 * model.clock.substep:.3f} us; ns per particle and step, medians of {REPEATS}")
    with tempfile.TemporaryDirectory() as folder:
        write_case(Path(folder), model, state)
        for threads in (1, 2):
            ours, theirs = [], []
            for _ in range(REPEATS):
                model, seconds = piece(on_threads(model, threads), state)
                ours.append(1e9 * (seconds / steps - mechanism / substeps) / n)
                theirs.append(lammps(command, Path(folder), threads))
            a, b = statistics.median(ours), statistics.median(time for time, _ in theirs)
            ratios = statistics.median(t / o for o, (t, _) in zip(ours, theirs, strict=True))
            touching = model.reading.contacts[0] / n
            print(
                f"{threads} thread{'s' if threads > 1 else ''}: nutamill {a:.1f}, LAMMPS granular {b:.1f}, ratio {ratios:.2f}"
                f"   (pair contacts per particle: {touching:.2f}, {theirs[-1][1]:.2f})"
            )


if __name__ == "__main__":
    main()
