"""Friction: a spring with Coulomb's limit whose length a contact remembers."""

from typing import NamedTuple

from nutamill.base.frames import add3, scale3
from nutamill.base.kernel import kernel, like
from nutamill.charge.laws.pair import PairLaw
from nutamill.charge.laws.spring import spring_with_limit
from nutamill.charge.laws.terms import Terms, Touch


class StoredDisplacement(NamedTuple):
    """Tangential: the contact remembers the length of its spring."""


LAW = StoredDisplacement()


@kernel(inline="always")
def force(law, p, spring, sliding, u, n, kt, m_eff, load, least, dt):
    """Return the friction of a tangential spring with Coulomb's limit, by the trapezoidal rule with one
    stored vector, its length.

    The force is ``-kt s`` with ``|kt s| <= mu load`` (`spring_with_limit`).  A spring that was at its limit
    stays under the dynamic coefficient until it falls below it.

    Parameters
    ----------
    law : tag
    p : static and dynamic coefficient of friction [1], twice the tangential damping ratio [1], not used
    spring : stored spring [m] (3), world axes
    sliding : 1 if the last substep ended at the limit, else 0 [1]
    u : tangential part of the relative velocity [m/s] (3)
    n : contact normal [1] (3)
    kt : tangential stiffness [N/m]
    m_eff : reduced mass [kg]; not used
    load : normal force that counts for friction, clipped at 0 [N]
    least : length of the spring that counts as nothing [m]
    dt : substep [s]

    Returns
    -------
    force [N] (3), new stored spring [m] (3), sliding [1]

    Source
    ------
    Ansys Rocky, DEM Technical Manual: linear spring Coulomb limit, no tangential dashpot; limit on F_n.
    """
    static, dynamic, _ = p
    holds = load * (dynamic if sliding > like(0.5, dt) else static)
    half = scale3(like(0.5, dt) * dt, u)
    spring, sliding = spring_with_limit(spring, half, n, kt, holds, load * dynamic, least)
    return scale3(-kt, spring), add3(spring, half), sliding


@kernel(inline="always")
def energy(law, square, kt):
    """Return the energy [J] in a tangential spring of stiffness kt [N/m] whose stored length has this
    `square` [m^2]: ``kt s^2/2``.
    """
    return 0.5 * kt * square


def faults(pair: PairLaw) -> list[tuple[str, str]]:
    """Return no faults: any coefficient will do."""
    return []


def terms(touch: Touch) -> dict[str, Terms]:
    """Return this law in the terms of other programs."""
    pair = touch.pair
    note = "# it remembers the tangential force, not the length: the same at constant stiffness"
    if touch.stiffens:
        rule = f"mindlin {8.0 * pair.tangential_ratio * pair.contact_shear_modulus:.6g}"
    else:
        rule = f"linear_history {touch.kt:.6g}"
    return {
        "Rocky": Terms(notes=() if touch.stiffens else (note,)),
        "PFC": Terms("dp_sratio 0"),
        "LAMMPS": Terms(f"{rule} 0 {pair.static_friction:g}"),
        "LIGGGHTS": Terms("tangential_damping off"),
    }
