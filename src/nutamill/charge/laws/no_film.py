"""No liquid between the particles."""

from typing import NamedTuple

from nutamill.charge.laws.pair import PairLaw
from nutamill.charge.laws.terms import Terms, Touch


class NoFilm(NamedTuple):
    """Film: none."""


LAW = NoFilm()


def numbers(pair: PairLaw) -> list[float]:
    """Return no numbers."""
    return []


def reach(pair: PairLaw, radius: float) -> float:
    """Return the largest gap across which a film acts, 0 [m]."""
    return 0.0


def faults(pair: PairLaw) -> list[tuple[str, str]]:
    """Return what a pair has that this law does not read, and what to write instead."""
    faulty = []
    if pair.liquid_viscosity != 0.0:
        what = f"liquid_viscosity {pair.liquid_viscosity:g} Pa s has no film"
        faulty.append((what, "Choose a viscous film, or write 0"))
    if pair.bridge_volume != 0.0:
        what = f"bridge_volume {pair.bridge_volume:g} m^3 has no bridges"
        faulty.append((what, "Choose capillary bridges, or write 0"))
    return faulty


def terms(touch: Touch) -> dict[str, Terms]:
    """Return this law in the terms of other programs."""
    return {"Rocky": Terms(), "PFC": Terms(), "LAMMPS": Terms(), "LIGGGHTS": Terms()}
