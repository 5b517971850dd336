"""The whole law of one contact, composed of its four stages, and the energy it stores."""

from nutamill.base.kernel import kernel, like
from nutamill.charge.laws.cohesion import cohesive_pull
from nutamill.charge.laws.normal import normal_energy, normal_force
from nutamill.charge.laws.rolling import rolling_energy, rolling_moment
from nutamill.charge.laws.tangential import friction_energy, friction_force


@kernel(inline="always")
def contact(
    law, n0, n1, n2, overlap, u0, u1, u2, w0, w1, w2, s0, s1, s2, t0, t1, t2, sliding, history,
    m_eff, r_eff, diameter_a, diameter_b, numbers, dt,
):  # fmt: skip
    """The whole law of one contact: normal, tangential and rolling part.

    Parameters
    ----------
    law : `ContactLaw`
    n0, n1, n2 : normal [1]; overlap : [m]; u : relative velocity at the contact point [m/s]; w : relative
        spin [rad/s]
    s, t, sliding, history : contact memory, see `displacement_friction`, `spring_rolling` and
        `hysteretic_force`
    m_eff, r_eff : reduced mass [kg] and radius [m]; diameter_a, diameter_b : [m]
    numbers : of the pair, as `LawColumn` (11,); dt : substep [s]

    Returns
    -------
    F [N] (3), tangential force [N] (3), M [N m] (3), s (3), t [rad] (3), sliding [1], history, power of
    normal, tangential and rolling part on the relative motion [W] (3)
    """
    c0, c1, c2, ratio, damping, floor, static, dynamic, rolling, _, pressure = numbers
    v_n = u0 * n0 + u1 * n1 + u2 * n2
    u0 -= v_n * n0
    u1 -= v_n * n1
    u2 -= v_n * n2
    f_n, k, history = normal_force(
        law.normal,
        overlap,
        v_n,
        history,
        m_eff,
        r_eff,
        diameter_a,
        diameter_b,
        c0,
        c1,
        c2,
        damping,
        floor,
        dt,
    )
    load = f_n if f_n > like(0.0, dt) else like(0.0, dt)
    f_n -= cohesive_pull(law.cohesion, overlap, r_eff, pressure)
    kt = ratio * k
    f0, f1, f2, s0, s1, s2, sliding = friction_force(
        law.tangential, s0, s1, s2, sliding, u0, u1, u2, n0, n1, n2, kt, load, static, dynamic, dt
    )  # fmt: skip
    m0, m1, m2, t0, t1, t2 = rolling_moment(
        law.rolling, t0, t1, t2, w0, w1, w2, n0, n1, n2, kt, m_eff, r_eff, rolling * r_eff * load, dt
    )  # fmt: skip
    power_n = -f_n * v_n
    power_t = f0 * u0 + f1 * u1 + f2 * u2
    power_r = m0 * w0 + m1 * w1 + m2 * w2
    return (
        f0 - f_n * n0,
        f1 - f_n * n1,
        f2 - f_n * n2,
        f0,
        f1,
        f2,
        m0,
        m1,
        m2,
        s0,
        s1,
        s2,
        t0,
        t1,
        t2,
        sliding,
        history,
        power_n,
        power_t,
        power_r,
    )


@kernel
def stored_energy(law, numbers, memory, last, overlap, radius_a, radius_b, r_eff):
    """Energy one contact would give back [J] (3): normal with cohesion, tangential, rolling.

    A tangential spring whose stiffness changes with the overlap changes its energy with it, without work:
    what it seems to lose or gain is booked as dissipated.

    Parameters
    ----------
    law : `ContactLaw`
    numbers : of the pair, as `LawColumn`
    memory : of the contact, as `ChargeState.memory`; counts only if its stamp is `last`
    overlap, radius_a, radius_b, r_eff : [m]; a wall takes the particle's radius for both, and for r_eff
    """
    alive = 1.0 if abs(memory[6]) == last else 0.0
    c0, c1, c2 = float(numbers[0]), float(numbers[1]), float(numbers[2])
    damping, floor, history = float(numbers[4]), float(numbers[5]), alive * float(memory[7])
    normal, k = normal_energy(
        law.normal, overlap, history, r_eff, 2.0 * radius_a, 2.0 * radius_b, c0, c1, c2, damping, floor
    )
    normal -= 0.5 * overlap * cohesive_pull(law.cohesion, overlap, r_eff, float(numbers[10]))
    kt = k * float(numbers[3])
    s2, t2 = 0.0, 0.0
    for e in range(3):
        s2 += float(memory[e]) * float(memory[e])
        t2 += float(memory[3 + e]) * float(memory[3 + e])
    return (
        normal,
        friction_energy(law.tangential, alive * s2, kt),
        rolling_energy(law.rolling, alive * t2, kt, r_eff),
    )
