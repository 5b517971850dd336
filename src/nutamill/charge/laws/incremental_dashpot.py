"""Friction: a spring with Coulomb's limit whose force a contact remembers, and a dashpot beside it."""

import math
from typing import NamedTuple

from nutamill.base.frames import dot3, scale3, sub3
from nutamill.base.kernel import kernel, like
from nutamill.charge.laws import incremental
from nutamill.charge.laws.pair import PairLaw
from nutamill.charge.laws.spring import share_at_limit
from nutamill.charge.laws.terms import Terms, Touch


class StoredForceDashpot(NamedTuple):
    """Tangential: as `incremental`, with a dashpot beside the spring."""


LAW = StoredForceDashpot()

spring_force = incremental.force

energy = incremental.energy
"""Energy in the tangential spring; the dashpot stores none."""


@kernel(inline="always")
def force(law, p, spring, sliding, u, n, kt, m_eff, load, least, dt):
    """Return the friction of the spring of `incremental.force` and of a dashpot beside it.

    ``F = pull - c u`` with ``c = 2 ratio sqrt(m* kt)``, shortened to Coulomb's limit where it is longer.  The
    spring alone decides whether the contact slides.  The dashpot never gives energy: with forces a of the
    spring and b of the dashpot, and f the force nearest to a + b within a limit that a obeys,
    ``b (f - a) >= 0``.

    Parameters
    ----------
    as `displacement.force`

    Source
    ------
    Itasca PFC, linear model, "dp_sratio"; LAMMPS, pair_style granular, for a dashpot within Coulomb's limit
    (there the spring is changed with it).
    """
    static, dynamic, twice_ratio = p
    one = like(1.0, dt)
    pull, spring, sliding = spring_force(law, p, spring, sliding, u, n, kt, m_eff, load, least, dt)
    limit = load * (dynamic if sliding > like(0.5, dt) else static)
    both = sub3(pull, scale3(twice_ratio * math.sqrt(m_eff * kt), u))
    square = dot3(both, both)
    share = share_at_limit(limit, one, square, least * kt) if square > limit * limit else one
    return scale3(share, both), spring, sliding


def faults(pair: PairLaw) -> list[tuple[str, str]]:
    """Return what is wrong with the tangential dashpot of a pair."""
    if 0.0 <= pair.tangential_damping < 1.0:
        return []
    return [(f"tangential_damping must be from 0 to below 1, got {pair.tangential_damping:g}", "")]


def terms(touch: Touch) -> dict[str, Terms]:
    """Return this law in the terms of other programs."""
    ratio, spring = touch.pair.tangential_damping, incremental.terms(touch)
    note = f"# its tangential dashpot has the ratio of the normal one; here it is {ratio:g}"
    notes = (*spring["LIGGGHTS"].notes, note) if touch.stiffens else ()
    return {
        "Rocky": Terms(missing="a tangential dashpot"),
        "PFC": Terms(f"dp_sratio {ratio:.6g}"),
        "LAMMPS": Terms(missing="a tangential dashpot by its own ratio"),
        "LIGGGHTS": Terms("tangential_damping on", notes=notes),
    }
