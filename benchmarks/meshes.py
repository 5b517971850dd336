"""What a meshed wall costs beside the exact one: ``python benchmarks/meshes.py [--quick]``, some minutes.

The chamber of the published mill with its pellets at 700 rpm, once of exact walls and once as closed meshes
of 640, 16900 and 66000 triangles, each after its own run-up of 0.3 s from the bed of the exact one; and a
drum with and without 24 meshed lifters.  One thread.  All are marched in turn, piece by piece, in one
process; the table has medians of the CPU time of a substep and of the ratio to the neighbouring piece of the
first.  The power that the charge takes from the chamber is compared over whole revolutions; behind +- stands
the standard deviation between the revolutions.
"""

import argparse
import itertools
import resource
import statistics
import struct
import tempfile
import time
from pathlib import Path

import numpy as np

import nutamill as nm
from nutamill.base.provenance import git_commit, processor
from nutamill.case import load_case
from nutamill.charge.filling.fill import random_fill
from nutamill.charge.model import Clock
from nutamill.charge.walls.mesh import closed_mesh
from nutamill.charge.walls.mesh_patches import mesh_surfaces
from nutamill.charge.walls.surface import Surface, SurfaceKind
from nutamill.simulation.setup.bed import settled_bed
from nutamill.simulation.speed import ROWS, developed_flow, on_threads, piece
from nutamill.simulation.warm_up import warm_up

BORE, FLOOR, CEILING = 70.0, -350.0, -122.0
"""Radius and heights of the chamber [mm], its axes."""

MESHES = {640: (32, 7, 2), 16900: (130, 46, 10), 66000: (250, 93, 20)}
"""Faces around, bands along, and rings of each end, by the number of triangles [1]."""

SPEED = 700.0 / 60.0
"""Revolutions in a second [1/s]."""


def chamber_triangles(around: int, along: int, rings: int) -> np.ndarray:
    """Corners [mm] (n, 3, 3) of a closed prism, normals outwards; the mean distance of its faces from the
    axis is that of the bore.
    """
    outer = BORE / (1.0 - np.pi**2 / around**2 / 3.0)
    angle = 2.0 * np.pi * np.arange(around) / around
    unit = np.stack([np.cos(angle), np.sin(angle)], axis=1)

    def ring(share, height):
        return np.column_stack([outer * share * unit, np.full(around, height)])

    def band(a, b):
        c, d = np.roll(a, -1, axis=0), np.roll(b, -1, axis=0)
        return np.concatenate([np.stack([a, c, d], axis=1), np.stack([a, d, b], axis=1)])

    rows = [ring(1.0, z) for z in np.linspace(FLOOR, CEILING, along + 1)]
    parts = [band(a, b) for a, b in itertools.pairwise(rows)]
    for height, turn in ((FLOOR, -1), (CEILING, 1)):
        circles = [ring(1.0 - k / rings, height) for k in range(rings)]
        ends = [band(a, b) for a, b in itertools.pairwise(circles)]
        last = circles[-1]
        middle = np.broadcast_to([0.0, 0.0, height], last.shape)
        ends.append(np.stack([last, np.roll(last, -1, axis=0), middle], axis=1))
        parts += [end[:, ::turn] for end in ends]
    return np.concatenate(parts)


def write_stl(path: Path, corners: np.ndarray) -> Path:
    """Write a binary STL file."""
    rows = np.zeros(len(corners), np.dtype([("n", "<f4", 3), ("c", "<f4", (3, 3)), ("a", "<u2")]))
    rows["c"] = corners
    path.write_bytes(bytes(80) + struct.pack("<I", len(corners)) + rows.tobytes())
    return path


