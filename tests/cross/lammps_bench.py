"""One charge twice, in this engine and in LAMMPS, within walls that nutate: both in double precision."""

import dataclasses

import numpy as np

from nutamill.case import load_case
from nutamill.charge.assembly import charge_of
from nutamill.charge.kernels.dynamics import start, window
from nutamill.charge.walls.mesh import closed_mesh
from nutamill.charge.walls.mesh_patches import mesh_surfaces
from nutamill.charge.walls.surface import Surface, SurfaceKind, plane
from nutamill.simulation.lammps.grains import Grains
from nutamill.simulation.lammps.ranks import Ranks, all_ranks
from nutamill.simulation.setup.charge import contact_law_of, pair_laws
from nutamill.simulation.setup.kinds import particle_kinds
from nutamill.simulation.setup.particles import charge_particles

TILT, SPEED = 0.106, 73.0
SUBSTEPS = 10
REFERENCE = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0])
RADIUS = 0.0025


def wall_of(kind):
    """The walls of one kind, material 1, about the origin of the body; pellets fall on them along -z."""
    if kind == "floor":
        return [plane("floor", material=1)]
    if kind == "cylinder":  # lying, so that pellets fall into it
        turned = [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]
        return [Surface("shell", SurfaceKind.CYLINDER, 0, 1, (0.0, 0.0, 0.07), turned, (0.07, 0.0, 0.0))]
    if kind == "rib edge":
        half = np.sqrt(0.5)
        turned = [[half, 0.0, -half], [0.0, 1.0, 0.0], [half, 0.0, half]]
        return [Surface("rib", SurfaceKind.BOX, 0, 1, (0.0, 0.0, -0.01 * half), turned, (0.005, 0.1, 0.005))]
    if kind == "cone":
        return [Surface("cone", SurfaceKind.CONE, 0, 1, (0.0, 0.0, -0.0015), size=(0.002, 0.08, 0.06))]
    corners = np.array([[x, y, z] for x in (-0.05, 0.05) for y in (-0.05, 0.05) for z in (0.0, 0.2)])
    faces = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]]
    faces += [[2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
    return mesh_surfaces(
        closed_mesh("box.stl", corners, np.array(faces), "inside", RADIUS), 0, 1, [0.0, 0.0, 0.0]
    )


def nutating(time):
    """Motion (1, 19) of a body that nutates about the origin, over a window that begins at `time` [s]."""
    angle, half = SPEED * time, 0.5 * TILT
    attitude = [np.cos(half), np.sin(half) * np.sin(angle), -np.sin(half) * np.cos(angle), 0.0]
    s, c = np.sin(TILT), np.cos(TILT)
    spin = SPEED * np.array([s * np.cos(angle), s * np.sin(angle), 1.0 - c])
    rate = SPEED**2 * s * np.array([-np.sin(angle), np.cos(angle), 0.0])
    still = [0.0, 0.0, 0.0]
    return np.array([[*still, *attitude, *still, *spin, *still, *rate]])


class Both:
    """The same particles in this engine and in LAMMPS.

    Parameters
    ----------
    places, velocities, spins : of the particles (n, 3), world
    surfaces : walls
    dt : substep [s]
    nutates : whether the walls move
    """

    def __init__(self, places, velocities, spins, surfaces, dt, nutates=True, changes=(), ranks=None):
        machine = load_case(
            "numill", ["charge.engine=lammps", f"charge.count={len(places)}", *changes]
        ).machine
        self.dt, self.windows, self.nutates = dt, 0, nutates
        kinds = particle_kinds(machine)
        particles = dataclasses.replace(
            charge_particles(machine).placed(np.array(places, float), None), material=kinds.of_particles
        )
        densities = [machine.materials[kind.material].density for kind in kinds.kinds]
        given = {
            "velocities": np.array(velocities, float),
            "spins": np.array(spins, float),
            "gravity": (0.0, 0.0, -300.0),
            "law": contact_law_of(machine),
            "domain": ((0.0, 0.0, 0.0), 1.0),
            "poses": self.motion()[:, :7],
            "precision": "double",
        }

        def made():
            charge = charge_of(particles, densities, pair_laws(machine), surfaces, 1, **given)
            start(*charge, dt)
            return charge

        self.ours = made()
        self.theirs = Grains(machine, made(), dt, ranks or Ranks())

    def motion(self):
        return nutating(self.windows * SUBSTEPS * self.dt if self.nutates else 0.0) * self.moves()

    def moves(self):
        """Ones, or zeros for the velocities of walls at rest (19,)."""
        return np.where(np.arange(19) < 7, 1.0, float(self.nutates))

    def march(self, windows, ours=True):
        """March both, or LAMMPS alone."""
        for _ in range(windows):
            motion = self.motion()
            if ours:
                window(*self.ours, motion, REFERENCE, SUBSTEPS, self.dt, 0, 1)
            self.theirs.window(motion, SUBSTEPS)
            self.windows += 1
        self.theirs.take()

    def column(self, name):
        """A column of the state (3, n) by id, in this engine and in LAMMPS."""
        return [by_id(charge[1], name, charge[0].n_particles) for charge in (self.ours, self.of_lammps())]

    def of_lammps(self):
        return self.theirs.model, self.theirs.state

    def close(self):
        self.theirs.close()


def by_id(state, name, n):
    out = np.empty((3, n))
    out[:, state.ids[:n]] = getattr(state, name)[:, :n]
    return out


__all__ = ["Both", "all_ranks", "by_id", "nutating", "wall_of"]
