"""What the march of the charge does to a dashpot, and the share that makes up for it."""

from nutamill.base.kernel import kernel, like


@kernel(inline="always")
def dashpot_share(square):
    """Return the share of a dashpot to apply in a substep [1]: ``1 - (w dt)^2/2``.

    Forces act at mid-substep with the predicted velocity ``v + a dt/2``, a from the substep before
    (docs/decisions/007).  That misses ``dt^2/2 da/dt`` of the velocity there, which is ``-(w dt)^2/2`` of it
    in a contact of frequency w: the contact would lose too much, by that share.

    Parameters
    ----------
    square : ``(w dt)^2`` [1] with ``w^2 = k/m_eff`` and the substep dt; at most 0.15 where a contact lasts
        eight substeps or more
    """
    return like(1.0, square) - like(0.5, square) * square
