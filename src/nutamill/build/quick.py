"""The demonstration: a case made short enough to be run in under a minute, and what it says of itself."""

import itertools
import math

from nutamill.build.chamber_charge import material_order, pair_stiffness_of
from nutamill.case import Case

RAMP_TIME = 0.2
"""Time from rest to full speed in a demonstration [s]."""

TURNS = 3
"""Turns at full speed in a demonstration [1]."""

SOFTER = 9.0
"""How many times softer contacts between particles are [1]; walls stay as they are."""


def quick(case: Case) -> Case:
    """The case in demonstration quality: rigid mounts, short ramp, a few turns at speed, softer contacts between particles."""
    until = RAMP_TIME + TURNS * 2.0 * math.pi / case.drive.speed
    changes = {
        "title": f"demonstration of {case.name}",
        "mechanism.mounting": "rigid",
        "drive.ramp": case.drive.speed / RAMP_TIME,
        "run.until": until,
        "run.snapshots.last": 0.1,
    }
    if case.charge.parts and case.contact.stiffness == "young":
        changes["contact.stiffness"] = "direct"
        for own, other in itertools.product(case.charge.materials, material_order(case)):
            softer = SOFTER if other in case.charge.materials else 1.0
            changes[f"contact.pairs.{pair_name(case, own, other)}.normal_stiffness"] = pair_stiffness_of(case, own, other) / softer
    return case.with_(**{key.replace(".", "__"): value for key, value in changes.items()})


def pair_name(case: Case, first: str, second: str) -> str:
    """Name of the table of a pair of materials in the case's file."""
    return next(name for name in (f"{first}-{second}", f"{second}-{first}") if name in case.contact.pairs)


def banner() -> str:
    """What a demonstration leaves out."""
    return (
        f"demonstration: rigid mounts, {RAMP_TIME:g} s ramp, {TURNS} turns at speed, contacts between particles {SOFTER:g} times softer."
        " It shows the program, not the mill: run without --quick for numbers"
    )
