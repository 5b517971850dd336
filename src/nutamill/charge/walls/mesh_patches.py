"""From meshes to the arrays of the kernels: shared edges and corners, their regions and owners, their
places.
"""

from collections.abc import Sequence

import numpy as np

from nutamill.charge.walls.mesh import Mesh
from nutamill.charge.walls.mesh_faces import mesh_faces
from nutamill.charge.walls.mesh_grid import mesh_grid
from nutamill.charge.walls.mesh_model import MeshPlaces, MeshShape, MeshWalls
from nutamill.charge.walls.surface import Surface, SurfaceKind
from nutamill.charge.walls.triangles import directed_edges, normals_and_areas

SLACK = 1e-9
"""Slack of the regions of edges and corners within a patch, as a share of the edge's length [1].

Rounding must not let a centre straight above a corner fall between all regions.  Within a patch an overlap of
regions is harmless, for only the deepest contact counts; where patches meet there is none."""


def mesh_surfaces(
    mesh: Mesh,
    body: int,
    material: int,
    origin: Sequence[float] = (0.0, 0.0, 0.0),
    rotation: Sequence[Sequence[float]] | np.ndarray = ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
) -> list[Surface]:
    """Return the patches of a mesh as surfaces of a body, in the order of their numbers.

    Parameters
    ----------
    mesh : of `closed_mesh`
    body, material : index of the carrying body, and of the mesh's material
    origin, rotation : place [m] (3,) in the body's axes, from its mass centre, and rotation (3, 3) to them,
        of the mesh's axes
    """
    return [
        Surface(
            f"{mesh.name} patch {patch + 1}",
            SurfaceKind.MESH_PATCH,
            body,
            material,
            tuple(origin),
            rotation,
            mesh=mesh,
            patch=patch,
        )
        for patch in range(mesh.n_patches)
    ]


def mesh_walls(surfaces: Sequence[Surface], largest_radius: float) -> MeshWalls:
    """Return the meshes among the surfaces of a charge as arrays for its kernels.

    Parameters
    ----------
    surfaces : all surfaces of the charge
    largest_radius : of its particles [m]
    """
    meshes = list({id(s.mesh): s.mesh for s in surfaces if s.mesh is not None}.values())
    first_patch = np.cumsum([0, *(mesh.n_patches for mesh in meshes)])
    number = {id(mesh): k for k, mesh in enumerate(meshes)}
    patch_of = [first_patch[number[id(s.mesh)]] + s.patch if s.mesh is not None else -1 for s in surfaces]
    patch = np.concatenate([np.zeros(0, int), *(m.patch + first_patch[k] for k, m in enumerate(meshes))])
    places, place_of = _places(surfaces, number, first_patch)
    shape = _joined_shapes([_shape(mesh, int(first_patch[k])) for k, mesh in enumerate(meshes)])
    grid = mesh_grid(meshes, shape, first_patch, largest_radius)
    return MeshWalls(
        patch_of=np.array(patch_of, np.int64),
        place_of=place_of,
        mesh_of=np.repeat(np.arange(len(meshes)), np.diff(first_patch)).astype(np.int64),
        first_patch=first_patch.astype(np.int64),
        shape=shape,
        faces=mesh_faces(shape, grid, patch, meshes),
        grid=grid,
        places=places,
    )


def _places(surfaces, number, first_patch) -> tuple[MeshPlaces, np.ndarray]:
    """Return the places of the meshes, and that of each surface [1] (S,).

    Parameters
    ----------
    surfaces : all surfaces of the charge
    number : number of each mesh by its id
    first_patch : first patch of each mesh [1] (G + 1,)
    """
    places: dict[tuple, list[int]] = {}
    place_of = np.full(len(surfaces), -1)
    for s, surface in enumerate(surfaces):
        if surface.mesh is not None:
            place = np.concatenate([surface.origin, np.ravel(surface.rotation)]).tolist()
            key = (number[id(surface.mesh)], surface.body, *place)
            place_of[s] = list(places).index(key) if key in places else len(places)
            at = places.setdefault(key, [-1] * int(np.diff(first_patch)[key[0]]))
            at[surface.patch] = s
    first = np.cumsum([0, *(len(at) for at in places.values())])
    return (
        MeshPlaces(
            body=np.array([key[1] for key in places], np.int64),
            mesh=np.array([key[0] for key in places], np.int64),
            first=first.astype(np.int64),
            surface=np.array([s for at in places.values() for s in at], np.int64),
        ),
        place_of.astype(np.int64),
    )


