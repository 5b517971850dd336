"""The clock of a run: charge substep, window and row of the record, each a whole number of the one before."""

import math
from typing import NamedTuple

from nutamill.build.chamber_charge import pair_law, pair_stiffness_of
from nutamill.build.charge_mix import quickest_pebble
from nutamill.case import Case
from nutamill.charge.contact_terms import SUBSTEPS_PER_CONTACT, contact_time, largest_overlap, restitution_from_damping_ratio
from nutamill.charge.model import PairLaw
from nutamill.errors import CaseError, Fault

FEWEST_SUBSTEPS = 10
"""Substeps in the shortest contact below which a case is refused [1]."""

MECHANISM_STEP = 55e-6
"""Longest step of a mechanism without charge [s]: errors of the joint reactions are then of the order of 1e-5."""


class ContactFacts(NamedTuple):
    """What a pair of materials means for those of their particles that have the shortest contacts."""

    pair: str
    """Names of the two materials."""
    stiffness: float
    """Normal stiffness [N/m]."""
    time: float
    """Duration of a contact [s]."""
    overlap: float
    """Largest overlap of a head-on contact at the speed of the crank circle, share of the smaller diameter [1]."""
    restitution: float
    """Restitution of the pair [1]."""
    law: PairLaw
    """The law itself."""


class Clock(NamedTuple):
    """How a run steps."""

    substeps: int
    """Charge substeps in a window [1]; 0 without charge."""
    window: float
    """Mechanism step [s]."""
    windows_per_row: int
    """Windows between two rows of the record [1]."""
    ruled_by: str
    """What decided the step."""

    @property
    def substep(self) -> float:
        """Charge substep [s]; the window without charge."""
        return self.window / max(self.substeps, 1)


def contact_facts(case: Case) -> list[ContactFacts]:
    """Facts of the contacts between particles of all materials, then of each with every wall material; the quickest particles rule."""
    own = case.charge.materials
    walls = dict.fromkeys([case.chamber.material] + ([case.chamber.rib.material] if case.chamber.ribs else []))
    between = [_facts(case, a, b, False) for number, a in enumerate(own) for b in own[number:]]
    return between + [_facts(case, a, wall, True) for a in own for wall in walls]


def _facts(case: Case, own: str, other: str, wall: bool) -> ContactFacts:
    """Facts of the quickest particle of one material against that of another, or against a wall."""
    one = quickest_pebble(case, own)
    two = one if wall else quickest_pebble(case, other)
    mass = one.mass if wall else 1 / (1 / one.mass + 1 / two.mass)
    law = pair_law(case, own, other)
    k = pair_stiffness_of(case, own, other)
    duration = contact_time(k, mass, law.damping_ratio, law.tension_cut)
    overlap = largest_overlap(k, mass, law.damping_ratio, crank_circle_speed(case)) / min(one.diameter, two.diameter)
    restitution = restitution_from_damping_ratio(law.damping_ratio, law.tension_cut)
    return ContactFacts(f"{own}-{other}{' wall' * wall}", k, duration, overlap, restitution, law)


def crank_circle_speed(case: Case) -> float:
    """Speed of the crank pin on its circle at full speed [m/s]: the scale of the speeds at which particles meet."""
    return case.drive.speed * case.mechanism.crank_radius


def run_clock(case: Case) -> Clock:
    """Substep, window and row of a run; a row lasts one period of the series rate and holds a whole number of windows.

    Raises
    ------
    CaseError : a substep that resolves the shortest contact by fewer than `FEWEST_SUBSTEPS`
    """
    row = 1.0 / case.run.series_rate
    if not case.charge.parts:
        windows = math.ceil(row / MECHANISM_STEP)
        return Clock(0, row / windows, windows, f"mechanism alone, at most {MECHANISM_STEP * 1e6:g} us")
    shortest = min(contact_facts(case), key=lambda facts: facts.time)
    if case.run.dt == "auto":
        longest = shortest.time / SUBSTEPS_PER_CONTACT
        ruled_by = f"{shortest.pair}, {SUBSTEPS_PER_CONTACT} substeps per contact"
    else:
        longest = case.run.dt
        ruled_by = f"run.dt, {shortest.time / longest:.1f} substeps per {shortest.pair} contact"
        if shortest.time / longest < FEWEST_SUBSTEPS:
            raise CaseError(_too_long(case, shortest, longest))
    substeps = min(case.run.window, math.ceil(row / longest))
    windows = math.ceil(row / (substeps * longest) - 1e-9)
    return Clock(substeps, row / windows, windows, ruled_by)


def _too_long(case: Case, shortest: ContactFacts, substep: float) -> Fault:
    """What is wrong with a substep that is too long, and what would be right."""
    ratio = FEWEST_SUBSTEPS * substep / shortest.time
    return Fault(
        f"run.dt = {substep * 1e6:.3g} us",
        f"a {shortest.pair} contact lasts {shortest.time * 1e6:.3g} us, {shortest.time / substep:.2g} substeps;"
        f" it needs {FEWEST_SUBSTEPS}, better {SUBSTEPS_PER_CONTACT} ({shortest.time / SUBSTEPS_PER_CONTACT * 1e6:.2g} us)",
        f'Use dt = "auto", or soften: {shortest.stiffness / ratio**2 / 1e3:.3g} kN/m would do'
        f" (overlap {100 * shortest.overlap * ratio:.2g} % of the diameter at {crank_circle_speed(case):.2g} m/s)",
    )
