"""The parts of a nutating mill as on the drawing: frozen data, SI floats, no bodies or joints.

Depths are measured downwards from the nutation point; those of the chamber along its axis.
"""

import math
from typing import Annotated, Literal

from pydantic import Field

from nutamill.base.schema import (
    Acceleration,
    AddedMass,
    Angle,
    AnyAngle,
    BushingStiffness,
    Coefficient,
    Coordinate,
    Count,
    Density,
    Inertia,
    Length,
    Mass,
    RotationalDamping,
    Stiffness,
    Table,
    Torque,
)
from nutamill.case.connections import BushingRates

FRAME, CHAMBER, CROSS = "frame", "chamber", "bearing_cross"
CARRIAGE, DRIVESHAFT, SHAFT = "carriage", "driveshaft", "intermediate_shaft"
BODIES = (FRAME, CHAMBER, CROSS, CARRIAGE, DRIVESHAFT, SHAFT)
"""Bodies of a mill, in the order in which the engine and snapshots hold them."""
GROUND = "ground"
"""What stands still; no body of the mill."""


class DrawnMechanism(Table):
    """The crank that drives the chamber, what is weighed of the whole machine, and the friction of its
    joints.
    """

    mounting: Literal["flexible", "rigid"] = "flexible"
    """Frame on bushings, or fixed to the ground."""
    nutation_point_to_crank: Length
    """Distance along the driveshaft axis from the nutation point to the plane of the crank pin [m]."""
    crank_radius: Length
    """Distance of the crank pin from the driveshaft axis [m]."""
    total_mass: Mass
    """Whole machine on its mounts, without ribs, bars, balance mass and charge [kg]."""
    joint_friction: Coefficient = 0.0
    """Coulomb coefficient of the driveshaft bearing and of the crank pin [1]."""
    joint_friction_radius: Length = 0.024
    """Radius at which that friction acts [m]."""
    joint_friction_constant: Torque = 0.0
    """Part that does not depend on the load, each joint [N m]."""
    joint_friction_viscous: RotationalDamping = 0.0
    """Part proportional to the speed, each joint [N m s/rad]."""
    gravity: Acceleration = 9.81
    """Acceleration of gravity, downwards [m/s^2]."""

    @property
    def nutation_angle(self) -> float:
        """Half-angle of the nutation cone [rad] by the lengths of the crank, not as printed."""
        return math.atan2(self.crank_radius, self.nutation_point_to_crank)


class Rib(Table):
    """One straight bar on the bore of the chamber, parallel to its axis, from the floor up."""

    width: Length
    """Along the circumference [m]."""
    depth: Length
    """From the bore towards the axis [m]."""
    length: Length
    """Along the axis [m]; what stands above the ceiling is weighed but not touched."""
    density: Density
    """For its mass [kg/m^3]."""
    material: str
    """For its contacts."""

    @property
    def mass(self) -> float:
        """Mass of one rib [kg]."""
        return self.width * self.depth * self.length * self.density


class Bars(Table):
    """A ring of rigid mass fixed to the base of the chamber in place of a charge."""

    mass: AddedMass = 0.0
    """Mass of the ring [kg]."""
    radius: Length
    """Radius of the ring [m]."""
    depth: Length
    """Below the nutation point along the chamber axis [m]."""


class MeshFile(Table):
    """A closed triangle mesh in a file, STL or OBJ; its normals point out of the solid it bounds."""

    file: str
    """Name of the file; a relative one is looked for beside the case file."""
    unit: Literal["m", "cm", "mm", "um", "in"]
    """What one of its coordinates is; neither format says."""
    at: tuple[Coordinate, Coordinate, Coordinate] = (0.0, 0.0, 0.0)
    """Place of its origin in chamber axes, from the nutation point [m]."""
    sha256: Annotated[str, Field(pattern="^[0-9a-f]{64}$")] | None = None
    """Digest of the file's content; written when the case is read."""


class MeshedWall(MeshFile):
    """A solid inside the chamber and fixed to it, such as a lifter; the charge stays out of it."""

    material: str
    """For its contacts; its mass is part of that of the chamber."""


class Chamber(Table):
    """The grinding vessel: a cylinder with floor and ceiling, and what is fixed to it."""

    inner_diameter: Length
    """Bore [m]."""
    height: Length
    """Free height between floor and ceiling [m]."""
    floor_depth: Length
    """Floor below the nutation point along the chamber axis [m]."""
    nutation_angle: Angle
    """Half-angle of the cone as printed [rad]. The lengths of the crank are used; this is a check."""
    mass: Mass
    """Without ribs and bars [kg]."""
    mass_centre_depth: Length
    """Mass centre below the nutation point on the chamber axis [m]."""
    inertia_transverse: Inertia
    """About an axis through the nutation point at right angles to the chamber axis [kg m^2]."""
    inertia_axial: Inertia
    """About the chamber axis [kg m^2]."""
    material: str
    """Of bore, floor and ceiling, for their contacts."""
    ribs: Annotated[Count, Field(ge=0, le=1000)] = 0
    """Number of ribs, evenly spaced, the first at the chamber's x axis."""
    rib: Rib | None = None
    """The ribs, where there are any."""
    mesh: MeshFile | None = None
    """The space inside as a mesh, in place of bore, floor and ceiling; ribs are added to it."""
    bars: Bars | None = None
    """Rigid bars, where there are any."""

    @property
    def ceiling_depth(self) -> float:
        """Ceiling below the nutation point along the chamber axis [m]."""
        return self.floor_depth - self.height

    @property
    def ribs_mass(self) -> float:
        """Mass of all ribs [kg]."""
        return self.ribs * self.rib.mass if self.rib else 0.0

    @property
    def bars_mass(self) -> float:
        """Mass of the rigid bars [kg]."""
        return self.bars.mass if self.bars else 0.0

    @property
    def free_volume(self) -> float:
        """Volume inside, less the ribs [m^3]."""
        bore = 0.25 * math.pi * self.inner_diameter**2 * self.height
        ribs = (
            self.ribs * self.rib.width * self.rib.depth * min(self.rib.length, self.height)
            if self.rib
            else 0.0
        )
        return bore - ribs


