"""Damped spring in a leapfrog: the spring and the dashpot with which its steps lie on the exact motion."""

from nutamill.base.kernel import kernel, like


@kernel(inline="always")
def leapfrog_shares(k, m_eff, twice_zeta, dt):
    """Return the shares of the spring and of the dashpot to apply in a substep.

    The charge marches with positions at mid-substep and with the dashpot at the predicted velocity
    ``v + a dt/2``, a from the substep before (docs/decisions/007).  Such a march of
    ``u'' + 2 zeta w u' + w^2 u = 0`` has the roots ``exp((-zeta +- i sqrt(1 - zeta^2)) w dt)`` of the exact
    motion if its coefficients solve ``(z - 2 + 1/z)/dt^2 = -K - C ((1 - 1/z)/dt + (1 - 1/z)^2/(2 dt))``;
    these are K and C to the second power of ``w dt``.  The motion within a contact is then of third order, of
    fourth without damping.

    Parameters
    ----------
    k : stiffness [N/m]
    m_eff : reduced mass [kg]
    twice_zeta : twice the share of critical damping [1]
    dt : substep [s]

    Returns
    -------
    ``1 + (w dt)^2 (5 zeta^2/3 - 1/12)``, ``1 + (w dt)^2 (5 zeta^2/3 - 1/2)`` [1], with ``w^2 = k/m_eff``

    Source
    ------
    R. E. Mickens, "Nonstandard Finite Difference Models of Differential Equations", World Scientific 1994,
    for the exact scheme of a damped oscillator.
    """
    square = k * dt * dt / m_eff
    damped = like(5.0 / 12.0, dt) * twice_zeta * twice_zeta
    one = like(1.0, dt)
    return one + square * (damped - like(1.0 / 12.0, dt)), one + square * (damped - like(0.5, dt))