class Mill:
    """The published mill, developed, marched by pieces of some rows."""

    def __init__(self, name: str, until: float, overrides: tuple[str, ...] = ()) -> None:
        settings = ["mechanism.mounting=rigid", "drive.ramp=7000 rpm/s", f"run.until={until} s"]
        bed = settled_bed(load_case("numill", settings).machine)
        self.name = name
        self.model, self.state, self.scratch = developed_flow(
            load_case("numill", [*settings, *overrides]), bed
        )
        self.model = on_threads(self.model, 1)
        self.particles = self.model.charge.n_particles
        self.substeps = ROWS * self.model.plan.windows_per_row * self.model.plan.substeps
        self.samples: list[tuple[float, float]] = []

    def march(self) -> None:
        """March one piece, and note the time and the work of the chamber on the charge at its end."""
        self.model, _ = piece(self.model, self.state, self.scratch)
        charge = self.state.charge
        self.samples.append(
            (int(charge.clock[Clock.STEP]) * self.model.clock.substep, float(charge.ledger[6]))
        )

    def power(self) -> tuple[float, float]:
        """Return mean power of the chamber on the charge and its deviation between revolutions [W]."""
        t, work = np.array(self.samples).T
        turns = int((t[-1] - t[0]) * SPEED)
        at = np.interp(t[-1] - np.arange(turns + 1)[::-1] / SPEED, t, work)
        each = np.diff(at) * SPEED
        return float(each.mean()), float(each.std(ddof=1)) if turns > 1 else 0.0


class Drum:
    """A drum about a horizontal axis, 30 % full, with or without meshed lifters."""

    RADIUS, LENGTH, BALL = 0.15, 0.1, 0.004
    LIFTERS, HEIGHT, WIDTH = 24, 0.012, 0.01
    COUNT, SUBSTEPS = 3000, 2000

    def __init__(self, name: str, lifters: bool, settle: int) -> None:
        self.name, self.particles, self.substeps = name, self.COUNT, self.SUBSTEPS
        upside_down = np.diag([1.0, -1.0, -1.0])
        walls = [
            Surface("bore", SurfaceKind.CYLINDER, 0, 0, size=(self.RADIUS, 0, 0)),
            Surface("floor", SurfaceKind.PLANE, 0, 0),
            Surface("ceiling", SurfaceKind.PLANE, 0, 0, (0, 0, self.LENGTH), upside_down),
        ]
        if lifters:
            vertices, faces = lifter_triangles(self)
            self.triangles = len(faces)
            walls += mesh_surfaces(closed_mesh("lifters", vertices, faces, "outside", self.BALL), 0, 0)
        x = random_fill(
            np.full(self.COUNT, self.BALL), self.RADIUS - 1.5 * self.HEIGHT, 0.0, self.LENGTH, seed=1
        )
        balls = nm.spheres(np.full(self.COUNT, 2.0 * self.BALL)).placed(x)
        steel = nm.linear_pair(stiffness=1e5, restitution=0.6, friction=0.3)
        self.charge = nm.Charge(
            balls, [7850.0], steel, walls, dt=1e-5, gravity=(-9.81, 0.0, 0.0), domain=((0, 0, 0), 0.5)
        )
        turning = self.charge.motion.copy()
        turning[0, 12] = 0.7 * np.sqrt(9.81 / self.RADIUS)
        self.charge.march(0.0, turning)
        self.charge.step(settle)

    def march(self) -> None:
        """March one piece."""
        self.charge.step(self.SUBSTEPS)


def lifter_triangles(drum: Drum) -> tuple[np.ndarray, np.ndarray]:
    """Corners [m] (V, 3) and triangles (T, 3) of straight bars on the bore of a drum, from end to end."""
    half = np.array([0.5 * drum.HEIGHT + 0.001, 0.5 * drum.WIDTH, 0.5 * drum.LENGTH - 1e-4])
    vertices, faces = box_grid(half, (2, 2, 12))
    corners, triangles = [], []
    for k in range(drum.LIFTERS):
        angle = 2.0 * np.pi * k / drum.LIFTERS
        c, s = np.cos(angle), np.sin(angle)
        moved = vertices + np.array([drum.RADIUS + 0.001 - 0.5 * drum.HEIGHT, 0.0, 0.5 * drum.LENGTH])
        corners.append(moved @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]))
        triangles.append(faces + k * len(vertices))
    return np.concatenate(corners), np.concatenate(triangles)


