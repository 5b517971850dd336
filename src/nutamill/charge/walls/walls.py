"""Any surface of a charge, simple shape or patch of a mesh: its contact with a particle."""

from nutamill.base.kernel import kernel
from nutamill.charge.walls.mesh_contact import mesh_overlap
from nutamill.charge.walls.surface import SurfaceKind
from nutamill.charge.walls.surfaces import surface_overlap

MESH_PATCH = int(SurfaceKind.MESH_PATCH)


@kernel(inline="always")
def wall_overlap(kind, model, surface_poses, s, x0, x1, x2, r):
    """Return overlap [m] and normal [1] (3), world axes, of a sphere of radius `r` at (x0, x1, x2) [m] with
    surface `s` of `kind`.

    `surface_poses` (S, 12) as from `place_surfaces`.  No contact where the overlap is not positive.
    """
    if kind == MESH_PATCH:
        return mesh_overlap(model.mesh, surface_poses, s, x0, x1, x2, r)
    return surface_overlap(kind, model.surface_size, surface_poses, s, x0, x1, x2, r)


@kernel
def wall_overlaps(model, surface_poses, s, x, r, out):
    """Write the overlaps [m] (n,) of spheres of radii `r` [m] (n,) at `x` [m] (n, 3), world, with surface
    `s`, to `out`.
    """
    kind = model.surface_kind[s]
    for i in range(len(r)):
        out[i] = wall_overlap(kind, model, surface_poses, s, x[i, 0], x[i, 1], x[i, 2], r[i])[0]
