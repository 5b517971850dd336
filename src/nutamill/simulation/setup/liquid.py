"""The liquid of a wet charge: its checks, and what film and bridge do to an impact."""

from typing import NamedTuple

from nutamill.base.errors import CaseError, Fault
from nutamill.base.units import shown
from nutamill.case.machine import Machine
from nutamill.case.touching import TouchingPair
from nutamill.charge.laws import capillary, viscous_film
from nutamill.charge.laws.composition import law_files
from nutamill.simulation.setup.charge import contact_law_of, pair_law, quickest_meeting


class FilmFacts(NamedTuple):
    """What the film of a pair does to a head-on impact of its quickest particles."""

    stokes: float
    """Stokes number of the impact [1]; infinite where the pair is dry."""
    sticks_below: float
    """Stokes number below which the two do not part again [1]."""


def film_facts(machine: Machine, pair: TouchingPair, v: float) -> FilmFacts | None:
    """Return what the film of a pair does to an impact at `v` [m/s], or None where the charge is dry."""
    if machine.contact.film == "none":
        return None
    law, met = pair_law(machine, pair.first, pair.second), quickest_meeting(machine, *pair)
    dry = law_files(contact_law_of(machine))[0].restitution(law)
    stokes = viscous_film.stokes_number(law, met.mass, met.radius, v)
    return FilmFacts(stokes, (1.0 + dry) / dry * viscous_film.passage(law))


class BridgeFacts(NamedTuple):
    """What the bridge of a pair does to its quickest particles."""

    pull: float
    """Largest pull [N]."""
    rupture: float
    """Gap at which it breaks [m]."""
    work: float
    """Work that parts the two [J]."""


def bridge_facts(machine: Machine, pair: TouchingPair) -> BridgeFacts | None:
    """Return what the bridge of a pair does, or None where it has none."""
    law, met = pair_law(machine, pair.first, pair.second), quickest_meeting(machine, *pair)
    if machine.contact.film != "capillary" or law.bridge_volume == 0.0:
        return None
    numbers = capillary.largest_pull, capillary.rupture_distance, capillary.separation_work
    return BridgeFacts(*(number(law, met.radius) for number in numbers))


def refuse_films(machine: Machine) -> None:
    """Raise CaseError with every film that is none, or too thick for a thin layer on the smallest particles,
    and with every bridge too large for its closed form.
    """
    if machine.contact.film == "none":
        return
    faults = []
    smallest = min(part.size_range[0] for part in machine.charge.parts)
    most = viscous_film.MOST_SHARE * smallest
    for first, second, wall in machine.touching:
        law, where = pair_law(machine, first, second), f"contact.pairs {first}-{second}"
        faults += [Fault(where, *fault) for fault in law_files(contact_law_of(machine))[4].faults(law)]
        if law.liquid_viscosity > 0.0 and law.film_thickness > most:
            what = (
                f"film_thickness must be at most {viscous_film.MOST_SHARE:g} of the smallest diameter, "
                f"{shown(most, 'um', '.3g')}, got {shown(law.film_thickness, 'um', '.3g')}"
            )
            faults.append(Fault(where, what, "The film law holds for thin layers; it does not model a bath"))
        largest = capillary.MOST_VOLUME * (smallest if wall else 0.5 * smallest) ** 3
        if law.bridge_volume > largest:
            what = (
                f"bridge_volume must be at most {capillary.MOST_VOLUME:g} of R^3 of the smallest particles, "
                f"{shown(largest, 'nL', '.3g')}, got {shown(law.bridge_volume, 'nL', '.3g')}"
            )
            hint = "The closed form of the bridge holds for small drops; R is the diameter at a wall"
            faults.append(Fault(where, what, f"{hint}, else the radius"))
    if faults:
        raise CaseError(*dict.fromkeys(faults))
