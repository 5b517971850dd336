"""The clock of a run: charge substep, window and row of the record, each a whole number of the one before."""

import functools
import math
from typing import NamedTuple

import numpy as np

from nutamill.base import units
from nutamill.base.errors import CaseError, Fault
from nutamill.base.required import required
from nutamill.base.units import shown
from nutamill.case.machine import Machine
from nutamill.case.placement import axes_along
from nutamill.case.touching import TouchingPair
from nutamill.charge.laws.area import cohesive_softening
from nutamill.charge.laws.impact import SUBSTEPS_PER_CONTACT
from nutamill.charge.laws.pair import PairLaw, spring_stiffness
from nutamill.simulation.setup.charge import impact_of, pair_law, quickest_meeting
from nutamill.simulation.setup.liquid import BridgeFacts, FilmFacts, bridge_facts, film_facts, refuse_films
from nutamill.simulation.setup.walls import region_corners

FEWEST_SUBSTEPS = 10
"""Smallest number of substeps in the shortest contact [1]; a case with fewer is refused."""

MOST_STEPS = 1e12
"""Steps of a run above which a case is refused as a slip of the pen [1]."""


class ContactFacts(NamedTuple):
    """The shortest contact of a pair of materials."""

    pair: str
    """Names of the two materials."""
    stiffness: float
    """Normal stiffness [N/m]; hysteretic: loading; Hertz: tangent at the largest overlap."""
    time: float
    """Duration of a contact at the speed that contacts have [s]; infinite if the two stick."""
    resolve: float
    """Time that substeps must resolve [s]: the duration, hysteretic half a period of the unloading spring."""
    overlap: float
    """Largest overlap of a head-on contact at the speed that contacts have, share of the smaller diameter
    [1].
    """
    restitution: float
    """Restitution of the pair at that speed, its film included [1]."""
    law: PairLaw
    """The law of the pair."""
    film: FilmFacts | None
    """What its film does to that contact; None where the charge is dry."""
    bridge: BridgeFacts | None
    """What its bridge does; None without one."""


class Clock(NamedTuple):
    """Lengths of the steps of a run."""

    substeps: int
    """Charge substeps in a window [1]; 0 without charge."""
    window: float
    """Mechanism step [s]."""
    windows_per_row: int
    """Windows between two rows of the record [1]."""
    ruled_by: str
    """What determines the step, in words."""

    @property
    def substep(self) -> float:
        """Return the charge substep [s]. Without a charge it is the window."""
        return self.window / max(self.substeps, 1)


def contact_facts(machine: Machine) -> list[ContactFacts]:
    """Return the shortest contact of each pair of materials that can touch: particles, then walls."""
    return [_facts(machine, pair) for pair in machine.touching]


def _facts(machine: Machine, pair: TouchingPair) -> ContactFacts:
    """Return the shortest contact of one pair of materials."""
    speed = contact_speed(machine)
    met, sizes, film = (
        impact_of(machine, *pair, speed),
        quickest_meeting(machine, *pair),
        film_facts(machine, pair, speed),
    )
    share = met.overlap / min(sizes.diameter, sizes.other_diameter)
    law = pair_law(machine, pair.first, pair.second)
    return ContactFacts(
        pair.name, met.stiffness, met.time, met.resolve, share, met.restitution, law, film,
        bridge_facts(machine, pair),
    )  # fmt: skip


@functools.lru_cache(maxsize=16)
def contact_speed(machine: Machine) -> float:
    """Return the scale of the speeds of contacts [m/s]: the largest speed at which any drive alone moves a
    point of its body b on the way to another joint, or a fall through the regions, whichever is faster.

    Of a nutating mill it is the speed of the crank pin on its circle.
    """
    speeds = []
    for drive in machine.drives:
        joint = next(joint for joint in machine.joints if joint.name == drive.joint)
        axis = axes_along(required(joint.axis))
        held = [other.point for other in machine.joints if joint.between[1] in other.between]
        points = np.array(held) @ axis - np.array(joint.point) @ axis
        speeds.append(abs(drive.speed) * float(np.hypot(points[:, 0], points[:, 1]).max()))
    carried = [region_corners(machine, region) for region in machine.regions]
    if carried and not any(speeds):
        corners = np.concatenate(carried)
        height = float(np.linalg.norm(np.ptp(corners, axis=0)))
        speeds.append(math.sqrt(2.0 * float(np.linalg.norm(machine.gravity)) * height))
    return max(speeds, default=0.0)


