"""The particles of a charge: shape, size, material and position of each."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from nutamill.base.errors import CaseError, Fault
from nutamill.charge.particles.shapes import ClumpShape, sphere_shape

LOOSE_PACKING = 0.58
"""Share of its bulk volume that a loose random bed of spheres fills [1].

Source: G. D. Scott, "Packing of spheres", Nature 188, 908 (1960): 0.60 to 0.63 less the wall's share.
"""

NAMED = 5
"""Offenders that a message names [1]."""


@dataclass(frozen=True, slots=True, eq=False)
class Particles:
    """The particles of a charge, by id.

    Attributes
    ----------
    shapes : the shapes that occur
    shape_of : index of each particle's shape [1] (n,)
    scale : factor on the lengths of its shape [1] (n,); a diameter [m] for shapes of unit diameter
    material : number of its material [1] (n,)
    centre : mass centre [m] (n, 3); None before they are placed
    attitude : quaternion from the shape's axes to those of `centre` (n, 4); None for spheres, and before they
        are placed
    """

    shapes: tuple[ClumpShape, ...]
    shape_of: np.ndarray
    scale: np.ndarray
    material: np.ndarray
    centre: np.ndarray | None = None
    attitude: np.ndarray | None = None

    @property
    def number(self) -> int:
        """Number of particles [1]."""
        return len(self.scale)

    @property
    def spheres_only(self) -> bool:
        """Whether every particle is a single sphere."""
        return all(shape.spheres == 1 for shape in self.shapes)

    @property
    def pebbles(self) -> int:
        """Number of spheres of all particles [1]."""
        return int(self._of_shape([shape.spheres for shape in self.shapes]).sum())

    @property
    def volume(self) -> np.ndarray:
        """Solid volume of each particle [m^3] (n,)."""
        return self._of_shape([shape.volume for shape in self.shapes]) * self.scale**3

    @property
    def diameter(self) -> np.ndarray:
        """Equivalent diameter of each particle [m] (n,)."""
        return self._of_shape([shape.equivalent_diameter for shape in self.shapes]) * self.scale

    @property
    def bounding_radius(self) -> np.ndarray:
        """Radius [m] (n,) of the sphere about its mass centre that holds each particle."""
        return self._of_shape([shape.bounding_radius for shape in self.shapes]) * self.scale

    @property
    def poses(self) -> np.ndarray:
        """Positions [m] (n, 3), with the attitudes (n, 7) where there are any. Particles must be placed."""
        assert self.centre is not None
        return self.centre if self.attitude is None else np.column_stack([self.centre, self.attitude])

    def mass(self, densities: Sequence[float]) -> np.ndarray:
        """Return the mass of each particle [kg] (n,), with the densities of the materials [kg/m^3]."""
        return np.asarray(densities, float)[self.material] * self.volume

    def placed(self, centre: np.ndarray, attitude: np.ndarray | None = None) -> "Particles":
        """Return the same particles at other positions and attitudes."""
        return replace(self, centre=centre, attitude=attitude)

    def _of_shape(self, values) -> np.ndarray:
        return np.asarray(values, float)[self.shape_of]


def joined(parts: Sequence[Particles]) -> Particles:
    """Return the particles of several parts that are not placed yet, part after part, with one list of
    shapes.
    """
    first = np.cumsum([0] + [len(part.shapes) for part in parts])
    return Particles(
        tuple(shape for part in parts for shape in part.shapes),
        np.concatenate([part.shape_of + k for part, k in zip(parts, first, strict=False)]),
        np.concatenate([part.scale for part in parts]),
        np.concatenate([part.material for part in parts]),
    )


def spheres(diameters: np.ndarray, material: int = 0) -> Particles:
    """Return spheres of the given diameters [m] (n,), not placed yet, of one `material` or of one each."""
    diameters = np.asarray(diameters, float)
    n = len(diameters)
    return Particles((sphere_shape(),), np.zeros(n, np.int32), diameters, np.full(n, material, np.int32))


def clumps(
    shapes: Sequence[ClumpShape], diameters: np.ndarray, material: int = 0, seed: int = 1
) -> Particles:
    """Return clumps of the given equivalent diameters [m] (n,), not placed yet, with each shape equally
    often.

    Parameters
    ----------
    shapes : of any size; only their form counts
    seed : of which shape goes with which size
    """
    diameters = np.asarray(diameters, float)
    n = len(diameters)
    shape_of = np.random.default_rng(seed).permutation(np.arange(n, dtype=np.int32) % len(shapes))
    return Particles(
        tuple(shape.scaled(1.0) for shape in shapes), shape_of, diameters, np.full(n, material, np.int32)
    )


def check_particles(particles: Particles, densities: Sequence[float]) -> None:
    """Reject particles without a valid shape, size, mass or position.

    Raises
    ------
    CaseError : every fault, with the ids of the particles
    """
    n = particles.number
    faults = []
    for name, width in (("shape_of", ()), ("material", ()), ("centre", (3,)), ("attitude", (4,))):
        array = getattr(particles, name)
        if array is not None and np.shape(array) != (n, *width):
            faults.append(Fault(f"particles.{name}", f"must have shape {(n, *width)}, got {np.shape(array)}"))
    if particles.centre is None:
        faults.append(Fault("particles.centre", "is missing", "Place the particles first"))
    if particles.attitude is None and not particles.spheres_only:
        faults.append(
            Fault(
                "particles.attitude",
                "is missing, and not all particles are spheres",
                "Give each a quaternion (w, x, y, z)",
            )
        )
    if faults or particles.centre is None:
        raise CaseError(*faults)
    faults += _named("scale", ~(np.isfinite(particles.scale) & (particles.scale > 0.0)), "positive")
    faults += _named(
        "shape_of",
        _outside(particles.shape_of, len(particles.shapes)),
        f"from 0 to {len(particles.shapes) - 1}",
    )
    strange = _outside(particles.material, len(densities))
    faults += _named("material", strange, f"from 0 to {len(densities) - 1}")
    faults += _named("centre", ~np.isfinite(particles.centre).all(axis=1), "finite")
    if particles.attitude is not None:
        length = np.linalg.norm(particles.attitude, axis=1)
        faults += _named("attitude", ~(np.abs(length - 1.0) < 1e-6), "unit quaternions")
    if not strange.any():
        density = np.asarray(densities, float)[particles.material]
        faults += _named("density", ~(np.isfinite(density) & (density > 0.0)), "positive")
    if faults:
        raise CaseError(*faults)


def motion_faults(number: int, velocities: np.ndarray | None, spins: np.ndarray | None) -> list[Fault]:
    """Return what is wrong with the first velocities [m/s] and spins [rad/s], each (number, 3), None for
    rest.
    """
    faults = []
    for name, given in (("velocities", velocities), ("spins", spins)):
        if given is not None and np.shape(given) != (number, 3):
            faults.append(Fault(name, f"must have shape {(number, 3)}, got {np.shape(given)}"))
        elif given is not None:
            faults += _named(name, ~np.isfinite(np.asarray(given, float)).all(axis=1), "finite", "")
    return faults


def _outside(numbers, count) -> np.ndarray:
    return (numbers < 0) | (numbers >= count)


def _named(name, bad, must, prefix="particles.") -> list[Fault]:
    """Return a fault with the numbers of the particles for which it holds, or none."""
    ids = np.flatnonzero(bad)
    if not len(ids):
        return []
    more = f" and {len(ids) - NAMED} more" if len(ids) > NAMED else ""
    return [
        Fault(prefix + name, f"must be {must}, not so for particles {', '.join(map(str, ids[:NAMED]))}{more}")
    ]
