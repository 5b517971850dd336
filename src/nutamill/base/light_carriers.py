"""A body that the charge pushes about: is it heavy enough for the contact laws, and the window short enough?

The charge marches a window inside a motion that its own push changes only afterwards.  A carrier of effective
mass m under contacts of stiffness k swings with ``w = sqrt(k/m)``; the push of the window before acts in its
drift.  Without a dashpot, energy then grows in half a swing by a share of about ``(w dt)^3``: by 0.9 % at
``w dt`` = 0.2, and to twice of what it was at 0.83.  Windows that are repeated keep the energy, but each pass
leaves ``(w dt)^2/6`` of the difference, so that passes beyond ``w dt = sqrt(6)`` diverge.
"""

import math
from typing import NamedTuple

from nutamill.base import units
from nutamill.base.errors import Fault

LIGHT = 50.0
"""Effective mass of a carrier over that of a particle below which it counts as light [1]."""
LONG_WINDOW = 0.2
"""Frequency of a carrier on its contacts times window [1] above which the window counts as long."""
UNSTABLE_WINDOW = 0.83
"""The same above which half a swing without a dashpot more than doubles its energy."""
DIVERGING_WINDOW = math.sqrt(6.0)
"""The same above which repeated windows diverge."""

ITERATED = 'coupling = "iterated"'
"""What makes up for a long window."""


class PushedCarrier(NamedTuple):
    """A body that the charge pushes about, as far as the coupling of the two goes."""

    name: str
    """Its name, or the key of a case, for messages."""
    mass: float
    """Least effective mass at its contacts [kg]; infinite where it does not give way."""
    particle: float
    """Mass of the heaviest particle that touches it [kg]."""
    stiffness: float
    """Normal stiffness of one contact, the stiffest [N/m]."""
    contacts: int = 1
    """Contacts that push at the same time [1]; they count as parallel springs."""

    @property
    def frequency(self) -> float:
        """Angular frequency of the carrier on its contacts [rad/s]."""
        return math.sqrt(self.contacts * self.stiffness / self.mass)


def carrier_warnings(carrier: PushedCarrier, window: float, iterated: bool = False) -> list[Fault]:
    """Return what is doubtful about a carrier whose motion is held for a `window` [s].

    `iterated` windows are repeated with the push that they produced.
    """
    warnings = []
    if carrier.mass < LIGHT * carrier.particle:
        share = math.sqrt(1.0 + carrier.particle / carrier.mass) - 1.0
        what = (
            f"weighs {carrier.mass / carrier.particle:.3g} particles where they touch it, less than "
            f"{LIGHT:g}: contact laws take a wall as immovable, and the damping ratio there is "
            f"{100.0 * share:.2g} % higher than given"
        )
        warnings.append(
            Fault(carrier.name, what, "Expect a lower restitution there, or make the body heavier")
        )
    if carrier.frequency * window > LONG_WINDOW and not iterated:
        warnings.append(_too_long(carrier, window, LONG_WINDOW, "its contacts gain energy", ITERATED))
    return warnings


def carrier_faults(carrier: PushedCarrier, window: float, iterated: bool = False) -> list[Fault]:
    """Return why a carrier cannot be coupled in this `window` [s].

    Parameters are those of `carrier_warnings`.
    """
    if iterated and carrier.frequency * window >= DIVERGING_WINDOW:
        return [_too_long(carrier, window, 1.0, "repeated windows diverge", "make the body heavier")]
    if not iterated and carrier.frequency * window >= UNSTABLE_WINDOW:
        return [_too_long(carrier, window, LONG_WINDOW, "its contacts are unstable", ITERATED)]
    return []


def _too_long(carrier: PushedCarrier, window: float, share: float, effect: str, otherwise: str) -> Fault:
    """Return that the window is too long, and the window that makes it a `share` of the inverse frequency."""
    phase = carrier.frequency * window
    what = f"moves on its contacts by {phase:.3g} rad in a window of {units.shown(window, 'us')}: {effect}"
    longest = units.shown(share / carrier.frequency, "us")
    return Fault(carrier.name, what, f"Take a window of at most {longest}, or {otherwise}")
