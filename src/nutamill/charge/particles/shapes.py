"""Shapes of particles: one sphere, or a rigid clump of spheres with the mass properties of their union.

A shape has no density and no position.  Its axes are its principal axes and its origin is its mass centre,
so that a particle needs a centre, an attitude and a factor on the lengths of its shape.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from nutamill.base.errors import CaseError, Fault
from nutamill.charge.particles.union import union_properties

TOUCHING = 1e-9
"""Gap between two spheres, over the sum of their radii, up to which they count as joined [1]."""


@dataclass(frozen=True, slots=True, eq=False)
class ClumpShape:
    """A rigid particle of spheres (pebbles), in its principal axes about its mass centre.

    Attributes
    ----------
    offsets : centres of the spheres [m] (k, 3)
    radii : of the spheres [m] (k,)
    volume : of the union of the spheres [m^3]
    inertia : principal moments of the union over density [m^5] (3,), rising
    """

    offsets: np.ndarray
    radii: np.ndarray
    volume: float
    inertia: np.ndarray

    def __post_init__(self):
        """Make the arrays read-only: particles share shapes."""
        for name in ("offsets", "radii", "inertia"):
            array = np.array(getattr(self, name), float)
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    @property
    def spheres(self) -> int:
        """Number of spheres [1]."""
        return len(self.radii)

    @property
    def bounding_radius(self) -> float:
        """Radius [m] of the smallest sphere about the mass centre that holds the particle."""
        return float((np.linalg.norm(self.offsets, axis=1) + self.radii).max())

    @property
    def equivalent_diameter(self) -> float:
        """Diameter [m] of the sphere of the same volume."""
        return (6.0 * self.volume / math.pi) ** (1.0 / 3.0)

    @property
    def extents(self) -> np.ndarray:
        """Sizes [m] (3,) along the principal axes."""
        return (self.offsets + self.radii[:, None]).max(axis=0) - (self.offsets - self.radii[:, None]).min(
            axis=0
        )

    @property
    def aspect_ratio(self) -> float:
        """Longest over shortest of the `extents` [1]."""
        return float(self.extents.max() / self.extents.min())

    def scaled(self, to: float) -> "ClumpShape":
        """Return the same shape with the equivalent diameter `to` [m]."""
        factor = to / self.equivalent_diameter
        return ClumpShape(
            self.offsets * factor, self.radii * factor, self.volume * factor**3, self.inertia * factor**5
        )

    def push_mass(self) -> np.ndarray:
        """Return the least effective mass over density [m^3] (k,) of a push through the centre of each
        sphere.

        A normal force at sphere c in direction n moves the contact as a free mass m_n does, with
        ``1/m_n = 1/m + (c x n) . I^-1 (c x n)``; the direction that yields most rules.  It replaces the
        particle's mass in the duration of a contact.
        """
        least = np.empty(self.spheres)
        for k, (x, y, z) in enumerate(self.offsets):
            cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
            yielding = np.linalg.eigvalsh(cross.T @ (cross / self.inertia[:, None])).max()
            least[k] = 1.0 / (1.0 / self.volume + max(yielding, 0.0))
        return least


def sphere_shape(diameter: float = 1.0) -> ClumpShape:
    """Return one sphere of the given diameter [m]. With 1, a particle's scale is its diameter."""
    radius = 0.5 * diameter
    volume = 4.0 / 3.0 * math.pi * radius**3
    return ClumpShape(np.zeros((1, 3)), np.array([radius]), volume, np.full(3, 0.4 * volume * radius**2))


def clump_shape(centres: Sequence[Sequence[float]], radii: Sequence[float]) -> ClumpShape:
    """Return the shape of a rigid union of spheres, given in any axes and from any origin.

    Where moments are equal their axes are not determined, and which are taken is not defined; where they
    differ, each axis points to the side on which its largest direction cosine is positive, and the third
    completes a right-handed set.

    Parameters
    ----------
    centres : [m] (k, 3)
    radii : [m] (k,)

    Raises
    ------
    CaseError : radii that are not positive, a sphere wholly inside another, spheres that do not hang together
    """
    centre, radius = np.array(centres, float), np.array(radii, float)
    if faults := shape_faults(centre, radius):
        raise CaseError(*faults)
    if len(radius) == 1:
        return sphere_shape(2.0 * float(radius[0]))
    solid = union_properties(centre, radius)
    moments, axes = np.linalg.eigh(solid.inertia)
    axes *= np.sign(axes[np.abs(axes).argmax(axis=0), range(3)])
    axes[:, 2] = np.cross(axes[:, 0], axes[:, 1])
    return ClumpShape((centre - solid.mass_centre) @ axes, radius, solid.volume, moments)


def shape_faults(centres: np.ndarray, radii: np.ndarray) -> list[Fault]:
    """Return what prevents spheres from being one rigid particle, counting them from 0."""
    if centres.ndim != 2 or centres.shape[1:] != (3,) or radii.shape != (len(centres),) or not len(centres):
        return [
            Fault("spheres", f"must be (k, 3) centres and (k,) radii, got {centres.shape} and {radii.shape}")
        ]
    faults = []
    for k in np.flatnonzero(~np.isfinite(centres).all(axis=1)):
        faults.append(Fault(f"sphere {k}", "the centre must be finite"))
    for k in np.flatnonzero(~(np.isfinite(radii) & (radii > 0.0))):
        faults.append(
            Fault(f"sphere {k}", f"the radius must be positive, got {radii[k]:g}", "Leave the sphere out")
        )
    if faults:
        return faults
    gaps = np.linalg.norm(centres[:, None] - centres, axis=2)
    for i in range(len(radii)):
        holders = [
            j
            for j in range(len(radii))
            if j != i and gaps[i, j] + radii[i] <= radii[j] and (radii[i] < radii[j] or i > j)
        ]
        if holders:
            faults.append(
                Fault(
                    f"sphere {i}",
                    f"must not be wholly inside another, it is in sphere {holders[0]}",
                    "Leave it out",
                )
            )
    reached: set[int] = {0}
    waiting = [0]
    joined = gaps <= (radii[:, None] + radii) * (1.0 + TOUCHING)
    while waiting:
        new = set(np.flatnonzero(joined[waiting.pop()]).tolist()) - reached
        reached |= new
        waiting += new
    if len(reached) < len(radii):
        loose = ", ".join(str(k) for k in range(len(radii)) if k not in reached)
        faults.append(
            Fault(
                "spheres",
                f"must hang together, no chain of overlaps leads from sphere 0 to {loose}",
                "Move them closer",
            )
        )
    return faults
