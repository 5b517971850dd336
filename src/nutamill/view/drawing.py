"""The machine of a case as triangles, for pictures: one list of parts, each fixed to one body.

Lengths that a case states (chamber, ribs, bars, crank, mounts) are drawn as stated; what no case states
(thickness of shafts, columns and plates) is given proportions of the bore.  Nothing is computed from these
shapes.
"""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from nutamill.case import Case
from nutamill.case.drawing import CARRIAGE, CHAMBER, CROSS, DRIVESHAFT, FRAME, GROUND, SHAFT
from nutamill.case.rigid_parts import whole_chamber
from nutamill.result import WallMesh

STEEL, DARK, RUBBER, GLASS, BRASS, RED = "#8f98a3", "#5b6570", "#2e2e2e", "#a8c8dc", "#c9a227", "#b5482a"
INSET = 0.998
"""Radius of floor and ceiling within the wall, share of it [1]: two faces in one place would flicker."""
FACETS = 96
"""Facets of a full circle."""


class Part(NamedTuple):
    """One solid of the machine."""

    name: str
    """What it is."""
    body: str
    """The body it is fixed to; ``ground`` stands still."""
    vertices: np.ndarray
    """Corners [m] (n, 3), from the nutation point, in the body's axes (of the ground: world axes)."""
    triangles: np.ndarray
    """Corners of each triangle [1], int32 (m, 3), counter-clockwise seen from outside."""
    colour: str
    """``#rrggbb``."""
    opacity: float = 1.0
    """1 solid, less for what one looks through."""


class Solid(NamedTuple):
    """Triangles without a name."""

    vertices: np.ndarray
    """Corners [m] (n, 3)."""
    triangles: np.ndarray
    """Corners of each triangle [1], int32 (m, 3), counter-clockwise seen from outside."""

    def at(self, x: float, y: float, z: float) -> "Solid":
        """Return the solid moved by (x, y, z) [m]."""
        return Solid(self.vertices + np.array([x, y, z]), self.triangles)

    def lying(self, axis: str) -> "Solid":
        """Return the solid with its z axis along ``x`` or ``y``."""
        order = {"x": [2, 0, 1], "y": [1, 2, 0]}[axis]  # cyclic, so that outside stays outside
        return Solid(self.vertices[:, order], self.triangles)

    def turned(self, angle: float) -> "Solid":
        """Return the solid turned about z by `angle` [rad]."""
        c, s = math.cos(angle), math.sin(angle)
        return Solid(self.vertices @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]), self.triangles)


def ring(
    inner: float, outer: float, low: float, high: float, opening: float = 0.0, middle: float = 0.0
) -> Solid:
    """Return a tube about z between two radii and two heights [m], without an `opening` [rad] about the
    azimuth `middle` [rad].

    ``inner = 0`` makes a disc or a rod.
    """
    return revolved([(inner, low), (outer, low), (outer, high), (inner, high)], opening, middle)


def revolved(meridian: Sequence[tuple[float, float]], opening: float = 0.0, middle: float = 0.0) -> Solid:
    """Return the solid that a closed line of radii and heights [m] sweeps about z, without an `opening` [rad]
    about the azimuth `middle` [rad].

    The line runs counter-clockwise where radii point right and heights up.  A side on the axis is left out.
    """
    whole = opening <= 0.0
    count = max(3, round(FACETS * (1.0 - opening / math.tau)))
    first = middle + 0.5 * opening
    angle = first + (math.tau - max(opening, 0.0)) * np.arange(count + (not whole)) / count
    vertices = np.concatenate(
        [np.column_stack([r * np.cos(angle), r * np.sin(angle), np.full(len(angle), z)]) for r, z in meridian]
    )
    n, sides = len(angle), len(meridian)
    k = np.arange(count)
    after = (k + 1) % n
    faces = []
    for side in range(sides):
        if meridian[side][0] == meridian[(side + 1) % sides][0] == 0.0:
            continue
        a, b = side * n, (side + 1) % sides * n
        faces += [np.column_stack([a + k, a + after, b + after]), np.column_stack([a + k, b + after, b + k])]
    if not whole:
        start, end = np.arange(sides) * n, np.arange(sides) * n + n - 1
        fan = np.array([[0, side, side + 1] for side in range(1, sides - 1)])
        faces += [start[fan], end[fan[:, ::-1]]]
    return Solid(vertices, np.concatenate(faces).astype(np.int32))


