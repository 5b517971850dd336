"""Materials and how pairs of them touch: frozen data, SI floats.

The table of a pair is called by the two materials, ``steel-acrylic``; the order does not matter.
"""

from typing import Annotated, Literal

from pydantic import Field

from nutamill.base.schema import (
    AddedPressure,
    BridgeVolume,
    Coefficient,
    ContactAngle,
    Density,
    Length,
    Number,
    Positive,
    Pressure,
    RollingStiffness,
    Share,
    Stiffness,
    SurfaceTension,
    Table,
    Viscosity,
)
from nutamill.case.contact_laws import Cohesion, Film, Normal, Rolling, Tangential

PoissonRatio = Annotated[Number, Field(gt=-1.0, lt=0.5)]


class Material(Table):
    """An elastic solid."""

    density: Density
    """Density [kg/m^3]."""
    young_modulus: Pressure
    """Young's modulus of the real solid [Pa], before `softening`."""
    poisson_ratio: PoissonRatio
    """Poisson's ratio [1]."""


class ContactPair(Table):
    """How two materials touch."""

    sliding_friction: Coefficient
    """Coefficient of sliding friction [1]."""
    rolling_friction: Coefficient = 0.0
    """Coefficient of rolling friction [1]: rolling moment over normal force times rolling radius."""
    restitution: Share | None = None
    """Coefficient of normal restitution [1], needed with ``damping = "restitution"``; hysteretic: sets the
    unloading stiffness.
    """
    damping_ratio: Annotated[Number, Field(ge=0.0, lt=1.0)] | None = None
    """Dashpot over its critical value [1], needed with ``damping = "ratio"``."""
    normal_stiffness: Stiffness | None = None
    """Stiffness of the normal spring [N/m], needed with ``stiffness = "direct"``."""
    tangential_ratio: Positive = 1.0
    """Tangential over normal stiffness [1]; with ``normal = "hertz"`` over Mindlin's stiffness."""
    tangential_damping: Annotated[Number, Field(ge=0.0, lt=1.0)] | None = None
    """Tangential dashpot over ``2 sqrt(m* k_t)`` with the reduced mass m* [1], needed with
    ``tangential = "incremental_dashpot"``.
    """
    rolling_stiffness: RollingStiffness | None = None
    """Stiffness of the rolling spring [N m/rad], needed with ``rolling = "type_c_direct"``."""
    cohesive_pressure: AddedPressure | None = None
    """Pull over contact area [Pa], needed with ``cohesion = "area"``."""
    liquid_viscosity: Viscosity | None = None
    """Dynamic viscosity of the liquid between the two [Pa s], needed with ``film = "viscous"``; 0 for a dry
    pair.
    """
    film_thickness: Length | None = None
    """Thickness of the liquid between the two at which its film begins to act [m], the layers of both
    together, needed with ``film = "viscous"``.
    """
    film_roughness: Length | None = None
    """Separation at which the peaks of the two surfaces touch [m], needed with ``film = "viscous"``."""
    bridge_volume: BridgeVolume | None = None
    """Volume of the liquid in each bridge between the two [m^3], needed with ``film = "capillary"``; 0 for a
    pair without bridges.
    """
    surface_tension: SurfaceTension | None = None
    """Surface tension of the liquid [N/m], needed with ``film = "capillary"``."""
    contact_angle: ContactAngle | None = None
    """Contact angle of the liquid on the two [rad], needed with ``film = "capillary"``."""
    overlap_warn: Share = 0.05
    """Overlap that is reported, as a share of the particle diameter [1]."""
    overlap_stop: Share = 0.10
    """Overlap that stops the run, as a share of the particle diameter [1]."""


class ContactLaws(Table):
    """The laws all contacts share, and the numbers of each pair."""

    normal: Normal = "linear"
    """Linear spring and dashpot, linear spring that is stiffer on unloading, or Hertz's spring and
    dashpot.
    """
    tangential: Tangential = "displacement"
    """Whether a contact remembers the length of its tangential spring, or its force; they differ where the
    stiffness changes.  The last has a dashpot beside the spring.
    """
    stiffness: Literal["young", "direct"] = "young"
    """``"young"``: each body's spring is softening x young_modulus x particle diameter, two in series (Hertz:
    softening x young_modulus and poisson_ratio of both); ``"direct"``: `normal_stiffness`, not with Hertz."""
    softening: Share = 1.0
    """Factor on Young's modulus [1]."""
    damping: Literal["restitution", "ratio"] = "restitution"
    """Which number of the pair sets the dashpot; hysteretic: ``"restitution"`` only."""
    tension: Literal["kept", "cut"] = "kept"
    """Whether the normal force may pull on release (``"kept"``) or is clipped at zero (``"cut"``); a
    hysteretic spring never pulls.
    """
    rolling: Rolling = "type_c"
    """Rolling resistance: constant moment, spring with a limit whose stiffness follows from the tangential
    one or is given (``"type_c_direct"``), or none.
    """
    cohesion: Cohesion = "none"
    """None, or a pull in proportion to the contact area."""
    film: Film = "none"
    """Liquid between particles, and between particles and walls: none, a viscous film, or capillary bridges,
    with a viscous film between pairs that have a `liquid_viscosity`.
    """
    pairs: dict[str, ContactPair]
    """Numbers of each pair of materials, by ``first-second``."""

    def pair(self, first: str, second: str) -> ContactPair:
        """Return the contact numbers of two materials, in either order.

        Raises
        ------
        KeyError : the file has no such pair
        """
        pair = self.pairs.get(f"{first}-{second}") or self.pairs.get(f"{second}-{first}")
        if pair is None:
            raise KeyError(f"{first}-{second}")
        return pair
