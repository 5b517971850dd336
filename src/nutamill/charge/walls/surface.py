"""A wall piece in the axes of the body that carries it."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from nutamill.charge.walls.mesh import Mesh


class SurfaceKind(IntEnum):
    """Shape of a wall piece, in its own axes.

    A particle whose centre is beyond the ends of a CONE, SPHERE_CAP, DISC or TUBE does not touch it, nor one
    whose centre is its radius or more behind a SPHERE_CAP, DISC or TUBE.
    """

    PLANE = 0
    """Plane z = 0; the charge is on the side of +z."""
    CYLINDER = 1
    """Inside of an endless cylinder about z, of radius ``size[0]``."""
    BOX = 2
    """Outside of a box about the origin with half sizes ``size``; faces, edges and corners."""
    CONE = 3
    """Inside of a cone about z, from radius ``size[0]`` at z = 0 to radius ``size[1]`` at z = ``size[2]``."""
    SPHERE_CAP = 4
    """Inside of a sphere about the origin of radius ``size[0]``, as far as ``size[1]`` [rad] from -z: a bowl
    that opens to +z.
    """
    MESH_PATCH = 5
    """A smooth patch of a triangle mesh; ``Surface.mesh`` and ``Surface.patch`` say which."""
    DISC = 6
    """Disc of radius ``size[0]`` about the origin in the plane z = 0; the charge is on the side of +z."""
    TUBE = 7
    """Inside of a cylinder about z of radius ``size[0]``, from z = 0 to z = ``size[1]``."""
    ROD = 8
    """Outside of a solid cylinder about z of radius ``size[0]``, from z = -``size[1]`` to z = ``size[1]``:
    side, flat ends and rims.
    """
    BALL = 9
    """Outside of a sphere about the origin of radius ``size[0]``."""


@dataclass(frozen=True, slots=True)
class Surface:
    """A smooth wall piece carried by a body.

    Attributes
    ----------
    name : for messages
    kind : shape
    body : index of the carrying body
    material : index of its material
    origin : [m] (3,), in the body's axes, from the body's mass centre
    rotation : [1] (3, 3), from surface axes to the body's axes
    size : [m], angles [rad] (3,), by `SurfaceKind`
    mesh, patch : for MESH_PATCH, the mesh in surface axes and the number of the patch; see `mesh_surfaces`
    """

    name: str
    kind: SurfaceKind
    body: int
    material: int
    origin: Sequence[float] | np.ndarray = (0.0, 0.0, 0.0)
    rotation: Sequence[Sequence[float]] | np.ndarray = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    size: Sequence[float] = (0.0, 0.0, 0.0)
    mesh: Mesh | None = None
    patch: int = 0


def plane(
    name: str,
    point: Sequence[float] = (0.0, 0.0, 0.0),
    normal: Sequence[float] = (0.0, 0.0, 1.0),
    body: int = 0,
    material: int = 0,
) -> Surface:
    """Return an endless plane.

    Parameters
    ----------
    name : for messages
    point : any point of it [m] (3,), in the body's axes, from the body's mass centre
    normal : direction to the side of the charge (3,), of any length, in the body's axes
    body : index of the carrying body
    material : index of its material
    """
    up = np.asarray(normal, float) / np.linalg.norm(normal)
    along = np.roll(np.eye(3)[np.argmax(np.abs(up))], 1)
    along = along - (along @ up) * up
    along /= np.linalg.norm(along)
    rotation = np.column_stack([along, np.cross(up, along), up])
    return Surface(name, SurfaceKind.PLANE, body, material, tuple(map(float, point)), rotation)
