"""Words for what stopped a charge."""

from collections.abc import Sequence

from nutamill.charge.model import ChargeState, Status


def status_text(state: ChargeState, surfaces: Sequence[str] = ()) -> str:
    """What `ChargeState.status` says: which particles, which surface, how deep.

    Parameters
    ----------
    surfaces : names of the surfaces, in their order; numbers are used where there are none
    """
    kind, particle, other, _ = (int(number) for number in state.status)
    share = 100 * state.largest_overlap[2]
    if kind == Status.PAIR_OVERLAP:
        return f"particles {particle} and {other} overlap by {share:.1f} % of the diameter, more than the pair's overlap_stop"
    if kind == Status.WALL_OVERLAP:
        surface = f'"{surfaces[other]}"' if other < len(surfaces) else f"number {other}"
        return f"particle {particle} overlaps surface {surface} by {share:.1f} % of its diameter, more than the pair's overlap_stop"
    return f"particle {particle} left the chamber, or its position is not a number"
