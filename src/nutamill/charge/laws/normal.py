"""Normal force of a contact: linear spring and dashpot, hysteretic spring, Hertz's spring and dashpot."""

import math

from nutamill.base.kernel import by_type, kernel, like
from nutamill.charge.laws.tags import HertzSpring, HystereticSpring, LinearSpring


@kernel(inline="always")
def pair_stiffness(compliance, compliance_a, compliance_b, diameter_a, diameter_b):
    """Normal stiffness k of a pair: given directly, or two springs in series whose stiffness grows with the
    diameter.

    ``1/k = compliance + compliance_a/diameter_a + compliance_b/diameter_b``

    Parameters
    ----------
    compliance : 1/k where k is given directly, else 0 [m/N]
    compliance_a, compliance_b : inverse of stiffness per diameter [m^2/N]; 0 where k is given directly
    diameter_a, diameter_b : of the two particles [m]; a wall takes the particle's

    Returns
    -------
    k [N/m]

    Source
    ------
    Ansys Rocky, DEM Solver SDK manual: K = E L of each entity, in series.
    """
    both = diameter_a * diameter_b
    return both / (compliance * both + compliance_a * diameter_b + compliance_b * diameter_a)


@kernel(inline="always")
def dashpot_speed(overlap, v_n, dt):
    """Approach speed with the share of the substep's dashpot impulse that belongs to the contact, in its
    first and last substep.

    Forces are sampled at mid-substep, but the dashpot's force jumps when contact begins: seen first at
    overlap d < v_n dt, the contact has lasted d/v_n + dt/2 by the end of the substep, half a substep at least
    and one and a half at most.  The same holds, backwards in time, on release.  Without this share the
    restitution scatters with the phase of the first substep, by first order in dt; with it the error is of
    second order (but where tension slows a release so that it is met twice).

    Parameters
    ----------
    overlap : [m], positive in contact
    v_n : approach speed [m/s], positive when closing
    dt : substep [s]

    Returns
    -------
    speed [m/s]: v_n/2 + overlap/dt with the sign of v_n when overlap < abs(v_n) dt, else v_n
    """
    # round-off can make a touching pair's overlap negative
    covered = overlap / dt if overlap > like(0.0, dt) else like(0.0, dt)
    return like(0.5, dt) * v_n + math.copysign(covered, v_n) if covered < abs(v_n) else v_n


@kernel(inline="always")
def linear_force(
    law, overlap, v_n, history, m_eff, r_eff, diameter_a, diameter_b, c0, c1, c2, damping, floor, dt
):
    """Normal force of a linear spring and dashpot.

    ``F_n = max(k overlap + c v, floor)`` with ``c = 2 zeta sqrt(m_eff k)`` and v of `dashpot_speed`

    Parameters
    ----------
    law : tag
    overlap : [m], positive in contact
    v_n : approach speed [m/s], positive when closing
    history : not used
    m_eff, r_eff : reduced mass [kg], reduced radius [m]
    diameter_a, diameter_b, c0, c1, c2 : diameters [m] and compliances as `pair_stiffness`
    damping : 2 zeta, twice the share of critical damping [1]
    floor : 0 where tension is cut, -inf where it is kept [N]
    dt : substep [s], for `dashpot_speed`

    Returns
    -------
    F_n [N], positive pushing apart; k, what the tangential stiffness is measured against [N/m]; history, 0

    Source
    ------
    P. A. Cundall and O. D. L. Strack, "A discrete numerical model for granular assemblies", Geotechnique 29
    (1979).
    """
    k = pair_stiffness(c0, c1, c2, diameter_a, diameter_b)
    force = k * overlap + damping * math.sqrt(m_eff * k) * dashpot_speed(overlap, v_n, dt)
    return force if force > floor else floor, k, like(0.0, dt)


@kernel(inline="always")
def hysteretic_force(
    law, overlap, v_n, history, m_eff, r_eff, diameter_a, diameter_b, c0, c1, c2, damping, floor, dt
):
    """Normal force of a linear spring that is stiffer on unloading and on reloading below the largest load.

    ``F_n = max(min(F_n' + K_u (overlap - overlap'), K_l overlap), lambda K_l overlap)``, the prime marking
    the substep before. What is remembered is not the force but the overlap at which it would vanish,
    ``overlap - F_n/K_u``: the law is then a function of overlap and memory, and rounding does not add up.

    Parameters
    ----------
    as `linear_force`, but
    history : remembered overlap [m]; 0 for a new contact
    c0, c1, c2 : compliances of the loading stiffness K_l
    damping : K_l/K_u, the square of the restitution [1]
    floor : lambda, least force over that of loading [1]
    v_n, m_eff, r_eff, dt : not used

    Returns
    -------
    F_n [N]; K_l [N/m]; remembered overlap [m]

    Source
    ------
    O. R. Walton and R. L. Braun, "Viscosity, granular-temperature, and stress calculations for shearing
    assemblies of inelastic, frictional disks", Journal of Rheology 30 (1986); the form with lambda: Ansys
    Rocky, DEM Technical Manual.
    """
    k = pair_stiffness(c0, c1, c2, diameter_a, diameter_b)
    unloading = k / damping
    loading = k * overlap
    force = unloading * (overlap - history)
    force = force if force < loading else loading
    least = floor * loading
    force = force if force > least else least
    return force, k, overlap - force / unloading