def box(x: float, y: float, z: float) -> Solid:
    """Return a box of these edges [m] about the origin."""
    signs = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)], float)
    quads = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]).astype(np.int32)
    return Solid(0.5 * signs * np.array([x, y, z]), triangles)


def cut_open(mesh: WallMesh, opening: float, middle: float) -> Solid:
    """Return a mesh without the triangles with their middle in an `opening` [rad] about the azimuth `middle`
    [rad].
    """
    x, y, _ = mesh.vertices[mesh.triangles].mean(axis=1).T
    turn = np.abs((np.arctan2(y, x) - middle + math.pi) % math.tau - math.pi)
    return Solid(mesh.vertices, mesh.triangles[turn >= 0.5 * opening])


def joined(*solids: Solid) -> Solid:
    """Join several solids into one list of triangles."""
    firsts = np.cumsum([0] + [len(solid.vertices) for solid in solids[:-1]])
    return Solid(
        np.concatenate([solid.vertices for solid in solids]),
        np.concatenate([solid.triangles + first for solid, first in zip(solids, firsts, strict=True)]).astype(
            np.int32
        ),
    )


def machine_parts(
    case: Case,
    opening: float = 0.0,
    opening_at: float = -0.5 * math.pi,
    walls: Mapping[str, WallMesh] | None = None,
) -> tuple[Part, ...]:
    """Return the parts of a mill, ground first.

    Parameters
    ----------
    opening : the chamber's wall is cut open over this azimuth [rad]
    opening_at : middle of the cut, azimuth in the chamber [rad]; -pi/2 faces the camera that looks along +y
    walls : meshed walls, as a result keeps them: that of the chamber takes the place of the wall as drawn
    """
    meshes = dict(walls or {})
    shell = meshes.pop("chamber.mesh", None)
    from_point = whole_chamber(case.chamber).mass_centre  # a drawing counts from the nutation point
    solids = [
        Part(key, CHAMBER, mesh.vertices + from_point, mesh.triangles, STEEL) for key, mesh in meshes.items()
    ]
    if shell is not None:
        shell = shell._replace(vertices=shell.vertices + from_point)
    return (
        *_standing_parts(case),
        *_driven_parts(case),
        *solids,
        *_chamber_parts(case, opening, opening_at, shell),
    )


def _standing_parts(case: Case) -> list[Part]:
    """Return mounts and frame: a base plate on the mounts, a column over each, a top ring that carries the
    yoke, and the bearing's plate.
    """
    bore, plane = case.chamber.inner_diameter, -case.mounts.depth
    bearing = -(case.mechanism.nutation_point_to_crank + 0.9 * bore)
    reach = math.hypot(*case.mounts.points[0])
    thick, column = 0.09 * bore, 0.11 * bore
    under = [ring(0.0, 0.2 * bore, plane - 0.36 * bore, plane).at(x, y, 0.0) for x, y in case.mounts.points]
    columns = [ring(0.0, column, plane + thick, -0.5 * thick).at(x, y, 0.0) for x, y in case.mounts.points]
    yoke = [
        box(0.16 * bore, reach, 0.16 * bore).at(0.0, side * (0.5 * reach + 0.25 * bore), 0.0)
        for side in (-1.0, 1.0)
    ]
    plates = [
        ring(0.4 * bore, reach + column, plane, plane + thick),
        ring(reach - column, reach + column, -0.5 * thick, 0.5 * thick),
        ring(0.16 * bore, reach, bearing - 0.5 * thick, bearing + 0.5 * thick),
        ring(0.13 * bore, 0.26 * bore, bearing - 0.3 * bore, bearing + 0.3 * bore),
    ]
    return [
        Part("mounts", GROUND, *joined(*under), RUBBER),
        Part("frame", FRAME, *joined(*columns, *plates), STEEL),
        Part("yoke", FRAME, *joined(*yoke), STEEL),
    ]


