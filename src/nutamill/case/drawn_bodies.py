"""The rigid bodies of a drawn nutating mill: mass, mass centre and inertia of frame, chamber and shafts."""

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from nutamill.base.errors import CaseError, Fault
from nutamill.case.drawing import CARRIAGE, CHAMBER, CROSS, DRIVESHAFT, SHAFT
from nutamill.case.rigid_parts import RigidPart, chamber_shell, compose, remove, rotated, whole_chamber

if TYPE_CHECKING:
    from nutamill.case.mill import Case

Triple = tuple[float, float, float]


def triple(vector: Iterable[float]) -> Triple:
    """Return the three components of a vector as plain numbers."""
    x, y, z = map(float, vector)
    return x, y, z


def chamber_rotation(case: "Case") -> np.ndarray:
    """Return ``R_WC`` (3, 3) as assembled, at crank angle 0, with the lower end of the chamber towards +x."""
    angle = -case.mechanism.nutation_angle
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def bare_driveshaft(case: "Case") -> RigidPart:
    """Return driveshaft and torque arm without carriage and balance, world axes from the nutation point."""
    shaft = case.driveshaft
    inertia = np.diag([shaft.inertia_transverse, shaft.inertia_transverse, shaft.inertia_axial])
    return RigidPart(shaft.mass, np.array([0.0, 0.0, -shaft.mass_centre_depth]), inertia)


def moving_parts(case: "Case") -> dict[str, RigidPart]:
    """Return every part but the frame, in world axes from the nutation point, at crank angle 0."""
    mechanism, rotation = case.mechanism, chamber_rotation(case)
    crank_pin = np.array([mechanism.crank_radius, 0.0, -mechanism.nutation_point_to_crank])
    driveshaft = bare_driveshaft(case)
    for weight in case.balance.weights:
        across = [weight.radius * math.cos(weight.azimuth), weight.radius * math.sin(weight.azimuth)]
        driveshaft = compose(
            driveshaft, RigidPart(weight.mass, np.array([*across, -weight.depth]), np.zeros((3, 3)))
        )
    shaft = case.intermediate_shaft
    return {
        CHAMBER: rotated(whole_chamber(case.chamber), rotation),
        CROSS: RigidPart(case.bearing_cross.mass, np.zeros(3), case.bearing_cross.inertia * np.eye(3)),
        CARRIAGE: RigidPart(case.carriage.mass, crank_pin, case.carriage.inertia * np.eye(3)),
        DRIVESHAFT: driveshaft,
        SHAFT: RigidPart(
            shaft.mass,
            np.array([0.0, 0.0, -case.shaft_coupling.depth]),
            np.diag([shaft.inertia_transverse, shaft.inertia_transverse, shaft.inertia_axial]),
        ),
    }


def frame_part(case: "Case") -> RigidPart:
    """Return the frame: the unribbed, empty machine on its mounts without its moving parts.

    The file gives mass, height of the mass centre and radii of gyration of the whole machine on the mounts.
    The moving parts are subtracted as averages over a revolution, so that the frame is symmetric about the
    driveshaft axis.

    Raises
    ------
    CaseError : no possible inertia left for the frame; `nutamill.case.mill_checks` refuses one without mass
    """
    parts = {
        **moving_parts(case),
        CHAMBER: rotated(chamber_shell(case.chamber), chamber_rotation(case)),
        DRIVESHAFT: bare_driveshaft(case),
    }
    del parts[SHAFT]  # supported by the ground, not by the mounts
    frame, mass = case.frame, case.mechanism.total_mass
    mass_centre = np.array([0.0, 0.0, -case.mounts.depth + frame.mass_centre_height])
    inertia = mass * np.diag([frame.gyration_rocking**2] * 2 + [frame.gyration_yaw**2])
    whole = RigidPart(mass, mass_centre, inertia)
    about_axis = remove(whole, *(_averaged_over_a_revolution(part) for part in parts.values()))
    lowest = np.linalg.eigvalsh(about_axis.inertia)
    if lowest[0] <= 0 or lowest[2] > lowest[0] + lowest[1]:
        what = (
            "the radii of gyration of the whole machine leave the frame moments of inertia of "
            f"{lowest.round(3).tolist()} kg m^2, which no body has"
        )
        raise CaseError(Fault("frame", what, "Give larger frame.gyration_rocking or frame.gyration_yaw"))
    return about_axis


def _averaged_over_a_revolution(part: RigidPart) -> RigidPart:
    """Return the average of a part over a revolution about the z axis: mass centre on the axis, same axial
    and mean transverse inertia about it.
    """
    x, y, z = part.mass_centre
    inertia = part.inertia + part.mass * np.diag([(x * x + y * y) / 2, (x * x + y * y) / 2, x * x + y * y])
    transverse = (inertia[0, 0] + inertia[1, 1]) / 2
    return RigidPart(part.mass, np.array([0.0, 0.0, z]), np.diag([transverse, transverse, inertia[2, 2]]))
