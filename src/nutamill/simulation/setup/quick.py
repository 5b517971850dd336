"""The demonstration: a case made short enough to be run in under a minute, and what it says of itself."""

import itertools
import math

from nutamill.case import Case
from nutamill.charge.laws.impact import spring_stiffness
from nutamill.simulation.setup.charge import material_order, pair_law, quickest_meeting

RAMP_TIME = 0.2
"""Time from rest to full speed in a demonstration [s]."""

TURNS = 3
"""Turns at full speed in a demonstration [1]."""

SOFTER = 9.0
"""How many times softer contacts between particles are [1]; walls stay as they are."""


def quick(case: Case) -> Case:
    """The case in demonstration quality: rigid mounts, short ramp, a few turns at speed, softer contacts
    between particles.
    """
    rows = (
        2.0 / case.run.series_rate
    )  # the record begins up to a row after the ramp and ends up to a row before the end
    until = RAMP_TIME + TURNS * 2.0 * math.pi / case.drive.speed + rows
    changes = {
        "title": f"demonstration of {case.name}: {simplified(case)}",
        "mechanism.mounting": "rigid",
        "drive.ramp": case.drive.speed / RAMP_TIME,
        "run.until": until,
        "run.snapshots.last": 0.1,
    }
    if softens(case):
        changes["contact.stiffness"] = "direct"
        for own, other in itertools.product(case.charge.materials, material_order(case)):
            wall = other not in case.charge.materials
            softer, met = 1.0 if wall else SOFTER, quickest_meeting(case, own, other, wall)
            stiffness = spring_stiffness(pair_law(case, own, other), met.diameter, met.other_diameter)
            changes[f"contact.pairs.{pair_name(case, own, other)}.normal_stiffness"] = stiffness / softer
    return case.with_(**{key.replace(".", "__"): value for key, value in changes.items()})


def softens(case: Case) -> bool:
    """Whether the demonstration of a case takes softer springs; Hertz's have no stiffness of their own to
    change.
    """
    return bool(case.charge.parts) and case.contact.stiffness == "young" and case.contact.normal != "hertz"


def pair_name(case: Case, first: str, second: str) -> str:
    """Name of the table of a pair of materials in the case's file."""
    return next(name for name in (f"{first}-{second}", f"{second}-{first}") if name in case.contact.pairs)


def simplified(case: Case) -> str:
    """What the demonstration of a case simplifies, as its title and its reports say it."""
    softer = f", contacts between particles {SOFTER:g} times softer" if softens(case) else ""
    return f"rigid mounts, {RAMP_TIME:g} s ramp, {TURNS} turns at speed{softer}"


def banner(case: Case) -> str:
    """What is printed before a demonstration."""
    return (
        f"demonstration: {simplified(case)}. It shows the program, not the mill: run without --quick for "
        "numbers"
    )