@kernel(inline="always")
def hertz_share(overlap, v_n, dt):
    """As `dashpot_speed`, for a dashpot that grows with the fourth root of the overlap: share [1], and the
    overlap to take [m].

    In the first substep the overlap grows as v_n t from 0 to overlap + v_n dt/2; the integral of ``t^(1/4)``
    over that time is ``4/5 t^(5/4)``.  On release the same holds backwards in time.
    """
    travel = abs(v_n) * dt + like(1e-30, dt)
    depth = overlap if overlap > like(0.0, dt) else like(0.0, dt)
    ends = depth < travel
    share = like(0.4, dt) + like(0.8, dt) * depth / travel if ends else like(1.0, dt)
    return share, depth + like(0.5, dt) * travel if ends else depth


@kernel(inline="always")
def hertz_force(
    law, overlap, v_n, history, m_eff, r_eff, diameter_a, diameter_b, c0, c1, c2, damping, floor, dt
):
    """Normal force of two elastic spheres, and a dashpot with the same share of critical damping at any
    overlap.

    ``F_n = max(4/3 E* sqrt(R*) d^(3/2) + 2 sqrt(5/6) beta sqrt(m* S) v_n share, floor)`` with the tangent
    stiffness ``S = 2 E* sqrt(R* d)`` of overlap d

    Parameters
    ----------
    as `linear_force`, but
    c0 : contact modulus E*, 1/E* = (1 - nu_a^2)/E_a + (1 - nu_b^2)/E_b [Pa]
    damping : 2 sqrt(5/6) beta [1]
    history, diameter_a, diameter_b, c1, c2 : not used

    Returns
    -------
    F_n [N]; S [N/m]; history, 0

    Source
    ------
    K. L. Johnson, "Contact Mechanics", 1985, section 4.2; Y. Tsuji, T. Tanaka and T. Ishida, Powder
    Technology 71 (1992); the damping that gives a restitution exactly: D. Antypov and J. A. Elliott, "On an
    analytical solution for the damped Hertzian spring", Europhysics Letters 94 (2011).
    """
    two = like(2.0, dt)
    share, deep = hertz_share(overlap, v_n, dt)
    depth = overlap if overlap > like(0.0, dt) else like(0.0, dt)
    stiffness = two * c0 * math.sqrt(r_eff * depth)
    dashpot = damping * math.sqrt(m_eff * two * c0 * math.sqrt(r_eff * deep)) * share
    force = like(2.0 / 3.0, dt) * stiffness * depth + dashpot * v_n
    return force if force > floor else floor, stiffness, like(0.0, dt)


normal_force = by_type(
    {LinearSpring: linear_force, HystereticSpring: hysteretic_force, HertzSpring: hertz_force}
)
"""Normal force of the law whose tag comes first; parameters and returned values as `linear_force`."""


@kernel(inline="always")
def linear_energy(law, overlap, history, r_eff, diameter_a, diameter_b, c0, c1, c2, damping, floor):
    """Energy in a linear spring, ``k d^2/2`` [J], and its stiffness k [N/m]; parameters as `linear_force`."""
    k = pair_stiffness(c0, c1, c2, diameter_a, diameter_b)
    return 0.5 * k * overlap * overlap, k


@kernel(inline="always")
def hysteretic_energy(law, overlap, history, r_eff, diameter_a, diameter_b, c0, c1, c2, damping, floor):
    """Energy a hysteretic spring would give back [J], and its stiffness K_l [N/m]; parameters as
    `hysteretic_force`.

    Below the unloading line down to where it meets the least force, and below that from there on.
    """
    force, k, meets = hysteretic_force(
        law, overlap, 0.0, history, 0.0, r_eff, diameter_a, diameter_b, c0, c1, c2, damping, floor, 0.0
    )  # fmt: skip
    # where K_u (d - meets) = lambda K_l d
    corner = min(overlap, meets / (1.0 - floor * damping))
    least = floor * k * corner
    return 0.5 * (force + least) * (overlap - corner) + 0.5 * least * corner, k


@kernel(inline="always")
def hertz_energy(law, overlap, history, r_eff, diameter_a, diameter_b, c0, c1, c2, damping, floor):
    """Energy in Hertz's spring, ``8/15 E* sqrt(R*) d^(5/2)`` [J], and its tangent stiffness [N/m]; parameters
    as `hertz_force`.
    """
    stiffness = 2.0 * c0 * math.sqrt(r_eff * max(overlap, 0.0))
    return 4.0 / 15.0 * stiffness * overlap * overlap, stiffness


normal_energy = by_type(
    {LinearSpring: linear_energy, HystereticSpring: hysteretic_energy, HertzSpring: hertz_energy}
)
"""Energy stored along the normal by the law whose tag comes first, and the stiffness; as `linear_energy`."""
