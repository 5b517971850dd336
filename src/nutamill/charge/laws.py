"""Contact laws: one equation, one function.

Scalar kernels in the precision of their arguments, without branches, so that a batch of contacts becomes vector code.
The normal n points from the first particle to the second (or to the surface); velocities are those of the first relative
to the second at the common contact point, at mid-substep; forces and moments act on the first particle.
"""

import math

from nutamill.kernel import kernel, like


@kernel(inline="always")
def pair_stiffness(compliance, compliance_a, compliance_b, diameter_a, diameter_b):
    """Normal stiffness k of a pair: given directly, or two springs in series whose stiffness grows with the diameter.

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
def substep_share(overlap, v_n, dt):
    """Share of the substep's dashpot impulse that belongs to the contact, in its first and last substep.

    Forces are sampled at mid-substep, but the dashpot's force jumps when contact begins: seen first at overlap d < v_n dt, the
    contact has lasted d/v_n + dt/2 by the end of the substep, half a substep at least and one and a half at most.  The same
    holds, backwards in time, on release.  Without this share the restitution scatters with the phase of the first substep,
    by first order in dt; with it the error is of second order (but where tension slows a release so that it is met twice).

    Parameters
    ----------
    overlap : [m], positive in contact
    v_n : approach speed [m/s], positive when closing
    dt : substep [s]

    Returns
    -------
    share [1], 1/2 + overlap/(abs(v_n) dt) when overlap < abs(v_n) dt, else 1
    """
    # round-off can make a touching pair's overlap negative and its speed zero; neither may divide zero by zero
    travel = abs(v_n) * dt + like(1e-30, dt)
    depth = overlap if overlap > like(0.0, dt) else like(0.0, dt)
    return like(0.5, dt) + depth / travel if depth < travel else like(1.0, dt)


@kernel(inline="always")
def normal_force(overlap, v_n, k, damping, m_eff, floor, dt):
    """Normal force of a linear spring and dashpot.

    ``F_n = max(k overlap + c v_n share, floor)`` with ``c = 2 zeta sqrt(m_eff k)``

    Parameters
    ----------
    overlap : [m], positive in contact
    v_n : approach speed [m/s], positive when closing
    k : stiffness [N/m]
    damping : 2 zeta, twice the share of critical damping [1]
    m_eff : reduced mass [kg]
    floor : 0 where tension is cut, -inf where it is kept [N]
    dt : substep [s], for `substep_share`

    Returns
    -------
    F_n [N], positive pushing apart

    Source
    ------
    P. A. Cundall and O. D. L. Strack, "A discrete numerical model for granular assemblies", Geotechnique 29 (1979).
    """
    force = k * overlap + damping * math.sqrt(m_eff * k) * v_n * substep_share(overlap, v_n, dt)
    return force if force > floor else floor


@kernel(inline="always")
def friction_force(s0, s1, s2, sliding, u0, u1, u2, n0, n1, n2, kt, load, static, dynamic, dt):
    """Tangential spring with Coulomb's limit, by the trapezoidal rule with one stored vector.

    The stored spring belongs to the end of the last substep.  It is laid into the present tangent plane, stretched by half a
    substep's slip, gives the force ``-kt s`` with ``|kt s| <= mu load``, and is stretched by the other half.  A spring that was
    at its limit stays under the dynamic coefficient until it falls below it.

    Parameters
    ----------
    s0, s1, s2 : stored spring [m], world axes
    sliding : 1 if the last substep ended at the limit, else 0 [1]
    u0, u1, u2 : tangential part of the relative velocity [m/s]
    n0, n1, n2 : contact normal [1]
    kt : tangential stiffness [N/m]
    load : normal force that counts for friction, F_n clipped at 0 [N]
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
    size = kt * math.sqrt(s0 * s0 + s1 * s1 + s2 * s2)
    slides = sliding > like(0.5, dt)
    limit = load * (dynamic if slides else static)
    beyond = size > limit
    scale = load * dynamic / size if beyond else like(1.0, dt)
    s0 *= scale
    s1 *= scale
    s2 *= scale
    flag = like(1.0, dt) if beyond else like(0.0, dt)
    return -kt * s0, -kt * s1, -kt * s2, s0 + half * u0, s1 + half * u1, s2 + half * u2, flag


