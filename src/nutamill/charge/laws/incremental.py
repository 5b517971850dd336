"""Friction: a spring with Coulomb's limit whose force a contact remembers."""

from typing import NamedTuple

from nutamill.base.frames import add3, scale3
from nutamill.base.kernel import kernel, like
from nutamill.charge.laws.pair import PairLaw
from nutamill.charge.laws.spring import spring_with_limit
from nutamill.charge.laws.terms import Terms, Touch


class StoredForce(NamedTuple):
    """Tangential: the contact remembers the force of its spring, which grows by increments."""


LAW = StoredForce()


@kernel(inline="always")
def force(law, p, spring, sliding, u, n, kt, m_eff, load, least, dt):
    """Return the friction of a spring whose stored vector is its pull [N], which grows by ``kt u dt`` a
    substep.

    Otherwise as `displacement.force`; with a constant kt the two are the same.  Where kt falls while a
    contact unloads, the stored force stays and the stored length does not: the force lasts longer, and may
    give back more energy than it took.

    Source
    ------
    R. D. Mindlin and H. Deresiewicz, Journal of Applied Mechanics 20 (1953), case of no slip, as an
    increment; Ansys Rocky, DEM Solver SDK. Energy: G. Elata and J. G. Berryman, "Contact force-displacement
    laws and the mechanical behavior of random packs of identical spheres", Mechanics of Materials 24 (1996).
    """
    static, dynamic, _ = p
    holds = load * (dynamic if sliding > like(0.5, dt) else static)
    half = scale3(like(0.5, dt) * dt * kt, u)
    one = like(1.0, dt)
    spring, sliding = spring_with_limit(spring, half, n, one, holds, load * dynamic, least * kt)
    return scale3(-one, spring), add3(spring, half), sliding


@kernel(inline="always")
def energy(law, square, kt):
    """Return the energy [J] in a tangential spring of stiffness kt [N/m] whose stored force has this `square`
    [N^2]: ``f^2/(2 kt)``.
    """
    return 0.5 * square / kt if kt > 0.0 else 0.0


def faults(pair: PairLaw) -> list[tuple[str, str]]:
    """Return no faults: any coefficient will do."""
    return []


def terms(touch: Touch) -> dict[str, Terms]:
    """Return this law in the terms of other programs."""
    pair = touch.pair
    if touch.stiffens:
        rule = f"mindlin/force {8.0 * pair.tangential_ratio * pair.contact_shear_modulus:.6g}"
    else:
        rule = f"linear_history {touch.kt:.6g}"
    note = "# it remembers the tangential length, not the force"
    return {
        "Rocky": Terms(),
        "PFC": Terms("dp_sratio 0"),
        "LAMMPS": Terms(f"{rule} 0 {pair.static_friction:g}"),
        "LIGGGHTS": Terms("tangential_damping off", notes=(note,) if touch.stiffens else ()),
    }
