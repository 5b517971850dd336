"""The walls of a drawn chamber: bore, floor and ceiling or its mesh, ribs, meshed walls; and its inside."""

import math
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Literal

import numpy as np

from nutamill.base.required import required
from nutamill.case.drawing import CHAMBER, MeshFile
from nutamill.case.drawn_bodies import Triple, chamber_rotation, triple
from nutamill.case.walls import RegionEntry, WallEntry

if TYPE_CHECKING:
    from nutamill.case.mill import Case


def drawn_walls(case: "Case") -> tuple[WallEntry, ...]:
    """Return bore, floor and ceiling, or the chamber's mesh, then ribs and meshed walls."""
    chamber, rotation = case.chamber, chamber_rotation(case)
    axis, across = triple(rotation[:, 2]), triple(rotation[:, 0])

    def placed(x: float, y: float, z: float) -> Triple:
        return triple(rotation @ np.array([x, y, z]))

    floor, ceiling = placed(0.0, 0.0, -chamber.floor_depth), placed(0.0, 0.0, -chamber.ceiling_depth)
    drawn = partial(WallEntry, body=CHAMBER, material=chamber.material)
    walls = []
    if chamber.mesh is None:
        radius = chamber.inner_diameter / 2
        walls += [
            drawn(
                name="bore", shape="cylinder", point=floor, axis=axis, radius=radius, height=chamber.height
            ),
            drawn(name="floor", shape="plane", point=floor, axis=axis),
            drawn(name="ceiling", shape="plane", point=ceiling, axis=triple(-rotation[:, 2])),
        ]
    walls += [_rib(case, number, placed, axis) for number in range(chamber.ribs)]
    meshes: list[tuple[str, MeshFile, str, Literal["inside", "outside"]]] = []
    if chamber.mesh is not None:
        meshes.append(("chamber_mesh", chamber.mesh, chamber.material, "inside"))
    meshes += [(f"wall_{n}", wall, wall.material, "outside") for n, wall in enumerate(case.walls, start=1)]
    for name, mesh, material, side in meshes:
        walls.append(
            WallEntry(
                name=name,
                body=CHAMBER,
                material=material,
                shape="mesh",
                side=side,
                point=placed(*mesh.at),
                axis=axis,
                across=across,
                file=mesh.file,
                unit=mesh.unit,
                sha256=mesh.sha256,
                extent=math.hypot(chamber.inner_diameter, chamber.inner_diameter, chamber.height),
            )
        )
    return tuple(walls)


def _rib(
    case: "Case", number: int, placed: Callable[[float, float, float], Triple], axis: Triple
) -> WallEntry:
    """Return rib `number` as a box, which reaches as far into wall and floor as into the charge, so that
    there is no gap.
    """
    chamber, rib = case.chamber, required(case.chamber.rib)
    angle = 2 * math.pi * number / chamber.ribs
    c, s = math.cos(angle), math.sin(angle)
    height, radius = min(rib.length, chamber.height), chamber.inner_diameter / 2
    middle = placed(radius * c, radius * s, (height - rib.depth) / 2 - chamber.floor_depth)
    return WallEntry(
        name=f"rib_{number + 1}",
        body=CHAMBER,
        material=rib.material,
        shape="box",
        point=middle,
        axis=axis,
        across=placed(c, s, 0.0),
        size=(2.0 * rib.depth, rib.width, height + rib.depth),
    )


def drawn_region(case: "Case") -> RegionEntry:
    """Return the inside of the chamber."""
    chamber, rotation = case.chamber, chamber_rotation(case)
    axis = triple(rotation[:, 2])
    if chamber.mesh is not None:
        return RegionEntry(name=CHAMBER, body=CHAMBER, shape="mesh", wall="chamber_mesh", axis=axis)
    return RegionEntry(
        name=CHAMBER,
        body=CHAMBER,
        shape="cylinder",
        point=triple(rotation @ np.array([0.0, 0.0, -chamber.floor_depth])),
        axis=axis,
        radius=chamber.inner_diameter / 2,
        height=chamber.height,
        free_volume=None if case.walls else chamber.free_volume,
    )