EMPTY = MeshShape(
    np.zeros((0, 3)),
    np.zeros((0, 3)),
    np.zeros(0, np.int32),
    np.zeros(0),
    np.zeros(1, np.int32),
    np.zeros(0, np.int32),
    np.zeros((0, 2), np.int32),
    np.zeros((0, 3)),
    np.zeros(0),
    np.zeros((0, 2, 3)),
    np.zeros((0, 3)),
    np.zeros((0, 2), np.int32),
    np.zeros(0, np.int32),
    np.zeros(0),
    np.zeros((0, 3), np.int32),
    np.zeros((0, 3), np.int32),
    np.zeros((0, 3)),
    np.zeros(0),
)
"""No triangles."""


def _shape(mesh: Mesh, first_patch: int) -> MeshShape:
    """Return the features of one mesh."""
    vertices, faces, patch = mesh.vertices, mesh.faces, mesh.patch + first_patch
    corners = mesh.corners
    normals, _ = normals_and_areas(corners)
    edges, of_side, _ = directed_edges(faces)
    order = np.argsort(of_side.ravel(), kind="stable")
    triangles = (order // 3).reshape(-1, 2)
    side = np.empty(3 * len(faces), np.int32)
    side[order] = np.arange(len(order)) % 2
    begin, end = vertices[edges[:, 0]], vertices[edges[:, 1]]
    length = np.linalg.norm(end - begin, axis=1)
    direction = (end - begin) / length[:, None]
    # in the plane of the triangle, at right angles to the edge, towards the triangle's middle
    wing = np.cross(normals[triangles], direction[:, None, :])
    inward = ((corners[triangles].mean(axis=2) - begin[:, None, :]) * wing).sum(axis=2)
    wing *= np.sign(inward)[:, :, None]
    meeting = patch[triangles]
    ends = edges.ravel()
    by_vertex = np.argsort(ends, kind="stable")
    vertex_first = np.searchsorted(ends[by_vertex], np.arange(len(vertices) + 1))
    vertex_edges = by_vertex // 2
    lowest, highest = np.full(len(vertices), np.iinfo(np.int32).max), np.full(len(vertices), -1)
    shortest = np.full(len(vertices), np.inf)
    np.minimum.at(lowest, faces, patch[:, None])
    np.maximum.at(highest, faces, patch[:, None])
    np.minimum.at(shortest, ends, np.repeat(length, 2))
    return MeshShape(
        vertices=vertices,
        vertex_normal=_vertex_normals(corners, faces, normals, len(vertices)),
        vertex_owner=lowest.astype(np.int32),
        vertex_slack=np.where(lowest == highest, SLACK * shortest, 0.0),
        vertex_first=vertex_first.astype(np.int32),
        vertex_edges=vertex_edges.astype(np.int32),
        edge_ends=edges.astype(np.int32),
        edge_direction=direction,
        edge_length=length,
        edge_wing=wing,
        edge_normal=normals[triangles].sum(axis=1),
        edge_triangles=triangles.astype(np.int32),
        edge_owner=meeting.min(axis=1).astype(np.int32),
        edge_slack=np.where(meeting[:, 0] == meeting[:, 1], SLACK * length, 0.0),
        triangle_edges=of_side.astype(np.int32),
        triangle_side=side.reshape(-1, 3),
        triangle_normal=normals,
        triangle_height=(normals * corners[:, 0]).sum(axis=1),
    )


def _vertex_normals(corners, faces, normals, n_vertices) -> np.ndarray:
    """Sum the normals about each corner, weighted by the angle of the triangle there [rad] (V, 3).

    Source: J. A. Baerentzen and H. Aanaes, IEEE Trans. Vis. Comput. Graph. 11 (2005) 243-253: its sign
    separates front and back.
    """
    out = np.zeros((n_vertices, 3))
    for k in range(3):
        a, b = corners[:, (k + 1) % 3] - corners[:, k], corners[:, (k + 2) % 3] - corners[:, k]
        angle = np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(axis=1))
        np.add.at(out, faces[:, k], angle[:, None] * normals)
    return out


COUNTS = {
    "vertex_edges": "edge",
    "edge_ends": "vertex",
    "edge_triangles": "triangle",
    "triangle_edges": "edge",
}
"""Fields that hold numbers of vertices, edges or triangles."""


def _joined_shapes(shapes: list[MeshShape]) -> MeshShape:
    """Join several meshes to one set of arrays."""
    joined = EMPTY
    for shape in shapes:
        offset = {
            "vertex": len(joined.vertices),
            "edge": len(joined.edge_length),
            "triangle": len(joined.triangle_normal),
        }
        fields = []
        for name, more in shape._asdict().items():
            present = getattr(joined, name)
            if name == "vertex_first":
                fields.append(np.concatenate([present, present[-1] + more[1:]]).astype(np.int32))
            else:
                shifted = more + offset[COUNTS[name]] if name in COUNTS else more
                fields.append(np.concatenate([present, shifted]).astype(present.dtype))
        joined = MeshShape(*fields)
    return joined
