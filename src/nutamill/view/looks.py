"""How a picture in three dimensions looks: camera, colours and their range, cut, background."""

import math
import re
from typing import Literal, NamedTuple, get_args

import numpy as np
from matplotlib.colors import is_color_like, to_rgb

from nutamill.base import units
from nutamill.base.errors import CaseError, Fault
from nutamill.base.schema import spelled
from nutamill.base.units import Kind
from nutamill.view.cameras import VIEWS, Camera, View

Colour = Literal["speed", "height", "force", "material", "size"]
KINDS = {"speed": Kind.VELOCITY, "height": Kind.LENGTH, "force": Kind.FORCE, "size": Kind.LENGTH}
"""What each colour bar measures."""
AXES = "xyz"
"""Normals of planes that cut a picture."""
CLEAR = "transparent"
"""Background of a picture that is put over something else."""
STRAIGHT_UP = math.radians(89.0)
"""Elevation beyond which a camera keeps its own upward direction [rad]."""


class Cut(NamedTuple):
    """A plane that takes away what is between it and the camera."""

    axis: int
    """Axis of the world that it is normal to: 0, 1 or 2."""
    at: float
    """Where it crosses that axis [m]."""


class Look(NamedTuple):
    """What a picture shows from where."""

    view: View = "front"
    """Camera: ``front``; ``inside``, riding on the chamber under its ceiling as the camera of the NuMill
    papers; ``axis``, down the shaft."""
    colour: Colour = "speed"
    """Quantity by which the particles are coloured."""
    limits: tuple[float, float] | None = None
    """Ends of the colour bar, SI; zero and the 99.9 % quantile of what is shown if None."""
    cut: Cut | None = None
    """Plane that takes away what is in front of it."""
    background: str = "white"
    """Name of a colour, ``#rrggbb``, or ``transparent``."""
    azimuth: float | None = None
    """Azimuth of the camera about its target, from the x axis [rad]; that of the view if None."""
    elevation: float | None = None
    """Angle of the camera above the horizontal plane through its target [rad]; that of the view if None."""

    @property
    def ink(self) -> str:
        """Colour of words that are read on the background."""
        if self.background == CLEAR:
            return "black"
        red, green, blue = to_rgb(self.background)
        return "black" if 0.3 * red + 0.6 * green + 0.1 * blue > 0.5 else "white"

    def aimed(self, camera: Camera) -> Camera:
        """Return a camera turned about its target to the angles that are asked for."""
        if self.azimuth is None and self.elevation is None:
            return camera
        azimuth = camera.azimuth if self.azimuth is None else self.azimuth
        elevation = camera.elevation if self.elevation is None else self.elevation
        level = math.cos(elevation)
        away = np.array([level * math.cos(azimuth), level * math.sin(azimuth), math.sin(elevation)])
        up = np.array([0.0, 0.0, 1.0])
        if abs(elevation) > STRAIGHT_UP:
            up = -math.copysign(1.0, elevation) * np.array([math.cos(azimuth), math.sin(azimuth), 0.0])
        return camera._replace(eye=camera.target + camera.distance * away, up=up)


def check_look(look: Look, film: bool = False) -> None:
    """Raise CaseError with all faults of a look."""
    faults = []
    for where, given, names in (
        ("--camera", look.view, VIEWS),
        ("--colour", look.colour, get_args(Colour)),
    ):
        if given not in names:
            what = f'must be one of {", ".join(names)}, got "{given}"'
            faults.append(Fault(where, what, f"Write e.g. {where} {names[0]}"))
    if look.background != CLEAR and not is_color_like(look.background):
        what = f"must be a colour, as white or #202830, or {CLEAR}, got {spelled(look.background)}"
        faults.append(Fault("--background", what))
    if film and look.background == CLEAR:
        faults.append(Fault("--background", "cannot be transparent in a film", "Choose a colour"))
    if look.limits is not None and look.colour == "material":
        faults.append(Fault("--range", "has no use for materials", "Leave it out"))
    if faults:
        raise CaseError(*faults)


def cut_of(text: str) -> Cut:
    """Return the plane of ``y`` or ``y=20 mm``.

    Raises
    ------
    CaseError : no axis, or no length
    """
    axis, _, place = text.partition("=")
    if axis.strip() not in tuple(AXES):
        what = f"must be an axis, and where the plane crosses it, got {spelled(text)}"
        raise CaseError(Fault("--cut", what, 'Write e.g. --cut y or --cut "y=20 mm"'))
    return Cut(AXES.index(axis.strip()), _parsed("--cut", place, Kind.LENGTH) if place else 0.0)


def range_of(text: str, colour: str) -> tuple[float, float]:
    """Return the ends of a colour bar, SI, of ``0..3 m/s``.

    Raises
    ------
    CaseError : no two numbers with a unit of the colour, or not in rising order
    """
    kind = KINDS.get(colour, Kind.VELOCITY)
    match = re.fullmatch(r"\s*(\S+?)\s*\.\.\s*(\S+)\s+(.+?)\s*", text)
    example = units.example(kind).split(" ", 1)[1]
    hint = f'Write e.g. --range "0..3 {example}"'
    if match is None:
        raise CaseError(Fault("--range", f"must be two ends and a unit, got {spelled(text)}", hint))
    low, high = (_parsed("--range", f"{match[part]} {match[3]}", kind) for part in (1, 2))
    if not low < high:
        raise CaseError(Fault("--range", f"must rise, got {spelled(text)}", hint))
    return low, high


def _parsed(where: str, text: str, kind: Kind) -> float:
    try:
        return units.parse(text, kind)
    except units.UnitError as error:
        raise CaseError(Fault(where, error.what, error.hint)) from None
