"""Walls that the bodies of a machine carry, and the regions that its charge is put into.

Points and directions are in world axes, as assembled.
"""

import math
from typing import Annotated, Literal

from pydantic import Field

from nutamill.base.schema import Angle, Coordinate, Length, Table, Volume
from nutamill.case.names import Direction, Name, Point

Shape = Literal["plane", "disc", "cylinder", "tube", "cone", "cap", "box", "rod", "ball", "mesh"]

WALL_KEYS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "plane": ((), ()),
    "disc": (("radius",), ()),
    "cylinder": (("radius",), ("height",)),
    "tube": (("radius", "height"), ()),
    "cone": (("radius", "end_radius", "height"), ()),
    "cap": (("radius", "angle"), ()),
    "box": (("size",), ("across",)),
    "rod": (("radius", "height"), ()),
    "ball": (("radius",), ()),
    "mesh": (("file", "unit"), ("across", "sha256", "extent")),
}
"""Keys that each shape of wall needs, and those that it may have, beside point and axis."""

SIDES: dict[str, tuple[str, ...]] = {
    "plane": ("outside",),
    "disc": ("outside",),
    "cylinder": ("inside",),
    "tube": ("inside",),
    "cone": ("inside",),
    "cap": ("inside",),
    "box": ("outside", "inside"),
    "rod": ("outside",),
    "ball": ("outside",),
    "mesh": ("outside", "inside"),
}
"""Sides of each shape on which the charge can be; the first is the one where none is given."""

REGION_KEYS = {"cylinder": ("radius", "height"), "box": ("size",), "mesh": ("wall",)}
"""Keys that each shape of region needs; none of another shape may be given."""


class WallEntry(Table):
    """A wall that a body carries."""

    name: Name
    """Unique name."""
    body: str = "ground"
    """The body that carries it."""
    material: str
    """For its contacts; its mass is part of that of the body."""
    shape: Shape
    """Endless plane, or a disc of it; inside of an endless cylinder, or of a tube, which ends; inside of a
    cone, inside of a spherical cap; box; outside of a solid rod or ball; or closed mesh.
    """
    side: Literal["inside", "outside"] | None = None
    """Where the charge is: inside or outside of a box or a mesh; outside if not given."""
    point: Point = (0.0, 0.0, 0.0)
    """World [m]: a point of the plane, centre of the disc, of the ball or of the box, a point of the
    cylinder's axis at its lower end, centre of the lower end of tube, cone and rod, of the cap's sphere, or
    the origin of the mesh file.
    """
    axis: Direction = (0.0, 0.0, 1.0)
    """Normal of plane and disc towards the charge; axis of cylinder, tube, cone and rod, from the lower end;
    axis to which a cap opens; z axis of a box or of a mesh file; any length.
    """
    across: Direction | None = None
    """Direction of the x axis of a box or of a mesh file; any direction across the axis if not given."""
    radius: Length | None = None
    """Radius of disc, cylinder, tube, rod, ball, cone at its lower end, or the cap's sphere [m]."""
    end_radius: Annotated[Coordinate, Field(ge=0.0)] | None = None
    """Radius of the cone at its upper end [m]."""
    height: Length | None = None
    """Height of cone, tube or rod; of a cylinder, which is endless, for pictures and wear [m]."""
    angle: Angle | None = None
    """How far the cap reaches from its bottom [rad]."""
    size: tuple[Length, Length, Length] | None = None
    """Lengths of a box along x, y, z [m]."""
    file: str | None = None
    """Name of a mesh file; a relative one is looked for beside the case file."""
    unit: Literal["m", "cm", "mm", "um", "in"] | None = None
    """Unit of the coordinates of a mesh file."""
    extent: Length | None = None
    """Size that the mesh has about [m], where it is known: another unit is then refused."""
    sha256: Annotated[str, Field(pattern="^[0-9a-f]{64}$")] | None = None
    """Digest of the mesh file's content; written when the case is read."""

    @property
    def charge_side(self) -> str:
        """Where the charge is, given or not."""
        return self.side or SIDES[self.shape][0]