def box_grid(half: np.ndarray, cuts: tuple[int, int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Corners and triangles of a box about the origin whose faces are cut into rectangles."""
    corners, faces = [], []
    n = 0
    for axis in range(3):
        b, c = (axis + 1) % 3, (axis + 2) % 3
        for side in (-1.0, 1.0):
            u, v = (np.linspace(-half[k], half[k], cuts[k] + 1) for k in (b, c))
            points = np.zeros((len(u) * len(v), 3))
            points[:, axis] = side * half[axis]
            points[:, b], points[:, c] = (g.ravel() for g in np.meshgrid(u, v, indexing="ij"))
            number = n + np.arange(len(points)).reshape(len(u), len(v))
            p, q, r, s = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
            for triangle in ((p, q, r), (p, r, s)):
                three = np.stack([t.ravel() for t in triangle], axis=1)
                faces.append(three if side > 0 else three[:, ::-1])
            corners.append(points)
            n += len(points)
    return np.concatenate(corners), np.concatenate(faces)


def in_turn(scenes: list, pieces: int) -> dict[str, tuple[float, float]]:
    """March the scenes in turn and return, by name, CPU time of a substep [s] and its ratio to that of the
    first scene, medians.
    """
    times: dict[str, list[float]] = {scene.name: [] for scene in scenes}
    for _ in range(pieces):
        for scene in scenes:
            begun = resource.getrusage(resource.RUSAGE_SELF).ru_utime
            scene.march()
            taken = resource.getrusage(resource.RUSAGE_SELF).ru_utime - begun
            times[scene.name].append(taken / scene.substeps)
    first = times[scenes[0].name]
    return {
        name: (statistics.median(own), statistics.median(a / b for a, b in zip(own, first, strict=True)))
        for name, own in times.items()
    }


def main() -> None:
    parser = argparse.ArgumentParser(description="What a meshed wall costs beside the exact one.")
    parser.add_argument("--quick", action="store_true", help="a check that it runs, no measurement")
    quick = parser.parse_args().quick
    until, pieces, settle = (0.05, 3, 2000) if quick else (0.3, 30, 30_000)
    warm_up(lambda _: None)
    print(f"$ python benchmarks/meshes.py{' --quick' if quick else ''}      # {processor()}, ", end="")
    print(f"{time.strftime('%Y-%m-%d')}, commit {git_commit()[:9]}")
    with tempfile.TemporaryDirectory() as folder:
        mills = [Mill("exact walls", until)]
        for n, cut in MESHES.items():
            corners = chamber_triangles(*cut)
            assert len(corners) == n
            path = write_stl(Path(folder) / f"chamber-{n}.stl", corners)
            overrides = (f"chamber.mesh.file={path}", "chamber.mesh.unit=mm")
            mills.append(Mill(f"mesh of {n} triangles", until, overrides))
        table = in_turn(mills, pieces)
    print(f"chamber of the published mill, {mills[0].particles} pellets at 700 rpm, one thread:")
    exact = mills[0].power()
    for mill in mills:
        taken, ratio = table[mill.name]
        mean, scatter = mill.power()
        print(
            f"  {mill.name:26} {taken * 1e6:7.1f} us per substep, {ratio:5.2f} times;"
            f" power {mean:6.1f} +- {scatter:4.1f} W, {100 * (mean / exact[0] - 1):+5.1f} %"
        )
    drums = [Drum("drum, exact walls", False, settle), Drum("with 24 meshed lifters", True, settle)]
    table = in_turn(drums, pieces)
    print(f"drum with {drums[0].particles} balls, lifters of {drums[1].triangles} triangles:")
    for drum in drums:
        taken, ratio = table[drum.name]
        pairs, walls = drum.charge.contacts
        print(
            f"  {drum.name:26} {taken * 1e6:7.1f} us per substep, {ratio:5.2f} times;"
            f" {pairs} pair and {walls} wall contacts"
        )


if __name__ == "__main__":
    main()
