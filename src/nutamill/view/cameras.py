"""The cameras of pictures, films and pages: one table of where each stands and looks.

A camera is described in axes of the world, or of the chamber where it rides on the chamber.  Both have their
origin at the nutation point as assembled and z upwards along the axis of the machine at rest.
"""

import math
from typing import Literal, NamedTuple, get_args

import numpy as np

from nutamill.analysis.replay import Frame
from nutamill.case import Case
from nutamill.case.drawing import CHAMBER

View = Literal["front", "inside", "axis"]
"""From the front; riding on the chamber under its ceiling as in the NuMill papers; down the shaft."""
VIEWS: tuple[View, ...] = get_args(View)
"""Names of the cameras."""
IN_THE_WAY = ("frame", "yoke", "bearing cross", "ceiling", "mounts")
"""Parts between a camera above the machine and the charge, and mounts that would float without the frame."""
OUTSIDE = (*IN_THE_WAY, "driveshaft", "intermediate shaft", "shaft coupling", "carriage", "balance mass")
"""Parts that nobody within the chamber sees."""
SIDE = -math.radians(76.0)
"""Azimuth of the camera in front of a mill [rad]: beside the yoke, which would hide the joint behind it."""


class Camera(NamedTuple):
    """Where a picture is taken from."""

    eye: np.ndarray
    """Position of the camera [m], (3,)."""
    target: np.ndarray
    """Point in the middle of the picture [m], (3,)."""
    up: np.ndarray
    """Direction that points up in the picture, (3,)."""
    angle: float
    """Angle of view from top to bottom [rad]."""
    hides: tuple[str, ...]
    """Parts that stand in the way and are not drawn."""
    rides: bool
    """Whether the three vectors are in chamber axes, and the camera moves with the chamber."""

    @property
    def distance(self) -> float:
        """Distance from the eye to the target [m]."""
        return float(np.linalg.norm(self.eye - self.target))

    @property
    def azimuth(self) -> float:
        """Azimuth of the eye about the target [rad]. That of the lower edge of the picture where it is above
        the target.
        """
        away = self.eye - self.target
        if np.hypot(away[0], away[1]) < 1e-9 * self.distance:
            away = -self.up
        return math.atan2(away[1], away[0])

    @property
    def elevation(self) -> float:
        """Angle of the eye over the horizontal plane through the target [rad]."""
        return math.asin((self.eye - self.target)[2] / self.distance)

    def in_world(self, frame: Frame) -> "Camera":
        """Return this camera in world axes at the moment of a frame."""
        if not self.rides:
            return self
        pose = frame.bodies[CHAMBER]
        return self._replace(
            eye=pose.origin + pose.rotation @ self.eye,
            target=pose.origin + pose.rotation @ self.target,
            up=pose.rotation @ self.up,
            rides=False,
        )


def camera_of(view: View, case: Case) -> Camera:
    """Return the camera of a view of a mill."""
    chamber = case.chamber
    floor = np.array([0.0, 0.0, -chamber.floor_depth])
    across = np.array([0.0, 1.0, 0.0])
    if view == "front":  # from the joint at the top to the crank below the chamber
        lowest = case.mechanism.nutation_point_to_crank + 0.5 * chamber.inner_diameter
        target = np.array([0.0, 0.0, -0.5 * lowest])
        away = np.array([math.cos(SIDE), math.sin(SIDE), 0.3])
        eye = target + 2.3 * lowest * away / np.linalg.norm(away)
        return Camera(eye, target, np.array([0.0, 0.0, 1.0]), math.radians(28.0), (), rides=False)
    if view == "axis":
        eye = floor + np.array([0.0, 0.0, 4.5 * chamber.inner_diameter])
        return Camera(eye, floor, across, math.radians(30.0), IN_THE_WAY, rides=False)
    under_ceiling = -chamber.ceiling_depth - 0.02 * chamber.height
    eye = np.array([0.0, -0.2 * chamber.inner_diameter, under_ceiling])
    return Camera(eye, floor, across, math.radians(50.0), OUTSIDE, rides=True)
