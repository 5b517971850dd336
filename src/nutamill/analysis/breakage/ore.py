"""The ore: a TOML file with the numbers of its breakage tests and where they come from, checked as a case
is.
"""

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, model_validator

from nutamill.base.file_kind import FileKind, refuse_other_kind
from nutamill.base.library import ore_file
from nutamill.base.required import required
from nutamill.base.schema import (
    Coefficient,
    Density,
    LeastSpecificEnergy,
    Length,
    Number,
    Positive,
    SpecificEnergy,
    Table,
    refusal,
)
from nutamill.base.units import in_unit, shown
from nutamill.case.toml.layers import read_layers
from nutamill.case.toml.merge import merge
from nutamill.case.toml.messages import checked

PERCENT = 100.0
"""Numbers in percent that make one [1]."""

A = Annotated[Number, Field(gt=0.0, lt=PERCENT)]


class DropWeight(Table):
    """An ore by its drop-weight test: ``t10 = A (1 - exp(-b E))``, no damage by loadings that it survives."""

    A: A
    """Largest t10 that can be reached [%]."""
    b: Annotated[Positive, Field(le=100.0)]
    """Steepness of t10 over the specific energy of the test [t/kWh]."""
    size: Length
    """Size of the particles for which A and b were measured [m]."""
    size_exponent: Annotated[Coefficient, Field(le=2.0)]
    """How the steepness grows with size: ``b (d/size)^size_exponent``; 0: not at all [1]."""
    least_energy: LeastSpecificEnergy = 0.0
    """Specific energy below which a particle of `size` is not harmed [J/kg]; inversely as the size for
    others.
    """


class Tavares(Table):
    """An ore by the distribution of its fracture energies, weakened by every loading that it survives."""

    A: A
    """Largest t10 that can be reached [%]."""
    steepness: Positive
    """b' of ``t10 = A (1 - exp(-b' E/E50))`` [1]."""
    fracture_energy: SpecificEnergy
    """Median specific fracture energy of large particles [J/kg]."""
    half_size: Length
    """Size of particles with twice that [m]."""
    size_exponent: Annotated[Positive, Field(le=5.0)]
    """How it grows for smaller ones: ``fracture_energy (1 + (half_size/d)^size_exponent)`` [1]."""
    spread: Annotated[Positive, Field(le=3.0)]
    """Standard deviation of the logarithm of the fracture energy [1]."""
    largest: Annotated[Number, Field(gt=1.0)]
    """Fracture energy of the strongest particle over the median [1]."""
    damage_exponent: Annotated[Positive, Field(ge=0.5, le=50.0)]
    """Damage accumulation coefficient [1]."""


class Ore(Table):
    """An ore, what is fed of it, and how fine it shall be."""

    schema_version: Annotated[Literal[1], Field(alias="schema")] = 1
    """Version of the form of this file."""
    title: str = ""
    """Name of the ore, for tables."""
    source: Annotated[str, Field(min_length=1)]
    """Where the numbers of its breakage come from."""
    assumed: str = ""
    """Which of them do not, where some are assumed."""
    density: Density
    """Density of its particles [kg/m^3]."""
    feed: Length
    """Size than which 80 % of the feed is finer [m]."""
    feed_exponent: Annotated[Positive, Field(ge=0.2)]
    """Slope of the feed: the share ``(d/top)^feed_exponent`` is finer than d [1]."""
    product: Length
    """Size than which 80 % of the product shall be finer [m]."""
    fineness: Annotated[Positive, Field(le=5.0)]
    """Exponent of the sizes of fragments, ``t_n = 1 - (1 - t10)^((9/(n - 1))^fineness)`` [1]."""
    drop_weight: DropWeight | None = None
    """An ore by A and b; or give `tavares`."""
    tavares: Tavares | None = None
    """An ore by its fracture energies."""

    @model_validator(mode="after")
    def _possible(self) -> "Ore":
        if (self.drop_weight is None) == (self.tavares is None):
            given = "none" if self.tavares is None else "both"
            raise refusal(
                f"must have one of [drop_weight] and [tavares], got {given}",
                "Write [drop_weight] with A, b, size and size_exponent of the ore's test",
            )
        if self.product >= self.feed:
            raise refusal(
                f"product must be less than feed, got {shown(self.product, 'mm')} and "
                f"{shown(self.feed, 'mm')}"
            )
        return self

    @property
    def breakage(self) -> DropWeight | Tavares:
        """Return the law of its breakage."""
        return self.drop_weight or required(self.tavares)

    @property
    def top_size(self) -> float:
        """Return the size of the coarsest of the feed [m]."""
        return float(self.feed / 0.8 ** (1.0 / self.feed_exponent))


def load_ore(name: str | Path) -> Ore:
    """Read an ore: a TOML file, or the name of one in the library.

    Raises
    ------
    CaseError : no such file, or all faults of it at once, each with its file, line and key
    """
    path = ore_file(str(name)) or Path(name)
    refuse_other_kind(path, FileKind.ORE)
    content, positions, faults = merge(read_layers(path))
    return checked(Ore, content, positions, faults)


def steepness_of(law: DropWeight) -> float:
    """Return b in SI [kg/J]."""
    return in_unit(law.b, "kWh/t")
