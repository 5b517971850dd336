"""Closed meshes for tests: boxes, plates cut at will, and cylinders of n facets, normals out of the solid."""

import numpy as np

from nutamill.charge.walls.mesh import closed_mesh


def box_corners(half, centre=(0.0, 0.0, 0.0)):
    """Corners and triangles of a box."""
    vertices = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float) * half + centre
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return vertices, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


def box(half, keep="outside", radius=0.0025, centre=(0.0, 0.0, 0.0)):
    return closed_mesh("box", *box_corners(half, centre), keep, radius)


def cylinder_corners(radius, bottom, top, n):
    """An upright prism of `n` facets with its edges on the cylinder, ends as fans about their middles."""
    angle = 2 * np.pi * np.arange(n) / n
    ring = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    vertices = np.concatenate(
        [
            np.column_stack([ring, np.full(n, bottom)]),
            np.column_stack([ring, np.full(n, top)]),
            [[0, 0, bottom], [0, 0, top]],
        ]
    )
    faces = []
    for i in range(n):
        j = (i + 1) % n
        faces += [(i, j, n + j), (i, n + j, n + i), (2 * n, j, i), (2 * n + 1, n + i, n + j)]
    return vertices, np.array(faces)


def cylinder(radius, bottom, top, n, keep="inside", particle_radius=0.0025):
    return closed_mesh(f"cylinder of {n}", *cylinder_corners(radius, bottom, top, n), keep, particle_radius)


def plate(half, depth, cuts, radius=0.0025, seed=4):
    """A plate with its top in z = 0, of 2 half by 2 half, the top cut into ``2 cuts^2`` triangles at random
    places.
    """
    rng = np.random.default_rng(seed)
    line = np.linspace(-half, half, cuts + 1)
    x, y = np.meshgrid(line, line, indexing="ij")
    inner = np.zeros_like(x, bool)
    inner[1:-1, 1:-1] = True
    shift = 0.6 * half / cuts
    x, y = x + inner * rng.uniform(-shift, shift, x.shape), y + inner * rng.uniform(-shift, shift, y.shape)
    top = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    number = np.arange(x.size).reshape(x.shape)
    faces = []
    for i in range(cuts):
        for j in range(cuts):
            a, b, c, d = number[i, j], number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]
            faces += [(a, b, c), (a, c, d)]
    # round about, against the way of the triangles, and down to one corner below the middle
    rim = [*number[:-1, 0], *number[-1, :-1], *number[:0:-1, -1], *number[0, :0:-1]]
    faces += [(b, a, x.size) for a, b in zip(rim, [*rim[1:], rim[0]], strict=True)]
    return closed_mesh(
        "plate", np.concatenate([top, [[0.0, 0.0, -depth]]]), np.array(faces), "outside", radius
    )
