"""A contact in the terms of other programs: what a law file returns of itself, and what it gets for it.

The file of a law has ``terms(touch)``, which returns its `Terms` for each of `PROGRAMS`.  SI units.

Sources: Ansys Rocky, DEM Technical Manual 2024 R2; Itasca PFC documentation 6 to 9, contact models linear,
rrlinear, hertz; LAMMPS documentation, pair_style granular; LIGGGHTS-PUBLIC 3.8 documentation, gran models.
"""

from dataclasses import dataclass

from nutamill.charge.laws.oscillator import restitution_from_damping_ratio
from nutamill.charge.laws.pair import PairLaw, spring_stiffness

PROGRAMS = ("Rocky", "PFC", "LAMMPS", "LIGGGHTS")
"""Programs whose terms the laws know."""


@dataclass(frozen=True, slots=True)
class Terms:
    """A law in the terms of one program."""

    words: str = ""
    """Name of the law, with its numbers where they stand behind it."""
    lines: tuple[str, ...] = ()
    """Further numbers."""
    notes: tuple[str, ...] = ()
    """Where the program means something else."""
    missing: str = ""
    """What the program does not have."""


@dataclass(frozen=True, slots=True)
class Touch:
    """Two materials in contact: all that `terms` reads."""

    pair: PairLaw
    """Their numbers."""
    wall: bool
    """Whether the second is a wall."""
    mass: float
    """Reduced mass of the particles with the shortest contacts [kg]."""
    diameters: tuple[float, float]
    """Diameters of the two [m]; a wall takes the particle's."""
    young: tuple[float, float]
    """Young's modulus of the two as the law takes it, softened [Pa]."""
    poisson: tuple[float, float]
    """Poisson's ratio of the two [1]."""
    softening: float
    """Share of the solid's Young's modulus that the law takes [1]; 0 where stiffness is given directly."""
    stiffens: bool
    """Whether the stiffness of the normal law grows with the overlap."""
    restitution: float
    """Restitution without cohesion [1]."""

    @property
    def k(self) -> float:
        """Normal stiffness of a linear or hysteretic spring [N/m]."""
        return spring_stiffness(self.pair, *self.diameters)

    @property
    def kt(self) -> float:
        """Its tangential stiffness [N/m]."""
        return self.pair.tangential_ratio * self.k

    @property
    def plain_restitution(self) -> float:
        """Restitution the dashpot would give with tension kept [1]: so it is understood by programs that take
        a restitution.
        """
        return restitution_from_damping_ratio(self.pair.damping_ratio, False)

    @property
    def restitution_notes(self) -> tuple[str, ...]:
        """Why the restitution written is not that of the case."""
        if not self.pair.tension_cut or self.pair.damping_ratio == 0.0:
            return ()
        return (
            f"# {self.plain_restitution:.6g} gives the dashpot of this case; with tension cut the "
            f"restitution is {self.restitution:.6g}",
        )