class Carriage(Table):
    """The part that carries the crank pin and that only the load cell holds."""

    mass: Mass
    """Mass, at the crank pin [kg]."""
    inertia: Inertia
    """About each axis of its mass centre [kg m^2]."""


class Driveshaft(Table):
    """Driveshaft and torque arm without the carriage, balanced about the axis."""

    mass: Mass
    """Mass [kg]."""
    inertia_axial: Inertia
    """About the driveshaft axis [kg m^2]."""
    inertia_transverse: Inertia
    """About an axis through the mass centre at right angles to it [kg m^2]."""
    mass_centre_depth: Length
    """Mass centre below the nutation point [m]."""


class Counterweight(Table):
    """A point mass on the driveshaft."""

    mass: AddedMass = 0.0
    """Mass [kg]."""
    radius: Length
    """Distance from the driveshaft axis [m]."""
    depth: Length
    """Below the nutation point [m]."""
    azimuth: AnyAngle = math.pi
    """From the crank pin in the direction of rotation [rad]; half a turn is opposite the pin."""


class Balance(Counterweight):
    """The balance mass, and a second one in another plane."""

    second: Counterweight | None = None
    """The second one, where there is one."""

    @property
    def weights(self) -> list[Counterweight]:
        """Those that weigh something."""
        return [weight for weight in (self, self.second) if weight is not None and weight.mass > 0.0]


class BearingCross(Table):
    """The cross of the universal joint at the nutation point."""

    mass: Mass
    """Mass, at the nutation point [kg]."""
    inertia: Inertia
    """About each axis [kg m^2]."""


class Rod(Table):
    """One of six rods with spherical ends that hold the yoke of the universal joint."""

    at: tuple[Coordinate, Coordinate, Coordinate]
    """Where it takes hold of the yoke, in frame axes from the nutation point [m]."""
    along: Literal["x", "y", "z"]
    """Frame axis it is parallel to, from the yoke in its positive sense."""


class IntermediateShaft(Table):
    """The shaft between the motor and the shaft coupling, held by the ground."""

    mass: Mass
    """Mass [kg]."""
    inertia_axial: Inertia
    """About its axis [kg m^2]."""
    inertia_transverse: Inertia
    """About an axis at right angles to it [kg m^2]."""


class TopFrame(Table):
    """What stands on the mounts and does not move with the drive; its mass is the total less the other parts.

    Mass centre and radii of gyration are those of the *whole machine* as assembled, which is what a test can
    measure.
    """

    mass_centre_height: Length
    """Mass centre of the whole machine above the plane of the mounts [m]."""
    gyration_rocking: Length
    """Radius of gyration of the whole machine about x and y through its mass centre [m]."""
    gyration_yaw: Length
    """Radius of gyration of the whole machine about z through its mass centre [m]."""


class MountPlaces(Table):
    """Where the bushings under the frame stand."""

    set: str | None = None
    """Name of a published set of properties in the library of mounts; keys beside it override it."""
    count: Annotated[Count, Field(ge=3, le=100)] = 4
    """Number of mounts."""
    half_spacing: Length
    """Four mounts stand at (+-half_spacing, +-half_spacing) [m]."""
    depth: Length
    """Plane of the mounts below the nutation point [m]."""

    @property
    def points(self) -> tuple[tuple[float, float], ...]:
        """Places (x, y) of the mounts in world axes from the driveshaft axis [m], the first in the quadrant
        +x, +y.
        """
        radius, turn = math.sqrt(2.0) * self.half_spacing, 2.0 * math.pi / self.count
        angles = (0.25 * math.pi + k * turn for k in range(self.count))
        return tuple((radius * math.cos(angle), radius * math.sin(angle)) for angle in angles)


class Mounts(BushingRates, MountPlaces):  # a file begins with the keys of the last
    """The bushings under the frame, axis upright, evenly spaced on the circle through (half_spacing,
    half_spacing).
    """

    shear_stiffness: Stiffness
    """Across the axis, each mount [N/m]."""
    axial_stiffness: Stiffness
    """Along the axis [N/m]."""


class CouplingPlace(Table):
    """Where the shaft coupling is."""

    depth: Length
    """Below the nutation point [m]."""


class ShaftCoupling(BushingRates, CouplingPlace):  # a file begins with the keys of the last
    """The elastic coupling between intermediate shaft and driveshaft, axis upright."""

    shear_stiffness: BushingStiffness
    """Across the axis [N/m]."""
    axial_stiffness: BushingStiffness
    """Along the axis [N/m]."""