class RegionEntry(Table):
    """A region that charge is put into at the start, fixed to a body."""

    name: Name
    """Unique name."""
    body: str = "ground"
    """The body in whose axes the bed is at rest."""
    shape: Literal["cylinder", "box", "mesh"] = "cylinder"
    """Upright cylinder, box, or the inside of a meshed wall."""
    point: Point = (0.0, 0.0, 0.0)
    """Centre of the cylinder's lower end, or centre of the box, world [m]."""
    axis: Direction = (0.0, 0.0, 1.0)
    """Axis of the cylinder, or z axis of the box; any length."""
    across: Direction | None = None
    """Direction of the x axis of a box; any direction across the axis if not given."""
    radius: Length | None = None
    """Radius of a cylinder [m]."""
    height: Length | None = None
    """Height of a cylinder [m]."""
    size: tuple[Length, Length, Length] | None = None
    """Lengths of a box along x, y, z [m]."""
    wall: str | None = None
    """The meshed wall whose inside it is."""
    free_volume: Volume | None = None
    """Volume of the region that no wall takes [m^3]; counted by sampling if not given."""

    @property
    def volume(self) -> float | None:
        """Return the free volume [m^3], as given, or that of the shape.

        None stands for the inside of a mesh.
        """
        if self.free_volume is not None:
            return self.free_volume
        return self.shape_volume

    @property
    def shape_volume(self) -> float | None:
        """Return the volume of the shape [m^3], or None for the inside of a mesh or with keys missing."""
        if self.shape == "cylinder" and self.radius and self.height:
            return math.pi * self.radius**2 * self.height
        return math.prod(self.size) if self.shape == "box" and self.size else None

    @property
    def width(self) -> float | None:
        """Return the smallest width of the shape [m], or None for the inside of a mesh or where keys are
        missing.
        """
        if self.shape == "cylinder" and self.radius and self.height:
            return min(2.0 * self.radius, self.height)
        return min(self.size) if self.shape == "box" and self.size else None


def wall_findings(number: int, part: WallEntry) -> list[tuple[tuple[str | int, ...], str, str]]:
    """Return what is wrong with the keys of a wall for its shape: key, what, hint."""
    needed, allowed = WALL_KEYS[part.shape]
    findings = _key_findings(
        ("walls", number),
        part,
        needed,
        allowed,
        {key for keys in WALL_KEYS.values() for own in keys for key in own},
    )
    if part.charge_side not in SIDES[part.shape]:
        what = f'a {part.shape} has the charge {SIDES[part.shape][0]}, got side = "{part.side}"'
        findings.append((("walls", number, "side"), what, "Leave it out, or use a box or a mesh"))
    return findings + _direction_findings(("walls", number), part)


def region_findings(number: int, part: RegionEntry) -> list[tuple[tuple[str | int, ...], str, str]]:
    """Return what is wrong with the keys of a region for its shape: key, what, hint."""
    all_keys = {key for keys in REGION_KEYS.values() for key in keys}
    findings = _key_findings(("regions", number), part, REGION_KEYS[part.shape], (), all_keys)
    return findings + _direction_findings(("regions", number), part)


def _key_findings(where, part, needed, allowed, all_keys) -> list[tuple[tuple[str | int, ...], str, str]]:
    """Return the keys that a shape lacks, and those that it has no use for."""
    findings = []
    for key in sorted(all_keys):
        given = getattr(part, key) is not None
        if key in needed and not given:
            findings.append(((*where, key), f'is missing, with shape = "{part.shape}"', ""))
        elif given and key not in (*needed, *allowed):
            hint = f"Its keys: {', '.join((*needed, *allowed)) or 'point and axis'}"
            findings.append(((*where, key), f'has no meaning with shape = "{part.shape}"', hint))
    return findings


def _direction_findings(where, part) -> list[tuple[tuple[str | int, ...], str, str]]:
    """Return directions without a length, or parallel to each other."""
    findings = []
    if not any(part.axis):
        findings.append(((*where, "axis"), "must have a length, got zero", ""))
    elif part.across is not None:
        a, b = part.axis, part.across
        normal = (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
        if sum(n * n for n in normal) <= 1e-12 * sum(x * x for x in a) * sum(x * x for x in b):
            findings.append(((*where, "across"), "must not be parallel to axis", ""))
    return findings
