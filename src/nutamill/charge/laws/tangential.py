"""Friction of a contact: a spring with Coulomb's limit that remembers its length, or its force."""

import math

from nutamill.base.kernel import by_type, kernel, like
from nutamill.charge.laws.numbers import TINY
from nutamill.charge.laws.tags import StoredDisplacement, StoredForce


@kernel(inline="always")
def displacement_friction(law, s0, s1, s2, sliding, u0, u1, u2, n0, n1, n2, kt, load, static, dynamic, dt):
    """Tangential spring with Coulomb's limit, by the trapezoidal rule with one stored vector, its length.

    The stored spring belongs to the end of the last substep.  It is laid into the present tangent plane,
    stretched by half a substep's slip, gives the force ``-kt s`` with ``|kt s| <= mu load``, and is stretched
    by the other half.  A spring that was at its limit stays under the dynamic coefficient until it falls
    below it.

    Parameters
    ----------
    law : tag
    s0, s1, s2 : stored spring [m], world axes
    sliding : 1 if the last substep ended at the limit, else 0 [1]
    u0, u1, u2 : tangential part of the relative velocity [m/s]
    n0, n1, n2 : contact normal [1]
    kt : tangential stiffness [N/m]
    load : normal force that counts for friction, clipped at 0 [N]
    static, dynamic : coefficients of friction [1]
    dt : substep [s]

    Returns
    -------
    force [N] (3 numbers), new stored spring [m] (3), sliding [1]

    Source
    ------
    Ansys Rocky, DEM Technical Manual: linear spring Coulomb limit, no tangential dashpot; limit on F_n.
    """
    half = like(0.5, dt) * dt
    along = s0 * n0 + s1 * n1 + s2 * n2
    s0 += half * u0 - along * n0
    s1 += half * u1 - along * n1
    s2 += half * u2 - along * n2
    square = s0 * s0 + s1 * s1 + s2 * s2
    slides = sliding > like(0.5, dt)
    limit = load * (dynamic if slides else static)
    # squares, so that the root is only wanted as a divisor: an estimate refined takes the place of root and
    # division
    beyond = kt * kt * square > limit * limit
    scale = load * dynamic / (kt * math.sqrt(square + like(TINY, dt))) if beyond else like(1.0, dt)
    s0 *= scale
    s1 *= scale
    s2 *= scale
    flag = like(1.0, dt) if beyond else like(0.0, dt)
    return -kt * s0, -kt * s1, -kt * s2, s0 + half * u0, s1 + half * u1, s2 + half * u2, flag


@kernel(inline="always")
def force_friction(law, s0, s1, s2, sliding, u0, u1, u2, n0, n1, n2, kt, load, static, dynamic, dt):
    """As `displacement_friction`, but the stored vector is the spring's pull [N], which grows by ``kt u dt``
    a substep.

    With a constant kt the two are the same.  Where kt falls while a contact unloads, the stored force stays
    and the stored length does not: the force lasts longer, and may give back more energy than it took.

    Source
    ------
    R. D. Mindlin and H. Deresiewicz, Journal of Applied Mechanics 20 (1953), case of no slip, as an
    increment; Ansys Rocky, DEM Solver SDK. Energy: G. Elata and J. G. Berryman, "Contact force-displacement
    laws and the mechanical behavior of random packs of identical spheres", Mechanics of Materials 24 (1996).
    """
    half = like(0.5, dt) * dt * kt
    along = s0 * n0 + s1 * n1 + s2 * n2
    s0 += half * u0 - along * n0
    s1 += half * u1 - along * n1
    s2 += half * u2 - along * n2
    square = s0 * s0 + s1 * s1 + s2 * s2
    slides = sliding > like(0.5, dt)
    limit = load * (dynamic if slides else static)
    beyond = square > limit * limit
    scale = load * dynamic / math.sqrt(square + like(TINY, dt)) if beyond else like(1.0, dt)
    s0 *= scale
    s1 *= scale
    s2 *= scale
    flag = like(1.0, dt) if beyond else like(0.0, dt)
    return -s0, -s1, -s2, s0 + half * u0, s1 + half * u1, s2 + half * u2, flag


friction_force = by_type({StoredDisplacement: displacement_friction, StoredForce: force_friction})
"""Friction of the law whose tag comes first; parameters and returned values as `displacement_friction`."""


@kernel(inline="always")
def displacement_energy(law, square, kt):
    """Energy [J] in a tangential spring of stiffness kt [N/m] whose stored length has this `square` [m^2]:
    ``kt s^2/2``.
    """
    return 0.5 * kt * square


@kernel(inline="always")
def force_energy(law, square, kt):
    """Energy [J] in a tangential spring of stiffness kt [N/m] whose stored force has this `square` [N^2]:
    ``f^2/(2 kt)``.
    """
    return 0.5 * square / kt if kt > 0.0 else 0.0


friction_energy = by_type({StoredDisplacement: displacement_energy, StoredForce: force_energy})
"""Energy in the tangential spring of the law whose tag comes first; as `displacement_energy`."""
