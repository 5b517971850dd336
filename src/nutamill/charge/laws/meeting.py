"""One contact with or without liquid: the law of the solids where they touch, film and bridge beside it."""

from nutamill.base.frames import add3, dot3, scale3, sub3
from nutamill.base.kernel import by_type, kernel, like
from nutamill.charge.laws import capillary, no_film, viscous_film
from nutamill.charge.laws.composition import contact


@kernel(inline="always")
def meet_dry(
    film, law, n, overlap, u, w, spring, rolled, sliding, history, alive, m_eff, r_eff, diameters, numbers,
    liquid, dt,
):  # fmt: skip
    """Return what `composition.contact` does for two bodies that touch, without film."""
    force, friction, moment, spring, rolled, sliding, history, powers = contact(
        law, n, overlap, u, w, spring, rolled, sliding, history, m_eff, r_eff, diameters, numbers, dt
    )
    return force, friction, moment, spring, rolled, sliding, history, powers, like(0.0, dt), alive


@kernel(inline="always")
def meet_wet(
    film, law, n, overlap, u, w, spring, rolled, sliding, history, alive, m_eff, r_eff, diameters, numbers,
    liquid, dt,
):  # fmt: skip
    """Return force, moment, memory and powers of two bodies that touch or have a film between them.

    Without contact the memory holds minus the separation at the end of the substep in place of the history,
    which is never negative, and no springs.

    Parameters
    ----------
    film : tag
    law, n, overlap, u, w, spring, rolled, sliding, history : as `composition.contact`; the overlap is
        negative where there is a gap
    alive : 1 where the memory is of the last substep, else 0 [1]
    m_eff, r_eff, diameters, numbers : as `composition.contact`
    liquid : numbers of the pair, as `viscous_film.numbers` (3)
    dt : substep [s]

    Returns
    -------
    what `composition.contact` returns; power of the film on the relative motion [W]; 0 where a contact of the
    solids begins, else 1 [1]
    """
    zero, one = like(0.0, dt), like(1.0, dt)
    touches = overlap > zero
    v_n = dot3(u, n)
    in_film = history < zero
    solid = zero if in_film else alive
    before = viscous_film.separation_before(liquid, -overlap, v_n, dt)
    before = -history if in_film else before
    before = liquid[2] if solid > zero else before
    after = viscous_film.separation_after(liquid, -overlap, v_n, dt)
    after = liquid[2] if touches else after
    push = viscous_film.push(liquid, before, after, r_eff, dt)
    force, friction, moment, spring, rolled, sliding, history, powers = contact(
        law, n, overlap if touches else zero, u, w, spring, rolled, sliding, zero if in_film else history,
        m_eff, r_eff, diameters, numbers, dt,
    )  # fmt: skip
    force, friction = only_where(touches, force), only_where(touches, friction)
    moment, powers = only_where(touches, moment), only_where(touches, powers)
    spring, rolled = only_where(touches, spring), only_where(touches, rolled)
    # rounding must not make the history of a contact a separation
    history = history if history > zero else zero
    lasts = solid if touches else one
    return (
        sub3(force, scale3(push, n)), friction, moment, spring, rolled, sliding if touches else zero,
        history if touches else -after, powers, -push * v_n, lasts,
    )  # fmt: skip


@kernel(inline="always")
def meet_bridged(
    film, law, n, overlap, u, w, spring, rolled, sliding, history, alive, m_eff, r_eff, diameters, numbers,
    liquid, dt,
):  # fmt: skip
    """Return what `meet_wet` does of two bodies that touch, have a film between them, or a bridge.

    A bridge forms where the solids touch, and lasts until rupture.  Across a gap, where nothing slides,
    `sliding` remembers it: 1 with a bridge.  Parameters and values are those of `meet_wet`; `liquid` as
    `capillary.numbers` (7).  The power is that of film and bridge together.
    """
    zero, one = like(0.0, dt), like(1.0, dt)
    touches = overlap > zero
    across = history < zero
    lasted = sliding > zero if across else alive > zero
    gap = zero if touches else -overlap
    bridge = liquid[3], liquid[4], liquid[5], liquid[6]
    joined = touches or (lasted and gap < capillary.rupture(bridge, r_eff))
    pull = capillary.pull(bridge, gap, r_eff) if joined else zero
    force, friction, moment, spring, rolled, sliding, history, powers, power, lasts = meet_wet(
        film, law, n, overlap, u, w, spring, rolled, zero if across else sliding, history, alive, m_eff,
        r_eff, diameters, numbers, (liquid[0], liquid[1], liquid[2]), dt,
    )  # fmt: skip
    remembered = one if joined else zero
    return (
        add3(force, scale3(pull, n)), friction, moment, spring, rolled, sliding if touches else remembered,
        history, powers, power + pull * dot3(u, n), lasts,
    )  # fmt: skip


@kernel(inline="always")
def only_where(condition, a):
    """Return the vector `a` where the condition holds, else zeros."""
    zero = like(0.0, a[0])
    return a[0] if condition else zero, a[1] if condition else zero, a[2] if condition else zero


meeting = by_type(
    {type(no_film.LAW): meet_dry, type(viscous_film.LAW): meet_wet, type(capillary.LAW): meet_bridged}
)
"""One contact under the film whose tag comes first; as `meet_wet`."""
