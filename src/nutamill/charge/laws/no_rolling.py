"""No resistance to rolling."""

from typing import NamedTuple

from nutamill.base.kernel import kernel, like
from nutamill.charge.laws.pair import PairLaw
from nutamill.charge.laws.terms import Terms, Touch


class NoRolling(NamedTuple):
    """Rolling: no resistance."""


LAW = NoRolling()


@kernel(inline="always")
def moment(law, rolled, w, n, kt, m_eff, r_eff, stiffness, limit, dt):
    """Return no moment and no memory. Parameters are those of `type_c.moment`."""
    zero = like(0.0, dt)
    return (zero, zero, zero), (zero, zero, zero)


@kernel(inline="always")
def energy(law, square, kt, r_eff, stiffness):
    """Return the stored energy, 0 [J]. Parameters are those of `type_c.energy`."""
    return 0.0


def faults(pair: PairLaw) -> list[tuple[str, str]]:
    """Return no faults: any coefficient will do."""
    return []


def terms(touch: Touch) -> dict[str, Terms]:
    """Return this law in the terms of other programs."""
    return {"Rocky": Terms("none"), "PFC": Terms(), "LAMMPS": Terms(), "LIGGGHTS": Terms()}
