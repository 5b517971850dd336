"""Deepest overlap of a contact, in the memory of a normal law that has no other history."""

from nutamill.base.kernel import kernel, like


@kernel(inline="always")
def turned(law, p, parting, history):
    """Return whether the work of loading has to be booked: the contact opens, from deeper than ever.

    Parameters
    ----------
    law : tag
    p : `numbers` of the pair (5)
    parting : overlap of a contact that opens, minus the overlap of one that closes [m]; 0 where there is none
    history : deepest overlap that has been booked [m], 0 before; across a film no overlap, and negative
    """
    zero = like(0.0, parting)
    return parting > (history if history > zero else zero)


@kernel(inline="always")
def to_book(law, p, parting, beyond, history, before):
    """Return the overlap whose work of loading is to be booked, that whose work is to be taken back [m], 0
    for none, and the history to remember.

    Parameters
    ----------
    law, p, parting, history : as `turned`, which holds
    beyond : how much deeper the contact has been since the substep before [m]
    before : history of the substep before; not used
    """
    booked = parting + beyond
    return booked, max(history, 0.0), booked