def run_clock(machine: Machine) -> Clock:
    """Return substep, window and row of a run.

    A row is one period of the series rate and a whole number of windows.

    Raises
    ------
    CaseError : a substep that resolves the shortest contact by fewer than `FEWEST_SUBSTEPS`, cohesion
        stronger than the spring
    """
    row = 1.0 / machine.run.series_rate
    if not machine.charge.parts:
        step = machine.run.step
        refuse_endless(machine.run.end, min(row, step))
        windows = max(1, math.ceil(row / step * (1.0 - 1e-12)))
        return Clock(0, row / windows, windows, f"mechanism alone, at most {units.shown(step, 'us', 'g')}")
    _refuse_soft_springs(machine)
    refuse_films(machine)
    shortest = min(contact_facts(machine), key=lambda facts: facts.resolve)
    if isinstance(machine.run.dt, str):  # "auto"
        longest = shortest.resolve / SUBSTEPS_PER_CONTACT
        ruled_by = f"{shortest.pair}, {SUBSTEPS_PER_CONTACT} substeps per contact"
    else:
        longest = machine.run.dt
        ruled_by = f"run.dt, {shortest.resolve / longest:.1f} substeps per {shortest.pair} contact"
        if shortest.resolve / longest < FEWEST_SUBSTEPS:
            raise CaseError(_too_long(machine, shortest, longest))
    refuse_endless(machine.run.end, longest)
    substeps = min(machine.run.window, math.ceil(row / longest))
    windows = math.ceil(row / (substeps * longest) - 1e-9)
    return Clock(substeps, row / windows, windows, ruled_by)


def refuse_endless(end: float, step: float) -> None:
    """Raise CaseError where a run to the time `end` [s] takes more steps [s] than can be meant."""
    if end / step > MOST_STEPS:
        what = f"makes {end / step:.2g} steps of {step:.2g} s, at most {MOST_STEPS:.0e} can be meant"
        raise CaseError(
            Fault("run.until", what, "End the run sooner, lengthen run.dt, or soften the contacts")
        )


def _refuse_soft_springs(machine: Machine) -> None:
    """Raise CaseError if cohesion exceeds a linear spring at any overlap, for the largest particles."""
    if machine.contact.cohesion == "none" or machine.contact.normal == "hertz":
        return
    diameter = max(part.size_range[1] for part in machine.charge.parts)
    faults = []
    for first, second, wall in machine.touching:
        law = pair_law(machine, first, second)
        spring = spring_stiffness(law, diameter, diameter)
        softening = cohesive_softening(law, diameter / (2 if wall else 4))
        if softening >= spring:
            most = law.cohesive_pressure * spring / softening
            what = (
                f"cohesion takes {shown(softening, 'kN/m', '.3g')} from a spring of "
                f"{shown(spring, 'kN/m', '.3g')}: particles would collapse"
            )
            faults.append(
                Fault(
                    f"contact.pairs {first}-{second}",
                    what,
                    f"Give a cohesive_pressure well below {shown(most, 'MPa', '.3g')}",
                )
            )
    if faults:
        raise CaseError(*faults)


def _too_long(machine: Machine, shortest: ContactFacts, substep: float) -> Fault:
    """Return the fault of a substep that is too long, with the substep and the stiffness that would do."""
    ratio = FEWEST_SUBSTEPS * substep / shortest.resolve
    if machine.contact.normal == "hertz":
        # duration ~ modulus^(-2/5); 5 % less, so that two digits are enough
        softer = f"softening = {0.95 * machine.contact.softening / ratio**2.5:.2g} would do"
    else:
        overlap = (
            f"overlap {100 * shortest.overlap * ratio:.2g} % of the diameter at "
            f"{contact_speed(machine):.2g} m/s"
        )
        softer = f"{shown(shortest.stiffness / ratio**2, 'kN/m', '.3g')} would do ({overlap})"
    return Fault(
        f"run.dt = {shown(substep, 'us', '.3g')}",
        f"a {shortest.pair} contact lasts {shown(shortest.resolve, 'us', '.3g')}, "
        f"{shortest.resolve / substep:.2g} substeps;"
        f" it needs {FEWEST_SUBSTEPS}, better {SUBSTEPS_PER_CONTACT} "
        f"({shown(shortest.resolve / SUBSTEPS_PER_CONTACT, 'us', '.2g')})",
        f'Use dt = "auto", or soften: {softer}',
    )