@kernel(inline="always")
def rolling_moment(t0, t1, t2, w0, w1, w2, n0, n1, n2, kr, drag, spring, limit, dt):
    """Resistance to rolling: ``M = -q min(1, limit/|q|)`` with ``q = kr t + drag w``.

    Type C: a spring `kr` on the relative rolling angle t (trapezoidal rule, as `friction_force`), no drag.  Type A: no spring,
    and a drag so stiff that the limit decides, unless the spin is about to stop; then it brakes a share of the
    spin in one substep instead of turning it round.

    Parameters
    ----------
    t0, t1, t2 : stored rolling angle [rad], world axes
    w0, w1, w2 : spin of the first relative to the second [rad/s]; its twist about n counts for type A only
    n0, n1, n2 : contact normal [1]
    kr : rolling stiffness [N m/rad], 0 for type A
    drag : [N m s/rad], 0 for type C
    spring : 1 for type C, 0 for type A [1]
    limit : largest moment, rolling friction x reduced radius x F_n [N m]
    dt : substep [s]

    Returns
    -------
    moment [N m] (3 numbers), new stored angle [rad] (3)

    Source
    ------
    Ansys Rocky, DEM Technical Manual: rolling types A and C.  Type A acts here on the relative spin, with the reduced
    radius (as "cdt" in LIGGGHTS), so that a pair keeps its angular momentum; against a resting wall it is Rocky's.  Type C equals
    "rrlinear" in PFC and "epsd2" in LIGGGHTS: J. Ai, J.-F. Chen, J. M. Rotter and J. Y. Ooi, Powder Technology 206 (2011).
    """
    half = spring * like(0.5, dt) * dt
    twist = spring * (w0 * n0 + w1 * n1 + w2 * n2)
    w0 -= twist * n0
    w1 -= twist * n1
    w2 -= twist * n2
    along = t0 * n0 + t1 * n1 + t2 * n2
    t0 = spring * (t0 - along * n0) + half * w0
    t1 = spring * (t1 - along * n1) + half * w1
    t2 = spring * (t2 - along * n2) + half * w2
    q0 = kr * t0 + drag * w0
    q1 = kr * t1 + drag * w1
    q2 = kr * t2 + drag * w2
    size = math.sqrt(q0 * q0 + q1 * q1 + q2 * q2)
    scale = limit / size if size > limit else like(1.0, dt)
    return -scale * q0, -scale * q1, -scale * q2, scale * t0 + half * w0, scale * t1 + half * w1, scale * t2 + half * w2


@kernel(inline="always")
def contact(
    n0, n1, n2, overlap, u0, u1, u2, w0, w1, w2, s0, s1, s2, t0, t1, t2, sliding,
    m_eff, r_eff, k, ratio, damping, floor, static, dynamic, rolling, spring, constant, dt,
):  # fmt: skip
    """The whole law of one contact: normal, tangential and rolling part.

    Parameters
    ----------
    n0, n1, n2 : normal [1]; overlap : [m]; u : relative velocity at the contact point [m/s]; w : relative spin [rad/s]
    s, t, sliding : contact memory, see `friction_force` and `rolling_moment`
    m_eff, r_eff : reduced mass [kg] and radius [m]; k : normal stiffness [N/m]
    ratio : tangential over normal stiffness [1]; damping, floor, static, dynamic, rolling : see `LawColumn`
    spring, constant : which rolling law, 1 or 0 [1]; dt : substep [s]

    Returns
    -------
    F [N] (3), tangential force [N] (3), M [N m] (3), s [m] (3), t [rad] (3), sliding [1], power of normal, tangential and
    rolling part on the relative motion [W] (3)
    """
    v_n = u0 * n0 + u1 * n1 + u2 * n2
    u0 -= v_n * n0
    u1 -= v_n * n1
    u2 -= v_n * n2
    f_n = normal_force(overlap, v_n, k, damping, m_eff, floor, dt)
    load = f_n if f_n > like(0.0, dt) else like(0.0, dt)
    kt = ratio * k
    f0, f1, f2, s0, s1, s2, sliding = friction_force(s0, s1, s2, sliding, u0, u1, u2, n0, n1, n2, kt, load, static, dynamic, dt)
    kr = spring * kt * r_eff * r_eff
    # a tenth of the reduced inertia (2/5 m R^2) a substep: several contacts at once brake a spin, and never turn it round
    drag = constant * like(0.04, dt) * m_eff * r_eff * r_eff / dt
    m0, m1, m2, t0, t1, t2 = rolling_moment(t0, t1, t2, w0, w1, w2, n0, n1, n2, kr, drag, spring, rolling * r_eff * load, dt)
    power_n = -f_n * v_n
    power_t = f0 * u0 + f1 * u1 + f2 * u2
    power_r = m0 * w0 + m1 * w1 + m2 * w2
    return (
        f0 - f_n * n0, f1 - f_n * n1, f2 - f_n * n2, f0, f1, f2, m0, m1, m2, s0, s1, s2, t0, t1, t2, sliding, power_n, power_t, power_r,
    )  # fmt: skip
