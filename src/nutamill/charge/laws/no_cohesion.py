"""No cohesion."""

from typing import NamedTuple

from nutamill.base.kernel import kernel, like
from nutamill.charge.laws.pair import PairLaw
from nutamill.charge.laws.terms import Terms, Touch


class NoCohesion(NamedTuple):
    """Cohesion: none."""


LAW = NoCohesion()


@kernel(inline="always")
def pull(law, overlap, r_eff, pressure):
    """Return no pull. Parameters are those of `area.pull`."""
    return like(0.0, overlap)


def faults(pair: PairLaw) -> list[tuple[str, str]]:
    """Return what a pair has that this law does not read, and what to write instead."""
    if pair.cohesive_pressure == 0.0:
        return []
    what = f"cohesive_pressure {pair.cohesive_pressure:g} Pa has no cohesive law"
    return [(what, "Choose area cohesion, or write 0")]


def terms(touch: Touch) -> dict[str, Terms]:
    """Return this law in the terms of other programs."""
    return {"Rocky": Terms(), "PFC": Terms(), "LAMMPS": Terms(), "LIGGGHTS": Terms()}
