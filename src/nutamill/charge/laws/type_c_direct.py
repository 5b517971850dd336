"""Rolling type C with a stiffness of its own, in place of that of the tangential spring."""

from typing import NamedTuple

from nutamill.base.kernel import kernel
from nutamill.charge.laws.pair import PairLaw
from nutamill.charge.laws.terms import Terms, Touch
from nutamill.charge.laws.type_c import rolling_spring


class RollingTypeCDirect(NamedTuple):
    """Rolling: spring on the relative rolling angle with a limit, its stiffness given."""


LAW = RollingTypeCDirect()


@kernel(inline="always")
def moment(law, rolled, w, n, kt, m_eff, r_eff, stiffness, limit, dt):
    """Return the moment of a spring of given `stiffness` [N m/rad] on the relative rolling angle.
    The other parameters are those of `type_c.moment`.

    Source
    ------
    K. Iwashita and M. Oda, "Rolling resistance at contacts in simulation of shear band development by DEM",
    Journal of Engineering Mechanics 124 (1998), without the dashpot.
    """
    return rolling_spring(rolled, w, n, stiffness, limit, dt)


@kernel(inline="always")
def energy(law, square, kt, r_eff, stiffness):
    """Return the energy [J] in a rolling spring of given `stiffness` [N m/rad] whose stored angle has this
    `square` [rad^2].
    """
    return 0.5 * stiffness * square


def faults(pair: PairLaw) -> list[tuple[str, str]]:
    """Return what a pair lacks for this law, and what to write instead."""
    if pair.rolling_stiffness > 0.0:
        return []
    what = f"rolling_stiffness must be above 0, got {pair.rolling_stiffness:g} N m/rad"
    return [(what, "Give it, or choose type_c, whose stiffness follows from the tangential one")]


def terms(touch: Touch) -> dict[str, Terms]:
    """Return this law in the terms of other programs."""
    pair, (first, second) = touch.pair, touch.diameters
    radius = 0.5 * first if touch.wall else 0.5 * first * second / (first + second)
    rolling = f"{pair.rolling_friction:g}"
    return {
        "Rocky": Terms(
            "Type C: Linear Spring Rolling Limit",
            lines=(f"rolling resistance {rolling}  # belongs to the particle, not to the pair",),
            missing="a rolling stiffness by itself",
        ),
        "PFC": Terms(missing="a rolling stiffness by itself"),
        "LAMMPS": Terms(f" rolling sds {pair.rolling_stiffness / radius**2:.6g} 0 {rolling}"),
        "LIGGGHTS": Terms(missing="a rolling stiffness by itself"),
    }