def _driven_parts(case: Case) -> list[Part]:
    """Return shafts, coupling, torque arm, carriage with crank pin, bearing cross, balance mass."""
    bore, radius, depth = (
        case.chamber.inner_diameter,
        case.mechanism.crank_radius,
        case.mechanism.nutation_point_to_crank,
    )
    rod, coupling = 0.12 * bore, -case.shaft_coupling.depth
    arm = -(depth + 0.32 * bore)
    crank = [
        ring(0.0, rod, coupling, arm),
        ring(0.0, 0.34 * bore, coupling, coupling + 0.1 * bore),
        box(radius + 0.5 * bore, 0.36 * bore, 0.2 * bore).at(0.5 * radius, 0.0, arm),
    ]
    parts = [
        Part("driveshaft", DRIVESHAFT, *joined(*crank), DARK),
        Part(
            "intermediate shaft",
            SHAFT,
            *joined(ring(0.0, rod, coupling - 0.8 * bore, coupling - 0.1 * bore)),
            DARK,
        ),
        Part("shaft coupling", SHAFT, *ring(0.0, 0.34 * bore, coupling - 0.1 * bore, coupling), RUBBER),
        Part(
            "carriage",
            CARRIAGE,
            *ring(0.0, 0.17 * bore, arm + 0.1 * bore, -depth + 0.05 * bore).at(radius, 0.0, 0.0),
            BRASS,
        ),
        Part(
            "bearing cross",
            CROSS,
            *joined(
                ring(0.0, 0.06 * bore, -0.34 * bore, 0.34 * bore).lying("x"),
                ring(0.0, 0.06 * bore, -0.34 * bore, 0.34 * bore).lying("y"),
            ),
            BRASS,
        ),
    ]
    if case.balance.mass > 0.0:
        disc = ring(0.0, 0.2 * bore, -0.1 * bore, 0.1 * bore).at(
            -case.balance.radius, 0.0, -case.balance.depth
        )
        parts.append(Part("balance mass", DRIVESHAFT, *disc, RED))
    return parts


def _chamber_parts(case: Case, opening: float, opening_at: float, mesh: WallMesh | None) -> list[Part]:
    """Return the shell, or the mesh that stands for it, floor and ceiling with the stubs to pin and pivot,
    ribs and bars.
    """
    chamber, depth = case.chamber, case.mechanism.nutation_point_to_crank
    bore, wall = 0.5 * chamber.inner_diameter, 0.035 * chamber.inner_diameter
    floor, ceiling = -chamber.floor_depth, -chamber.ceiling_depth
    lid = INSET * bore if mesh is None else bore + wall
    below = [ring(0.0, lid, floor - wall, floor), ring(0.0, 0.2 * bore, -depth, floor - wall)]
    above = [
        ring(0.0, lid, ceiling, ceiling + wall),
        ring(0.0, 0.2 * bore, ceiling + wall, 0.0),
        ring(0.0, 0.16 * bore, -0.6 * bore, 0.6 * bore).lying("x"),
    ]
    parts = [Part("floor", CHAMBER, *joined(*below), DARK), Part("ceiling", CHAMBER, *joined(*above), DARK)]
    if chamber.ribs and chamber.rib:
        height = min(chamber.rib.length, chamber.height)
        bar = box(chamber.rib.depth, chamber.rib.width, height).at(
            bore - 0.5 * chamber.rib.depth, 0.0, floor + 0.5 * height
        )
        parts.append(
            Part(
                "ribs",
                CHAMBER,
                *joined(*(bar.turned(math.tau * k / chamber.ribs) for k in range(chamber.ribs))),
                STEEL,
            )
        )
    if chamber.bars is not None and chamber.bars_mass > 0.0:
        ring_of_bars = ring(
            chamber.bars.radius - wall,
            chamber.bars.radius,
            -chamber.bars.depth - wall,
            -chamber.bars.depth + wall,
        )
        parts.append(Part("rigid bars", CHAMBER, *ring_of_bars, RED))
    shell = (
        ring(bore, bore + wall, floor - wall, ceiling + wall, opening, opening_at)
        if mesh is None
        else cut_open(mesh, opening, opening_at)
    )
    parts.append(Part("chamber wall", CHAMBER, *shell, GLASS, 0.3))
    return parts
