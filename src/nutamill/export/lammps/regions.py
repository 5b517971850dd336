"""Walls as regions of LAMMPS, at rest in the axes of the body that carries them."""

from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

from nutamill.charge.walls.surface import Surface, SurfaceKind

ALIGNED = 1e-12
"""Rotation below which the axes of a wall are those of its body [rad]."""


def _plane(surface: Surface) -> str:
    point, normal = np.asarray(surface.origin), np.asarray(surface.rotation)[:, 2]
    return f"plane {_numbers(*point)} {_numbers(*normal)} side in"


def _cylinder(surface: Surface) -> str:
    return f"cylinder z 0 0 {surface.size[0]:.15g} INF INF side in open 1 open 2"


def _box(surface: Surface) -> str:
    return f"block {' '.join(_numbers(-half, half) for half in surface.size)} side out"


def _rod(surface: Surface) -> str:
    return f"cylinder z 0 0 {_numbers(surface.size[0], -surface.size[1], surface.size[1])} side out"


def _ball(surface: Surface) -> str:
    return f"sphere 0 0 0 {surface.size[0]:.15g} side out"


SHAPES: dict[SurfaceKind, Callable[[Surface], str]] = {
    SurfaceKind.PLANE: _plane,
    SurfaceKind.CYLINDER: _cylinder,
    SurfaceKind.BOX: _box,
    SurfaceKind.ROD: _rod,
    SurfaceKind.BALL: _ball,
}
"""Surfaces that a region of LAMMPS stands for, with the same nearest point.

Its cones and tubes have rims, which ours leave to the next wall; it has no caps and no meshes.
"""


def region_lines(number: int, surface: Surface) -> list[str]:
    """Return the commands that make the region ``wall<number>`` of a surface, in the axes of its body."""
    name, shape = f"wall{number}", SHAPES[surface.kind](surface)
    origin, turn = np.asarray(surface.origin, float), Rotation.from_matrix(np.asarray(surface.rotation))
    if surface.kind == SurfaceKind.PLANE:
        return [f"region {name} {shape}"]
    vector = turn.as_rotvec()
    angle = float(np.linalg.norm(vector))
    places = [f"variable {name}{c} equal {place:.15g}" for c, place in zip("xyz", origin, strict=True)]
    moved = " ".join(f"v_{name}{c}" for c in "xyz")
    line = f"region {name} {shape} move {moved}"
    if angle < ALIGNED:
        return [*places, line]
    turned = f"rotate v_{name}turn 0 0 0 {_numbers(*vector / angle)}"
    return [*places, f"variable {name}turn equal {angle:.15g}", f"{line} {turned}"]


def _numbers(*values: float) -> str:
    return " ".join(f"{value:.15g}" for value in values)
