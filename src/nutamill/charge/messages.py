"""Messages for what stopped a charge."""

from collections.abc import Sequence

from nutamill.charge.model import ChargeState, Status


def status_text(state: ChargeState, surfaces: Sequence[str] = ()) -> str:
    """Return `ChargeState.status` as a sentence: particles or surface, overlap and speeds.

    Parameters
    ----------
    state : the charge as its last window left it
    surfaces : names of the surfaces, in their order; numbers are used where there are none
    """
    kind, particle, other, _ = (int(number) for number in state.status)
    share = 100 * state.largest_overlap[2]
    first, second, closing = state.halt_speeds
    if kind == Status.PAIR_OVERLAP:
        return (
            f"particles {particle} and {other}, at {first:.3g} and {second:.3g} m/s, overlap by "
            f"{share:.1f} % of the diameter, more than"
            f" the pair's overlap_stop, and {_closing(closing)}"
        )
    if kind == Status.WALL_OVERLAP:
        surface = f'"{surfaces[other]}"' if other < len(surfaces) else f"number {other}"
        return (
            f"particle {particle}, at {first:.3g} m/s, overlaps surface {surface}, there at "
            f"{second:.3g} m/s, by {share:.1f} % of its"
            f" diameter, more than the pair's overlap_stop, and they {_closing(closing)}"
        )
    return f"particle {particle}, at {first:.3g} m/s, left the chamber, or its position is not a number"


def _closing(speed: float) -> str:
    """Return how fast two bodies close or part [m/s], in words."""
    return f"{'close' if speed > 0 else 'part'} at {abs(speed):.3g} m/s"


def status_time(state: ChargeState, dt: float) -> float:
    """Return the simulated time of the positions of `ChargeState.status` [s]. `dt` is the substep [s]."""
    return (int(state.status[3]) + 0.5) * dt
