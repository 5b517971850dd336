"""Rolling type A: a constant moment against the relative spin."""

import math
from typing import NamedTuple

from nutamill.base.frames import dot3, scale3
from nutamill.base.kernel import kernel, like
from nutamill.charge.laws.pair import PairLaw
from nutamill.charge.laws.spring import LEAST_ANGLE
from nutamill.charge.laws.terms import Terms, Touch


class RollingTypeA(NamedTuple):
    """Rolling: constant moment against the relative spin."""


LAW = RollingTypeA()


@kernel(inline="always")
def moment(law, rolled, w, n, kt, m_eff, r_eff, stiffness, limit, dt):
    """Return the limit moment against the relative spin, ``M = -limit w/|w|``.

    A spin that is about to stop meets a drag instead, which brakes a share of it in one substep and does not
    reverse it.  Parameters and returned values as `type_c.moment`; the twist about n counts here.

    Source
    ------
    Ansys Rocky, DEM Technical Manual: rolling type A.  It acts here on the relative spin, with the reduced
    radius (as "cdt" in LIGGGHTS), so that a pair keeps its angular momentum; against a resting wall it is
    Rocky's.
    """
    zero = like(0.0, dt)
    # a tenth of the reduced inertia (2/5 m R^2) a substep: several contacts at once brake a spin, and never
    # reverse it
    drag = like(0.04, dt) * m_eff * r_eff * r_eff / dt
    square, least = dot3(w, w), like(LEAST_ANGLE, dt) / dt
    brake = limit / math.sqrt(square + least * least) if drag * drag * square > limit * limit else drag
    return scale3(-brake, w), (zero, zero, zero)


@kernel(inline="always")
def energy(law, square, kt, r_eff, stiffness):
    """Return the stored energy, 0 [J]. Parameters are those of `type_c.energy`."""
    return 0.0


def faults(pair: PairLaw) -> list[tuple[str, str]]:
    """Return no faults: any coefficient will do."""
    return []


def terms(touch: Touch) -> dict[str, Terms]:
    """Return this law in the terms of other programs."""
    rolling = f"{touch.pair.rolling_friction:g}"
    return {
        "Rocky": Terms(
            "Type A: Constant",
            lines=(f"rolling resistance {rolling}  # belongs to the particle, not to the pair",),
        ),
        "PFC": Terms(missing="type A rolling"),
        "LAMMPS": Terms(missing="type A rolling"),
        "LIGGGHTS": Terms(" rolling_friction cdt", lines=(f"coefficientRollingFriction {rolling}",)),
    }
