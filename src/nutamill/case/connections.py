"""Numbers of connections, declared once for machines part by part and for the drawing of a mill: rates of a
bushing, friction of a joint.
"""

from nutamill.base.schema import (
    BushingStiffness,
    Coefficient,
    Coordinate,
    Damping,
    PassiveForce,
    RotationalDamping,
    RotationalStiffness,
    Table,
    Torque,
)


class BushingRates(Table):
    """Stiffness and damping of a bushing about its axis."""

    shear_stiffness: BushingStiffness = 0.0
    """Across the axis [N/m]."""
    axial_stiffness: BushingStiffness = 0.0
    """Along the axis [N/m]."""
    bending_stiffness: RotationalStiffness = 0.0
    """About a direction across the axis [N m/rad]."""
    torsion_stiffness: RotationalStiffness = 0.0
    """About the axis [N m/rad]."""
    shear_damping: Damping = 0.0
    """Across the axis [N s/m]."""
    axial_damping: Damping = 0.0
    """Along the axis [N s/m]."""
    bending_damping: RotationalDamping = 0.0
    """About a direction across the axis [N m s/rad]."""
    torsion_damping: RotationalDamping = 0.0
    """About the axis [N m s/rad]."""

    @property
    def stiffness(self) -> tuple[float, float, float, float]:
        """Shear, axial [N/m], bending and torsion [N m/rad]."""
        return self.shear_stiffness, self.axial_stiffness, self.bending_stiffness, self.torsion_stiffness

    @property
    def damping(self) -> tuple[float, float, float, float]:
        """Shear, axial [N s/m], bending and torsion [N m s/rad]."""
        return self.shear_damping, self.axial_damping, self.bending_damping, self.torsion_damping


class FrictionEntry(Table):
    """Friction of a joint: a moment, or in a prismatic joint a force along its axis."""

    coefficient: Coefficient = 0.0
    """Coulomb coefficient [1]."""
    radius: Coordinate = 0.0
    """Radius at which it acts [m], in joints that turn."""
    constant: Torque = 0.0
    """Part that does not depend on the load [N m], in joints that turn."""
    viscous: RotationalDamping = 0.0
    """Part proportional to the speed [N m s/rad], in joints that turn."""
    constant_force: PassiveForce = 0.0
    """Part that does not depend on the load [N], in prismatic joints."""
    viscous_force: Damping = 0.0
    """Part proportional to the speed [N s/m], in prismatic joints."""

    @property
    def numbers(self) -> tuple[float, float, float, float, float, float]:
        """All numbers [SI], in the order of the keys."""
        moment = self.coefficient, self.radius, self.constant, self.viscous
        return *moment, self.constant_force, self.viscous_force
