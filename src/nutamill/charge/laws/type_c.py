"""Rolling type C: a spring on the relative rolling angle with a limit."""

from typing import NamedTuple

from nutamill.base.frames import add3, dot3, scale3, sub3
from nutamill.base.kernel import kernel, like
from nutamill.charge.laws.pair import PairLaw
from nutamill.charge.laws.spring import LEAST_ANGLE, share_at_limit, tangent_spring
from nutamill.charge.laws.terms import Terms, Touch


class RollingTypeC(NamedTuple):
    """Rolling: spring on the relative rolling angle with a limit."""


LAW = RollingTypeC()


@kernel(inline="always")
def moment(law, rolled, w, n, kt, m_eff, r_eff, stiffness, limit, dt):
    """Return the moment of a spring ``kr = kt R*^2`` on the relative rolling angle t, ``M = -kr t`` with
    ``|M| <= limit``.

    By the trapezoidal rule, as friction (`spring`).  The twist about n does not count.

    Parameters
    ----------
    law : tag
    rolled : stored rolling angle [rad] (3), world axes
    w : spin of the first relative to the second [rad/s] (3)
    n : contact normal [1] (3)
    kt : tangential stiffness [N/m]
    m_eff, r_eff : reduced mass [kg] and radius [m]
    stiffness : of a rolling spring that is given by itself [N m/rad]; not used
    limit : largest moment, rolling friction x reduced radius x normal force that counts for friction [N m]
    dt : substep [s]

    Returns
    -------
    moment [N m] (3), new stored angle [rad] (3)

    Source
    ------
    Ansys Rocky, DEM Technical Manual: rolling type C.  It equals "rrlinear" in PFC and "epsd2" in LIGGGHTS:
    J. Ai, J.-F. Chen, J. M. Rotter and J. Y. Ooi, Powder Technology 206 (2011).
    """
    return rolling_spring(rolled, w, n, kt * r_eff * r_eff, limit, dt)


@kernel(inline="always")
def rolling_spring(rolled, w, n, kr, limit, dt):
    """Return the moment [N m] (3) of a rolling spring of stiffness `kr` [N m/rad] with a limit, and its new
    angle [rad] (3).  The other parameters are those of `moment`.
    """
    half = scale3(like(0.5, dt) * dt, sub3(w, scale3(dot3(w, n), n)))
    rolled = tangent_spring(rolled, half, n)
    square = dot3(rolled, rolled)
    beyond = kr * kr * square > limit * limit
    least = like(LEAST_ANGLE, dt)
    rolled = scale3(share_at_limit(limit, kr, square, least) if beyond else like(1.0, dt), rolled)
    return scale3(-kr, rolled), add3(rolled, half)


@kernel(inline="always")
def energy(law, square, kt, r_eff, stiffness):
    """Return the energy [J] in a rolling spring ``kt r_eff^2`` whose stored angle has this `square`
    [rad^2].
    """
    return 0.5 * kt * r_eff * r_eff * square


def faults(pair: PairLaw) -> list[tuple[str, str]]:
    """Return no faults: any coefficient will do."""
    return []


def terms(touch: Touch) -> dict[str, Terms]:
    """Return this law in the terms of other programs."""
    rolling = f"{touch.pair.rolling_friction:g}"
    if touch.stiffens:
        pfc = Terms(missing="rolling with hertz")
        lammps = Terms(missing="a rolling spring that follows Mindlin's stiffness")
    else:
        pfc = Terms(f" rr_fric {rolling}")
        lammps = Terms(f" rolling sds {touch.kt:.6g} 0 {rolling}")
    return {
        "Rocky": Terms(
            "Type C: Linear Spring Rolling Limit",
            lines=(f"rolling resistance {rolling}  # belongs to the particle, not to the pair",),
        ),
        "PFC": pfc,
        "LAMMPS": lammps,
        "LIGGGHTS": Terms(" rolling_friction epsd2", lines=(f"coefficientRollingFriction {rolling}",)),
    }
